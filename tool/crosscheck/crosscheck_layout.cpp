// The structure of a scene at its start: which bodies lie on which, columns, rows, sizes.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "tool/crosscheck/crosscheck.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::BodyType;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr int circle_corner_count = 32;    // the outline deviates by less than half a percent of the radius
constexpr double placed_gap_max = 0.5;     // of a body's height: a body that starts higher is in the air
constexpr double rest_speed_share = 0.02;  // of the speed of a body after a fall over half its own size

double dot(const Point& a, const Point& b) {
  return a.x * b.x + a.y * b.y;
}

Point turned(const Point& p, const engine::SinCos& turn) {
  return {turn.cos * p.x - turn.sin * p.y, turn.sin * p.x + turn.cos * p.y};
}

// A convex outline in (across, up), counter-clockwise, with its bounding box.
struct BoundedOutline {
  std::vector<Point> points;
  Point lower{infinite, infinite};
  Point upper{-infinite, -infinite};
};

// The outline of all places within the radius of a core: its farthest point in each of many directions.
std::vector<Point> rounded(const std::vector<Point>& core, double radius) {
  std::vector<Point> corners;
  for (int i = 0; i < circle_corner_count; ++i) {
    const engine::SinCos turn = engine::sin_cos(2 * engine::pi * i / circle_corner_count);
    const Point direction{turn.cos, turn.sin};
    Point farthest = core[0];
    for (const Point& p : core)
      if (dot(p, direction) > dot(farthest, direction)) farthest = p;
    corners.push_back({farthest.x + radius * direction.x, farthest.y + radius * direction.y});
  }
  return corners;
}

BoundedOutline bounded_outline_of(const Body& body, const std::vector<Point>& corners, const CrosscheckLayout& layout) {
  const engine::SinCos turn = engine::pose_sin_cos(body.angle);
  BoundedOutline outline;
  for (const Point& corner : corners) {
    const Point p = turned(corner, turn);
    const Point world{body.position.x + p.x, body.position.y + p.y};
    const Point seen{dot(world, layout.right), dot(world, layout.up)};
    outline.points.push_back(seen);
    outline.lower = {std::min(outline.lower.x, seen.x), std::min(outline.lower.y, seen.y)};
    outline.upper = {std::max(outline.upper.x, seen.x), std::max(outline.upper.y, seen.y)};
  }
  return outline;
}

// One outline, or one for each edge of a segment or chain. A sensor has none, because no body can lie on a sensor.
std::vector<BoundedOutline> bounded_outlines_of(const Body& body, const Shape& shape, const CrosscheckLayout& layout) {
  if (shape.sensor) return {};
  const std::vector<Point> core = engine::core_of(shape);
  if (!engine::is_line(shape.kind))
    return {bounded_outline_of(body, shape.radius > 0 ? rounded(core, shape.radius) : core, layout)};
  std::vector<BoundedOutline> edges;
  for (std::size_t i = 0; i + 1 < core.size(); ++i)
    edges.push_back(bounded_outline_of(body, {core[i], core[i + 1]}, layout));
  if (shape.loop) edges.push_back(bounded_outline_of(body, {core.back(), core.front()}, layout));
  return edges;
}

// Lowest and highest point of a convex outline at one `across` coordinate.
struct Span {
  double low = infinite;
  double high = -infinite;
};
Span span_at(const BoundedOutline& outline, double across) {
  Span span;
  for (std::size_t i = 0; i < outline.points.size(); ++i) {
    const Point& a = outline.points[i];
    const Point& b = outline.points[(i + 1) % outline.points.size()];
    if (across < std::min(a.x, b.x) || across > std::max(a.x, b.x)) continue;
    const double share = b.x == a.x ? 0 : (across - a.x) / (b.x - a.x);
    for (const double up : {a.y + share * (b.y - a.y), b.x == a.x ? b.y : a.y + share * (b.y - a.y)}) {
      span.low = std::min(span.low, up);
      span.high = std::max(span.high, up);
    }
  }
  return span;
}

// How far `upper` may sink until it touches `lower`; infinite if neither is above the other. The result is exact for
// polygons, because both outlines are straight between their corners.
double gap_between(const BoundedOutline& upper, const BoundedOutline& lower) {
  const double left = std::max(upper.lower.x, lower.lower.x);
  const double right = std::min(upper.upper.x, lower.upper.x);
  const double width = std::min(upper.upper.x - upper.lower.x, lower.upper.x - lower.lower.x);
  if (right - left < 0.01 * width) return infinite;  // side by side
  double gap = infinite;
  const auto measure_gap_at = [&](double across) {
    if (across < left || across > right) return;
    gap = std::min(gap, span_at(upper, across).low - span_at(lower, across).high);
  };
  measure_gap_at(left);
  measure_gap_at(right);
  for (const Point& p : upper.points) measure_gap_at(p.x);
  for (const Point& p : lower.points) measure_gap_at(p.x);
  return gap;
}

struct Outlines {
  std::vector<BoundedOutline> shapes;
  Point lower{infinite, infinite};
  Point upper{-infinite, -infinite};
};

// Drops every dynamic body straight down, lowest body first, and stores the bodies that carry it.
void drop_bodies(const std::vector<Outlines>& outlines, CrosscheckLayout& layout) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t id = 0; id < layout.bodies.size(); ++id)
    if (layout.bodies[id].is_dynamic) order.push_back(id);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return outlines[a].lower.y < outlines[b].lower.y; });
  std::vector<std::uint32_t> below;  // bodies that may carry: static and kinematic bodies, then dropped bodies
  for (std::uint32_t id = 0; id < layout.bodies.size(); ++id)
    if (!layout.bodies[id].is_dynamic) below.push_back(id);

  struct Found {
    std::uint32_t id;
    double gap;
  };
  std::vector<Found> found;
  for (const std::uint32_t id : order) {
    CrosscheckBody& body = layout.bodies[id];
    const Outlines& outline = outlines[id];
    found.clear();
    body.drop = infinite;
    for (const std::uint32_t other : below) {
      const Outlines& under = outlines[other];
      if (under.upper.x <= outline.lower.x || under.lower.x >= outline.upper.x || under.lower.y >= outline.upper.y)
        continue;
      double gap = infinite;
      for (const BoundedOutline& a : outline.shapes)
        for (const BoundedOutline& b : under.shapes) gap = std::min(gap, gap_between(a, b));
      if (gap < -0.1 * body.height) continue;  // beside or around the body, not below
      if (gap == infinite) continue;
      const double own_drop = layout.bodies[other].is_dynamic ? layout.bodies[other].drop : 0;
      found.push_back({other, gap});
      body.drop = std::min(body.drop, gap + own_drop);
    }
    for (const Found& candidate : found) {
      const double own_drop = layout.bodies[candidate.id].is_dynamic ? layout.bodies[candidate.id].drop : 0;
      if (candidate.gap + own_drop > body.drop + 0.02 * body.height) continue;
      body.supports.push_back(candidate.id);
      const CrosscheckBody& support = layout.bodies[candidate.id];
      const bool is_near = candidate.gap <= placed_gap_max * body.height;
      if (is_near && (support.is_placed || !support.is_dynamic)) body.is_placed = true;  // hanging links are not placed
    }
    below.push_back(id);
  }
}

bool find_column(const CrosscheckLayout& layout) {
  std::vector<int> carried_count(layout.bodies.size(), 0);
  std::size_t stacked = 0;
  for (const CrosscheckBody& body : layout.bodies) {
    if (!body.is_dynamic) continue;
    if (!body.is_placed || body.supports.size() != 1) return false;
    const std::uint32_t support = body.supports.front();
    if (!layout.bodies[support].is_dynamic) continue;
    ++stacked;
    if (++carried_count[support] > 1) return false;
  }
  return stacked > 0;
}

// Finds dynamic bodies of equal height that touch side by side, from left to right.
void find_rows(const std::vector<Outlines>& outlines, CrosscheckLayout& layout) {
  std::vector<std::uint32_t> order;
  for (std::uint32_t id = 0; id < layout.bodies.size(); ++id)
    if (layout.bodies[id].is_dynamic) order.push_back(id);
  const double band = 0.1 * layout.size;
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double band_a = std::floor(layout.bodies[a].up / band + 0.5);
    const double band_b = std::floor(layout.bodies[b].up / band + 0.5);
    if (band_a != band_b) return band_a < band_b;
    return layout.bodies[a].across < layout.bodies[b].across;
  });
  std::vector<std::uint32_t> row;
  const auto close_row = [&] {
    if (row.size() > 1) layout.body_rows.push_back(row);
    row.clear();
  };
  for (const std::uint32_t id : order) {
    if (!row.empty()) {
      const std::uint32_t left = row.back();
      const bool level = std::fabs(layout.bodies[id].up - layout.bodies[left].up) < band;
      const bool touching = std::fabs(outlines[id].lower.x - outlines[left].upper.x) < 0.02 * layout.size;
      if (!level || !touching) close_row();
    }
    row.push_back(id);
  }
  close_row();
}

bool has_weight_alone(const engine::Scene& scene) {
  const auto is_driven = [](const Body& body) {
    const bool moves = body.velocity.x != 0 || body.velocity.y != 0 || body.angular_velocity != 0;
    const auto is_conveyor = [](const Shape& shape) { return shape.material.tangent_speed != 0; };
    return (body.type == BodyType::kinematic_body && moves) ||
           std::any_of(body.shapes.begin(), body.shapes.end(), is_conveyor);
  };
  return scene.joints.empty() && scene.forces.empty() &&
         std::none_of(scene.bodies.begin(), scene.bodies.end(), is_driven);
}

}  // namespace

CrosscheckLayout make_layout(const engine::Scene& scene) {
  CrosscheckLayout layout;
  if (!scene.joints.empty()) layout.jointed = std::make_shared<const engine::Scene>(scene);
  layout.gravity = std::hypot(scene.gravity.x, scene.gravity.y);
  layout.has_weight_alone = has_weight_alone(scene);
  layout.friction_mix = scene.settings.friction_mix;
  if (layout.gravity > 0) {
    layout.up = {-scene.gravity.x / layout.gravity, -scene.gravity.y / layout.gravity};
    layout.right = {layout.up.y, -layout.up.x};
  }

  std::vector<Outlines> outlines(scene.bodies.size());
  std::vector<double> sizes;
  double speed_max = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& description = scene.bodies[i];
    CrosscheckBody body;
    body.is_dynamic = description.type == BodyType::dynamic_body;
    const engine::MassProperties mass = engine::body_mass(description);
    body.weight = mass.mass * layout.gravity * description.gravity_scale;
    const Point offset = turned(mass.center, engine::pose_sin_cos(description.angle));
    const Point center{description.position.x + offset.x, description.position.y + offset.y};
    body.across = dot(center, layout.right);
    body.up = dot(center, layout.up);
    body.angle = description.angle;
    body.friction = description.shapes.empty() ? 0 : infinite;
    for (const Shape& shape : description.shapes) {
      body.friction = std::min(body.friction, shape.material.friction);
      if (shape.kind != ShapeKind::circle) body.shows_tilt = true;
      Outlines& all = outlines[i];
      for (BoundedOutline& outline : bounded_outlines_of(description, shape, layout)) {
        all.lower = {std::min(all.lower.x, outline.lower.x), std::min(all.lower.y, outline.lower.y)};
        all.upper = {std::max(all.upper.x, outline.upper.x), std::max(all.upper.y, outline.upper.y)};
        all.shapes.push_back(std::move(outline));
      }
    }
    body.width = outlines[i].upper.x - outlines[i].lower.x;
    body.height = outlines[i].upper.y - outlines[i].lower.y;
    if (body.is_dynamic) {
      ++layout.dynamic_count;
      sizes.push_back(std::min(body.width, body.height));
      speed_max = std::max(speed_max, std::hypot(description.velocity.x, description.velocity.y));
    }
    layout.bodies.push_back(std::move(body));
  }
  if (layout.dynamic_count == 0) return layout;

  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
  layout.size = sizes[sizes.size() / 2];
  layout.rest_speed = rest_speed_share * (layout.gravity > 0 ? std::sqrt(layout.gravity * layout.size) : speed_max);
  if (layout.gravity > 0) {
    drop_bodies(outlines, layout);
    find_rows(outlines, layout);
  }

  double base = infinite;
  double top = -infinite;
  for (std::size_t i = 0; i < layout.bodies.size(); ++i) {
    CrosscheckBody& body = layout.bodies[i];
    if (!body.is_dynamic) continue;
    const Body& description = scene.bodies[i];
    const bool moves = description.velocity.x != 0 || description.velocity.y != 0 || description.angular_velocity != 0;
    // A body that moves, or has no weight, is not placed. A body that a moving body may hit is placed.
    if (moves || body.weight <= 0) body.is_placed = false;
    if (body.is_placed) ++layout.placed_count;
    const double drop = std::isfinite(body.drop) ? body.drop : 0;
    base = std::min(base, outlines[i].lower.y - drop);
    top = std::max(top, body.up - drop);
  }
  layout.base = base;
  layout.height = std::max(top - base, layout.size);
  layout.is_structure = layout.placed_count > 0 && 2 * layout.placed_count >= layout.dynamic_count;
  layout.is_column = layout.is_structure && find_column(layout);
  return layout;
}

}  // namespace ticktrue::tool
