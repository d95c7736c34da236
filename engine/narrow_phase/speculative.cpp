// Conservative advancement up to the margin, and the manifold at this time.
// SPDX-License-Identifier: MIT
// Source: Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996, chapter 2 (no pair can close its gap
// sooner than gap / greatest closing speed).
#include "engine/narrow_phase/speculative.h"

#include "engine/narrow_phase/distance.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr int speculative_step_max = 16;

BodyRow predicted_pose(const BodyRow& body, Real time) {
  BodyRow later = body;
  later.position = body.position + time * body.velocity;
  later.rotation = rotation_by(time * body.angular_velocity) * body.rotation;
  return later;
}

Real spin_of(const Model& model, const BodyRow& body) {
  return absolute(body.angular_velocity) * model.bodies[body.source].extent;
}

/// Whether the bounding circles of two shapes are farther apart than `distance`, m.
bool are_farther(const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a, const BodyRow& body_b,
                 Real distance) {
  const Vec2 from_a =
      (body_b.position - body_a.position) + (rotate(body_b.rotation, b.center) - rotate(body_a.rotation, a.center));
  const Real touch_distance = (a.bounding_radius + b.bounding_radius) + distance;
  return length_squared(from_a) > Real(1.001) * (touch_distance * touch_distance);
}

/// An upper bound of the speed at which two points of the bodies close, m/s. An impact at one corner turns velocity
/// into spin, hence the sum.
Real closing_bound(const Model& model, const BodyRow& body_a, const BodyRow& body_b) {
  return length(body_b.velocity - body_a.velocity) + (spin_of(model, body_a) + spin_of(model, body_b));
}

bool may_have_later_point(const ShapeModel& shape) {
  return shape.family == ShapeFamily::polygon || shape.family == ShapeFamily::round;
}

}  // namespace

void add_later_point(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                     const BodyRow& body_b, Real gravity_displacement, Real dt, Manifold& manifold) {
  if (manifold.point_count != 1 || !may_have_later_point(a) || !may_have_later_point(b)) return;
  const Real reach = dt * closing_bound(model, body_a, body_b);
  if (!(reach > speculative_margin(pair_size(a, b), gravity_displacement))) return;
  const Manifold wide = collide(model, a, b, body_a, body_b, gravity_displacement, reach);
  if (wide.point_count == 2) manifold = wide;
}

Manifold speculative_manifold(const Model& model, const ShapeModel& a, const ShapeModel& b, const BodyRow& body_a,
                              const BodyRow& body_b, Real gravity_displacement, Real dt) {
  const Real margin = speculative_margin(pair_size(a, b), gravity_displacement);
  const Vec2 relative = body_b.velocity - body_a.velocity;
  const Real spin = spin_of(model, body_a) + spin_of(model, body_b);
  const Real fastest =
      Real(1.001) * closing_bound(model, body_a, body_b);  // rounding must not reject a pair that meets
  if (are_farther(a, b, body_a, body_b, margin + fastest * dt)) return {};
  Real time = 0;
  BodyRow at_a = body_a;
  BodyRow at_b = body_b;
  for (int i = 0;; ++i) {
    const Real reach = margin + fastest * (dt - time);
    const Distance gap = distance(model, a, {at_a.position, at_a.rotation}, b, {at_b.position, at_b.rotation}, reach);
    if (gap.separation > reach) return {};
    if (gap.separation <= Real(0.5) * margin) break;
    const Real closing_max = spin - dot(relative, gap.normal);
    const Real distance_left = gap.separation - Real(0.25) * margin;
    if (i == speculative_step_max || !(distance_left < closing_max * (dt - time))) return {};
    time += distance_left / closing_max;
    at_a = predicted_pose(body_a, time);
    at_b = predicted_pose(body_b, time);
  }
  Manifold manifold = collide(model, a, b, at_a, at_b, gravity_displacement);
  add_later_point(model, a, b, at_a, at_b, gravity_displacement, dt - time, manifold);
  // Moves the points back to the start of the tick. The pivots that rotate with the bodies are a radius behind the
  // anchors.
  const Rotation back_a = rotation_by(-time * body_a.angular_velocity);
  const Rotation back_b = rotation_by(-time * body_b.angular_velocity);
  const Vec2 normal = manifold.normal;
  const Real normal_displacement = time * dot(relative, normal);
  int kept = 0;
  for (int i = 0; i < manifold.point_count; ++i) {
    ManifoldPoint point = manifold.points[i];
    const Vec2 pivot_a = point.anchor_a - a.radius * normal;
    const Vec2 pivot_b = point.anchor_b + b.radius * normal;
    const Vec2 start_a = rotate(back_a, pivot_a);
    const Vec2 start_b = rotate(back_b, pivot_b);
    point.separation =
        (point.separation - normal_displacement) + dot((start_b - pivot_b) - (start_a - pivot_a), normal);
    if (!(point.separation > 0)) continue;  // it only closed along the normal of the other point
    point.anchor_a = start_a + a.radius * normal;
    point.anchor_b = start_b - b.radius * normal;
    manifold.points[kept++] = point;
  }
  manifold.point_count = kept;
  return manifold;
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
