// Pairs whose impacts are located in time, and the paths of their bodies.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Two shapes that may hit in this tick, where the contact solver alone would miss the impact.
struct ImpactPair {
  std::uint32_t body_a, body_b;    // rows
  std::uint32_t shape_a, shape_b;  // in Model::shapes
  Real friction, restitution;
  bool is_fast;     // may pass through each other in a substep
  bool is_located;  // false: the pair is only close to an impact, and its bodies stop
  Real slow;        // m/s; the contact solver has slower touching pairs without restitution; < 0: no pair
  bool is_done;     // for this substep
  Real time;        // s from the start of the substep; no_impact: none
  Vec2 normal;      // from A to B, at that moment
  Vec2 point;       // world, m
};

/// An entry of the heap of impacts.
struct ImpactEvent {
  Real time;           // s from the start of the substep
  std::uint32_t pair;  // in TickLists::impacts
};

/// The path of a body in a substep: x(t) = delta_position + velocity (t - time) + acceleration (t - time)^2 / 2.
struct ImpactPath {
  Vec2 delta_position;  // since the tick began, at `time`, m
  Rotation delta_rotation;
  Real time;      // s from the start of the substep
  Vec2 velocity;  // at `time`, m/s
  Vec2 acceleration;
  Real angular_velocity;
  Real angle;           // rotation since the start of the substep, at `time`, rad
  Vec2 start_velocity;  // before the integrator's prediction, m/s
  Vec2 saved_velocity;  // of a stopped body: its velocity after the substep, m/s
  Real saved_spin;      // rad/s
  Vec2 saved_acceleration;
  Vec2 correction;           // the path beyond the drift with the end velocity, m
  Real rotation_correction;  // rad
  bool is_hit;
  bool is_stopped;
  bool slides;  // a stopped body, along what stopped it
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
