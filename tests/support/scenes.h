// Small scenes that tests build inline.
// SPDX-License-Identifier: MIT
#pragma once

#include <utility>
#include <vector>

#include "engine/scene.h"

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

/// Its top is the line y = 0.
inline Body ground(double half_width = 100) {
  return body_of(box_shape(half_width, 1), {0, -1}, BodyType::static_body);
}

/// No bodies, f64 unless said, gravity (0, -10), nothing that damps.
inline Scene empty_scene(Precision precision = Precision::f64) {
  Scene scene;
  scene.settings.precision = precision;
  return scene;
}

/// For one body in the air: no collisions, one substep.
inline Scene flight_scene(Precision precision, Body body) {
  Scene scene = empty_scene(precision);
  scene.settings.solver = SolverKind::free_flight;
  scene.settings.substeps = 1;
  scene.bodies.push_back(std::move(body));
  return scene;
}

/// `count` unit boxes upon each other on the ground, lowest first: bodies 1..count, the ground is body 0.
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

/// A box of 1 m by 1 m that slides along the ground with `speed`, friction `friction` against it.
inline Scene slide_scene(double speed, double friction, Precision precision = Precision::f64) {
  Scene scene = empty_scene(precision);
  scene.name = "slide";
  scene.bodies.push_back(ground());
  scene.bodies.push_back(unit_box({0, 0.5}));
  scene.bodies[1].velocity = {speed, 0};
  for (Body& body : scene.bodies) body.shapes[0].material.friction = friction;
  return scene;
}

}  // namespace ticktrue::test
