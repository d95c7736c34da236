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
  bool locates, speculates, guards;
  Real farthest;  // m
};

/// How far any point of a body may get in a tick, m.
inline Real motion_bound_in(const MotionBounds& tick, const BodyModel& constants, const BodyRow& body) {
  if (constants.type == BodyType::static_body) return 0;
  const Real fall =
      constants.type == BodyType::dynamic_body ? absolute(constants.gravity_scale) * tick.gravity * tick.dt : Real(0);
  return tick.dt * ((length(body.velocity) + fall) + magnitude(body.angular_velocity) * constants.reach);
}

/// Whether a body moves so far in a tick that it might pass through something.
inline bool is_fast(const MotionBounds& tick, const BodyModel& constants, const BodyRow& body) {
  constexpr Real fast_share = Real(0.25);  // of its smallest shape's size: slower ones meet their contacts
  return motion_bound_in(tick, constants, body) > fast_share * constants.size;
}

/// How far ahead a body is looked for in a tick, m: 0 unless it is fast or impacts are located. Broad phases find every
/// pair that is nearer than the sum of its two.
inline Real swept_displacement_of(const MotionBounds& tick, const BodyModel& constants, const BodyRow& body) {
  if (constants.type == BodyType::static_body) return 0;
  if (tick.locates) return tick.farthest;
  const Real reach = motion_bound_in(tick, constants, body);
  if (tick.speculates) return reach;  // contacts are foreseen
  return tick.guards && is_fast(tick, constants, body) ? reach : Real(0);
}

/// Proxy::ahead of a body's shapes, whose boxes hold `way`. Impacts of two moving bodies are looked for only where the
/// scene locates all impacts, contacts are foreseen, or one of them is a bullet; else their near surroundings will do.
inline Real ahead_of(const MotionBounds& tick, const BodyModel& constants, Real way) {
  if (tick.locates || tick.speculates || constants.type != BodyType::dynamic_body || constants.is_bullet) return -1;
  if (!(way < Real(1e30))) return -1;  // nor where the box has no end
  return (1 - 16 * epsilon) * way;     // a little less: what is taken off must not take more than was put on
}

MotionBounds motion_bounds_of_tick(const Model& model, const State& state, Real dt);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
