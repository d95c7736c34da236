// What a difference looks like, and which bugs look like that.
// SPDX-License-Identifier: MIT
//
// A cause is named only where the values show its mark: a fill byte of a debug heap, an address, two zeros of other
// sign, rows that have each other's values. Where no mark is seen, no cause is named. Ours is no simulation with such
// bugs: for `ticktrue.engine` nothing is named.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "verifier/report/report.h"

namespace ticktrue::verifier {

enum class Cause : std::uint8_t {
  contraction,
  fast_math,
  unsaved_state,
  shared_generator,
  uninitialised_memory,
  address,
  clock,
  negative_zero,
  flush_to_zero,
  conversion_out_of_range,
  decimal_comma,
  row_order,
  tie,
  thread_order,
  sum_order,
  other_math,
  random_numbers
};

struct CauseInfo {
  Cause cause;
  std::string_view name;  // in JSON
  std::string_view text;  // for people: what is seen, and what makes it
};
inline constexpr std::size_t cause_count = 17;
extern const std::array<CauseInfo, cause_count> causes;
const CauseInfo& cause_info(Cause cause);

/// What is known of a difference between two runs.
struct Symptoms {
  std::string_view simulation;
  const Divergence* divergence = nullptr;  // null: no difference
  const MarksDifference* marks = nullptr;  // null: as recorded, or not compared
  const replay::BuildFacts* build_a = nullptr;
  const replay::BuildFacts* build_b = nullptr;
  bool repeats = true;                // two runs here are equal
  bool begins_at_checkpoint = false;  // a run from the start does not differ
};

/// At most two, the likelier one first. Empty where nothing differs, and where the values have no mark of a known bug.
std::vector<Cause> likely_causes(const Symptoms& symptoms);
std::vector<Cause> likely_causes(const Report& report);
/// What is seen and what makes it; the second line begins with "or".
std::vector<std::string> cause_lines(const std::vector<Cause>& found);

}  // namespace ticktrue::verifier
