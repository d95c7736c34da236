// The behaviour of floating point here, found by arithmetic: rounding, subnormals, contraction, and a digest.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "base/float_behaviour.h"

namespace ticktrue::tool {

struct FloatEnvironment {
  FloatBehaviour behaviour;
  int evaluation_method = 0;  // FLT_EVAL_METHOD
  std::uint64_t digest = 0;   // of a few thousand operations in f32 and f64
};

/// The digest of every platform that follows IEEE 754 operation by operation.
inline constexpr std::uint64_t float_digest_expected = 0xa67fd07f0e75dd74u;

FloatEnvironment probe_float_environment();

/// Whether traces of other machines can be expected to verify here.
bool follows_rules(const FloatEnvironment& environment);

}  // namespace ticktrue::tool
