// Compares two traces without simulating.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/state/simulation.h"
#include "replay/trace_reader.h"
#include "verifier/compare/setup_difference.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

enum class DiffVerdict : std::uint8_t { equal, different, damaged, incomplete, not_comparable };
struct DiffVerdictInfo {
  DiffVerdict verdict;
  std::string_view name;
  int exit_code;
  std::string_view summary;
};
inline constexpr std::array<DiffVerdictInfo, 5> diff_verdicts{{
    {DiffVerdict::equal, "equal", exit_ok, "same setup, inputs and states at every tick"},
    {DiffVerdict::different, "different", exit_finding, "setup, inputs, states or length differ"},
    {DiffVerdict::damaged, "damaged", exit_damaged, "equal as far as both are intact; one is damaged behind that"},
    {DiffVerdict::incomplete, "incomplete", exit_incomplete, "equal as far as both go; one ends early"},
    {DiffVerdict::not_comparable, "not_comparable", exit_not_comparable, "of different simulations or schemas"},
}};
const DiffVerdictInfo& diff_verdict_info(DiffVerdict verdict);

/// The first tick whose inputs or dt differ.
struct InputDifference {
  std::uint64_t tick = 0;
  double dt_a = 0;  // s
  double dt_b = 0;
  std::string inputs_a;  // JSON Lines
  std::string inputs_b;
};

/// Consecutive ticks, inclusive.
struct TickRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

struct DiffSide {
  std::string file;
  std::optional<std::uint64_t> ticks;  // number of readable ticks
  TraceEnd end;
  replay::BuildFacts build;
};

struct DiffReport {
  DiffVerdict verdict = DiffVerdict::equal;
  std::string reason;
  std::string simulation;  // of trace a
  DiffSide a, b;
  std::uint64_t ticks_compared = 0;
  std::uint64_t checkpoints_compared = 0;  // up to the first difference
  ComparedParts compared;                  // up to the first difference
  std::vector<SetupDifference> setup;
  std::optional<InputDifference> inputs;
  std::optional<Divergence> divergence;  // expected: from a, got: from b
  std::vector<TickRange> differing;      // ticks with different states; the last range may include equal states
  std::vector<std::string> notes;
  std::vector<std::string> again;

  int exit_code(bool allow_truncated = false) const;
};

struct DiffOptions {
  const SimulationInfo* simulation = nullptr;  // formats inputs as text; may be null
  std::size_t row_count_max = 64;
  std::function<void(std::uint64_t ticks_done)> progress;  // may be empty
  /// The keys of two setups that differ, where both can be read; may be empty.
  std::function<SetupKeys(const replay::TraceSetup& a, const replay::TraceSetup& b)> setup_keys;
  /// As in VerifyOptions; empty: only the program that recorded the traces can record again.
  std::string tool = "ticktrue";
};

/// Reads both traces to their ends.
DiffReport diff(replay::TraceReader& a, replay::TraceReader& b, const DiffOptions& options);

std::string diff_text(const DiffReport& report);
std::string diff_json(const DiffReport& report);  // schema ticktrue.diff/2

}  // namespace ticktrue::verifier
