// A session of the engine: runs it from inputs, measures it, and makes the setup of its trace.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "base/result.h"
#include "base/state/non_finite.h"
#include "engine/engine.h"
#include "replay/format/trace.h"
#include "replay/recorder.h"

namespace ticktrue::tool {

/// The choices of a recording.
struct TraceChoices {
  replay::Detail detail = replay::Detail::root;
  std::uint64_t full_first = 0;  // with Detail::full
  std::uint64_t full_last = 0;   // inclusive
  std::uint32_t checkpoint_interval = 600;
};

/// The setup for a trace of the engine in its current state.
replay::TraceSetup make_trace_setup(const engine::Engine& engine, const TraceChoices& choices);

/// The facts about this build that go into traces.
replay::BuildFacts make_build_facts();

/// Times of ticks in bounded memory: a histogram of logarithmic buckets, each 1 % wide.
class TickTimes {
 public:
  void add(double seconds);
  /// Accurate to 1 %; 0 without ticks.
  double median_s() const { return quantile_s(0.5); }
  double quantile_s(double share) const;
  double sum_s() const { return sum_s_; }

 private:
  std::array<std::uint64_t, 2400> counts_{};  // 10 ns .. 230 s
  std::uint64_t count_ = 0;
  double sum_s_ = 0;
};

struct RunResult {
  std::uint64_t tick_count = 0;
  TickTimes times;
  std::uint64_t root_hash = 0;
  bool stopped = false;  // `progress` returned false
  std::optional<NonFinite> non_finite;
};

/// Runs without recording, until `tick_count` ticks are done, the source ends, or a value is not finite. `progress`
/// (ticks done) may be empty; false stops the run. Errors: unsupported (check_float_behaviour), io, invalid_input,
/// limit.
Result<RunResult> run_session(engine::Engine& engine, replay::InputSource& source,
                              std::optional<std::uint64_t> tick_count,
                              const std::function<bool(std::uint64_t)>& progress);

}  // namespace ticktrue::tool
