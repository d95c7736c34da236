// Bodies, terrain and prototypes of random worlds.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/world_builder.h"

#include "engine/builtin_scenes/pieces.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

void widen(Point& lower, Point& upper, Point p) {
  lower = {p.x < lower.x ? p.x : lower.x, p.y < lower.y ? p.y : lower.y};
  upper = {p.x > upper.x ? p.x : upper.x, p.y > upper.y ? p.y : upper.y};
}

void move_shape(Shape& shape, Point by) {
  shape.center = {shape.center.x + by.x, shape.center.y + by.y};
  if (shape.vertices.empty()) return;
  shape.center = {};
  for (Point& p : shape.vertices) p = {p.x + by.x, p.y + by.y};
}

/// Clears the mask and the group, so that the shape touches nothing.
void isolate(Filter& filter) {
  filter.mask = 0;
  if (filter.group > 0) filter.group = -filter.group;
}

}  // namespace

WorldBuilder::WorldBuilder(Draw& draw_, const WorldPlan& plan_) : draw(draw_), plan(plan_) {
  scene.name = "random";
  scene.settings = plan.settings;
  scene.gravity = plan.gravity;
  size = draw.chance(70) ? 1 : draw.one_of({0.125, 0.25, 0.5, 0.75, 2, 8});
  all_alike_ = draw.chance(30);
}

void WorldBuilder::build() {
  if (draw.chance(has_gravity() ? 85 : plan.is_quiet ? 15 : 40)) add_terrain();
  double left = 0, right = 0;
  for (int part = 0; !is_full(); ++part) {
    const auto room = static_cast<std::uint32_t>(plan.body_count - scene.bodies.size());
    const std::uint32_t count = room <= 3 || draw.chance(30) ? room : 1 + draw.below(room);
    const double gap = size * draw.one_of({0, 0.015625, 0.125, 0.5, 1, 4});
    const double before = right;
    const bool is_quiet = part == 0 && room >= 4 && plan.is_quiet;
    right += gap +
             (is_quiet ? add_quiet_corner(*this, {right + gap, 0}, draw.chance(75) ? room : room - draw.below(room / 4))
                       : add_arrangement(*this, {right + gap, 0}, count));
    if (draw.half()) continue;
    // Moves the added bodies to the left instead, mirrored at a coordinate below zero.
    left -= right - before;
    for (Body& body : scene.bodies)
      if (body.type != BodyType::static_body && body.position.x >= before) body.position.x += left - before;
    right = before;
  }
  add_structures();
  add_prototypes();
  finish();
}

Material WorldBuilder::draw_material() {
  Material material;
  if (draw.half()) material.friction = draw.one_of({0.125, 0.25, 0.5, 1, 4});
  // The thesis' friction has no Coulomb bound: larger friction would gain energy without end.
  if (plan.is_plain() && material.friction > 0.5) material.friction = 0.5;
  if (plan.has(WorldFeature::frictionless) && draw.half()) material.friction = 0;
  if (plan.has(WorldFeature::restitution) && draw.half()) material.restitution = draw.one_of({0.25, 0.5, 0.75, 1});
  if (plan.has(WorldFeature::tangent_speed) && draw.chance(40)) material.tangent_speed = draw.part(-16, 16, 8);
  if (plan.has(WorldFeature::rolling_resistance) && draw.chance(40))
    material.rolling_resistance = draw.one_of({0.0625, 0.25, 1});
  return material;
}

Filter WorldBuilder::draw_filter() {
  Filter filter;
  if (plan.has(WorldFeature::category_filters) && draw.chance(50)) {
    filter.category = 1u << draw.below(3);
    filter.mask = draw.half() ? 0xffffffff : 7u - (1u << draw.below(3));
  }
  if (plan.has(WorldFeature::group_filters) && draw.chance(70))
    filter.group = draw.chance(70) ? -1 : draw.between(-2, 2);
  return filter;
}

Shape WorldBuilder::draw_shape(double shape_size) {
  const ShapeKind kind = draw.any(plan.shapes);
  Shape shape = make_shape(draw, kind, shape_size);
  if (plan.has(WorldFeature::rounded_shapes) && (kind == ShapeKind::box || kind == ShapeKind::polygon) && draw.half())
    shape.radius = shape_size / 16;
  if (kind == ShapeKind::box && draw.chance(10)) shape.angle = draw.half() ? pi / 4 : pi / 2;
  if (plan.has(WorldFeature::densities) && draw.half()) shape.density = draw.one_of({0.25, 0.5, 2, 4, 16});
  shape.material = draw_material();
  shape.filter = draw_filter();
  shape.sensor = plan.has(WorldFeature::sensors) && draw.chance(20);
  if (!plan.collides) isolate(shape.filter);
  return shape;
}

Body WorldBuilder::draw_body(BodyType type, double body_size) {
  Body result;
  result.type = type;
  if (!all_alike_) {
    result.shapes.push_back(draw_shape(body_size));
  } else {
    if (!shape_) shape_ = draw_shape(1);
    Shape shape = *shape_;
    shape.radius *= body_size;
    for (Point* p : {&shape.center, &shape.half_size}) *p = {p->x * body_size, p->y * body_size};
    for (Point& p : shape.vertices) p = {p.x * body_size, p.y * body_size};
    result.shapes.push_back(shape);
  }
  if (plan.has(WorldFeature::several_shapes) && draw.chance(40)) {
    Shape second = draw_shape(body_size / 2);
    move_shape(second, {body_size / 4 * draw.between(-2, 2), draw.half() ? 0 : body_size / 2});
    result.shapes.push_back(second);
  }
  if (type == BodyType::dynamic_body) decorate(result);
  return result;
}

void WorldBuilder::decorate(Body& body) {
  const auto wants = [&](WorldFeature feature) { return plan.has(feature) && draw.chance(35); };
  body.bullet = wants(WorldFeature::bullets);
  body.fixed_rotation = wants(WorldFeature::fixed_rotation);
  body.can_sleep = !wants(WorldFeature::never_sleeps);
  if (wants(WorldFeature::gravity_scale)) body.gravity_scale = draw.one_of({0, 0, -1, 0.5, 2});
  if (wants(WorldFeature::linear_damping)) body.linear_damping = draw.one_of({0.0625, 0.5, 2, 16});
  if (wants(WorldFeature::angular_damping)) body.angular_damping = draw.one_of({0.0625, 0.5, 2, 16});
  bool some_area = false;
  double area = 0;  // kg at the shapes' densities
  for (const Shape& shape : body.shapes) {
    some_area = some_area || !is_line(shape.kind);
    area += shape_mass(shape).mass;
  }
  if (!some_area) {
    const Point reach = body.shapes[0].vertices[0];
    const double square = reach.x * reach.x + reach.y * reach.y;
    body.mass = ExplicitMass{square, square * square, {}};
  } else if (wants(WorldFeature::explicit_mass)) {
    body.mass = ExplicitMass{area * draw.one_of({0.5, 1, 2, 8}), {}, {}};
    const MassProperties own = body_mass(body);
    if (draw.chance(30) && own.inertia > 0) body.mass->inertia = own.inertia * draw.one_of({0.5, 2, 4});
    if (draw.chance(30)) body.mass->center = Point{own.center.x + size / 16, own.center.y - size / 16};
  }
}

void WorldBuilder::push(Body body, const Placement& placement) {
  body.position = placement.position;
  body.angle = placement.angle;
  if (body.type != BodyType::static_body) {
    const double factor = body.bullet && draw.half() ? 16 : 1;  // a slow bullet passes nothing anyway
    body.velocity = {factor * placement.velocity.x, factor * placement.velocity.y};
    body.angular_velocity = placement.angular_velocity;
  }
  if (plan.has(WorldFeature::quarter_turns) && body.angle == 0 && draw.chance(30))
    body.angle = draw.one_of({pi / 2, -pi / 2, pi});
  widen(lower, upper, body.position);
  scene.bodies.push_back(std::move(body));
}

void WorldBuilder::add(const Placement& placement, double body_size) {
  if (!is_full()) push(draw_body(BodyType::dynamic_body, body_size), placement);
}

void WorldBuilder::add_exact(const Placement& placement, double body_size, ShapeKind kind) {
  if (is_full()) return;
  Body body = draw_body(BodyType::dynamic_body, body_size);
  const Shape drawn = body.shapes[0];
  Shape shape = kind == ShapeKind::box ? box(body_size / 2, body_size / 2) : circle(body_size / 2);
  shape.density = drawn.density;
  shape.material = drawn.material;
  shape.filter = drawn.filter;
  shape.sensor = drawn.sensor;
  body.shapes = {shape};
  push(std::move(body), placement);
}

ShapeKind WorldBuilder::draw_exact_kind() {
  std::vector<ShapeKind> kinds;
  for (const ShapeKind kind : plan.shapes)
    if (kind == ShapeKind::circle || kind == ShapeKind::box) kinds.push_back(kind);
  return kinds.empty() ? ShapeKind::circle : draw.any(kinds);
}

void WorldBuilder::add_kinematic(const Placement& placement, double body_size) {
  if (!is_full()) push(draw_body(BodyType::kinematic_body, body_size), placement);
}

void WorldBuilder::add_static(Point position, Shape shape) {
  if (is_full()) return;
  shape.material = draw_material();
  shape.filter = draw_filter();
  shape.sensor = plan.has(WorldFeature::sensors) && draw.chance(10);
  if (!plan.collides) isolate(shape.filter);
  Body body;
  body.type = BodyType::static_body;
  body.shapes.push_back(std::move(shape));
  push(std::move(body), {position, 0, {}, 0});
}

/// Adds a floor whose top is at y = 0 (a box, or a line if the plan has lines), and perhaps walls.
void WorldBuilder::add_terrain() {
  const double half = size * (plan.body_count < 64 ? 64 : 512);
  std::vector<ShapeKind> lines;
  for (const ShapeKind kind : plan.shapes)
    if (is_line(kind)) lines.push_back(kind);
  if (!lines.empty() && draw.chance(70)) {
    if (draw.any(lines) == ShapeKind::chain) {
      std::vector<Point> points;
      for (int i = 16; i >= -16; --i)
        points.push_back({half * i / 16, draw.chance(70) ? 0 : size * draw.part(-4, 0, 16)});
      add_static({}, line(ShapeKind::chain, points));
    } else {
      add_static({}, line(ShapeKind::segment, {{-half, 0}, {half, 0}}));
    }
  } else {
    const double depth = size * draw.one_of({0.5, 1, 4});
    add_static({0, -depth}, box(half, depth));
  }
  if (plan.body_count > 6 && draw.chance(35)) {
    const double x = size * draw.between(4, 24);
    add_static({-x, x}, box(size / 2, x));
    add_static({x, x}, box(size / 2, x));
  }
}

void WorldBuilder::add_prototypes() {
  bool spawns = false;
  for (const InputKind kind : plan.inputs) spawns = spawns || info_of(input_kinds, kind).may_make_body;
  if (!spawns) return;
  const int count = draw.between(1, 3);
  for (int i = 0; i < count; ++i) {
    const bool is_kinematic = draw.chance(10);
    Body prototype = draw_body(is_kinematic ? BodyType::kinematic_body : BodyType::dynamic_body, size);
    prototype.name = "prototype_" + std::to_string(i);
    scene.prototypes.push_back(std::move(prototype));
  }
}

/// Sets the bounds, the largest number of spawned bodies, and the place of the whole world.
void WorldBuilder::finish() {
  if (plan.has(WorldFeature::spawned_max) && !scene.prototypes.empty())
    scene.spawned_max = static_cast<std::uint32_t>(draw.between(1, 4));
  Point move;
  if (plan.has(WorldFeature::far_from_origin))
    move = {draw.one_of({-16384, 8192, 65536}), draw.one_of({0, -8192, 4096})};
  else if (draw.chance(30))
    move = {size * draw.between(-40, 40), size * draw.between(-40, 40)};
  for (Body& body : scene.bodies) body.position = {body.position.x + move.x, body.position.y + move.y};
  lower = {lower.x + move.x, lower.y + move.y};
  upper = {upper.x + move.x, upper.y + move.y};
  if (plan.has(WorldFeature::bounds)) {
    const double around = size * draw.one_of({1, 2, 8, 32});
    scene.bounds = Bounds{{lower.x - around, lower.y - around}, {upper.x + around, upper.y + around}};
  }
}

}  // namespace ticktrue::engine
