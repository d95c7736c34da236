// A probe of everything the engine computes with, part by part: the digests that every platform must give.
// SPDX-License-Identifier: MIT
//
// Verified: the operations of IEEE 754, sine, cosine, arc tangent and decay, square roots, rotations and vector lanes
// in both precisions, and some ticks of a small scene in both precisions. Not verified: what no part runs through; the
// golden traces (`ticktrue verify traces`) go through all of the engine.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace ticktrue::tool {

struct ProbePart {
  std::string_view name;
  std::string_view what;
  std::uint64_t digest = 0;
  std::uint64_t expected = 0;
  bool is_right() const { return digest == expected; }
};

/// In this order: later parts are made of earlier ones, so the first that differs is the one to look at.
std::vector<ProbePart> probe_arithmetic();

}  // namespace ticktrue::tool
