// Checks values that a program passes to calls, and the messages about wrong values.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "base/limits.h"
#include "base/result.h"

namespace ticktrue::capi {

inline std::string_view text_of(const char* text) {
  // Bounded: a name without a terminator is too long, and is not read out of bounds.
  return text == nullptr ? std::string_view() : std::string_view(text, strnlen(text, limits::name_size_max + 1));
}

inline Error usage(const std::string& message, const std::string& hint = "") {
  return {ErrorCode::usage, message, hint};
}

inline std::string number(std::uint64_t value) {
  return std::to_string(value);
}

}  // namespace ticktrue::capi
