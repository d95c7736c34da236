// Real alone: the only part of real.h for units that are compiled for several instruction sets.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

#if !defined(TICKTRUE_PRECISION)
#error "compile with -DTICKTRUE_PRECISION=f32 or f64 (CMakeLists.txt does)"
#endif

namespace ticktrue::engine {
namespace f32 {
using Real = float;
}
namespace f64 {
using Real = double;
}
}  // namespace ticktrue::engine
