// Contacts as the solver sees them: eight at a time, no body twice in a batch, batches in graph colours.
// SPDX-License-Identifier: MIT
//
// A colour is a set of contacts of which no two move the same body, so eight of them can be solved side by side, and
// batches of one colour in any order, on any thread, with the same result. Colours are derived anew each tick from the
// sorted contacts: they are no state.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/constraints/soft.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct Scratch;
struct SolveGroup;

inline constexpr int lane_count = 8;

/// One value for each contact of a batch.
struct alignas(lane_count * sizeof(Real)) Lanes {
  Real at[lane_count];
};

struct ContactPointLanes {
  Lanes anchor_a_x, anchor_a_y;  // from A's centre of mass at the start of the tick, world axes, m
  Lanes anchor_b_x, anchor_b_y;
  Lanes base_separation;  // separation minus (pivot_b - pivot_a) . normal, m
  Lanes normal_mass;      // effective mass along the normal, kg; 0 where there is no point
  Lanes tangent_mass;
  Lanes normal_impulse;  // N s, accumulated in this substep
  Lanes tangent_impulse;
  Lanes normal_impulse_max;  // N s, largest of the tick: a point that never pushed does not bounce
  Lanes approach;            // relative normal velocity at the start of the tick, m/s
};

struct ContactBatch {
  std::uint32_t read_a[lane_count];  // in Scratch::bodies; static bodies and empty lanes read the resting record
  std::uint32_t read_b[lane_count];
  std::uint32_t write_a[lane_count];  // bodies that impulses do not move are written to a record nobody reads
  std::uint32_t write_b[lane_count];
  std::uint32_t contact[lane_count];  // in State::contacts; lanes from `count` on are empty
  int count;
  bool bounces;  // some lane has restitution
  Lanes inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
  Lanes normal_x, normal_y, friction, restitution;
  Lanes radius_a, radius_b;                    // of round shapes, m
  Lanes bias_rate, mass_scale, impulse_scale;  // Softness
  ContactPointLanes points[2];
};

/// What conveyors and rolling resistance add to a batch.
struct SurfaceLanes {
  Lanes tangent_speed;       // m/s, of B's surface seen from A's, along right_turn(normal)
  Lanes rolling_resistance;  // m, torque per normal force
  Lanes rolling_mass;        // effective mass of the relative turn, kg m^2
  Lanes rolling_impulse;     // N m s, accumulated in this substep
};

struct ContactBatches {
  std::vector<ContactBatch> batches;       // in solving order
  std::vector<SurfaceLanes> surfaces;      // [batch]; empty where no material of the scene has either
  std::vector<std::uint32_t> colors;       // [contact]
  std::vector<std::uint32_t> color_start;  // [colour] in `sorted`; one more at the end
  std::vector<std::uint32_t> color_next;   // [colour] while sorting
  std::vector<std::uint32_t> body_colors;  // [body] bit set
  std::vector<std::uint32_t> sorted;       // contacts by colour
  std::vector<Lanes> saved;                // [batch, point] normal impulses
};

enum class Bias : std::uint8_t { off, on };

/// How stiff contacts are: against moving bodies and against immovable ones. `slop`: overlap that is left alone.
struct ContactStiffness {
  Softness moving;
  Softness immovable;
  Real slop = 0;  // relative to the size of the smaller shape
};

/// Stiffness of soft contacts, tied to the substep rate 1 / h.
ContactStiffness soft_contacts(Real h);
/// Contacts that remove a fifth of the overlap beyond the slop in each step of length h.
ContactStiffness baumgarte_contacts(Real h);
/// N/m of a soft contact point per kg of effective mass, for substeps of length h.
Real soft_contact_stiffness(Real h);

/// Forgets the batches of the last tick.
void clear_contacts(Scratch& scratch);

/// Colours and packs the contacts of a group, with impulses from state.contacts, for substeps of length group.h.
/// Appends to the batches and notes the range in `group`. Requires: scratch.bodies filled (prepare_bodies).
void prepare_contacts(const Model& model, const State& state, Scratch& scratch, SolveGroup& group,
                      const ContactStiffness& stiffness);
void warm_start_contacts(Scratch& scratch, const SolveGroup& group);
void solve_contacts(Scratch& scratch, const SolveGroup& group, Bias bias);
/// Gives points that hit faster than `threshold` their bounce. True if any did.
bool bounce_contacts(Scratch& scratch, const SolveGroup& group, Real threshold);
/// Keeps the normal impulses of a group for limit_impulses.
void save_impulses(Scratch& scratch, const SolveGroup& group);
/// No normal impulse above the saved one, and friction within its cone: what an impact added is no force that lasts.
void limit_impulses(Scratch& scratch, const SolveGroup& group);
/// Impulses back to state.contacts, as forces.
void store_contacts(const Scratch& scratch, const SolveGroup& group, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
