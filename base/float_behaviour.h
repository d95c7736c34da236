// The floating point behaviour of the calling thread, found by arithmetic: rounding, subnormals, contraction.
// SPDX-License-Identifier: MIT
//
// Control words differ between CPUs, and some CPUs have none (WebAssembly). A product with a known result gives the
// same answer everywhere. A dozen operations are cheap enough for the start of every run and of every thread.
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

/// The behaviour of the calling thread, in f32 and f64.
FloatBehaviour probe_float_behaviour();

/// Whether the calling thread may simulate: its results would equal those of other machines.
/// Errors: unsupported, with the found behaviour.
Status check_float_behaviour();

/// Checks a given behaviour.
Status check_float_behaviour(const FloatBehaviour& behaviour);

}  // namespace ticktrue
