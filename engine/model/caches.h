// The cached structures of an engine: their names, and counts of their uses.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace ticktrue::engine {

/// A cached structure. No cached structure is state: a tick gives the same bits with it, without it, or after any
/// subset of them was forgotten.
enum class CacheKind : std::uint8_t {
  body_set,        // the ids and sources of the bodies: the meaning of rows in other structures
  pair_list,       // fat AABBs, the trees over them and the pairs that overlap
  boxes,           // tight AABBs with a margin, in which slow bodies stay
  present_pairs,   // pairs of the tick before whose AABBs overlap
  manifolds,       // manifolds of pairs whose poses have not changed
  contact_places,  // contacts are written to the places of the tick before
  pair_blocks,     // candidates, lanes and features of 64 pairs
  velocity_steps,  // gravity and damping over one substep, per body
  free_motion,     // decay and gain over one substep, per body of the scene
  joint_plan,      // the order and the batches of joints
  joint_graph,     // the bodies solved directly with their joints, and their order of elimination
  contact_colors,  // colours and slots of contacts
  contact_blocks,  // the islands that are solved together
  cell_side,       // side of the cells of neighbour_cells
};
inline constexpr std::size_t cache_kind_count = 14;

struct CacheInfo {
  CacheKind kind;
  std::string_view name;
};
inline constexpr std::array<CacheInfo, cache_kind_count> cache_kinds{{
    {CacheKind::body_set, "body_set"},
    {CacheKind::pair_list, "pair_list"},
    {CacheKind::boxes, "boxes"},
    {CacheKind::present_pairs, "present_pairs"},
    {CacheKind::manifolds, "manifolds"},
    {CacheKind::contact_places, "contact_places"},
    {CacheKind::pair_blocks, "pair_blocks"},
    {CacheKind::velocity_steps, "velocity_steps"},
    {CacheKind::free_motion, "free_motion"},
    {CacheKind::joint_plan, "joint_plan"},
    {CacheKind::joint_graph, "joint_graph"},
    {CacheKind::contact_colors, "contact_colors"},
    {CacheKind::contact_blocks, "contact_blocks"},
    {CacheKind::cell_side, "cell_side"},
}};

/// A set of cached structures, one bit each.
using CacheSet = std::uint32_t;
inline constexpr CacheSet all_caches = (CacheSet{1} << cache_kind_count) - 1;
constexpr CacheSet cache_bit(CacheKind kind) {
  return CacheSet{1} << static_cast<unsigned>(kind);
}

/// Counts since the engine was made.
struct CacheCounts {
  std::uint64_t hits = 0;           // uses of the result of an earlier tick
  std::uint64_t invalidations = 0;  // checks that failed, so that the structure was rebuilt
};
using CacheReport = std::array<CacheCounts, cache_kind_count>;

/// One cached structure: a class with a key; no other code writes its fields. Derived classes have `valid_for(key)`,
/// which tells whether the structure is valid, and `rebuild`, which makes it for a key. Three differ: any value of
/// `CellSide` is valid, and expires after some ticks; `ContactPlaces` holds a guess, which needs no key; `PairBlocks`
/// hands out its blocks, which the narrow phase tests and fills.
class TickCache {
 public:
  explicit TickCache(CacheKind kind) : kind_(kind) {}
  virtual ~TickCache() = default;
  /// Makes the next tick rebuild the structure.
  virtual void invalidate() = 0;
  CacheKind kind() const { return kind_; }
  CacheCounts counts() const { return counts_; }
  std::uint64_t hits() const { return counts_.hits; }

 protected:
  TickCache(const TickCache&) = default;
  TickCache& operator=(const TickCache&) = default;
  void count_use(bool was_hit) { ++(was_hit ? counts_.hits : counts_.invalidations); }
  void count_uses(CacheCounts more) {
    counts_.hits += more.hits;
    counts_.invalidations += more.invalidations;
  }

 private:
  CacheKind kind_;
  CacheCounts counts_;
};

inline void add_counts(CacheReport& to, const CacheReport& more) {
  for (std::size_t i = 0; i < cache_kind_count; ++i) {
    to[i].hits += more[i].hits;
    to[i].invalidations += more[i].invalidations;
  }
}

}  // namespace ticktrue::engine
