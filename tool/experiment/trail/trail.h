// Finds the first call that differs between two runs. Each program runs once, then once more for the list of one tick.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/experiment/shake/launch.h"
#include "tool/experiment/trail/mark_lists.h"
#include "verifier/report/report.h"

namespace ticktrue::trail {

struct TrailOptions {
  std::string trace;
  std::vector<std::string> words;    // the program with the trace in its arguments
  std::vector<std::string> against;  // another program; empty: the trace is the other side
  std::string calls;                 // calls that the preload library marks: "random,libm"; empty: none
  shake::LaunchOptions launch;       // without words
};

/// `same`: no mark differs. `not_reproducible`: the second run of a program made other marks than its first run.
enum class TrailVerdict : std::uint8_t { differ, same, not_reproducible };
const char* name_of(TrailVerdict verdict);

struct TrailReport {
  TrailVerdict verdict = TrailVerdict::same;
  shake::Outcome here;
  std::optional<shake::Outcome> there;  // of the other program
  std::uint64_t tick_count = 0;         // ticks whose marks were compared
  std::optional<verifier::MarksDifference> marks;
  ListDifference lists;
  bool has_list_here = false;
  bool has_list_there = false;   // false: only counts and hashes are known
  bool is_against_lost = false;  // not_reproducible: because of the other program
  std::vector<std::string> notes;
};

/// Errors: io (files of runs), usage (nothing to compare).
Result<TrailReport> run_trail(const TrailOptions& options);

}  // namespace ticktrue::trail
