// Creates the shapes of a body in Box2D.
// SPDX-License-Identifier: MIT
#if defined(TICKTRUE_HAS_BOX2D)

#include "tool/box2d/box2d_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "tool/box2d/length_scale.h"

namespace ticktrue::tool {
namespace {

using engine::BodyType;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;

// In Box2D, the skins of resting polygons overlap by half a slop each. With this skin, the geometries then touch, as in
// the engine.
constexpr float thin_skin_m = 0.5f * b2_linearSlop;
constexpr double thickness_min_m = 3 * static_cast<double>(b2_polygonRadius);  // a thinner shape would be mostly skin
constexpr double thin_thickness_min_m = 3 * static_cast<double>(thin_skin_m);  // the same with the thin skin

// The smallest width of a shape over all directions. `hull` is counter-clockwise.
double thickness_of(const Shape& shape, const std::vector<Point>& hull) {
  if (shape.kind == ShapeKind::circle) return 2 * shape.radius;
  if (shape.kind == ShapeKind::box) return 2 * std::min(shape.half_size.x, shape.half_size.y);
  if (shape.kind == ShapeKind::capsule) return 2 * shape.radius;
  double thickness = extent_of(shape);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point& a = hull[i];
    const Point& b = hull[(i + 1) % hull.size()];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    double width = 0;
    for (const Point& p : hull)
      width = std::max(width, ((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / length);
    thickness = std::min(thickness, width);
  }
  return thickness;
}

// Four points around each end of a capsule.
void set_octagon(b2PolygonShape& polygon, const Shape& capsule, const Box2dUnits& units) {
  const Point& a = capsule.vertices[0];
  const Point& b = capsule.vertices[1];
  const double along = std::atan2(b.y - a.y, b.x - a.x);
  b2Vec2 vertices[b2_maxPolygonVertices];
  for (int i = 0; i < b2_maxPolygonVertices; ++i) {
    const Point& end = i < 4 ? b : a;
    const double angle = along + (i < 4 ? 0 : engine::pi) + (i % 4 - 1.5) * engine::pi / 3;
    vertices[i] = units.scaled({end.x + capsule.radius * std::cos(angle), end.y + capsule.radius * std::sin(angle)});
  }
  polygon.Set(vertices, b2_maxPolygonVertices);
}

// Errors: unsupported, for a shape that Box2D 2.4.1 cannot represent.
Status check_known(const Shape& shape, const Box2dOptions& options, const Box2dUnits& units, const std::string& place) {
  const auto refuse = [&](const char* what) {
    return Error{ErrorCode::unsupported, fmt::format("{}: {}", place, what), {}};
  };
  if (shape.kind == ShapeKind::capsule && !options.capsules_as_octagons) return refuse("Box2D 2.4.1 has no capsules");
  if (engine::is_line(shape.kind) && shape.radius > 0) return refuse("Box2D 2.4.1 rounds no lines");
  if (shape.material.rolling_resistance > 0) return refuse("Box2D 2.4.1 has no rolling resistance");
  const engine::Filter& filter = shape.filter;
  const std::uint32_t beyond = filter.mask >> 16;  // "all" and "all but some" set every bit
  if (filter.category > 0xffff || (beyond != 0 && beyond != 0xffff) || filter.group < -0x8000 || filter.group > 0x7fff)
    return refuse("Box2D 2.4.1 has filters of 16 bits");
  for (std::size_t i = shape.kind == ShapeKind::chain && shape.loop ? 0 : 1;
       shape.kind == ShapeKind::chain && i < shape.vertices.size(); ++i) {
    const b2Vec2 a = units.scaled(shape.vertices[i]);
    const b2Vec2 b = units.scaled(shape.vertices[(i + shape.vertices.size() - 1) % shape.vertices.size()]);
    if (b2Distance(a, b) <= 1.01f * b2_linearSlop) return refuse("a chain's edge is too short for Box2D");
  }
  return {};
}

std::vector<Point> hull_of(const Shape& shape) {
  if (shape.kind != ShapeKind::polygon) return {};
  Result<std::vector<Point>> built = engine::build_hull(shape.vertices);
  return built ? std::move(*built) : std::vector<Point>{};
}

}  // namespace

bool is_thin(const engine::Body& description, const Shape& shape, const Box2dUnits& units) {
  const bool has_skin = shape.kind == ShapeKind::box || shape.kind == ShapeKind::polygon;
  return description.type == BodyType::dynamic_body && has_skin && !shape.sensor &&
         thickness_of(shape, hull_of(shape)) * units.scale < thickness_min_m;
}

Status add_box2d_shape(b2Body* body, const engine::Body& description, const Shape& shape, double restitution_threshold,
                       const Box2dOptions& options, const Box2dUnits& units, const std::string& place) {
  b2CircleShape circle;
  b2PolygonShape polygon;
  b2EdgeShape edge;
  b2ChainShape chain;
  if (Status known = check_known(shape, options, units, place); !known) return known;
  b2FixtureDef definition;
  definition.userData.pointer = reinterpret_cast<std::uintptr_t>(&shape);
  definition.isSensor = shape.sensor;
  definition.filter.categoryBits = static_cast<std::uint16_t>(shape.filter.category);
  definition.filter.maskBits = static_cast<std::uint16_t>(shape.filter.mask);
  definition.filter.groupIndex = static_cast<std::int16_t>(shape.filter.group);
  definition.friction = static_cast<float>(shape.material.friction);
  definition.restitution = static_cast<float>(shape.material.restitution);
  definition.restitutionThreshold = static_cast<float>(restitution_threshold * units.scale);

  std::vector<Point> hull;
  if (shape.kind == ShapeKind::polygon) {
    Result<std::vector<Point>> built = engine::build_hull(shape.vertices);
    if (!built) return built.error();
    hull = std::move(*built);
  }
  const bool has_thin_skin = options.match_skin || is_thin(description, shape, units);
  const double thickness = thickness_of(shape, hull) * units.scale;
  if (is_thin(description, shape, units) && thickness < thin_thickness_min_m)
    return Error{ErrorCode::unsupported,
                 fmt::format("{}: too thin for Box2D's skin of {:g} m: found {:g} m, expected at least {:g} m", place,
                             static_cast<double>(thin_skin_m) / units.scale, thickness / units.scale,
                             thin_thickness_min_m / units.scale),
                 {}};
  switch (shape.kind) {
    case ShapeKind::circle:
      circle.m_p = units.scaled(shape.center);
      circle.m_radius = static_cast<float>(shape.radius * units.scale);
      definition.shape = &circle;
      break;
    case ShapeKind::box:
      polygon.SetAsBox(static_cast<float>(shape.half_size.x * units.scale),
                       static_cast<float>(shape.half_size.y * units.scale), units.scaled(shape.center),
                       static_cast<float>(shape.angle));
      definition.shape = &polygon;
      break;
    case ShapeKind::polygon: {
      if (hull.size() > b2_maxPolygonVertices)
        return Error{ErrorCode::unsupported,
                     fmt::format("{}/vertices: too many for Box2D: found {}, expected at most {}", place, hull.size(),
                                 b2_maxPolygonVertices),
                     {}};
      b2Vec2 vertices[b2_maxPolygonVertices];
      for (std::size_t i = 0; i < hull.size(); ++i) vertices[i] = units.scaled(hull[i]);
      // Box2D merges vertices this close. If fewer than three vertices are left, Box2D replaces the polygon by a box.
      const float weld = 0.5f * b2_linearSlop;
      for (std::size_t i = 0; i < hull.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          if (b2Distance(vertices[i], vertices[j]) <= 1.01f * weld)
            return Error{ErrorCode::unsupported,
                         fmt::format("{}/vertices: Box2D would weld two of them: found {:g} m apart, expected over "
                                     "{:g} m",
                                     place, static_cast<double>(b2Distance(vertices[i], vertices[j])) / units.scale,
                                     static_cast<double>(weld) / units.scale),
                         {}};
      polygon.Set(vertices, static_cast<int32>(hull.size()));
      if (polygon.m_count != static_cast<int32>(hull.size()))
        return Error{ErrorCode::unsupported,
                     fmt::format("{}/vertices: Box2D drops some as collinear: found {} left, expected {}", place,
                                 polygon.m_count, hull.size()),
                     {}};
      definition.shape = &polygon;
      break;
    }
    case ShapeKind::capsule:
      set_octagon(polygon, shape, units);
      definition.shape = &polygon;
      break;
    case ShapeKind::segment:
      edge.SetTwoSided(units.scaled(shape.vertices[0]), units.scaled(shape.vertices[1]));
      definition.shape = &edge;
      break;
    case ShapeKind::chain: {
      std::vector<b2Vec2> points;
      for (const Point& p : shape.vertices) points.push_back(units.scaled(p));
      const auto count = static_cast<int32>(points.size());
      const auto last = points.size() - 1;
      if (shape.loop)
        chain.CreateLoop(points.data(), count);
      else  // the ends need neighbours: each end continues straight on
        chain.CreateChain(points.data(), count, 2 * points[0] - points[1], 2 * points[last] - points[last - 1]);
      definition.shape = &chain;
      break;
    }
  }
  const double rounding = shape.kind == ShapeKind::capsule ? 0 : shape.radius;  // an octagon has the full width already
  if ((rounding > 0 || has_thin_skin) && definition.shape == &polygon)
    polygon.m_radius = static_cast<float>(rounding * units.scale) + thin_skin_m;
  body->CreateFixture(&definition);
  return {};
}

}  // namespace ticktrue::tool

#endif
