// Contacts as the solver sees them: batches of sixteen without a common dynamic body, in graph colours.
// SPDX-License-Identifier: MIT
//
// A colour is a set of contacts without a common dynamic body. Sixteen of them can be solved side by side, and batches
// of one colour in any order on any thread, with the same result. Colours follow from the sorted contacts and are
// computed anew in each tick whose contacts differ from the last: they are no state.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/contacts/contact_coloring.h"
#include "engine/contacts/contact_lanes.h"
#include "engine/contacts/soft.h"
#include "engine/math/vec2.h"
#include "engine/model/body_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;
struct State;
struct Scratch;
struct SolverSet;

/// Consecutive batches of one loop: of one colour on all threads, or of several colours on one thread.
struct BatchRun {
  std::uint32_t first;
  std::uint32_t end;
  std::size_t chunk_size;  // in batches
};

struct ContactBatches {
  std::vector<ContactBatch> batches;   // in solving order; the first `batch_count` are in use
  std::vector<SurfaceLanes> surfaces;  // [batch]; empty where no material of the scene has any
  std::vector<BounceLanes> bounces;    // [batch]; empty where the kernels leave restitution out
  std::size_t batch_count = 0;
  std::vector<std::uint32_t> slots;  // [batch of the set, lane] contact or no_contact; unless the set has all contacts
  std::vector<BatchRun> runs;        // in solving order
  std::vector<ContactLanes> saved;   // [batch of the set, point] normal impulses
};

enum class Bias : std::uint8_t { off, on };

/// Stiffness of contacts between dynamic bodies and of contacts with other bodies. `slop`: overlap that is not
/// corrected.
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

/// Discards the batches of the last tick.
void clear_contacts(Scratch& scratch);

/// Colours the contacts of a set. `may_split`: in blocks, if there are contacts enough for some. Requires:
/// prepare_bodies.
void color_contacts(Scratch& scratch, const SolverSet& set, bool may_split);

/// Packs the contacts of a set, with impulses from state.contacts, for substeps of length set.h. Appends to the batches
/// and stores the range in `set`. Requires: color_contacts, as one block.
void prepare_contacts(const Model& model, const State& state, Scratch& scratch, SolverSet& set);
void warm_start_contacts(Scratch& scratch, const SolverSet& set);
/// `poses`: unmoved if no pose has changed since the last pass over the same contacts.
void solve_contacts(Scratch& scratch, const SolverSet& set, Poses poses);
/// Removes the velocity that solve_contacts added to correct overlaps.
void relax_contacts(Scratch& scratch, const SolverSet& set);
/// Applies restitution at points that hit faster than `threshold`. True if there was one.
bool bounce_contacts(Scratch& scratch, const SolverSet& set, Real threshold);
/// Saves the normal impulses of a set for limit_impulses.
void save_impulses(Scratch& scratch, const SolverSet& set);
/// Limits normal impulses to the saved ones, and friction to its cone: the impulse of an impact is no lasting force.
void limit_impulses(Scratch& scratch, const SolverSet& set);
/// Stores impulses in state.contacts, as forces.
void store_contacts(const Scratch& scratch, const SolverSet& set, State& state);

/// Packs the contacts of a block, as above, as the only contacts of `out`. `sink`: a record that no other thread
/// writes.
void prepare_block(const Model& model, const State& state, Scratch& scratch, const SolverSet& set,
                   const ContactBlock& block, std::uint32_t sink, ContactBatches& out);
/// The arguments of a kernel for all batches of a block.
ContactWork work_of_block(Scratch& scratch, const SolverSet& set, ContactBatches& batches);
void store_block(const Scratch& scratch, const SolverSet& set, const ContactBatches& batches, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
