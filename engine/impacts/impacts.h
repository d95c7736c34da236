// Impacts located in time: fast bodies that would pass through others within a substep, and exact bounces.
// SPDX-License-Identifier: MIT
//
// Within a substep bodies follow parabolas. The earliest impact gets its impulse, the two bodies continue from there,
// and so on until no impact is left. Impacts of one substep thus happen in their order. Resting and sliding contacts
// are the contact solver's.
#pragma once

#include <cstdint>

#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct Scratch;
struct TickLists;

/// Two shapes that may hit in this tick in a way that the contact solver would miss.
struct ImpactPair {
  std::uint32_t body_a, body_b;    // rows
  std::uint32_t shape_a, shape_b;  // in Model::shapes
  Real friction, restitution;
  bool is_fast;     // may pass through in a substep
  bool is_located;  // false: the pair is only close to an impact, and stops
  Real slow;        // m/s: slower touching pairs without restitution are the contact solver's; < 0: no pair is
  bool is_done;     // for this substep
  Real time;        // s from the start of the substep; no_impact: none
  Vec2 normal;      // from A to B, at that moment
  Vec2 point;       // world, m
};

/// An entry of the heap of impacts.
struct ImpactEvent {
  Real time;           // s from the start of the substep
  std::uint32_t pair;  // in Scratch::impacts
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
};

/// Whether a contact that bounces is none of the contact solver's, in a scene whose impacts are located: all are but
/// those that carry a force, or touch and close too slowly to bounce. The solver would brake what is about to bounce,
/// to the speed at which it just gets there in a substep. `contact`: in scratch.contact_pairs and state.contacts.
bool is_left_to_impacts(const Model& model, const State& state, const TickLists& tick, std::uint32_t contact);
/// ImpactPair::slow of a pair. `contact`: as above, or the number of contacts if the pair has none.
Real slow_closing(const Model& model, const State& state, const TickLists& tick, const ImpactPair& pair,
                  std::uint32_t contact, Real dt);

/// Saves velocities before a substep. Call before the integrator predicts.
void save_impact_velocities(const State& state, Scratch& scratch);
/// Finds and applies the impacts of the set that is being solved, in a substep of length h. Call after the integrator's
/// prediction.
void apply_impacts(const Model& model, const State& state, Scratch& scratch, Real h);
/// Brings the bodies that were hit to the ends of their paths. Call after the integrator's drift.
void finish_impacts(Scratch& scratch);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
