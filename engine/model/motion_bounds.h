// Bounds of the motion of bodies in a tick.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/model.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The values that all bodies of a tick share. `farthest`: the largest motion bound of a body if the scene locates
/// impacts, since a body that is hit may move as far; otherwise 0.
struct MotionBounds {
  Real dt;       // s
  Real gravity;  // m/s^2
  bool locates_impacts, speculates, has_ccd;
  Real farthest;  // m
};

/// The motion bound of a body, m: an upper bound of the displacement of its points in a tick.
inline Real motion_bound_in(const MotionBounds& bounds, const BodyModel& constants, const BodyRow& body) {
  if (constants.type == BodyType::static_body) return 0;
  const Real gravity_speed = constants.type == BodyType::dynamic_body
                                 ? absolute(constants.gravity_scale) * bounds.gravity * bounds.dt
                                 : Real(0);
  return bounds.dt * ((length(body.velocity) + gravity_speed) + magnitude(body.angular_velocity) * constants.extent);
}

/// Whether a body may pass through another in a tick. Jointed bodies are fast from where an impact would be found as an
/// overlap: a push acts on one body alone and moves the others too late.
inline bool is_fast(const MotionBounds& bounds, const BodyModel& constants, const BodyRow& body) {
  constexpr Real fast_share = Real(0.25);  // of its smallest shape's size: slower bodies get contacts in time
  constexpr Real jointed_share = Real(0.05);
  const Real share = constants.is_jointed ? jointed_share : fast_share;
  return motion_bound_in(bounds, constants, body) > share * constants.size;
}

/// The swept displacement of a body in a tick, m, by which its boxes are enlarged. It is 0 unless the body is fast,
/// impacts are located or contacts are speculative. Broad phases find each pair that is closer than the sum of its
/// swept displacements.
inline Real swept_displacement_of(const MotionBounds& bounds, const BodyModel& constants, const BodyRow& body) {
  if (constants.type == BodyType::static_body) return 0;
  if (bounds.locates_impacts) return bounds.farthest;
  const Real bound = motion_bound_in(bounds, constants, body);
  if (bounds.speculates) return bound;  // contacts are speculative
  return bounds.has_ccd && is_fast(bounds, constants, body) ? bound : Real(0);
}

/// Proxy::ccd_margin of a body's shapes, whose boxes include `swept`. Impacts of two dynamic bodies are located in
/// three cases: the scene locates all impacts, contacts are speculative, or one body is a bullet. For other pairs of
/// dynamic bodies the boxes without the CCD margin are enough.
inline Real ccd_margin_of(const MotionBounds& bounds, const BodyModel& constants, Real swept) {
  if (bounds.locates_impacts || bounds.speculates || constants.type != BodyType::dynamic_body || constants.is_bullet)
    return -1;
  if (!(swept < Real(1e30))) return -1;  // likewise for an unbounded box
  return (1 - 16 * epsilon) * swept;     // rounding must not make the margin larger than the enlargement
}

MotionBounds motion_bounds_of_tick(const Model& model, const State& state, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
