// Proves that verify finds what it should: flips single bits of a simulation's state and requires the exact place back.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "base/simulation.h"
#include "replay/trace_reader.h"
#include "verifier/report.h"

namespace ticktrue::verifier {

struct InjectOptions {
  const SimulationInfo* simulation = nullptr;
  std::uint64_t count = 1;
  std::uint64_t seed = 1;
  // What is given is kept; the rest is drawn anew for each flip.
  std::optional<std::uint64_t> tick;
  std::string table;   // empty: any
  std::string column;  // empty: any
  std::optional<std::uint64_t> row;
  std::optional<std::uint32_t> lane;
  std::optional<std::uint32_t> bit;                        // 0: the lowest
  std::function<void(std::uint64_t flips_done)> progress;  // may be empty
};

/// One flip and what verify said of it.
struct InjectRow {
  enum class Outcome : std::uint8_t { missed, found, not_applicable };
  std::uint64_t index = 0;
  Outcome outcome = Outcome::missed;
  std::uint64_t tick = 0;
  LaneReport place;  // expected: the true bits, got: the flipped ones
  std::uint32_t bit = 0;
  bool place_required = false;  // false: the trace stores only the hash of this tick, so only the tick was required
  std::string reason;           // why missed or not applicable
  Verdict verdict = Verdict::match;
  std::optional<Divergence> divergence;  // what verify reported
};

struct InjectReport {
  std::string file;
  std::string detail;
  std::uint64_t seed = 0;
  Report baseline;  // the trace without any flip; nothing is injected unless it matches
  std::uint64_t passed = 0;
  std::uint64_t failed = 0;
  std::uint64_t not_applicable = 0;
  std::vector<InjectRow> rows;  // by index

  int exit_code() const;
};

/// Verifies the trace, then injects options.count flips, each at the end of a tick, each through verify_source.
/// Errors: usage (no such tick, table, column or row in this trace).
Result<InjectReport> inject(replay::TraceReader& reader, const InjectOptions& options);

std::string inject_text(const InjectReport& report);
std::string inject_json(const InjectReport& report);  // schema ticktrue.inject/1

}  // namespace ticktrue::verifier
