// Fault injection: flips single bits of a simulation's state, and requires that verify reports the exact place.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/state/simulation.h"
#include "replay/trace_reader.h"
#include "verifier/report/report.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::verifier {

struct InjectOptions {
  const SimulationInfo* simulation = nullptr;
  std::uint64_t count = 1;
  std::uint64_t seed = 1;
  // A field that is set applies to each flip. The other fields are drawn at random for each flip.
  std::optional<std::uint64_t> tick;
  std::string table;   // empty: any
  std::string column;  // empty: any
  std::optional<std::uint64_t> row;
  std::optional<std::uint32_t> lane;
  std::optional<std::uint32_t> bit;            // 0: the lowest
  std::uint32_t body_count = 0;                // this number of bodies, one bit each; 0: one bit in any table
  std::optional<std::uint32_t> after_substep;  // inside the solver, in one body; absent: at the end of the tick
  std::function<void(std::uint64_t flips_done)> progress;  // may be empty; called by one thread at a time

  unsigned thread_count = 1;  // number of parallel flips, if `reopen` is set; the report does not depend on it
  /// Opens the same trace for another thread; null: this failed. If it is empty, one thread is used.
  std::function<std::unique_ptr<TraceSource>()> reopen;
};

/// One flip and the verdict of verify.
struct InjectRow {
  enum class Outcome : std::uint8_t { missed, found, not_applicable };
  std::uint64_t index = 0;
  Outcome outcome = Outcome::missed;
  std::uint64_t tick = 0;
  struct Flipped {
    LaneReport place;  // expected: the true bits, got: the flipped bits; inside the solver both are unknown
    std::uint32_t bit = 0;
  };
  LaneReport place;  // of the first flipped bit
  std::uint32_t bit = 0;
  std::vector<Flipped> more;      // further bits of this flip
  bool place_required = false;    // the trace stores the state of this tick: verify must report the exact place
  bool cells_required = false;    // it stores cells: exact table and columns, and each concerned row in the list
  bool waived = false;            // inside the solver: its own row is unchanged, and need not be listed
  std::uint64_t concerned = 0;    // with cells: number of rows (bodies) that the flip concerns
  std::uint64_t list_length = 0;  // number of rows that verify listed
  std::string reason;             // why it was missed or is not applicable
  Verdict verdict = Verdict::match;
  std::optional<Divergence> divergence;  // what verify reported
};

struct InjectReport {
  std::string file;
  std::string detail;
  std::uint64_t seed = 0;
  bool is_inside = false;  // the flips were inside the solver
  Report baseline;         // the trace without a flip; flips are made only if it matches
  std::uint64_t passed = 0;
  std::uint64_t failed = 0;
  std::uint64_t not_applicable = 0;
  std::uint64_t waived = 0;     // passed flips whose own row was not required in the list
  std::vector<InjectRow> rows;  // by index
  // Statistics of the flips found by cells, without waived flips.
  struct Lengths {
    std::uint64_t count = 0, median = 0, max = 0, median_concerned = 0;
  };
  Lengths lists;

  int exit_code() const;
};

/// Verifies the trace, then injects options.count flips, each at the end of a tick, each through verify_source.
/// Errors: usage (no such tick, table, column or row in this trace).
Result<InjectReport> inject(replay::TraceReader& reader, const InjectOptions& options);

std::string inject_text(const InjectReport& report);
std::string inject_json(const InjectReport& report);  // schema ticktrue.inject/1

}  // namespace ticktrue::verifier
