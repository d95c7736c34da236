// How a run of a program ended, and what its session said.
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

/// `other`: a verdict that is neither match nor diverged. `no_result`: the program ended without one.
enum class OutcomeKind : std::uint8_t { match, diverged, other, no_result, crashed, hung, not_started };

/// Of a column, as the report has it.
struct OutcomeValue {
  std::string text;  // empty: none
  bool is_number = false;
};

struct Outcome {
  OutcomeKind kind = OutcomeKind::not_started;
  std::string reason;      // of all but match and diverged: one line
  std::uint64_t tick = 0;  // diverged: the tick at whose end the states differ; crashed, hung: the tick that ran
  std::string stage;       // where known
  std::string table;       // where known
  std::string column;      // where known
  std::optional<std::uint64_t> row;
  std::string row_name;
  OutcomeValue expected;  // of the first lane, where the trace holds it
  OutcomeValue got;
  std::string got_hash;  // of the state of that tick
  std::uint64_t ticks_compared = 0;
  int exit_status = 0;
  double wall_s = 0;
  std::vector<verifier::EscapedChild> escaped;  // processes that were left behind

  // Of the page.
  bool has_shim = false;     // the preload library was loaded
  bool has_session = false;  // a session was opened
  std::uint64_t changed_count = 0;
  std::array<std::uint64_t, shim::function_count> call_counts{};
  std::array<std::uint64_t, shim::function_count> tick_counts{};

  std::uint64_t calls_of(shim::Group group) const;
};

/// "diverged", "crashed" and so on: as in JSON.
const char* outcome_name(OutcomeKind kind);

/// Two runs with the same signature did the same.
std::string signature(const Outcome& outcome);

/// `result`: the lines of the result file, or the JSON that the program printed.
Outcome judge(const verifier::ChildResult& child, const verifier::ChildLimits& limits, const std::string& result,
              const shim::Page* page);

/// "tick 33  units.score row 7 "unit_7"  25 -> 42309", or the reason.
std::string outcome_text(const Outcome& outcome);

}  // namespace ticktrue::shake
