// Re-simulates a trace and compares every tick with the recording.
// SPDX-License-Identifier: MIT
//
// Verified: of every tick all that the trace stores of it: root hash, hash after each stage, state image, cells; every
// checkpoint; that the state made from the setup is the recorded one; that a divergence shows again in a second run. In
// segments each run begins with a recorded checkpoint, and its end is compared with the checkpoint where the next one
// begins. What a run from a checkpoint finds is a divergence only if a run from the setup has a finding as well; else
// the state is incomplete. With sync_ticks each tick runs twice, as in a rollback, and must end in one state.
// Not verified in order (one thread, from the start): that a run from a checkpoint goes the same way.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/state/simulation.h"
#include "replay/trace_reader.h"
#include "verifier/report/report.h"
#include "verifier/verify/trace_source.h"

namespace ticktrue::verifier {

enum class VerifyMode : std::uint8_t { replay, restore, twice, threads };
struct VerifyModeInfo {
  VerifyMode mode;
  std::string_view name;
  std::string_view summary;
};
inline constexpr std::array<VerifyModeInfo, 4> verify_modes{{
    {VerifyMode::replay, "replay", "run from the start, compare every tick and checkpoint"},
    {VerifyMode::restore, "restore", "load each checkpoint into a fresh simulation and run on from there"},
    {VerifyMode::twice, "twice", "run twice side by side; needs no recorded hashes"},
    {VerifyMode::threads, "threads", "run with 1, 2, 4 and 8 threads; simulations that have one refuse"},
}};

/// One of several runs that divide the segments of a trace (verifier/verify/parts.h).
struct TracePart {
  std::size_t index = 0;
  std::size_t count = 1;
};

struct VerifyOptions {
  const SimulationInfo* simulation = nullptr;  // null: this build has none with this name
  VerifyMode mode = VerifyMode::replay;
  std::uint64_t from = 0;           // first tick to compare; the run begins at the last checkpoint at or before it
  std::optional<std::uint64_t> to;  // last tick to compare; later ticks are not read
  bool to_end = false;              // restore: run from each checkpoint to the end, instead of to the next checkpoint
  std::size_t row_count_max = 64;   // number of lanes and candidates in a report
  std::uint64_t spread_ticks = 64;  // ticks after a divergence in which differing rows are counted; 0: none
  std::function<void(std::uint64_t ticks_done)> progress;  // may be empty; called by one thread at a time

  /// Replay: after each so many ticks the simulation is brought back to the state before them, and they run again; 0:
  /// none do. In order, on one thread.
  std::uint64_t sync_ticks = 0;

  /// Called after each tick that counts as compared, with the simulated time at its end. May be empty; any thread.
  std::function<void(double time_s)> on_compared;

  /// If the trace stores only the hash of the differing tick: search a single bit that explains the hash (replay).
  bool search_single_bit = false;

  std::string tool = "ticktrue";  // the begin of commands in reports, with the options that load a plug-in

  /// Replay: walks segments between checkpoints, even with one thread. Several threads with `reopen` always do so.
  bool in_segments = false;
  /// Replay of the whole trace: walks only the segments of this part. Findings are not confirmed from the setup.
  std::optional<TracePart> part;
  /// Whether a finding of a run from a checkpoint is confirmed by a run from the setup. False for fault injection.
  bool confirm_from_start = true;

  unsigned thread_count = 1;  // number of parallel segments, if `reopen` is set
  /// Opens the same trace for another thread; null: this failed. If it is empty, one thread is used.
  std::function<std::unique_ptr<TraceSource>()> reopen;

  /// Wraps the simulation (fault injection); may be empty. `ticks_done`: number of ticks before its present state.
  std::function<std::unique_ptr<Simulation>(std::unique_ptr<Simulation> simulation, std::uint64_t ticks_done)> wrap;
};

/// Reads the whole trace (up to options.to) in bounded memory, also after a finding.
Report verify(replay::TraceReader& reader, const VerifyOptions& options);

/// The same for any source of records. Fills all of the report except `file` and the build facts.
Report verify_source(TraceSource& source, const VerifyOptions& options);

/// The warning that no state outside the table `world` changed in all these ticks.
std::string unchanged_state_warning(std::uint64_t tick_count);

/// The report of a trace that could not be opened.
Report open_error_report(const std::string& file, const Error& error);

}  // namespace ticktrue::verifier
