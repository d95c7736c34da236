// Fault injection: flips single bits of a simulation's state and requires that verify reports the exact place.
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
  // Fields that are set apply to every flip; the others are drawn at random for each flip.
  std::optional<std::uint64_t> tick;
  std::string table;   // empty: any
  std::string column;  // empty: any
  std::optional<std::uint64_t> row;
  std::optional<std::uint32_t> lane;
  std::optional<std::uint32_t> bit;            // 0: the lowest
  std::uint32_t body_count = 0;                // so many rows of the table of bodies at once; 0: one row of any table
  std::optional<std::uint32_t> after_substep;  // inside the solver, in one body, instead of at the end of the tick
  std::function<void(std::uint64_t flips_done)> progress;  // may be empty; called by one thread at a time

  unsigned thread_count = 1;  // flips at once, where `reopen` is given; the report is the same
  /// Opens the same trace for another thread; null if that fails. May be empty: then one thread is used.
  std::function<std::unique_ptr<TraceSource>()> reopen;
};

/// One flip and what verify said of it.
struct InjectRow {
  enum class Outcome : std::uint8_t { missed, found, not_applicable };
  std::uint64_t index = 0;
  Outcome outcome = Outcome::missed;
  std::uint64_t tick = 0;
  struct Flipped {
    LaneReport place;  // expected: the true bits, got: the flipped ones; inside the solver neither is known
    std::uint32_t bit = 0;
  };
  LaneReport place;  // the first of the flipped
  std::uint32_t bit = 0;
  std::vector<Flipped> more;      // flipped at once with it
  bool place_required = false;    // the trace stores the state of this tick: the exact place was required
  bool cells_required = false;    // it stores cells: exact table and columns, and every row concerned in the list
  bool waived = false;            // inside the solver: its own row ends as it should, only others can be in the list
  std::uint64_t concerned = 0;    // with cells: rows (bodies) that the flips concern
  std::uint64_t list_length = 0;  // and how many verify listed
  std::string reason;             // why missed or not applicable
  Verdict verdict = Verdict::match;
  std::optional<Divergence> divergence;  // what verify reported
};

struct InjectReport {
  std::string file;
  std::string detail;
  std::uint64_t seed = 0;
  bool is_inside = false;  // the flips were made inside the solver
  Report baseline;         // the trace without any flip; nothing is injected unless it matches
  std::uint64_t passed = 0;
  std::uint64_t failed = 0;
  std::uint64_t not_applicable = 0;
  std::uint64_t waived = 0;     // of those passed: flips whose own row was not required in the list
  std::vector<InjectRow> rows;  // by index
  // Over the flips found by cells; those waived concern no row that could be listed, and do not count there.
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
