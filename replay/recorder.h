// Runs a simulation with inputs from a source and records a trace.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/result.h"
#include "base/state/simulation.h"
#include "replay/format/trace.h"
#include "replay/trace_writer.h"

namespace ticktrue::replay {

/// Where the inputs of a session come from: a file, a pipe, a program.
class InputSource {
 public:
  virtual ~InputSource() = default;
  /// The input of the given tick (asked for once, ascending), or nothing when the session ends before that tick.
  /// Blocks until it is known. The bytes stay valid until the next call.
  /// Errors: invalid_input, io, limit; those of Simulation::step, where ticks are tried.
  virtual Result<std::optional<TickInput>> next(std::uint64_t tick) = 0;
  /// Whether the source can be read again from the start. If so, a failed recording is removed; otherwise it is closed.
  virtual bool repeatable() const = 0;
  /// Whether next() failed because a tick that it simulated failed: then a recording keeps the earlier ticks.
  virtual bool tick_failed() const { return false; }
};

/// No input ever, the same dt every tick.
class NoInputs : public InputSource {
 public:
  explicit NoInputs(double dt) : dt_(dt) {}
  Result<std::optional<TickInput>> next(std::uint64_t tick) override;
  bool repeatable() const override { return true; }

 private:
  double dt_;
};

struct RecordOptions {
  std::optional<std::uint64_t> tick_count;  // stop after so many; absent: when the source ends
  WriterOptions writer;
  std::function<bool(std::uint64_t ticks_done)> progress;  // may be empty; false stops the recording (interrupted)
};

struct RecordResult {
  std::uint64_t tick_count = 0;
  std::uint64_t size = 0;           // bytes of the trace
  std::uint64_t root_hash = 0;      // of the last state
  double simulate_s = 0;            // wall time of the steps alone
  std::uint64_t saves_missing = 0;  // checkpoints for which the simulation had no save
  EndReason reason = EndReason::complete;
  std::string note;  // the place of a non-finite value, or why it was interrupted
};

/// (If `progress` returns false before the first tick: no file is left, tick_count and size are 0.)
/// Records from the current state of the simulation to its end. A tick that produces a non-finite value is not
/// recorded: the trace is closed before it. With Feature::saves in the setup, each checkpoint holds a save, as far as
/// the simulation gives one; requires SimulationInfo::has_saves. Errors: unsupported (check_float_behaviour), io, limit
/// and inconsistent (also of a tick that could not be done), invalid_input (also a session without a tick). On
/// invalid_input from a repeatable source, or before the first tick, no file is left behind and an overwritten one is
/// back; else the trace is closed (interrupted) and the message says what it holds.
Result<RecordResult> record(Simulation& simulation, InputSource& source, const std::string& path,
                            const TraceSetup& setup, const BuildFacts& facts, const RecordOptions& options);

}  // namespace ticktrue::replay
