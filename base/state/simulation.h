// The interface through which a simulation is recorded and verified. The verifier depends on no physics; the engine
// depends on no files.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/state_view.h"

namespace ticktrue {

/// The input of one tick. The input bytes are the simulation's own canonical encoding of the tick's input events,
/// in (player, sequence) order; empty when there are none.
struct TickInput {
  double dt = 0;    // s, recorded as bits
  ByteView inputs;  // must outlive the step
};

/// Called by step() after each stage of its pipeline.
class StageObserver {
 public:
  virtual ~StageObserver() = default;
  /// `stage` indexes Simulation::stage_names().
  virtual void after_stage(std::size_t stage, const StateView& state) = 0;
};

/// A bit to flip in the middle of a step, to test verification.
struct InnerFault {
  std::uint32_t substep = 0;  // after this one
  StatePlace place;
  std::uint32_t bit = 0;  // 0: the lowest
};

class Simulation {
 public:
  virtual ~Simulation() = default;

  /// Whether step() may be given this input in the present state. Changes nothing.
  /// Errors: invalid_input, with the reason; that of the last step, where it failed.
  virtual Status accept(const TickInput& input) const = 0;

  /// Advances exactly one tick. `observer` may be null.
  /// Requires: accept(input), or the step before failed.
  /// Errors: limit (the tick needs more than base/limits.h allows), inconsistent (the tick, done in two ways, gave two
  /// results), with the tick. After an error the state is that of no tick: accept() and step() fail with the same error
  /// until a state has been loaded.
  [[nodiscard]] virtual Status step(const TickInput& input, StageObserver* observer) = 0;

  /// Every column that can influence a later tick. Valid until the next step or load.
  virtual const StateView& state() const = 0;

  /// Replaces the state by an image made by encode_image. On error the state is unchanged.
  /// Errors: corrupt (a value out of its range), unsupported (the state can only be observed).
  virtual Status load(ByteView image) = 0;

  /// Bytes of the simulation's own that bring it back to its present state, with `tick` ticks done; nothing where it
  /// has none now. Changes nothing. Errors: unsupported, usage (what it gave is no save, or it changed its state),
  /// limit.
  virtual Result<std::optional<Bytes>> save(std::uint64_t tick) {
    static_cast<void>(tick);
    return Error{ErrorCode::unsupported, "its state cannot be saved", ""};
  }

  /// Replaces the state by one that save() gave, with `tick` ticks done. After an error the state is invalid.
  /// Errors: unsupported, usage (refused).
  virtual Status load_saved(std::uint64_t tick, ByteView save) {
    static_cast<void>(tick), static_cast<void>(save);
    return Error{ErrorCode::unsupported, "it loads no saves", ""};
  }

  /// Flips a bit in the middle of the next step only. Errors: unsupported, also for a place without a value inside a
  /// step.
  virtual Status inject(const InnerFault&) {
    return Error{ErrorCode::unsupported, "no bit can be flipped inside a step", ""};
  }

  virtual std::span<const std::string> stage_names() const = 0;

  /// What a person would call this row, such as "crate_7"; empty where it has no name.
  virtual std::string row_name(std::size_t table, std::size_t row) const = 0;

  /// The inputs of `tick` as JSON Lines, the form in which they are written by hand; empty if they cannot be read.
  virtual std::string inputs_text(std::uint64_t tick, ByteView inputs) const = 0;
};

/// What a trace must say so that a simulation can be made again from its setup.
struct SimulationInfo {
  std::string_view name;          // e.g. "ticktrue.engine"
  std::uint32_t physics_version;  // rises with every change that changes bits on purpose
  /// Errors: corrupt, invalid_scene, limit.
  std::function<Result<std::unique_ptr<Simulation>>(ByteView setup)> make;
  /// The same, each tick on so many threads, with the same results; empty: its ticks have one thread. Errors: also
  /// limit and unsupported (base/parallel/workers.h).
  std::function<Result<std::unique_ptr<Simulation>>(ByteView setup, unsigned thread_count)> make_on_threads = {};
  bool has_saves = false;  // its simulations have save() and load_saved()
};

}  // namespace ticktrue
