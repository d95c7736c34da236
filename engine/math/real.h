// Real: the one scalar type of the engine's state and kernels, f32 or f64 by compilation.
// SPDX-License-Identifier: MIT
//
// Sources that include this header are compiled twice, once per precision, into two namespaces: ticktrue::engine::f32
// and ticktrue::engine::f64. Their text uses one type.
#pragma once

#include <cstdint>

#include "engine/math/precision.h"
#include "engine/math/scalar.h"

namespace ticktrue::engine {
namespace f32 {
inline constexpr Precision precision = Precision::f32;
inline constexpr Real epsilon = 0x1p-23f;
inline Real square_root(Real x) {
  return __builtin_sqrtf(x);
}
}  // namespace f32
namespace f64 {
inline constexpr Precision precision = Precision::f64;
inline constexpr Real epsilon = 0x1p-52;
inline Real square_root(Real x) {
  return __builtin_sqrt(x);
}
}  // namespace f64
}  // namespace ticktrue::engine
