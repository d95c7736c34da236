// Blocks of pairs: the unit in which the narrow phase tests and caches pairs.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/model/proxies.h"
#include "engine/narrow_phase/box_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A pair of a block that may have a contact.
struct Candidate {
  std::uint8_t index;  // in the block
  std::uint8_t place;  // among its boxes, or no_place
};
inline constexpr std::uint8_t no_place = 0xff;

/// Consecutive pairs, the candidates among them, and the contacts found last. While shapes and margins are the same,
/// candidates and boxes follow from the pairs alone. `found` is valid for the next generation only.
struct PairBlock {
  static constexpr std::size_t pair_count_max = 64;

  bool is_valid = false;
  std::uint32_t pair_count = 0;
  std::uint32_t candidate_count = 0;
  std::uint32_t box_count = 0;   // pairs of quadrilaterals, for kernels
  std::uint32_t generation = 0;  // of `found`
  std::uint64_t found = 0;       // [candidate] one bit each: the candidate has a contact
  bool has_features = false;     // all candidates are boxes with two points
  Pair pairs[pair_count_max];
  Candidate candidates[pair_count_max];
  BoxPairs boxes[pair_count_max / lane_count];
  BoxFeatures features[pair_count_max / lane_count];  // of `found`, if has_features
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
