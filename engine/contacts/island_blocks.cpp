// Division of the bodies of a set into blocks of islands.
// SPDX-License-Identifier: MIT
#include "engine/contacts/island_blocks.h"

#include <algorithm>

#include "engine/math/union_find.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A block of this many contacts, with its bodies and batches, fits into a core's own cache.
constexpr std::size_t contacts_per_block = 1024;
/// Fewer contacts stay in the cache in any order.
constexpr std::size_t contacts_to_split_least = 2 * contacts_per_block;
/// Finding islands costs as much as several ticks can save.
constexpr std::uint32_t ticks_between_splits = 16;

}  // namespace

bool IslandBlocks::has_rows(std::span<const std::uint32_t> rows) const {
  return std::equal(rows.begin(), rows.end(), set_rows_.begin(), set_rows_.end());
}

bool IslandBlocks::valid_for(const IslandBlocksKey& key) const {
  if (count_ == 0 || block_of_.size() != key.body_count) return false;
  if (key.same_contacts && has_rows(key.rows)) return true;
  return std::all_of(key.contacts.begin(), key.contacts.end(), [&](const ContactBodies& bodies) {
    const std::uint32_t block = block_of_[dynamic_body_of(bodies)];
    return block != no_block && (!moves_both(bodies) || block_of_[bodies.b] == block);
  });
}

void IslandBlocks::invalidate() {
  count_ = 0;
  block_of_.clear();
  set_rows_.clear();
  ticks_unsplit_ = 0;
}

bool IslandBlocks::follow(const IslandBlocksKey& key, std::size_t forced, IslandBlocksWork& work) {
  if (key.contacts.size() < (forced > 0 ? 1 : contacts_to_split_least)) {
    count_ = 0;
    return false;
  }
  const bool is_hit = valid_for(key);
  count_use(is_hit);
  if (is_hit) {
    if (!has_rows(key.rows)) assign_rows(key.rows, work);
    return true;
  }
  count_ = 0;
  if (forced == 0 && ticks_unsplit_ > 0) {
    --ticks_unsplit_;
    return false;
  }
  ticks_unsplit_ = ticks_between_splits;
  return rebuild(key, forced, work);
}

/// Puts several islands into each block, in the order of their first rows. False: most contacts are of one island.
bool IslandBlocks::rebuild(const IslandBlocksKey& key, std::size_t forced, IslandBlocksWork& work) {
  std::vector<std::uint32_t>& parent = work.island_parent;
  parent.resize(key.body_count);
  for (std::uint32_t row = 0; row < key.body_count; ++row) parent[row] = row;
  for (const ContactBodies& bodies : key.contacts)
    if (moves_both(bodies)) unite(parent, bodies.a, bodies.b);
  std::vector<std::uint32_t>& counts = work.counts;
  counts.assign(key.body_count, 0);
  std::uint32_t most = 0;
  for (const ContactBodies& bodies : key.contacts)
    most = std::max(most, ++counts[find_root(parent, dynamic_body_of(bodies))]);
  if (forced == 0 && most > key.contacts.size() / 2) return false;
  const std::size_t wanted = forced > 0 ? forced : contacts_per_block;
  block_of_.assign(key.body_count, no_block);
  std::uint32_t block = 0;
  std::uint32_t in_block = 0;
  for (std::uint32_t row = 0; row < key.body_count; ++row) {
    const std::uint32_t root = find_root(parent, row);
    if (root == row && counts[row] > 0) {
      if (in_block > 0 && in_block + counts[row] > wanted) {
        ++block;
        in_block = 0;
      }
      in_block += counts[row];
      block_of_[row] = block;
    }
    block_of_[row] = block_of_[root];  // a root precedes its island
  }
  count_ = block + 1;
  generation_ = generation_ == 0xffffffff ? 1 : generation_ + 1;
  assign_rows(key.rows, work);
  return true;
}

void IslandBlocks::assign_rows(std::span<const std::uint32_t> rows, IslandBlocksWork& work) {
  set_rows_.assign(rows.begin(), rows.end());
  sort_by_block(
      count_, rows.size(), [&](std::size_t i) { return block_of_[rows[i]]; }, row_starts_, work.counts, rows_);
  for (std::uint32_t& row : rows_) row = rows[row];
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
