// Finds the first call that a run makes otherwise: runs of a program, then once more for the list of one tick.
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
  std::vector<std::string> words;    // of the program, with the trace in them
  std::vector<std::string> against;  // of another program; empty: the trace is the other side
  std::string calls;                 // that the preload library marks: "random,libm"; empty: none
  shake::LaunchOptions launch;       // without words
};

/// `same`: no mark differs. `not_reproducible`: the second run of a program made other marks than its first.
enum class TrailVerdict : std::uint8_t { differ, same, not_reproducible };
const char* name_of(TrailVerdict verdict);

struct TrailReport {
  TrailVerdict verdict = TrailVerdict::same;
  shake::Outcome here;
  std::optional<shake::Outcome> there;  // of the other program
  std::uint64_t tick_count = 0;         // whose marks were compared
  std::optional<verifier::MarksDifference> marks;
  ListDifference lists;
  bool has_list_here = false;
  bool has_list_there = false;   // else counts and hashes alone are known
  bool is_against_lost = false;  // not_reproducible: by the other program
  std::vector<std::string> notes;
};

/// Errors: io (files of runs), usage (nothing can be compared).
Result<TrailReport> run_trail(const TrailOptions& options);

}  // namespace ticktrue::trail
