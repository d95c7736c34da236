// The thesis' solver with its defects: one contact point, one pass, positional correction. A baseline to compare with.
// SPDX-License-Identifier: MIT
// Source: Claes, graduation work, DAE 2024, sections 1.2.2.3 and 1.3.3, figures 19..29. Kept as printed, on purpose:
// - one contact point, the deepest vertex, so that a box on a floor rocks;
// - separating bodies are pulled back (the source comments the test out);
// - friction stops the tangential velocity times mu (1 + e), with no Coulomb bound;
// - inertia as in BodyModel::impulse_inv_inertia; static polygons take part with their inertia;
// - a body of 2 000 kg or more counts as static;
// - the circle test stops at the first edge that has the circle outside; coincident circles give NaN.
#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/islands/solver_sets.h"
#include "engine/model/bodies.h"
#include "engine/solvers/solver.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real correction_percent = Real(0.7);
constexpr Real correction_slop = Real(0.01 / 25);  // m: 0.01 px at 25 px/m
constexpr Real static_inv_mass = Real(0.0005);     // 1/kg

struct Hit {
  bool found = false;
  Vec2 normal;  // from A to B
  Real depth = 0;
  Vec2 point;  // world
};

struct Placed {
  const ShapeModel& shape;
  const BodyRow& body;

  Vec2 center() const { return body.position + rotate(body.rotation, shape.center); }
  Vec2 vertex(const Model& model, std::uint32_t i) const {
    return body.position + rotate(body.rotation, model.vertices[shape.first_vertex + i]);
  }
  Vec2 normal(const Model& model, std::uint32_t i) const {
    return rotate(body.rotation, model.normals[shape.first_vertex + i]);
  }
};

/// The unit vector of an offset; upwards for a zero offset, such as of two discs at one place.
Vec2 direction_of(Vec2 offset, Real distance) {
  return distance > 0 ? (1 / distance) * offset : Vec2{0, 1};
}

Hit circle_circle(const Placed& a, const Placed& b) {
  const Vec2 offset = b.center() - a.center();
  const Real distance = length(offset);
  const Real depth = (a.shape.radius + b.shape.radius) - distance;
  if (depth <= 0) return {};
  const Vec2 normal = direction_of(offset, distance);
  return {true, normal, depth, b.center() - b.shape.radius * normal};
}

Hit polygon_circle(const Model& model, const Placed& polygon, const Placed& circle) {
  const Vec2 center = circle.center();
  std::uint32_t edge = 0;
  Real distance = 0;
  bool inside = true;
  for (std::uint32_t i = 0; i < polygon.shape.vertex_count; ++i) {
    const Real outside = dot(polygon.normal(model, i), center - polygon.vertex(model, i));
    if (outside > 0) {
      edge = i;
      distance = outside;
      inside = false;
      break;
    }
    if (i == 0 || outside > distance) {
      edge = i;
      distance = outside;
    }
  }
  const Vec2 v1 = polygon.vertex(model, edge);
  const Vec2 v2 = polygon.vertex(model, edge + 1 < polygon.shape.vertex_count ? edge + 1 : 0);
  if (!inside) {
    const bool zone_a = dot(center - v1, v2 - v1) < 0;
    const bool zone_c = dot(center - v2, v1 - v2) < 0;
    if (zone_a || zone_c) {
      const Vec2 corner = zone_a ? v1 : v2;
      const Vec2 offset = center - corner;
      const Real gap = length(offset);
      if (gap >= circle.shape.radius) return {};
      return {true, direction_of(offset, gap), circle.shape.radius - gap, corner};
    }
  }
  if (distance >= circle.shape.radius) return {};
  const Vec2 normal = polygon.normal(model, edge);
  return {true, normal, circle.shape.radius - distance, center - circle.shape.radius * normal};
}

/// The least overlap over the edges of `a`, and the vertex of `b` that is deepest behind this edge.
Hit least_overlap(const Model& model, const Placed& a, const Placed& b) {
  Hit best;
  for (std::uint32_t i = 0; i < a.shape.vertex_count; ++i) {
    const Vec2 normal = a.normal(model, i);
    const Vec2 vertex = a.vertex(model, i);
    Real deepest = 0;
    Vec2 point;
    for (std::uint32_t j = 0; j < b.shape.vertex_count; ++j) {
      const Vec2 candidate = b.vertex(model, j);
      const Real along = dot(normal, candidate - vertex);
      if (j == 0 || along < deepest) {
        deepest = along;
        point = candidate;
      }
    }
    if (deepest >= 0) return {};
    if (!best.found || -deepest < best.depth) best = {true, normal, -deepest, point};
  }
  return best;
}

Hit polygon_polygon(const Model& model, const Placed& a, const Placed& b) {
  const Hit from_a = least_overlap(model, a, b);
  if (!from_a.found) return {};
  Hit from_b = least_overlap(model, b, a);
  if (!from_b.found) return {};
  if (from_a.depth <= from_b.depth) return from_a;
  from_b.normal = -from_b.normal;
  return from_b;
}

Hit detect(const Model& model, const Placed& a, const Placed& b) {
  const bool a_round = a.shape.family == ShapeFamily::circle;
  const bool b_round = b.shape.family == ShapeFamily::circle;
  if (a_round && b_round) return circle_circle(a, b);
  const Real radius_sum = a.shape.bounding_radius + b.shape.bounding_radius;
  if (length_squared(b.center() - a.center()) > radius_sum * radius_sum) return {};
  if (!a_round && b_round) return polygon_circle(model, a, b);
  if (a_round) {
    Hit hit = polygon_circle(model, b, a);
    hit.normal = -hit.normal;
    return hit;
  }
  return polygon_polygon(model, a, b);
}

bool is_static(const BodyModel& body) {
  return body.inv_mass <= static_inv_mass;
}

void resolve(const Model& model, const Placed& shape_a, const Placed& shape_b, BodyRow& a, BodyRow& b, const Hit& hit) {
  const BodyModel& constants_a = model.bodies[a.source];
  const BodyModel& constants_b = model.bodies[b.source];
  const Real inv_mass_a = is_static(constants_a) ? 0 : constants_a.inv_mass;
  const Real inv_mass_b = is_static(constants_b) ? 0 : constants_b.inv_mass;
  const Real inv_mass = inv_mass_a + inv_mass_b;
  const Real correction = larger(hit.depth - correction_slop, 0) / inv_mass * correction_percent;
  a.position = a.position - (inv_mass_a * correction) * hit.normal;
  b.position = b.position + (inv_mass_b * correction) * hit.normal;

  const Settings& settings = model.scene.settings;
  const Real e = mix(settings.restitution_mix, shape_a.shape.restitution, shape_b.shape.restitution);
  const Real mu = mix(settings.friction_mix, shape_a.shape.friction, shape_b.shape.friction);
  const Vec2 arm_a = hit.point - a.position;
  const Vec2 arm_b = hit.point - b.position;
  const Vec2 relative =
      (a.velocity + cross(a.angular_velocity, arm_a)) - (b.velocity + cross(b.angular_velocity, arm_b));
  const auto impulse_along = [&](Vec2 direction) {
    const Real lever_a = cross(arm_a, direction);
    const Real lever_b = cross(arm_b, direction);
    const Real denominator = (inv_mass + lever_a * lever_a * constants_a.impulse_inv_inertia) +
                             lever_b * lever_b * constants_b.impulse_inv_inertia;
    return -(1 + e) * dot(relative, direction) / denominator;
  };
  const Vec2 tangent = right_turn(hit.normal);
  const Vec2 impulse = impulse_along(hit.normal) * hit.normal + (mu * impulse_along(tangent)) * tangent;
  if (!is_static(constants_a)) {
    a.velocity = stored(a.velocity + inv_mass_a * impulse);
    a.angular_velocity = stored(a.angular_velocity + constants_a.impulse_inv_inertia * cross(arm_a, impulse));
  }
  if (!is_static(constants_b)) {
    b.velocity = stored(b.velocity - inv_mass_b * impulse);
    b.angular_velocity = stored(b.angular_velocity - constants_b.impulse_inv_inertia * cross(arm_b, impulse));
  }
}

}  // namespace

void solve_impulse(const Model& model, State& state, TickLists& tick, SolverWork& work, Real dt) {
  const Integrator& scheme = integrator(model.scene.settings.integrator);
  prepare_bodies(model, state, tick, work.bodies);
  begin_motion(state, work.motion);
  put_all_into_one_set(model, state, work.bodies, tick);
  const SolvedSet solved = enter_solver_set(model, state, tick, work.bodies, 0, dt);
  prepare_mouse_joints(solved, work.mouse_joints);
  scheme.begin(solved, work.motion, dt);
  scheme.predict(solved, work.motion, dt);
  warm_start_mouse_joints(work.mouse_joints, work.bodies);
  solve_mouse_joints(work.mouse_joints, work.bodies);
  scheme.drift(solved, work.motion, dt);
  store_bodies(model, work.bodies, tick, state);
  store_motion(work.motion, state);
  store_mouse_joints(work.mouse_joints, state, dt);

  for (std::size_t i = 0; i < state.bodies.size(); ++i)
    for (std::size_t j = i + 1; j < state.bodies.size(); ++j) {
      BodyRow& a = state.bodies[i];
      BodyRow& b = state.bodies[j];
      const BodyModel& constants_a = model.bodies[a.source];
      const BodyModel& constants_b = model.bodies[b.source];
      if (is_static(constants_a) && is_static(constants_b)) continue;
      for (std::uint32_t child_a = 0; child_a < constants_a.shape_count; ++child_a)
        for (std::uint32_t child_b = 0; child_b < constants_b.shape_count; ++child_b) {
          const Placed shape_a{model.shape(constants_a, child_a), a};
          const Placed shape_b{model.shape(constants_b, child_b), b};
          const Hit hit = detect(model, shape_a, shape_b);
          if (hit.found) resolve(model, shape_a, shape_b, a, b, hit);
        }
    }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
