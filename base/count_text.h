// A number with the noun that it counts: "1 tick", "2 ticks".
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

namespace ticktrue {

/// `noun`: the singular; its plural ends in s.
inline std::string count_text(std::uint64_t count, const char* noun) {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace ticktrue
