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

/// The source of a session's inputs: a file, a pipe, a program.
class InputSource {
 public:
  virtual ~InputSource() = default;
  /// The input of the given tick, or nothing if the session ends before this tick. Blocks until the input is known.
  /// Each tick is requested once, in ascending order. The bytes stay valid until the next call.
  /// Errors: invalid_input, io, limit; if the source tries ticks, also the errors of Simulation::step.
  virtual Result<std::optional<TickInput>> next(std::uint64_t tick) = 0;
  /// Whether the source can be read again from the start. If so, a failed recording is removed. Otherwise it is closed.
  virtual bool repeatable() const = 0;
  /// Whether next() failed because a tick that the source simulated failed. A recording then keeps the earlier ticks.
  virtual bool tick_failed() const { return false; }
};

/// No inputs, and the same dt in every tick.
class NoInputs : public InputSource {
 public:
  explicit NoInputs(double dt) : dt_(dt) {}
  Result<std::optional<TickInput>> next(std::uint64_t tick) override;
  bool repeatable() const override { return true; }

 private:
  double dt_;
};

struct RecordOptions {
  std::optional<std::uint64_t> tick_count;  // stop after this number of ticks; absent: at the end of the source
  WriterOptions writer;
  std::function<bool(std::uint64_t ticks_done)> progress;  // may be empty; false stops the recording (interrupted)
};

struct RecordResult {
  std::uint64_t tick_count = 0;
  std::uint64_t size = 0;           // bytes of the trace
  std::uint64_t root_hash = 0;      // of the last state
  double simulate_s = 0;            // wall time of the steps
  std::uint64_t saves_missing = 0;  // checkpoints without a save, because the simulation returned none
  EndReason reason = EndReason::complete;
  std::string note;  // the place of a non-finite value, or the reason of the interruption
};

/// Records from the current state of the simulation until the source ends, options.tick_count ticks are recorded, or
/// `progress` returns false. A tick with a non-finite value is not recorded: the trace is closed before it. If the
/// setup has Feature::saves, each checkpoint has a save, unless the simulation returns none. Requires:
/// SimulationInfo::has_saves if the setup has Feature::saves. Errors: unsupported (check_float_behaviour), io, limit,
/// inconsistent (the last two also if a tick fails), invalid_input (also a session without a tick). If invalid_input
/// comes from a repeatable source, or before the first tick, no file is left and an overwritten file is restored. After
/// another error the trace is closed as interrupted, and the message states its content. If `progress` returns false
/// before the first tick, no file is left, and tick_count and size are 0.
Result<RecordResult> record(Simulation& simulation, InputSource& source, const std::string& path,
                            const TraceSetup& setup, const BuildFacts& facts, const RecordOptions& options);

}  // namespace ticktrue::replay
