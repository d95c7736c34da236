// Blocks of pairs, as the narrow phase looks at them and keeps them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/model/proxies.h"
#include "engine/narrow_phase/box_lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A pair of a block that may touch.
struct Candidate {
  std::uint8_t index;  // in the block
  std::uint8_t place;  // among its boxes, or no_place
};
inline constexpr std::uint8_t no_place = 0xff;

/// Pairs that follow each other, those of them that may touch, and those that did when last looked at. Pairs,
/// candidates and boxes follow from the pairs alone, as long as shapes and margins are the same; what was found holds
/// for the very next look.
struct PairBlock {
  static constexpr std::size_t pair_count_max = 64;

  bool is_valid = false;
  std::uint32_t pair_count = 0;
  std::uint32_t candidate_count = 0;
  std::uint32_t box_count = 0;   // pairs of shapes with four sharp corners, for kernels
  std::uint32_t generation = 0;  // when `found` was
  std::uint64_t found = 0;       // [candidate] one bit each: it is a contact
  bool has_features = false;     // all candidates are boxes that touch at two points
  Pair pairs[pair_count_max];
  Candidate candidates[pair_count_max];
  BoxPairs boxes[pair_count_max / lane_count];
  BoxFeatures features[pair_count_max / lane_count];  // of `found`, where all are two points
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
