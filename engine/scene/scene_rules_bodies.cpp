// The rules of bodies, prototypes and their shapes.
// SPDX-License-Identifier: MIT
#include "engine/scene/hull.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

bool is_within(const Point& p, double max) {
  return p.x >= -max && p.x <= max && p.y >= -max && p.y <= max;
}

}  // namespace

bool SceneRules::check_bodies(const std::vector<Body>& bodies, const char* list) {
  const bool is_prototype = &bodies == &scene_.prototypes;
  Names names;
  list_ = list;
  for (item_index_ = 0; item_index_ < bodies.size(); ++item_index_) {
    const Body& body = bodies[item_index_];
    if (!check_body(body)) return false;
    if (is_prototype && !check_prototype(body)) return false;
    if (!unique(body.name, names)) return false;
  }
  list_ = nullptr;
  return true;
}

bool SceneRules::check_prototype(const Body& body) {
  if (body.name.empty()) return refuse("name", "a prototype needs a name: found none", "inputs spawn it by its name");
  const Body unset;
  if (body.position != unset.position) return refuse("position", "is the input's to give: found one in a prototype");
  if (body.angle != 0) return refuse("angle", "is the input's to give: found one in a prototype");
  if (body.velocity != unset.velocity) return refuse("velocity", "is the input's to give: found one in a prototype");
  if (body.angular_velocity != 0) return refuse("angular_velocity", "is the input's to give: found one in a prototype");
  return true;
}

bool SceneRules::check_body(const Body& body) {
  if (!check_fields(body)) return false;
  if (body.type == BodyType::static_body) {
    if (body.velocity != Point{})
      return refuse("velocity", "a static body never moves: found one", "make it kinematic");
    if (body.angular_velocity != 0)
      return refuse("angular_velocity", "a static body never moves: found one", "make it kinematic");
  }
  if (body.mass && !check_mass(body)) return false;

  if (body.shapes.empty()) return refuse("shapes", "a body needs a shape: found none, expected at least one");
  if (body.shapes.size() > limits::shape_count_per_body_max)
    return fail(ErrorCode::limit, "shapes",
                "too many: found " + std::to_string(body.shapes.size()) + ", expected at most " +
                    std::to_string(limits::shape_count_per_body_max),
                "spread them over several bodies");
  for (shape_index_ = 0; shape_index_ < body.shapes.size(); ++shape_index_)
    if (!check_shape(body.shapes[shape_index_])) return false;
  shape_index_ = no_shape;
  std::size_t child_count = 0;
  for (const Shape& shape : body.shapes)
    child_count += shape.kind == ShapeKind::chain ? shape.vertices.size() - (shape.loop ? 0 : 1) : 1;
  if (child_count > limits::child_count_per_body_max)
    return fail(ErrorCode::limit, "shapes",
                "too many, with every edge of a chain: found " + std::to_string(child_count) + ", expected at most " +
                    std::to_string(limits::child_count_per_body_max),
                "spread them over several bodies");
  return body.type != BodyType::dynamic_body || check_resulting_mass(body);
}

bool SceneRules::check_mass(const Body& body) {
  if (body.type != BodyType::dynamic_body)
    return refuse("mass",
                  "only dynamic bodies have a mass: found " + number_text(body.mass->mass) + " kg of a " +
                      std::string(info_of(body_types, body.type).name) + " body",
                  "leave it out, or make the body dynamic");
  return check_fields(*body.mass);
}

bool SceneRules::check_resulting_mass(const Body& body) {
  bool some_area = false;
  for (const Shape& shape : body.shapes) some_area = some_area || !is_line(shape.kind);
  if (!some_area) {
    constexpr const char* hint =
        "segments and chains bring no mass: state \"mass\" and \"inertia\", or make the body static";
    if (!body.mass) return refuse("mass", "missing: found shapes without area only, expected a stated mass", hint);
    if (!body.mass->inertia && !body.fixed_rotation)
      return refuse("inertia", "missing: found shapes without area only, expected a stated inertia", hint);
    return true;
  }
  const MassProperties mass = body_mass(body);
  if (!(mass.mass >= limits::mass_min_kg && mass.mass <= limits::mass_max_kg))
    return refuse("",
                  "mass of its shapes out of range: found " + number_text(mass.mass) + " kg, expected " +
                      number_text(limits::mass_min_kg) + ".." + number_text(limits::mass_max_kg),
                  "change density or size, or state the mass");
  if (!body.fixed_rotation && !(mass.inertia >= ranges::inertia.min && mass.inertia <= ranges::inertia.max))
    return refuse("",
                  "inertia out of range: found " + number_text(mass.inertia) + " kg m^2, expected " +
                      number_text(ranges::inertia.min) + ".." + number_text(ranges::inertia.max),
                  "change density or size, state the inertia, or fix the rotation");
  return true;
}

bool SceneRules::check_shape(const Shape& shape) {
  if (!row("type", shape_kinds, shape.kind)) return false;
  const ShapeKindInfo& kind = info_of(shape_kinds, shape.kind);
  const bool has_good_numbers = check_own_fields(
      shape, kind, "a ", "", [this](const auto& field, std::string_view key, const auto& value, FieldRange range) {
        return check_value(key, value, range, field.hint);
      });
  if (!has_good_numbers) return false;
  if (shape.kind == ShapeKind::polygon && !check_polygon(shape)) return false;
  if (key_of(kind, ShapeField::vertices) == "points" && !check_points(shape)) return false;
  return check_fields(shape);
}

bool SceneRules::check_points(const Shape& shape) {
  const std::size_t count = shape.vertices.size();
  const std::string found = "wrong number of points: found " + std::to_string(count) + ", expected ";
  if (shape.kind != ShapeKind::chain && count != 2) return refuse("points", found + "2");
  if (count > limits::chain_vertex_count_max)
    return fail(ErrorCode::limit, "points", found + "at most " + std::to_string(limits::chain_vertex_count_max),
                "make several chains of it");
  const std::size_t min = shape.loop ? 3 : 2;
  if (count < min)
    return refuse("points", found + "at least " + std::to_string(min) + (shape.loop ? " of a loop" : ""));
  for (std::size_t i = 0; i < count; ++i)
    if (const Point& p = shape.vertices[i]; !is_within(p, limits::size_max_m)) {
      const std::string key = "points[" + std::to_string(i) + "]";
      return point(key, p, ranges::anchor);
    }
  const std::size_t edge_count = shape.loop ? count : count - 1;
  for (std::size_t i = 0; i < edge_count; ++i) {
    const std::size_t next = i + 1 == count ? 0 : i + 1;
    const double x = shape.vertices[next].x - shape.vertices[i].x;
    const double y = shape.vertices[next].y - shape.vertices[i].y;
    if (x * x + y * y >= limits::size_min_m * limits::size_min_m) continue;
    return refuse("points",
                  "points " + std::to_string(i) + " and " + std::to_string(next) + " coincide: found less than " +
                      number_text(limits::size_min_m) + " m between them",
                  shape.loop && next == 0 ? "a loop closes itself: leave the repeated point out" : "");
  }
  return true;
}

bool SceneRules::check_polygon(const Shape& shape) {
  for (std::size_t i = 0; i < shape.vertices.size() && i < limits::polygon_vertex_count_max; ++i) {
    const std::string key = "vertices[" + std::to_string(i) + "]";
    if (!point(key, shape.vertices[i], ranges::anchor)) return false;
  }
  const Result<std::vector<Point>> hull = build_hull(shape.vertices);
  if (!hull) return refuse("vertices", hull.error().message, hull.error().hint);
  // The hull starts at its lowest point, so two passes give the extent.
  Point lower = (*hull)[0], upper = (*hull)[0];
  for (const Point& p : *hull) {
    lower.x = p.x < lower.x ? p.x : lower.x;
    upper = {p.x > upper.x ? p.x : upper.x, p.y > upper.y ? p.y : upper.y};
  }
  const double extent = upper.x - lower.x > upper.y - lower.y ? upper.x - lower.x : upper.y - lower.y;
  return extent >= limits::size_min_m ||
         refuse("vertices", "too small: found an extent of " + number_text(extent) + " m, expected at least " +
                                number_text(limits::size_min_m));
}

}  // namespace ticktrue::engine
