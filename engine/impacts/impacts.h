// Impacts located in time: fast bodies that would pass through others within a substep, and bounces at their moment.
// SPDX-License-Identifier: MIT
//
// Within a substep bodies follow parabolas. The earliest impact gets its impulse, the two bodies go on from there, and
// so on until no impact is left: chains of impacts within one substep come in their order. What bodies do otherwise
// (resting, sliding) is the contact solver's.
#pragma once

#include <cstdint>

#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct Scratch;
struct TickLists;

/// Two shapes that may meet in this tick in a way that the contact solver would miss.
struct ImpactPair {
  std::uint32_t body_a, body_b;    // rows
  std::uint32_t shape_a, shape_b;  // in Model::shapes
  Real friction, restitution;
  bool is_fast;     // may pass through within a substep
  bool is_located;  // the impact below is one; else the pair is only near it, and stops there
  Real slow;        // m/s: what touches, does not bounce and closes no faster is the contact solver's; < 0: nothing is
  bool is_done;     // for this substep
  Real time;        // s from the start of the substep; no_impact: none
  Vec2 normal;      // from A to B, at that moment
  Vec2 point;       // world, m
};

/// An impact in the order of time.
struct ImpactEvent {
  Real time;           // s from the start of the substep
  std::uint32_t pair;  // in Scratch::impacts
};

/// A body's way through a substep: x(t) = moved + velocity (t - time) + acceleration (t - time)^2 / 2.
struct ImpactPath {
  Vec2 delta_position;  // since the tick began, at `time`, m
  Rotation delta_rotation;
  Real time;      // s from the start of the substep
  Vec2 velocity;  // at `time`, m/s
  Vec2 acceleration;
  Real angular_velocity;
  Real angle;           // turned since the start of the substep, at `time`, rad
  Vec2 start_velocity;  // before the integrator's prediction, m/s
  Vec2 saved_velocity;  // of a body that is stopped for the rest of the substep: what it goes on with, m/s
  Real saved_spin;      // rad/s
  Vec2 saved_acceleration;
  Vec2 correction;           // what the drift with the end velocity misses of the way, m
  Real rotation_correction;  // rad
  bool is_hit;
  bool is_stopped;
};

/// Whether a contact that bounces is none of the contact solver's, in a scene whose impacts are located: all are but
/// those that carry a force, or touch and close too slowly to bounce. The solver would brake what is about to bounce,
/// to the speed at which it just gets there in a substep. `contact`: in scratch.contact_pairs and state.contacts.
bool is_left_to_impacts(const Model& model, const State& state, const TickLists& tick, std::uint32_t contact);
/// ImpactPair::slow of a pair. `contact`: as above, or the number of contacts if the pair has none.
Real slow_closing(const Model& model, const State& state, const TickLists& tick, const ImpactPair& pair,
                  std::uint32_t contact, Real dt);

/// Notes velocities before a substep. Call before the integrator predicts.
void save_impact_velocities(const State& state, Scratch& scratch);
/// Finds and applies the impacts of a substep of length h of the group that is being solved. Call after the
/// integrator's prediction.
void apply_impacts(const Model& model, const State& state, Scratch& scratch, Real h);
/// Brings the bodies that were hit to the ends of their ways. Call after the integrator's drift.
void finish_impacts(Scratch& scratch);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
