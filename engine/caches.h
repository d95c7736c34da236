// The cached structures of an engine: their names, and how often each was used again.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace ticktrue::engine {

/// A cached structure. None of them is state: a tick gives the same bits with each of them, without it, or with any
/// subset of them forgotten.
enum class CacheKind : std::uint8_t {
  pair_list,       // fat AABBs, the trees over them and the pairs that overlap
  boxes,           // tight AABBs with a margin, in which slow bodies stay
  present_pairs,   // pairs of the tick before whose AABBs overlap
  manifolds,       // manifolds of pairs whose poses have not changed
  contact_places,  // contacts are written in the places of the tick before
  pair_blocks,     // candidates, lanes and features of 64 pairs
  velocity_steps,  // gravity and damping over one substep, per body
  free_motion,     // decay and gain over one substep, per body of the scene
  joint_plan,      // the order and the batches of joints
  contact_colors,  // colours and slots of contacts
  contact_blocks,  // which islands are solved together
  cell_side,       // side of the cells of neighbour_cells
};
inline constexpr std::size_t cache_kind_count = 12;

struct CacheInfo {
  CacheKind kind;
  std::string_view name;
};
inline constexpr std::array<CacheInfo, cache_kind_count> cache_kinds{{
    {CacheKind::pair_list, "pair_list"},
    {CacheKind::boxes, "boxes"},
    {CacheKind::present_pairs, "present_pairs"},
    {CacheKind::manifolds, "manifolds"},
    {CacheKind::contact_places, "contact_places"},
    {CacheKind::pair_blocks, "pair_blocks"},
    {CacheKind::velocity_steps, "velocity_steps"},
    {CacheKind::free_motion, "free_motion"},
    {CacheKind::joint_plan, "joint_plan"},
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

/// Since the engine was made.
struct CacheCounts {
  std::uint64_t hits = 0;           // uses of the result of an earlier tick
  std::uint64_t invalidations = 0;  // checks that failed, so that it was made anew
};
using CacheReport = std::array<CacheCounts, cache_kind_count>;

inline void count_use(CacheReport& report, CacheKind kind, bool was_hit) {
  CacheCounts& counts = report[static_cast<std::size_t>(kind)];
  ++(was_hit ? counts.hits : counts.invalidations);
}
inline void count_uses(CacheReport& report, CacheKind kind, CacheCounts more) {
  CacheCounts& counts = report[static_cast<std::size_t>(kind)];
  counts.hits += more.hits;
  counts.invalidations += more.invalidations;
}

}  // namespace ticktrue::engine
