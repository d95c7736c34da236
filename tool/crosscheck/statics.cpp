// Balance of a structure as a non-negative least squares problem, by the active sets of Lawson and Hanson.
// SPDX-License-Identifier: MIT
#include "tool/crosscheck/statics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace ticktrue::tool {
namespace {

using engine::Point;

constexpr double balance_tolerance = 1e-4;  // of a body's weight, and of its weight times its size
constexpr double gain_min = 1e-9;           // of a force along which the residual falls
constexpr double pivot_min = 1e-11;         // relative; an edge below it is a sum of others

// One edge of a friction cone: force and moment on both bodies.
struct ConeEdge {
  std::array<std::size_t, 6> row{};
  std::array<double, 6> value{};
  int count = 0;
};

double dot(const ConeEdge& edge, const std::vector<double>& rows) {
  double sum = 0;
  for (int i = 0; i < edge.count; ++i) sum += edge.value[i] * rows[edge.row[i]];
  return sum;
}

double dot(const ConeEdge& a, const ConeEdge& b) {
  double sum = 0;
  for (int i = 0; i < a.count; ++i)
    for (int j = 0; j < b.count; ++j)
      if (a.row[i] == b.row[j]) sum += a.value[i] * b.value[j];
  return sum;
}

// Rows are divided by `scale`, so that a residual of a light body counts as much as that of a heavy one.
ConeEdge edge_of(std::span<const StaticBody> bodies, const std::vector<double>& scale, const StaticContact& contact,
                 const Point& force_on_b) {
  ConeEdge edge;
  for (const auto& [id, sign] : {std::pair{contact.body_a, -1.0}, std::pair{contact.body_b, 1.0}}) {
    const StaticBody& body = bodies[id];
    if (!body.is_dynamic) continue;
    const Point arm{contact.point.x - body.center.x, contact.point.y - body.center.y};
    const std::array<double, 3> values{force_on_b.x, force_on_b.y,
                                       (arm.x * force_on_b.y - arm.y * force_on_b.x) / body.size};
    for (std::size_t axis = 0; axis < values.size(); ++axis) {
      edge.row[edge.count] = 3 * std::size_t{id} + axis;
      edge.value[edge.count++] = sign * values[axis] / scale[id];
    }
  }
  const double length = std::sqrt(dot(edge, edge));
  for (int i = 0; i < edge.count; ++i) edge.value[i] /= length;
  return edge;
}

// The least squares solution with the `used` edges alone, by Cholesky's method; empty if they depend on each other.
std::vector<double> solve(const std::vector<ConeEdge>& edges, const std::vector<std::size_t>& used,
                          const std::vector<double>& right) {
  const std::size_t n = used.size();
  std::vector<double> factor(n * n, 0);
  std::vector<double> x(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = dot(edges[used[i]], edges[used[j]]);
      for (std::size_t k = 0; k < j; ++k) sum -= factor[i * n + k] * factor[j * n + k];
      if (i == j && !(sum > pivot_min)) return {};
      factor[i * n + j] = i == j ? std::sqrt(sum) : sum / factor[j * n + j];
    }
    double sum = dot(edges[used[i]], right);
    for (std::size_t k = 0; k < i; ++k) sum -= factor[i * n + k] * x[k];
    x[i] = sum / factor[i * n + i];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = i + 1; k < n; ++k) x[i] -= factor[k * n + i] * x[k];
    x[i] /= factor[i * n + i];
  }
  return x;
}

}  // namespace

bool can_balance(std::span<const StaticBody> bodies, std::span<const StaticContact> contacts) {
  if (contacts.size() > statics_point_count_max) return false;
  std::vector<double> right(3 * bodies.size(), 0);  // what the contacts must give
  std::vector<double> scale(bodies.size(), 1);
  for (std::size_t id = 0; id < bodies.size(); ++id) {
    const StaticBody& body = bodies[id];
    if (!body.is_dynamic) continue;
    scale[id] = std::hypot(body.weight.x, body.weight.y);
    if (!(scale[id] > 0) || !(body.size > 0)) return false;
    right[3 * id] = -body.weight.x / scale[id];
    right[3 * id + 1] = -body.weight.y / scale[id];
  }
  std::vector<ConeEdge> edges;
  for (const StaticContact& contact : contacts) {
    if (!bodies[contact.body_a].is_dynamic && !bodies[contact.body_b].is_dynamic) continue;
    for (const double share : {-contact.friction, contact.friction}) {
      const Point force{contact.normal.x - share * contact.normal.y, contact.normal.y + share * contact.normal.x};
      edges.push_back(edge_of(bodies, scale, contact, force));
    }
  }

  std::vector<std::size_t> used;                     // edges with a force above 0
  std::vector<double> force;                         // of each used edge
  std::vector<bool> is_barred(edges.size(), false);  // used, or of no use beside the used ones
  std::vector<double> rest = right;
  for (std::size_t pass = 0; pass < 3 * edges.size(); ++pass) {
    std::size_t best = edges.size();
    double gain = gain_min;
    for (std::size_t c = 0; c < edges.size(); ++c)
      if (const double here = is_barred[c] ? 0 : dot(edges[c], rest); here > gain) {
        gain = here;
        best = c;
      }
    if (best == edges.size()) break;
    is_barred[best] = true;
    used.push_back(best);
    force.push_back(0);
    std::vector<double> wanted = solve(edges, used, right);
    if (wanted.empty() || wanted.back() <= 0) {  // it depends on the used ones, or rounding alone asked for it
      used.pop_back();
      force.pop_back();
      continue;
    }
    // Goes towards the solution as far as no force is below 0, and leaves out the edge whose force is 0 there.
    while (true) {
      std::size_t first = used.size();
      double share = 1;
      for (std::size_t i = 0; i < used.size(); ++i) {
        if (wanted[i] > 0) continue;
        const double here = force[i] / (force[i] - wanted[i]);
        if (first != used.size() && here >= share) continue;
        share = here;
        first = i;
      }
      for (std::size_t i = 0; i < used.size(); ++i) force[i] += share * (wanted[i] - force[i]);
      if (first == used.size()) break;
      std::fill(is_barred.begin(), is_barred.end(), false);
      used.erase(used.begin() + static_cast<std::ptrdiff_t>(first));
      force.erase(force.begin() + static_cast<std::ptrdiff_t>(first));
      wanted = solve(edges, used, right);
      if (wanted.size() != used.size()) return false;
    }
    for (const std::size_t c : used) is_barred[c] = true;
    rest = right;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const ConeEdge& edge = edges[used[i]];
      for (int k = 0; k < edge.count; ++k) rest[edge.row[k]] -= force[i] * edge.value[k];
    }
  }
  return std::all_of(rest.begin(), rest.end(), [](double value) { return std::fabs(value) <= balance_tolerance; });
}

}  // namespace ticktrue::tool
