// Likely bugs behind a difference, from marks in the values.
// SPDX-License-Identifier: MIT
//
// A cause is named only if the values have its mark: a fill byte of a debug heap, an address, two zeros of different
// sign, rows with exchanged values. Without a mark, no cause is named. The engine has no such bugs: for
// `ticktrue.engine` no cause is named.
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
  std::string_view text;  // for people: the mark, and its possible origin
};
inline constexpr std::size_t cause_count = 17;
extern const std::array<CauseInfo, cause_count> causes;
const CauseInfo& cause_info(Cause cause);

/// The known facts about a difference between two runs.
struct Symptoms {
  std::string_view simulation;
  const Divergence* divergence = nullptr;  // null: no difference
  const MarksDifference* marks = nullptr;  // null: equal to the recorded marks, or not compared
  const replay::BuildFacts* build_a = nullptr;
  const replay::BuildFacts* build_b = nullptr;
  bool repeats = true;                // two runs here are equal
  bool begins_at_checkpoint = false;  // a run from the start has no difference
};

/// At most two causes, the likelier first. Empty: no difference, or no mark of a known bug in the values.
std::vector<Cause> likely_causes(const Symptoms& symptoms);
std::vector<Cause> likely_causes(const Report& report);
/// The mark and its possible origin; the second line begins with "or".
std::vector<std::string> cause_lines(const std::vector<Cause>& found);

}  // namespace ticktrue::verifier
