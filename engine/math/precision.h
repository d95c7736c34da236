// The two precisions in which the engine is compiled.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace ticktrue::engine {

enum class Precision : std::uint8_t { f32, f64 };

}  // namespace ticktrue::engine
