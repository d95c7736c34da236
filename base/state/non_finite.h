// The place of a value that is not finite, as text and as fields.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/state/simulation.h"

namespace ticktrue {

/// The first NaN or infinity of a state, for people: "table bodies, row 41 (crate_7), column velocity, lane 1".
struct NonFinite {
  std::uint64_t tick = 0;
  std::string table;
  std::uint64_t row = 0;
  std::string row_name;
  std::string column;
  std::uint32_t lane = 0;
  std::string value;
};
std::optional<NonFinite> find_non_finite_of(const Simulation& simulation, std::uint64_t tick);
std::string non_finite_text(const NonFinite& found);

}  // namespace ticktrue
