// What the calling thread's floating point does, found by arithmetic: rounding, subnormals, contraction.
// SPDX-License-Identifier: MIT
//
// Control words differ from CPU to CPU and some have none (WebAssembly); a product that must come out as a certain
// number tells the same everywhere. A dozen operations: cheap enough for the start of every run and of every thread.
#pragma once

#include <string_view>

#include "base/result.h"

namespace ticktrue {

struct FloatBehaviour {
  std::string_view rounding;         // "nearest", "upward", "downward", "toward_zero"
  bool flushes_to_zero = false;      // subnormal results become zero
  bool subnormals_are_zero = false;  // subnormal operands count as zero
  bool contracts = false;            // a * b + c is rounded once

  bool operator==(const FloatBehaviour&) const = default;
};

/// Of the calling thread, in f32 and f64.
FloatBehaviour probe_float_behaviour();

/// Whether the calling thread may simulate: its results would be those of other machines.
/// Errors: unsupported, with what was found.
Status check_float_behaviour();

/// The same for a given behaviour.
Status check_float_behaviour(const FloatBehaviour& behaviour);

}  // namespace ticktrue
