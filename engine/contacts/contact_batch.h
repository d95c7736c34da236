// Contacts as the solver sees them: sixteen at a time, no body twice in a batch, batches in graph colours.
// SPDX-License-Identifier: MIT
//
// A colour is a set of contacts of which no two move the same body, so sixteen of them can be solved side by side, and
// batches of one colour in any order, on any thread, with the same result. Colours are derived from the sorted
// contacts, anew in each tick in which these are others than before: they are no state.
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

/// Batches that are solved in one go: those of a colour, on all threads, or of some colours one after the other.
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
  std::vector<std::uint32_t> slots;  // [batch of the group, lane] the contact, or no_contact; where not all are in it
  std::vector<BatchRun> runs;        // in solving order
  std::vector<ContactLanes> saved;   // [batch of the group, point] normal impulses
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

/// Packs the contacts of a group, with impulses from state.contacts, for substeps of length group.h. Appends to the
/// batches and notes the range in `set`. Requires: color_contacts, as one block.
void prepare_contacts(const Model& model, const State& state, Scratch& scratch, SolverSet& set);
void warm_start_contacts(Scratch& scratch, const SolverSet& set);
/// `poses`: unmoved if none has changed since the last pass over the same contacts.
void solve_contacts(Scratch& scratch, const SolverSet& set, Poses poses);
/// Takes out the velocity that solve_contacts put in to push overlaps apart.
void relax_contacts(Scratch& scratch, const SolverSet& set);
/// Gives points that hit faster than `threshold` their bounce. True if any did.
bool bounce_contacts(Scratch& scratch, const SolverSet& set, Real threshold);
/// Keeps the normal impulses of a group for limit_impulses.
void save_impulses(Scratch& scratch, const SolverSet& set);
/// No normal impulse above the saved one, and friction within its cone: what an impact added is no force that lasts.
void limit_impulses(Scratch& scratch, const SolverSet& set);
/// Impulses back to state.contacts, as forces.
void store_contacts(const Scratch& scratch, const SolverSet& set, State& state);

/// Packs the contacts of a block, as above, into `out`, which has no others then. `sink`: a record that no other
/// thread writes.
void prepare_block(const Model& model, const State& state, Scratch& scratch, const SolverSet& set,
                   const ContactBlock& block, std::uint32_t sink, ContactBatches& out);
/// All batches of a block, for one call of a kernel.
ContactWork work_of_block(Scratch& scratch, const SolverSet& set, ContactBatches& batches);
void store_block(const Scratch& scratch, const SolverSet& set, const ContactBatches& batches, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
