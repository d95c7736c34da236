// Blocks of islands: the division into islands that are coloured and solved together.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/math/real.h"
#include "engine/model/caches.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The rows of a contact's dynamic bodies; no_body for other bodies.
struct ContactBodies {
  std::uint32_t a;
  std::uint32_t b;

  bool operator==(const ContactBodies&) const = default;
};
inline constexpr std::uint32_t no_body = 0xffffffff;

inline bool moves_both(const ContactBodies& bodies) {
  return bodies.a != no_body && bodies.b != no_body;
}
inline std::uint32_t dynamic_body_of(const ContactBodies& bodies) {
  return bodies.a != no_body ? bodies.a : bodies.b;
}

/// The workspace of the search for islands and of the sorting by block.
struct IslandBlocksWork {
  std::vector<std::uint32_t> island_parent;  // [body]
  std::vector<std::uint32_t> counts;         // [body] contacts of the island, at its first row; [block] its start
};

template <typename Visit>
void list_fields(IslandBlocksWork& of, const Visit& visit) {
  auto& [island_parent, counts] = of;
  visit(island_parent, counts);
}

/// The inputs of the division into blocks.
struct IslandBlocksKey {
  std::span<const ContactBodies> contacts;  // of the set
  std::span<const std::uint32_t> rows;      // dynamic bodies of the set
  std::size_t body_count;
  bool same_contacts;  // the contacts are those of the last valid blocks
};

inline constexpr std::uint32_t no_block = 0xffffffff;

/// The division of a set's bodies into blocks that share no contact. Key: no contact connects two blocks. If the rows
/// of the set have changed, they are assigned to the blocks again.
class IslandBlocks final : public TickCache {
 public:
  IslandBlocks() : TickCache(CacheKind::contact_blocks) {}

  /// Whether each contact is within one block.
  bool valid_for(const IslandBlocksKey& key) const;
  /// Makes the blocks unless they are valid. `forced`: contacts per block, or 0 for the default. False: blocks do not
  /// pay, and there are none.
  bool follow(const IslandBlocksKey& key, std::size_t forced, IslandBlocksWork& work);
  void invalidate() override;

  /// A different number for each division; never 0.
  std::uint32_t generation() const { return generation_; }
  std::size_t count() const { return count_; }
  std::uint32_t block_of(std::uint32_t row) const { return block_of_[row]; }
  /// The rows of dynamic bodies in a block.
  std::span<const std::uint32_t> rows(std::size_t block) const {
    return {rows_.data() + row_starts_[block], row_starts_[block + 1] - row_starts_[block]};
  }
  /// The rows in no block.
  std::span<const std::uint32_t> free_rows() const { return std::span(rows_).subspan(row_starts_[count_]); }

 private:
  bool has_rows(std::span<const std::uint32_t> rows) const;
  bool rebuild(const IslandBlocksKey& key, std::size_t forced, IslandBlocksWork& work);
  void assign_rows(std::span<const std::uint32_t> rows, IslandBlocksWork& work);

  std::uint32_t generation_ = 1;
  std::size_t count_ = 0;
  std::vector<std::uint32_t> block_of_;    // [body] its block, or no_block
  std::vector<std::uint32_t> set_rows_;    // rows of the key
  std::vector<std::uint32_t> rows_;        // [block] rows of dynamic bodies; then the rows in no block
  std::vector<std::uint32_t> row_starts_;  // [block] in rows_, and the end
  std::uint32_t ticks_unsplit_ = 0;        // until islands are searched for again
};

/// Sorts the elements 0..count-1 by block into `out`, stable. block_at(i): the block of element i, or no_block.
/// `starts`: [block] its start, and the end of the last block.
template <typename BlockAt>
void sort_by_block(std::size_t block_count, std::size_t count, const BlockAt& block_at,
                   std::vector<std::uint32_t>& starts, std::vector<std::uint32_t>& next,
                   std::vector<std::uint32_t>& out) {
  const auto place_of = [&](std::size_t i) {
    const std::size_t block = block_at(i);
    return block < block_count ? block : block_count;
  };
  next.assign(block_count + 2, 0);
  for (std::size_t i = 0; i < count; ++i) ++next[place_of(i) + 1];
  for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
  starts.assign(next.begin(), next.begin() + static_cast<std::ptrdiff_t>(block_count) + 1);
  out.resize(count);
  for (std::size_t i = 0; i < count; ++i) out[next[place_of(i)]++] = static_cast<std::uint32_t>(i);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
