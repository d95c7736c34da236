// Finds neighbours of bodies, and connected groups of bodies.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/neighbourhood.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "engine/math/union_find.h"

namespace ticktrue::reduce {
namespace {

using engine::BroadPhaseReport;
using engine::Scene;
using Edge = std::pair<std::size_t, std::size_t>;

/// Pairs of bodies in the scene that may act on each other.
std::vector<Edge> edges_of(const Scene& scene, const BroadPhaseReport& broad_phase) {
  std::vector<Edge> edges;
  const std::size_t count = scene.bodies.size();
  const auto add = [&](std::size_t a, std::size_t b) {
    if (a < count && b < count && a != b) edges.emplace_back(a, b);
  };
  for (const BroadPhaseReport::Pair& pair : broad_phase.pairs)
    add(broad_phase.boxes[pair.first].body, broad_phase.boxes[pair.second].body);
  for (const engine::Joint& joint : scene.joints) {
    std::vector<std::uint32_t> joined;
    engine::for_each_body(scene, joint, [&](std::uint32_t body) { joined.push_back(body); });
    for (std::size_t i = 1; i < joined.size(); ++i) add(joined[0], joined[i]);
  }
  for (const engine::Force& force : scene.forces)
    if (force.body && force.other) add(*force.body, *force.other);
  return edges;
}

struct Box {
  engine::Point lower{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  engine::Point upper{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

/// The box of each body in the scene: around its shapes, or its centre if the body never collides.
std::vector<Box> boxes_of(const engine::Engine& engine, const BroadPhaseReport& broad_phase) {
  std::vector<Box> boxes(engine.scene().bodies.size());
  const auto grow = [&](std::size_t body, const engine::Point& lower, const engine::Point& upper) {
    if (body >= boxes.size()) return;
    Box& box = boxes[body];
    box.lower = {std::min(box.lower.x, lower.x), std::min(box.lower.y, lower.y)};
    box.upper = {std::max(box.upper.x, upper.x), std::max(box.upper.y, upper.y)};
  };
  for (const engine::BodyReport& body : engine.bodies()) grow(body.id, body.center, body.center);
  for (const BroadPhaseReport::Box& box : broad_phase.boxes) grow(box.body, box.lower, box.upper);
  return boxes;
}

/// Squared distance of two boxes; 0 if they overlap.
double distance(const Box& a, const Box& b) {
  const double x = std::max({0.0, a.lower.x - b.upper.x, b.lower.x - a.upper.x});
  const double y = std::max({0.0, a.lower.y - b.upper.y, b.lower.y - a.upper.y});
  return x * x + y * y;
}

constexpr std::size_t unreached = std::numeric_limits<std::size_t>::max();

/// The number of edges on the shortest path from `starts` to each body.
std::vector<std::size_t> steps_from(const std::vector<std::size_t>& starts, std::size_t count,
                                    const std::vector<Edge>& edges) {
  std::vector<std::vector<std::size_t>> neighbours(count);
  for (const auto& [a, b] : edges) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  std::vector<std::size_t> steps(count, unreached);
  std::vector<std::size_t> queue = starts;
  for (const std::size_t start : starts) steps[start] = 0;
  for (std::size_t i = 0; i < queue.size(); ++i)
    for (const std::size_t next : neighbours[queue[i]]) {
      if (steps[next] != unreached) continue;
      steps[next] = steps[queue[i]] + 1;
      queue.push_back(next);
    }
  return steps;
}

}  // namespace

std::vector<std::size_t> by_nearness(const engine::Engine& engine, const std::vector<std::uint32_t>& bodies) {
  const std::size_t count = engine.scene().bodies.size();
  std::vector<std::size_t> starts;
  for (const std::uint32_t id : bodies)
    if (id < count && std::find(starts.begin(), starts.end(), id) == starts.end()) starts.push_back(id);
  if (starts.empty()) return {};
  const BroadPhaseReport broad_phase = engine.broad_phase();
  const std::vector<std::size_t> steps = steps_from(starts, count, edges_of(engine.scene(), broad_phase));
  const std::vector<Box> boxes = boxes_of(engine, broad_phase);
  std::vector<std::tuple<std::size_t, double, std::size_t>> keys;
  for (std::size_t i = 0; i < count; ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const std::size_t start : starts) nearest = std::min(nearest, distance(boxes[i], boxes[start]));
    keys.emplace_back(steps[i], nearest, i);
  }
  // `bodies` begins with the most affected bodies, so the starts keep their order.
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> order = starts;
  for (const auto& [step, gap, index] : keys)
    if (step != 0) order.push_back(index);
  return order;
}

std::vector<std::vector<std::size_t>> connected_groups(const engine::Engine& engine) {
  const Scene& scene = engine.scene();
  std::vector<std::uint32_t> parent(scene.bodies.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto is_static = [&](std::size_t i) { return scene.bodies[i].type == engine::BodyType::static_body; };
  for (const auto& [a, b] : edges_of(scene, engine.broad_phase()))
    if (!is_static(a) && !is_static(b))
      engine::unite(parent, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  std::vector<std::vector<std::size_t>> groups;
  std::vector<std::size_t> group_of(parent.size(), unreached);
  for (std::uint32_t i = 0; i < parent.size(); ++i) {
    if (is_static(i)) continue;
    std::size_t& group = group_of[engine::find_root(parent, i)];
    if (group == unreached) {
      group = groups.size();
      groups.emplace_back();
    }
    groups[group].push_back(i);
  }
  return groups;
}

}  // namespace ticktrue::reduce
