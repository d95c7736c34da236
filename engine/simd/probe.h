// A run of the engine's own arithmetic in one precision. Its result is the same on every platform.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"

namespace ticktrue::engine {

// Results of square roots, rotations and vector lanes over arguments of many magnitudes, as bits, appended to `out`.
namespace f32 {
void probe_arithmetic(ByteWriter& out);
}
namespace f64 {
void probe_arithmetic(ByteWriter& out);
}

}  // namespace ticktrue::engine
