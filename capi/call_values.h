// Checks values that a program passes to calls, and the messages about wrong values.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"
#include "base/state/declared_members.h"

namespace ticktrue::capi {

inline std::string_view text_of(const char* text) {
  return bounded_name(text);
}

inline Error usage(const std::string& message, const std::string& hint = "") {
  return {ErrorCode::usage, message, hint};
}

inline std::string number(std::uint64_t value) {
  return std::to_string(value);
}

}  // namespace ticktrue::capi
