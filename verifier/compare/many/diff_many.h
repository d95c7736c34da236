// Compares three or more recordings of one match without simulating, and names the traces outside the majority.
// SPDX-License-Identifier: MIT
//
// Verified, for each tick that at least two traces have: dt and inputs, root hash; hashes after the stages, state image
// and cells, if two traces store them; each checkpoint against the tick before it. Not verified: traces with another
// simulation, physics version or schema than the majority.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "verifier/compare/diff.h"
#include "verifier/compare/many/input_difference.h"
#include "verifier/compare/many/trace_groups.h"
#include "verifier/report/likely_causes.h"

namespace ticktrue::verifier {

/// A requested trace.
struct OpenedTrace {
  std::string file;
  replay::TraceReader* reader = nullptr;  // null: the file could not be opened
  std::string error = {};                 // the reason if `reader` is null
};

struct ManyTrace {
  DiffSide side;
  std::string error;         // why the file could not be opened; empty: it was opened
  bool is_compared = false;  // its setup and schema can be compared
  std::uint64_t first_tick = 0;
  std::optional<std::uint64_t> inputs_from;  // first tick in which a majority has other inputs
  std::optional<std::uint64_t> state_from;   // first tick after which a majority has another state
};

/// Traces with the same value of a fact.
struct FactValue {
  std::string value;
  TraceGroup traces;
};

/// A fact with different values.
struct TraceFact {
  std::string what;
  std::vector<FactValue> values;  // the largest group first
  bool changes_bits = false;      // of a build: floats can differ because of it
};

/// Traces with the same state, which differs from the reference.
struct OddState {
  TraceGroup traces;
  Divergence divergence;  // expected: from the reference; got: from these traces
  std::vector<Cause> why;
};

/// The first tick with different root hashes.
struct StateFinding {
  std::uint64_t tick = 0;
  bool is_start = false;  // the states before this tick differ already
  TraceGroups who;
  TraceGroup reference;       // the majority; without a majority, one of the largest groups
  std::vector<OddState> odd;  // all other groups
};

/// The traces that went wrong first, if there is a majority.
struct Blame {
  TraceGroup traces;
  std::string_view by;  // inputs, state
  std::uint64_t tick = 0;
};

struct DiffManyReport {
  DiffVerdict verdict = DiffVerdict::equal;
  std::string reason;
  std::string simulation;
  std::vector<ManyTrace> traces;  // in the given order
  std::uint64_t ticks_compared = 0;
  std::uint64_t checkpoints_compared = 0;
  ComparedParts compared;
  std::vector<TraceFact> setup;
  std::vector<TraceFact> build;  // facts about programs
  std::optional<InputsFinding> inputs;
  std::optional<StateFinding> state;
  std::optional<Blame> blame;
  std::vector<std::string> contradictions;  // contradictions inside one trace
  std::vector<std::string> notes;
  std::vector<std::string> again;

  int exit_code(bool allow_truncated = false) const;
};

/// Reads all traces to their ends, tick by tick in parallel.
/// Requires: at least two open traces.
DiffManyReport diff_many(std::span<const OpenedTrace> traces, const DiffOptions& options);

std::string diff_many_text(const DiffManyReport& report);
std::string diff_many_json(const DiffManyReport& report);  // schema ticktrue.diff_many/2

}  // namespace ticktrue::verifier
