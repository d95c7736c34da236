// Small scenes that the studies build: parts, stacks, chains, pendulums.
// SPDX-License-Identifier: MIT
#include "tool/study/worlds.h"

#include <cmath>
#include <utility>

#include "engine/math/trig.h"

namespace ticktrue::worlds {

using engine::Body;
using engine::BodyType;
using engine::Joint;
using engine::JointKind;
using engine::Point;
using engine::Precision;
using engine::Scene;
using engine::Shape;
using engine::ShapeKind;

Shape box(double half_width, double half_height) {
  Shape shape;
  shape.kind = ShapeKind::box;
  shape.half_size = {half_width, half_height};
  return shape;
}

Shape disc(double radius) {
  Shape shape;
  shape.kind = ShapeKind::circle;
  shape.radius = radius;
  return shape;
}

Shape polygon(std::vector<Point> vertices) {
  Shape shape;
  shape.kind = ShapeKind::polygon;
  shape.vertices = std::move(vertices);
  return shape;
}

Shape regular(int corner_count, double radius) {
  std::vector<Point> vertices;
  const double step = 2 * engine::pi / corner_count;
  for (int i = 0; i < corner_count; ++i) {
    const engine::SinCos at = engine::sin_cos(-engine::pi / 2 + step / 2 + i * step);
    vertices.push_back({radius * at.cos, radius * at.sin});
  }
  return polygon(std::move(vertices));
}

double apothem(int corner_count, double radius) {
  return radius * engine::sin_cos(engine::pi / corner_count).cos;
}

Body body(Shape shape, Point position, BodyType type) {
  Body out;
  out.type = type;
  out.position = position;
  out.shapes.push_back(std::move(shape));
  return out;
}

Body weighted(Shape shape, Point position, double mass, double inertia) {
  Body out = body(std::move(shape), position);
  out.mass.emplace();
  out.mass->mass = mass;
  if (inertia > 0) out.mass->inertia = inertia;
  return out;
}

Body ground() {
  return body(box(100, 0.5), {0, -0.5}, BodyType::static_body);
}

Body peg(Point position) {
  return body(disc(0.05), position, BodyType::static_body);
}

Scene empty(Precision precision) {
  Scene scene;
  scene.settings.precision = precision;
  return scene;
}

Scene flight(Precision precision, Point position, Point velocity) {
  Scene scene = empty(precision);
  scene.settings.solver = engine::SolverKind::free_flight;
  scene.settings.substeps = 1;
  scene.gravity = {0, 0};
  scene.bodies = {weighted(disc(0.1), position, 1)};
  scene.bodies[0].velocity = velocity;
  return scene;
}

void set_material(Scene& scene, double friction, double restitution) {
  for (Body& each : scene.bodies)
    for (Shape& shape : each.shapes) {
      shape.material.friction = friction;
      shape.material.restitution = restitution;
    }
}

void touch_nothing(Scene& scene) {
  for (Body& each : scene.bodies)
    for (Shape& shape : each.shapes) shape.filter.group = -1;
}

void set_bounces(Scene& scene, double restitution) {
  scene.settings.locate_impacts = true;
  scene.settings.restitution_threshold = 0;
  set_material(scene, 0, restitution);
}

void lean(Scene& scene, double degrees) {
  const engine::SinCos turn = engine::sin_cos(degrees * engine::pi / 180);
  scene.gravity = {10 * turn.sin, -10 * turn.cos};
}

Joint joint(JointKind kind, std::uint32_t body_a, std::uint32_t body_b, Point anchor_a, Point anchor_b) {
  Joint out;
  out.kind = kind;
  out.body_a = body_a;
  out.body_b = body_b;
  out.anchor_a = anchor_a;
  out.anchor_b = anchor_b;
  return out;
}

Joint gear(std::uint32_t joint_a, std::uint32_t joint_b, double ratio) {
  Joint out;
  out.kind = JointKind::gear;
  out.joint_a = joint_a;
  out.joint_b = joint_b;
  out.ratio = ratio;
  return out;
}

Scene stack(Precision precision, int count, double size, double jitter) {
  Scene scene = empty(precision);
  scene.name = "stack";
  scene.bodies.push_back(ground());
  if (size > 10) {  // the ground is wider than the bodies on it
    scene.bodies[0].shapes[0].half_size = {100 * size, size};
    scene.bodies[0].position = {0, -size};
  }
  for (int i = 0; i < count; ++i)
    scene.bodies.push_back(body(box(size / 2, size / 2), {i % 2 == 0 ? -jitter : jitter, size * (i + 0.5)}));
  return scene;
}

Scene chain(Precision precision, int links, Point direction, double end_mass) {
  Scene scene = empty(precision);
  scene.name = "chain";
  scene.bodies.push_back(peg({0, 0}));
  for (int i = 0; i < links; ++i) {
    Body link =
        weighted(box(0.5, 0.1), {direction.x * (i + 0.5), direction.y * (i + 0.5)}, i + 1 == links ? end_mass : 1);
    link.angle = engine::arc_tangent(direction.y, direction.x);
    scene.bodies.push_back(std::move(link));
    scene.joints.push_back(joint(JointKind::revolute, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i) + 1,
                                 i == 0 ? Point{0, 0} : Point{0.5, 0}, {-0.5, 0}));
  }
  return scene;
}

Scene catenary(Precision precision) {
  constexpr int link_count = 20;
  constexpr double half_link = 0.3;
  const double c = 5.0 / 6;
  const double s = std::sqrt(1 - c * c);
  Scene scene = empty(precision);
  scene.name = "hanging_chain";
  scene.bodies.push_back(peg({0, 0}));
  for (int i = 0; i < link_count; ++i) {
    const bool falls = i < link_count / 2;
    const double along = half_link * (2 * i + 1);
    Body link = weighted(box(half_link, 0.05), {c * along, -s * (falls ? along : 12 - along)}, 1);
    link.angle = (falls ? -1 : 1) * engine::arc_tangent(s, c);
    link.linear_damping = 1;
    link.angular_damping = 1;
    scene.bodies.push_back(std::move(link));
  }
  scene.bodies.push_back(peg({10, 0}));
  for (int i = 0; i <= link_count; ++i)
    scene.joints.push_back(joint(JointKind::revolute, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i) + 1,
                                 i > 0 ? Point{half_link, 0} : Point{},
                                 i < link_count ? Point{-half_link, 0} : Point{}));
  return scene;
}

}  // namespace ticktrue::worlds
