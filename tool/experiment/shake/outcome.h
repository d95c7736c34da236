// How a run of a program ended, and the verdict of its session.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shim/page.h"
#include "verifier/runs/child.h"

namespace ticktrue::shake {

/// `other`: a verdict other than match and diverged. `no_result`: the program ended without a verdict.
enum class OutcomeKind : std::uint8_t { match, diverged, other, no_result, crashed, hung, not_started };

/// A value of a column, as in the report.
struct OutcomeValue {
  std::string text;  // empty: none
  bool is_number = false;
};

struct Outcome {
  OutcomeKind kind = OutcomeKind::not_started;
  std::string reason;      // one line; empty for match and diverged
  std::uint64_t tick = 0;  // diverged: the tick at whose end the states differ; crashed, hung: the running tick
  std::string stage;       // empty: unknown
  std::string table;       // empty: unknown
  std::string column;      // empty: unknown
  std::optional<std::uint64_t> row;
  std::string row_name;
  OutcomeValue expected;  // of the first lane, if the trace stores it
  OutcomeValue got;
  std::string got_hash;  // of the state after that tick
  std::uint64_t ticks_compared = 0;
  int exit_status = 0;
  double wall_s = 0;
  std::vector<verifier::EscapedChild> escaped;  // processes that the run left behind

  // Read from the page:
  bool has_shim = false;     // the preload library was loaded
  bool has_session = false;  // a session was opened
  std::uint64_t changed_count = 0;
  std::array<std::uint64_t, shim::function_count> call_counts{};
  std::array<std::uint64_t, shim::function_count> tick_counts{};

  std::uint64_t calls_of(shim::Group group) const;
};

/// The name in JSON: "diverged", "crashed" and so on.
const char* outcome_name(OutcomeKind kind);

/// Runs with equal signatures behaved in the same way.
std::string signature(const Outcome& outcome);

/// `result`: the lines of the result file, or the JSON that the program printed.
Outcome judge(const verifier::ChildResult& child, const verifier::ChildLimits& limits, const std::string& result,
              const shim::Page* page);

/// "tick 33  units.score row 7 "unit_7"  25 -> 42309", or the reason.
std::string outcome_text(const Outcome& outcome);

}  // namespace ticktrue::shake
