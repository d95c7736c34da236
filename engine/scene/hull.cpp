// Convex hulls of few points and exact mass properties.
// SPDX-License-Identifier: MIT
// Source: Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979 (monotone chain);
// Steger, "On the calculation of arbitrary moments of polygons", 1996 (area, centroid, inertia by edges). A rounded
// hull is the hull, a rectangle on each edge and a sector at each corner (Steiner, 1840).
#include "engine/scene/hull.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include "base/assert.h"
#include "base/limits.h"
#include "engine/json/number_text.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
namespace {

// Fractions of the extent. Vertices closer than the first fraction are one vertex. The second fraction bounds the
// distance of a corner from the line between its neighbours: smaller corners would not survive rounding to f32 (2^-24
// of the coordinates).
constexpr double duplicate_fraction = 1e-4;
constexpr double corner_fraction = 1e-5;

Point minus(const Point& a, const Point& b) {
  return {a.x - b.x, a.y - b.y};
}
double dot(const Point& a, const Point& b) {
  return a.x * b.x + a.y * b.y;
}
double cross(const Point& a, const Point& b) {
  return a.x * b.y - a.y * b.x;
}
double length(const Point& a) {
  return __builtin_sqrt(dot(a, a));
}

std::string point_text(const Point& p) {
  return "(" + number_text(p.x) + ", " + number_text(p.y) + ")";
}

bool is_lower(const Point& a, const Point& b) {
  return a.y < b.y || (a.y == b.y && a.x < b.x);
}

Error refused_hull(std::string message, std::string hint) {
  return Error{ErrorCode::invalid_scene, std::move(message), std::move(hint)};
}

/// Indices of the strictly convex hull, counter-clockwise from the lowest point.
std::vector<std::size_t> strict_hull(const std::vector<Point>& points) {
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    std::size_t at = i;
    for (; at > 0 && is_lower(points[i], points[order[at - 1]]); --at) order[at] = order[at - 1];
    order[at] = i;
  }
  std::vector<std::size_t> hull;
  const auto add = [&](std::size_t index, std::size_t size_min) {
    while (hull.size() > size_min) {
      const Point& last = points[hull.back()];
      const Point& before = points[hull[hull.size() - 2]];
      if (cross(minus(last, before), minus(points[index], last)) > 0) break;
      hull.pop_back();
    }
    hull.push_back(index);
  };
  for (const std::size_t index : order) add(index, 1);
  const std::size_t up_size = hull.size();
  for (std::size_t i = order.size() - 1; i-- > 0;) add(order[i], up_size);
  hull.pop_back();  // the first vertex again
  return hull;
}

/// Distance of a point from the segment a b.
double distance_to_segment(const Point& p, const Point& a, const Point& b) {
  const Point edge = minus(b, a);
  const double along = dot(minus(p, a), edge);
  if (along <= 0) return length(minus(p, a));
  if (along >= dot(edge, edge)) return length(minus(p, b));
  const double area = cross(edge, minus(p, a));
  return (area < 0 ? -area : area) / length(edge);
}

/// Mass properties from area, first moment and second moment about the origin of a unit-density shape.
struct Moments {
  double area = 0;
  Point center;
  double polar = 0;  // about the centre, m^4
};

Moments polygon_moments(const std::vector<Point>& hull) {
  Moments moments;
  // Relative to a vertex, so that no digits cancel for a polygon far from its body's origin.
  const Point base = hull[0];
  double area_twice = 0;
  Point first;
  for (std::size_t i = 1; i + 1 < hull.size(); ++i) {
    const Point a = minus(hull[i], base);
    const Point b = minus(hull[i + 1], base);
    const double c = cross(a, b);
    area_twice += c;
    first.x += c * (a.x + b.x);
    first.y += c * (a.y + b.y);
  }
  moments.area = area_twice / 2;
  moments.center = {base.x + first.x / (3 * area_twice), base.y + first.y / (3 * area_twice)};
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point a = minus(hull[i], moments.center);
    const Point b = minus(hull[i + 1 == hull.size() ? 0 : i + 1], moments.center);
    moments.polar += cross(a, b) * (dot(a, a) + dot(a, b) + dot(b, b)) / 12;
  }
  return moments;
}

Point unit_normal(const Point& a, const Point& b) {
  const Point edge = minus(b, a);
  const double size = length(edge);
  return {edge.y / size, -edge.x / size};
}

/// The moments of all points within `radius` of a hull of 2 (a capsule) or more vertices. With r the radius, a sector
/// of angle t between normals n and m has area r^2 t / 2. Its first moment is r^3 / 3 right_turn(m - n) and its second
/// moment r^4 t / 4, both about its corner.
Moments rounded_moments(const std::vector<Point>& hull, double radius) {
  struct Part {
    double area;
    Point first;   // about `at`, m^3
    double polar;  // about `at`, m^4
    Point at;
  };
  const std::size_t count = hull.size();
  std::vector<Part> parts;
  if (count > 2) {
    const Moments core = polygon_moments(hull);
    parts.push_back({core.area, {}, core.polar, core.center});
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Point& a = hull[i];
    const Point& b = hull[i + 1 == count ? 0 : i + 1];
    const Point& c = hull[(i + 2) % count];
    const Point n = unit_normal(a, b);
    const Point m = unit_normal(b, c);
    const double edge = length(minus(b, a));
    const double strip = edge * radius;
    const Point middle{(a.x + b.x) / 2 + n.x * radius / 2, (a.y + b.y) / 2 + n.y * radius / 2};
    parts.push_back({strip, {}, strip * (edge * edge + radius * radius) / 12, middle});
    const double angle = count == 2 ? pi : arc_tangent(cross(n, m), dot(n, m));
    const double r2 = radius * radius;
    const double third = r2 * radius / 3;
    parts.push_back({r2 * angle / 2, {third * (m.y - n.y), -third * (m.x - n.x)}, r2 * r2 * angle / 4, b});
  }
  Moments total;
  Point first;  // about hull[0], so that no digits cancel far from the body's origin
  for (const Part& part : parts) {
    const Point offset = minus(part.at, hull[0]);
    total.area += part.area;
    first = {first.x + part.first.x + part.area * offset.x, first.y + part.first.y + part.area * offset.y};
  }
  const Point center{first.x / total.area, first.y / total.area};
  for (const Part& part : parts) {
    const Point offset = minus(minus(part.at, hull[0]), center);
    total.polar += part.polar + 2 * dot(offset, part.first) + part.area * dot(offset, offset);
  }
  total.center = {hull[0].x + center.x, hull[0].y + center.y};
  return total;
}

std::vector<Point> box_corners(const Shape& shape) {
  const SinCos rotation = pose_sin_cos(shape.angle);
  const Point signs[4] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  std::vector<Point> corners;
  for (const Point sign : signs) {
    const double x = sign.x * shape.half_size.x;
    const double y = sign.y * shape.half_size.y;
    corners.push_back(
        {shape.center.x + rotation.cos * x - rotation.sin * y, shape.center.y + rotation.sin * x + rotation.cos * y});
  }
  return corners;
}

MassProperties at_density(const Moments& moments, double density) {
  return {density * moments.area, moments.center, density * moments.polar};
}

// ---- Core and mass by kind ----

std::vector<Point> hull_of(const Shape& shape) {
  Result<std::vector<Point>> hull = build_hull(shape.vertices);
  TICKTRUE_ASSERT(hull.has_value());
  return *std::move(hull);
}

MassProperties rounded_mass(const Shape& shape) {
  return at_density(rounded_moments(core_of(shape), shape.radius), shape.density);
}

MassProperties circle_mass(const Shape& shape) {
  const double mass = shape.density * pi * shape.radius * shape.radius;
  return {mass, shape.center, mass * shape.radius * shape.radius / 2};
}

MassProperties box_mass(const Shape& shape) {
  if (shape.radius > 0) {
    MassProperties result = rounded_mass(shape);
    result.center = shape.center;  // by symmetry, without rounding
    return result;
  }
  const double mass = shape.density * 4 * shape.half_size.x * shape.half_size.y;
  return {mass, shape.center, mass * dot(shape.half_size, shape.half_size) / 3};
}

MassProperties polygon_mass(const Shape& shape) {
  return shape.radius > 0 ? rounded_mass(shape) : at_density(polygon_moments(core_of(shape)), shape.density);
}

MassProperties capsule_mass(const Shape& shape) {
  MassProperties result = rounded_mass(shape);
  result.center = {(shape.vertices[0].x + shape.vertices[1].x) / 2, (shape.vertices[0].y + shape.vertices[1].y) / 2};
  return result;
}

MassProperties no_mass(const Shape&) {
  return {};
}
std::vector<Point> center_of(const Shape& shape) {
  return {shape.center};
}
std::vector<Point> vertices_of(const Shape& shape) {
  return shape.vertices;
}

struct ShapeGeometry {
  ShapeKind kind;
  std::vector<Point> (*core)(const Shape& shape);
  MassProperties (*mass)(const Shape& shape);
};
constexpr std::array<ShapeGeometry, shape_kinds.size()> geometries{{
    {ShapeKind::circle, center_of, circle_mass},
    {ShapeKind::box, box_corners, box_mass},
    {ShapeKind::polygon, hull_of, polygon_mass},
    {ShapeKind::capsule, vertices_of, capsule_mass},
    {ShapeKind::segment, vertices_of, no_mass},
    {ShapeKind::chain, vertices_of, no_mass},
}};
static_assert(rows_are_in_order(geometries));

}  // namespace

std::vector<Point> core_of(const Shape& shape) {
  return info_of(geometries, shape.kind).core(shape);
}

MassProperties shape_mass(const Shape& shape) {
  return info_of(geometries, shape.kind).mass(shape);
}

Result<std::vector<Point>> build_hull(const std::vector<Point>& points) {
  const std::size_t count = points.size();
  if (count < limits::polygon_vertex_count_min || count > limits::polygon_vertex_count_max)
    return refused_hull("wrong number of vertices: found " + std::to_string(count) + ", expected " +
                            std::to_string(limits::polygon_vertex_count_min) + ".." +
                            std::to_string(limits::polygon_vertex_count_max),
                        count < limits::polygon_vertex_count_min ? "a polygon needs an area"
                                                                 : "split it, or give the body several shapes");
  Point lower = points[0], upper = points[0];
  for (std::size_t i = 0; i < count; ++i) {
    const Point& p = points[i];
    if (!(p.x - p.x == 0) || !(p.y - p.y == 0))
      return refused_hull("vertex " + std::to_string(i) + ": must be finite: found " + point_text(p), "");
    lower = {p.x < lower.x ? p.x : lower.x, p.y < lower.y ? p.y : lower.y};
    upper = {p.x > upper.x ? p.x : upper.x, p.y > upper.y ? p.y : upper.y};
  }
  const double width = upper.x - lower.x, height = upper.y - lower.y;
  const double extent = width > height ? width : height;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t j = i + 1; j < count; ++j)
      if (!(length(minus(points[i], points[j])) > duplicate_fraction * extent))
        return refused_hull("vertices " + std::to_string(i) + " and " + std::to_string(j) + " coincide: found " +
                                point_text(points[i]) + " and " + point_text(points[j]) + ", expected more than " +
                                number_text(duplicate_fraction) + " of the polygon's extent between them",
                            "remove one of them");

  const std::vector<std::size_t> hull = strict_hull(points);
  const double corner_min = corner_fraction * extent;
  if (hull.size() < 3)
    return refused_hull("all vertices lie on one line: found no area, expected a convex polygon", "");
  std::vector<bool> is_corner(count, false);
  for (const std::size_t index : hull) is_corner[index] = true;
  for (std::size_t i = 0; i < count; ++i) {
    if (is_corner[i]) continue;
    double distance = extent;
    for (std::size_t k = 0; k < hull.size(); ++k) {
      const double d = distance_to_segment(points[i], points[hull[k]], points[hull[k + 1 == hull.size() ? 0 : k + 1]]);
      if (d < distance) distance = d;
    }
    if (distance <= corner_min)
      return refused_hull("vertex " + std::to_string(i) + " lies on the line between two others: found " +
                              point_text(points[i]) + ", expected a corner",
                          "remove it: the shape stays the same");
    return refused_hull("concave: found vertex " + std::to_string(i) + " " + point_text(points[i]) +
                            " inside the hull of the others, expected a convex polygon",
                        "split it into convex polygons of one body");
  }
  std::vector<Point> corners;
  corners.reserve(count);
  for (std::size_t k = 0; k < count; ++k) {
    const Point& before = points[hull[k == 0 ? count - 1 : k - 1]];
    const Point& after = points[hull[k + 1 == count ? 0 : k + 1]];
    if (!(distance_to_segment(points[hull[k]], before, after) > corner_min))
      return refused_hull("vertex " + std::to_string(hull[k]) + " lies on the line between two others: found " +
                              point_text(points[hull[k]]) + ", expected a corner",
                          "remove it: the shape stays the same");
    corners.push_back(points[hull[k]]);
  }
  return corners;
}

MassProperties body_mass(const Body& body) {
  std::vector<MassProperties> parts;
  parts.reserve(body.shapes.size());
  MassProperties total;
  Point first;
  for (const Shape& shape : body.shapes) {
    const MassProperties part = shape_mass(shape);
    parts.push_back(part);
    total.mass += part.mass;
    first.x += part.mass * part.center.x;
    first.y += part.mass * part.center.y;
  }
  // A single shape keeps its centre: a product and a quotient would round it.
  if (parts.size() == 1)
    total.center = parts[0].center;
  else if (total.mass > 0)
    total.center = {first.x / total.mass, first.y / total.mass};
  for (const MassProperties& part : parts) {
    const Point offset = minus(part.center, total.center);
    total.inertia += part.inertia + part.mass * dot(offset, offset);
  }
  if (body.mass) {
    const double scale = total.mass > 0 ? body.mass->mass / total.mass : 0;
    total.mass = body.mass->mass;
    total.inertia = body.mass->inertia ? *body.mass->inertia : total.inertia * scale;
    if (body.mass->center) total.center = *body.mass->center;
  }
  if (body.type != BodyType::dynamic_body) total.mass = 0;
  if (body.type != BodyType::dynamic_body || body.fixed_rotation) total.inertia = 0;
  return total;
}

}  // namespace ticktrue::engine
