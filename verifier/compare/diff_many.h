// Compares three or more recordings of one match without simulating, and names the odd ones out.
// SPDX-License-Identifier: MIT
//
// Verified, of every tick that at least two traces have: dt and inputs, root hash, and where two store it the hashes
// after the stages, the state image and the cells; each checkpoint with the tick before it. Not verified: traces that
// are of another simulation, physics version or schema than most.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "verifier/compare/diff.h"
#include "verifier/compare/input_difference.h"
#include "verifier/compare/trace_groups.h"
#include "verifier/report/likely_causes.h"

namespace ticktrue::verifier {

/// A trace that was asked for.
struct OpenedTrace {
  std::string file;
  replay::TraceReader* reader = nullptr;  // null: the file could not be opened
  std::string error = {};                 // then why
};

struct ManyTrace {
  DiffSide side;
  std::string error;         // not opened; empty: it was
  bool is_compared = false;  // its setup and schema allow it
  std::uint64_t first_tick = 0;
  std::optional<std::uint64_t> inputs_from;  // first tick in which a majority has other inputs
  std::optional<std::uint64_t> state_from;   // first tick at whose end a majority has another state
};

/// Traces with one value of a fact.
struct FactValue {
  std::string value;
  TraceGroup traces;
};

/// A fact that is not the same for all.
struct TraceFact {
  std::string what;
  std::vector<FactValue> values;  // the largest group first
  bool changes_bits = false;      // of a build: floats can differ because of it
};

/// Traces with another state than the reference, and with one state among themselves.
struct OddState {
  TraceGroup traces;
  Divergence divergence;  // expected: of the reference; got: of these
  std::vector<Cause> why;
};

/// The first tick whose root hashes are not the same.
struct StateFinding {
  std::uint64_t tick = 0;
  bool is_start = false;  // the states before this tick differ already
  TraceGroups who;
  TraceGroup reference;       // the majority; without one, one of the largest groups
  std::vector<OddState> odd;  // all other groups
};

/// Who went wrong first, where a majority tells.
struct Blame {
  TraceGroup traces;
  std::string_view by;  // inputs, state
  std::uint64_t tick = 0;
};

struct DiffManyReport {
  DiffVerdict verdict = DiffVerdict::equal;
  std::string reason;
  std::string simulation;
  std::vector<ManyTrace> traces;  // as they were given
  std::uint64_t ticks_compared = 0;
  std::uint64_t checkpoints_compared = 0;
  ComparedParts compared;
  std::vector<TraceFact> setup;
  std::vector<TraceFact> build;  // facts of programs
  std::optional<InputsFinding> inputs;
  std::optional<StateFinding> state;
  std::optional<Blame> blame;
  std::vector<std::string> contradictions;  // of a trace with itself
  std::vector<std::string> notes;
  std::vector<std::string> again;

  int exit_code(bool allow_truncated = false) const;
};

/// Reads all traces to their ends, tick by tick side by side.
/// Requires: at least two of them are open.
DiffManyReport diff_many(std::span<const OpenedTrace> traces, const DiffOptions& options);

std::string diff_many_text(const DiffManyReport& report);
std::string diff_many_json(const DiffManyReport& report);  // schema ticktrue.diff_many/2

}  // namespace ticktrue::verifier
