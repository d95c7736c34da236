// Small scenes that tests build inline.
// SPDX-License-Identifier: MIT
#pragma once

#include <utility>
#include <vector>

#include "engine/scene/scene.h"

namespace ticktrue::test {

using engine::Body;
using engine::BodyType;
using engine::Point;
using engine::Precision;
using engine::Scene;
using engine::Shape;
using engine::ShapeKind;
using engine::SolverKind;

inline Shape box_shape(double half_width, double half_height) {
  Shape shape;
  shape.kind = ShapeKind::box;
  shape.half_size = {half_width, half_height};
  return shape;
}

inline Shape disc_shape(double radius) {
  Shape shape;
  shape.kind = ShapeKind::circle;
  shape.radius = radius;
  return shape;
}

inline Shape polygon_shape(std::vector<Point> vertices) {
  Shape shape;
  shape.kind = ShapeKind::polygon;
  shape.vertices = std::move(vertices);
  return shape;
}

inline Shape capsule_shape(Point a, Point b, double radius) {
  Shape shape;
  shape.kind = ShapeKind::capsule;
  shape.vertices = {a, b};
  shape.radius = radius;
  return shape;
}

inline Shape segment_shape(Point a, Point b) {
  Shape shape;
  shape.kind = ShapeKind::segment;
  shape.vertices = {a, b};
  return shape;
}

inline Shape chain_shape(std::vector<Point> points) {
  Shape shape;
  shape.kind = ShapeKind::chain;
  shape.vertices = std::move(points);
  return shape;
}

inline Body body_of(Shape shape, Point position, BodyType type = BodyType::dynamic_body) {
  Body body;
  body.type = type;
  body.position = position;
  body.shapes.push_back(std::move(shape));
  return body;
}

/// A body of 1 m by 1 m and 1 kg.
inline Body unit_box(Point position) {
  return body_of(box_shape(0.5, 0.5), position);
}

/// A static box whose top is the line y = 0.
inline Body ground(double half_width = 100) {
  return body_of(box_shape(half_width, 1), {0, -1}, BodyType::static_body);
}

/// A scene without bodies: f64 by default, gravity (0, -10), no damping.
inline Scene empty_scene(Precision precision = Precision::f64) {
  Scene scene;
  scene.settings.precision = precision;
  return scene;
}

/// A scene for one body in the air: no collisions, one substep.
inline Scene flight_scene(Precision precision, Body body) {
  Scene scene = empty_scene(precision);
  scene.settings.solver = SolverKind::free_flight;
  scene.settings.substeps = 1;
  scene.bodies.push_back(std::move(body));
  return scene;
}

/// `count` unit boxes on top of each other on the ground. The ground is body 0; boxes 1..count follow from the bottom.
inline Scene stack_scene(int count, double gap = 0, Precision precision = Precision::f64) {
  Scene scene = empty_scene(precision);
  scene.name = "stack";
  scene.bodies.push_back(ground());
  for (int i = 0; i < count; ++i) scene.bodies.push_back(unit_box({0, 0.5 + i + gap * (i + 1)}));
  return scene;
}

/// Rows of `base`, base - 1, ... 1 unit boxes, touching, on the ground.
inline Scene pyramid_scene(int base, Precision precision = Precision::f64) {
  Scene scene = empty_scene(precision);
  scene.name = "pyramid";
  scene.bodies.push_back(ground());
  for (int row = 0; row < base; ++row)
    for (int i = 0; i + row < base; ++i)
      scene.bodies.push_back(unit_box({i + 0.5 * row - 0.5 * (base - 1), 0.5 + row}));
  return scene;
}

/// A box of 1 m by 1 m that slides along the ground with `speed` and `friction`.
inline Scene slide_scene(double speed, double friction, Precision precision = Precision::f64) {
  Scene scene = empty_scene(precision);
  scene.name = "slide";
  scene.bodies.push_back(ground());
  scene.bodies.push_back(unit_box({0, 0.5}));
  scene.bodies[1].velocity = {speed, 0};
  for (Body& body : scene.bodies) body.shapes[0].material.friction = friction;
  return scene;
}

/// A scene in which every field differs from its default, as far as the rules allow.
inline Scene everything_scene() {
  using engine::AutoSubsteps, engine::Bounds, engine::BroadPhaseKind, engine::ClockKind, engine::ClockSettings,
      engine::ExplicitMass, engine::Force, engine::force_kinds, engine::ForceKind, engine::input_kinds,
      engine::InputInfo, engine::Joint, engine::joint_kinds, engine::JointKind, engine::JointMotor,
      engine::JointSolverKind, engine::JointSpring, engine::MixRule, engine::PointerSettings, engine::Range,
      engine::Settings, engine::SleepSettings;
  Scene scene;
  scene.name = "all \"quoted\" \\ \xc3\xa4";
  Settings& settings = scene.settings;
  settings.dt = 1.0 / 3;
  settings.substeps = 2;
  settings.auto_substeps = AutoSubsteps{0.01, 64};
  settings.iterations = 7;
  settings.broad_phase = BroadPhaseKind::brute_force;
  settings.friction_mix = MixRule::minimum;
  settings.restitution_mix = MixRule::average;
  settings.restitution_threshold = 0.1 + 0.2;
  settings.locate_impacts = true;
  settings.continuous = false;
  settings.sleep = SleepSettings{0.25, 0.1};
  settings.events = true;
  settings.clock = ClockSettings{ClockKind::adaptive, 5, 1e-5, 1e-7, 0.2};
  settings.joints = JointSolverKind::direct;
  scene.gravity = {1, -9.81};

  Body odd;
  odd.name = "odd";
  odd.position = {-0.0, 5e-324};
  odd.angle = -0.0;
  odd.velocity = {1e-300, -1.2345678901234567};
  odd.angular_velocity = 1.0 / 7;
  odd.linear_damping = 0.25;
  odd.angular_damping = 0.125;
  odd.gravity_scale = -2;
  odd.fixed_rotation = true;
  odd.bullet = true;
  odd.can_sleep = false;
  odd.mass = ExplicitMass{2.5, 3.5, Point{0, -0.0}};
  Shape circle = disc_shape(0.3);
  circle.center = {0, -0.0};
  circle.density = 7;
  Shape box = box_shape(1, 2);
  box.angle = 0.7;
  box.radius = 0.125;
  box.material = {0, 1, -2.5, 0.01};
  Shape polygon = polygon_shape({{0, 0}, {1, 0}, {0, 1}});
  polygon.radius = 0.0625;
  polygon.filter = {0x80000000u, 0x7fffffffu, -2147483647 - 1};
  Shape capsule;
  capsule.kind = ShapeKind::capsule;
  capsule.vertices = {{-1, 0}, {1, 0.5}};
  capsule.radius = 0.25;
  capsule.sensor = true;
  Shape segment;
  segment.kind = ShapeKind::segment;
  segment.vertices = {{-1, 0}, {1, -0.0}};
  Shape chain;
  chain.kind = ShapeKind::chain;
  chain.vertices = {{-9, 0}, {9, 0}, {0, 5}};
  chain.loop = true;
  odd.shapes = {circle, box, polygon, capsule, segment, chain};
  scene.bodies = {odd, ground(), unit_box({3, 0}), unit_box({0, 3})};
  scene.bodies[1].name = "ground";
  scene.bodies[3].name = "cart";

  for (const auto& row : joint_kinds) {
    Joint& joint = scene.joints.emplace_back();
    joint.kind = row.kind;
    joint.name = "the " + std::string(row.name);
    if (row.kind == JointKind::gear) {
      joint.joint_a = 0;
      joint.joint_b = 1;
      joint.ratio = -3;
      joint.collide_connected = true;
      continue;
    }
    if (row.kind != JointKind::target) {
      joint.body_a = 1;
      joint.collide_connected = true;
    }
    joint.body_b = row.kind == JointKind::prismatic ? 3 : 2;
  }
  const auto joint = [&](JointKind kind) -> Joint& { return scene.joints[static_cast<std::size_t>(kind)]; };
  for (const JointKind kind :
       {JointKind::revolute, JointKind::prismatic, JointKind::distance, JointKind::weld, JointKind::wheel}) {
    joint(kind).anchor_a = {0.1, -0.0};
    joint(kind).anchor_b = {-0.0, 0.3};
    joint(kind).spring = JointSpring{false, 3, 0.7, 0, 0};
    if (kind == JointKind::weld) continue;
    joint(kind).limits = Range{0, 0.75};
    joint(kind).motor = JointMotor{-4, 5};
  }
  for (const JointKind kind : {JointKind::revolute, JointKind::prismatic, JointKind::weld})
    joint(kind).reference_angle = 0.1;
  for (const JointKind kind : {JointKind::prismatic, JointKind::wheel}) joint(kind).axis = {-0.0, 3};
  for (const JointKind kind : {JointKind::motor, JointKind::friction, JointKind::target}) joint(kind).force_max = 8;
  for (const JointKind kind : {JointKind::motor, JointKind::friction}) joint(kind).torque_max = 9;
  for (const JointKind kind : {JointKind::motor, JointKind::target}) {
    joint(kind).offset = {6, 7};
    joint(kind).spring = JointSpring{false, 0, 1, 0, 0};
  }
  joint(JointKind::distance).length = 0.5;
  joint(JointKind::weld).linear_spring = JointSpring{true, 0, 0, 20, 0.5};
  joint(JointKind::motor).angle_offset = 0.2;
  joint(JointKind::target).anchor_b = {0.25, 0};
  joint(JointKind::pulley).anchor_a = {-0.0, 0.4};
  joint(JointKind::pulley).anchor_b = {0.2, 0};
  joint(JointKind::pulley).ground_anchor_a = {-0.0, 4};
  joint(JointKind::pulley).ground_anchor_b = {2, 5};
  joint(JointKind::pulley).length = 9;
  joint(JointKind::pulley).ratio = 2;

  for (const auto& row : force_kinds) {
    Force& force = scene.forces.emplace_back();
    force.kind = row.kind;
    force.name = row.name;
    if (row.kind != ForceKind::wind) force.body = 3;
  }
  const auto force = [&](ForceKind kind) -> Force& { return scene.forces[static_cast<std::size_t>(kind)]; };
  force(ForceKind::constant).vector = {1, -0.0};
  force(ForceKind::constant).torque = -2;
  force(ForceKind::central).point = {3, 4};
  force(ForceKind::central).coefficient = -5;
  force(ForceKind::central).exponent = 1;
  force(ForceKind::spring).other = 1;
  force(ForceKind::spring).anchor = {0.5, 0.5};
  force(ForceKind::spring).point = {-3, 1};
  force(ForceKind::spring).stiffness = 40;
  force(ForceKind::spring).damping = 0.5;
  force(ForceKind::spring).rest_length = 2;
  force(ForceKind::wind).vector = {4, 0};
  for (const ForceKind kind : {ForceKind::linear_drag, ForceKind::quadratic_drag}) {
    force(kind).coefficient = 0.5;
    force(kind).angular_coefficient = 0.25;
  }

  scene.prototypes = {unit_box({0, 0})};
  scene.prototypes[0].name = "brick";
  for (const InputInfo& info : input_kinds) scene.inputs.push_back(info.kind);
  scene.pointer = PointerSettings{{"brick"}, 4, 0.5, 500, Bounds{{-1, -2}, {3, 4}}};
  scene.bounds = Bounds{{-100, -200}, {300, 400}};
  scene.spawned_max = 12;
  return scene;
}

}  // namespace ticktrue::test
