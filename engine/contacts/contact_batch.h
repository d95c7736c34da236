// Contacts as the solver sees them: batches of sixteen without a common dynamic body, in graph colours.
// SPDX-License-Identifier: MIT
//
// A colour is a set of contacts without a common dynamic body. Sixteen contacts of a colour are solved side by side.
// Batches of one colour give the same result in any order and on any thread. Colours follow from the sorted contacts
// and are recomputed whenever the contacts change: they are no state.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/contacts/contact_coloring.h"
#include "engine/contacts/contact_lanes.h"
#include "engine/model/poison.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Consecutive batches of one loop: of one colour on all threads, or of several colours on one thread.
struct BatchRun {
  std::uint32_t first;
  std::uint32_t end;
  std::size_t chunk_size;  // in batches
};

/// A batch with contacts whose pushes are taken back, and its impulses before they push.
struct PushingBatch {
  std::uint32_t batch;
  std::uint32_t lanes;                 // bit i: the push of lane i is taken back
  ContactLanes normal[2], tangent[2];  // [point] N s: before the push
};

struct ContactBatches {
  std::vector<ContactBatch> batches;   // in solving order; the first `batch_count` are in use
  std::vector<SurfaceLanes> surfaces;  // [batch]; empty if no material of the scene has surface effects
  std::vector<BounceLanes> bounces;    // [batch]; empty if the kernels leave restitution out
  std::size_t batch_count = 0;
  std::vector<std::uint32_t> slots;   // [batch of the set, lane] contact or no_contact; for sets of some contacts
  std::vector<BatchRun> runs;         // in solving order
  std::vector<ContactLanes> saved;    // [batch of the set, point] normal impulses
  std::vector<PushingBatch> pushing;  // of the set, ascending
  std::vector<PushingBatch> jointed;  // the same for contacts of jointed bodies: `lanes` are those contacts
};

template <typename Visit>
void list_fields(ContactBatches& of, const Visit& visit) {
  auto& [batches, surfaces, bounces, batch_count, slots, runs, saved, pushing, jointed] = of;
  visit(in_place(batches), in_place(surfaces), in_place(bounces), batch_count, slots, runs, saved, pushing, jointed);
}

/// The workspace and the caches of the contact solver.
struct ContactWorkspace {
  ContactColors colors;
  IslandBlocks blocks;
  ColoringWork coloring;
  ContactBatches batches;
  std::vector<ContactBatches> block_batches;  // [chunk] of the block that is being solved
};

template <typename Visit>
void list_fields(ContactWorkspace& of, const Visit& visit) {
  auto& [colors, blocks, coloring, batches, block_batches] = of;
  visit(colors, blocks, coloring, batches, in_place(block_batches));
}

/// Discards the batches of the last tick.
void clear_contacts(ContactBatches& batches);

/// Colours the contacts of a set. `may_split`: in blocks, if there are enough contacts. Requires: prepare_bodies.
void color_contacts(const SolvedSet& solved, bool may_split, ContactWorkspace& work);

/// Packs the contacts of a set, with impulses from state.contacts, for substeps of length set.h. Appends to the batches
/// and stores the range in the set. Requires: color_contacts, as one block.
void prepare_contacts(const SolvedSet& solved, const ContactColors& colors, ContactBatches& out);
void warm_start_contacts(const SolvedSet& solved, ContactBatches& batches);
/// Requires: no pose has changed since prepare_contacts or the last relax_contacts.
void solve_contacts(const SolvedSet& solved, ContactBatches& batches);
/// Adds a contact to those whose pushes are taken back; the contacts of crowds are among them already. Requires:
/// prepare_contacts.
void take_push_back_of(ContactBatches& batches, std::uint32_t batch, std::uint32_t lane);
/// Takes back the impulses that these contacts got since save_before_push: what pushes them apart moves bodies, and
/// gives them no speed.
void save_before_push(ContactBatches& batches);
void take_back_pushes(const SolvedSet& solved, ContactBatches& batches);
/// Lists the contacts of bodies with is_jointed[row] for limit_push_friction; none if it is empty. Requires:
/// prepare_contacts.
void find_jointed_contacts(const SolvedSet& solved, std::span<const std::uint8_t> is_jointed, ContactBatches& batches);
/// Limits the friction of these contacts to the cone of their normal impulses at save_before_push: what pushes overlaps
/// apart presses nothing, and its friction would turn back what joints turn.
void limit_push_friction(const SolvedSet& solved, ContactBatches& batches);
/// Removes the velocity that solve_contacts added to correct overlaps.
void relax_contacts(const SolvedSet& solved, ContactBatches& batches);
/// Applies restitution at points that hit faster than `threshold`. True if there was such a point.
bool bounce_contacts(const SolvedSet& solved, ContactBatches& batches, Real threshold);
/// Saves the normal impulses of a set for limit_impulses.
void save_impulses(const SolverSet& set, ContactBatches& batches);
/// Limits normal impulses to the saved ones, and friction to its cone, since the impulse of an impact is no lasting
/// force.
void limit_impulses(const SolverSet& set, ContactBatches& batches);
/// Stores impulses in state.contacts, as forces.
void store_contacts(const SolvedSet& solved, const ContactBatches& batches, State& state);

/// Packs the contacts of a block, as prepare_contacts does, as the only contacts of `out`. `sink`: a record that no
/// other thread writes.
void prepare_block(const SolvedSet& solved, const ContactColors& colors, const ContactBlock& block, std::uint32_t sink,
                   ContactBatches& out);
/// The arguments of a kernel for all batches of a block.
ContactWork work_of_block(const SolvedSet& solved, ContactBatches& batches);
void store_block(const SolvedSet& solved, const ContactBatches& batches, State& state);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
