// The caches and the workspace of the narrow phase.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "engine/model/caches.h"
#include "engine/model/contact_pairs.h"
#include "engine/model/poison.h"
#include "engine/model/state.h"
#include "engine/narrow_phase/pair_block.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The inputs of manifolds, beside the poses of their bodies.
struct ManifoldKey {
  bool is_known = false;  // bodies are compared with those of the tick before; false: nothing is valid
  std::uint32_t body_generation = 0;
  Real gravity_displacement = 0;  // m
  Real dt = 0;                    // s, if contacts are speculative; otherwise 0

  bool operator==(const ManifoldKey&) const = default;
};

/// The contact pairs of the tick before, parallel to State::contacts. A pair whose bodies are unchanged has the same
/// manifold. Key: ManifoldKey.
class ManifoldCache final : public TickCache {
 public:
  ManifoldCache() : TickCache(CacheKind::manifolds) {}
  bool valid_for(const ManifoldKey& key, std::size_t contact_count) const {
    return is_valid_ && key.is_known && key_ == key && pairs_.size() == contact_count;
  }
  /// Swaps the cached pairs with `pairs`.
  void rebuild(const ManifoldKey& key, std::vector<ContactPair>& pairs) {
    pairs_.swap(pairs);
    key_ = key;
    is_valid_ = key.is_known;
  }
  /// Moves the pairs out. The caller changes them in place and returns them with rebuild().
  void take(std::vector<ContactPair>& pairs) {
    pairs_.swap(pairs);
    is_valid_ = false;
  }
  /// `unchanged_count`: manifolds that were reused.
  void count(std::uint64_t unchanged_count, bool was_valid) { count_uses({unchanged_count, was_valid ? 0u : 1u}); }
  void invalidate() override { is_valid_ = false; }
  std::span<const ContactPair> pairs() const { return pairs_; }

 private:
  bool is_valid_ = false;
  ManifoldKey key_;
  std::vector<ContactPair> pairs_;
};

/// Whether the contacts of a tick are likely those of the tick before, so that new contacts overwrite old ones in
/// place.
class ContactPlaces final : public TickCache {
 public:
  ContactPlaces() : TickCache(CacheKind::contact_places) {}
  bool valid() const { return is_settled_; }
  /// `any_new`: some contact did not exist in the tick before. `same`: the contacts are those of the tick before.
  void rebuild(bool any_new, bool same) {
    is_settled_ = !any_new;
    if (!same) ++generation_;
  }
  void count(bool was_hit) { count_use(was_hit); }
  void invalidate() override { is_settled_ = false; }
  /// A different number whenever the contacts have changed.
  std::uint32_t generation() const { return generation_; }

 private:
  bool is_settled_ = false;
  std::uint32_t generation_ = 0;
};

/// Blocks of the pairs of the tick before. The key of each block: its pairs, and its use in the tick before.
class PairBlocks final : public TickCache {
 public:
  PairBlocks() : TickCache(CacheKind::pair_blocks) {}
  /// The blocks for the next tick, with their content of the last tick.
  PairBlock* begin_tick(std::size_t block_count) {
    if (blocks_.size() < block_count) blocks_.resize(block_count);
    ++tick_;
    return blocks_.data();
  }
  std::uint32_t tick() const { return tick_; }
  void count(CacheCounts more) { count_uses(more); }
  void invalidate() override {
    for (PairBlock& block : blocks_) block.is_valid = false;
  }

 private:
  std::uint32_t tick_ = 0;
  std::vector<PairBlock> blocks_;
};

/// The part that a chunk has added to a list.
struct ListPart {
  std::size_t first;     // begin of its place
  std::size_t in_place;  // contacts at this place; the rest is spilled
  std::size_t count;
  std::size_t place;  // in the list
};

/// The workspace of the narrow phase in a tick.
struct NarrowPhaseWork {
  std::vector<ContactPair> contact_pairs;
  std::vector<ContactRow> contacts;                // the rows that replace State::contacts
  std::vector<ContactPair> contact_pairs_spilled;  // contacts of chunks that do not fit at their place
  std::vector<ContactPair> contact_pairs_moved;
  std::vector<ContactRow> contacts_spilled;
  std::vector<ContactRow> contacts_moved;
  std::vector<ListPart> parts;  // [chunk]
};

template <typename Visit>
void list_fields(NarrowPhaseWork& of, const Visit& visit) {
  auto& [contact_pairs, contacts, contact_pairs_spilled, contact_pairs_moved, contacts_spilled, contacts_moved, parts] =
      of;
  visit(contact_pairs, contacts, contact_pairs_spilled, contact_pairs_moved, contacts_spilled, contacts_moved, parts);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
