// How far bodies may get in a tick, and how far ahead they are looked for.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/model/model.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// What all bodies of a tick have in common in this. `farthest`: the longest reach, where the scene locates impacts:
/// what is hit may go on as far. Else 0.
struct MotionBounds {
  Real dt;       // s
  Real gravity;  // m/s^2
  bool locates_impacts, speculates, has_ccd;
  Real farthest;  // m
};

/// How far any point of a body may get in a tick, m.
inline Real motion_bound_in(const MotionBounds& bounds, const BodyModel& constants, const BodyRow& body) {
  if (constants.type == BodyType::static_body) return 0;
  const Real gravity_displacement = constants.type == BodyType::dynamic_body
                                        ? absolute(constants.gravity_scale) * bounds.gravity * bounds.dt
                                        : Real(0);
  return bounds.dt *
         ((length(body.velocity) + gravity_displacement) + magnitude(body.angular_velocity) * constants.extent);
}

/// Whether a body moves so far in a tick that it might pass through something.
inline bool is_fast(const MotionBounds& bounds, const BodyModel& constants, const BodyRow& body) {
  constexpr Real fast_share = Real(0.25);  // of its smallest shape's size: slower ones meet their contacts
  return motion_bound_in(bounds, constants, body) > fast_share * constants.size;
}

/// How far ahead a body is looked for in a tick, m: 0 unless it is fast or impacts are located. Broad phases find every
/// pair that is nearer than the sum of its two.
inline Real swept_displacement_of(const MotionBounds& bounds, const BodyModel& constants, const BodyRow& body) {
  if (constants.type == BodyType::static_body) return 0;
  if (bounds.locates_impacts) return bounds.farthest;
  const Real bound = motion_bound_in(bounds, constants, body);
  if (bounds.speculates) return bound;  // contacts are foreseen
  return bounds.has_ccd && is_fast(bounds, constants, body) ? bound : Real(0);
}

/// Proxy::ahead of a body's shapes, whose boxes hold `swept`. Impacts of two moving bodies are looked for only where
/// the scene locates all impacts, contacts are foreseen, or one of them is a bullet; else their near surroundings will
/// do.
inline Real ccd_margin_of(const MotionBounds& bounds, const BodyModel& constants, Real swept) {
  if (bounds.locates_impacts || bounds.speculates || constants.type != BodyType::dynamic_body || constants.is_bullet)
    return -1;
  if (!(swept < Real(1e30))) return -1;  // nor where the box has no end
  return (1 - 16 * epsilon) * swept;     // a little less: what is taken off must not take more than was put on
}

MotionBounds motion_bounds_of_tick(const Model& model, const State& state, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
