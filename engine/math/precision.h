// The two precisions that the engine is compiled in.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace ticktrue::engine {

enum class Precision : std::uint8_t { f32, f64 };

}  // namespace ticktrue::engine
