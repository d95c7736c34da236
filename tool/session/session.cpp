// Runs a session, makes the setup of its trace, and measures the run.
// SPDX-License-Identifier: MIT
#include "tool/session/session.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "base/build_info.h"
#include "base/float_behaviour.h"
#include "engine/scene/scene_binary.h"

namespace ticktrue::tool {
namespace {

constexpr double bucket_ratio = 1.01;
constexpr double first_bucket_s = 10e-9;

}  // namespace

replay::TraceSetup make_trace_setup(const engine::Engine& engine, const TraceChoices& choices) {
  const SimulationInfo& info = engine::engine_info();
  replay::TraceSetup setup;
  setup.simulation = std::string(info.name);
  setup.physics_version = info.physics_version;
  setup.title = engine.scene().name;
  setup.dt = engine.scene().settings.dt;
  setup.detail = choices.detail;
  setup.full_first = choices.full_first;
  setup.full_last = choices.full_last;
  setup.checkpoint_interval = choices.checkpoint_interval;
  setup.schema = *engine.state().schema;
  setup.stages.assign(engine.stage_names().begin(), engine.stage_names().end());
  setup.setup = engine::encode_scene(engine.scene());
  return setup;
}

replay::BuildFacts make_build_facts() {
  const BuildInfo& build = build_info();
  return {{"version", build.version},
          {"commit", build.commit},
          {"compiler", build.compiler},
          {"flags", build.flags},
          {"target", build.target}};
}

void TickTimes::add(double seconds) {
  const double steps = std::log(seconds / first_bucket_s) / std::log(bucket_ratio);
  const auto last = static_cast<double>(counts_.size() - 1);
  const double bucket = steps > 0 ? (steps < last ? steps : last) : 0;  // a NaN of a broken clock counts as 0
  ++counts_[static_cast<std::size_t>(bucket)];
  ++count_;
  sum_s_ += seconds;
}

double TickTimes::quantile_s(double share) const {
  if (count_ == 0) return 0;
  const auto wanted = static_cast<std::uint64_t>(share * static_cast<double>(count_ - 1)) + 1;
  std::uint64_t seen = 0;
  double limit = first_bucket_s;
  for (const std::uint64_t count : counts_) {
    seen += count;
    if (seen >= wanted) break;
    limit *= bucket_ratio;
  }
  return limit;
}

Result<RunResult> run_session(engine::Engine& engine, replay::InputSource& source,
                              std::optional<std::uint64_t> tick_count,
                              const std::function<bool(std::uint64_t)>& progress) {
  using Clock = std::chrono::steady_clock;
  if (const Status floats = check_float_behaviour(); !floats) return floats.error();
  RunResult result;
  const std::uint64_t tick_end = tick_count.value_or(std::numeric_limits<std::uint64_t>::max());
  while (result.tick_count < tick_end) {
    const auto input = source.next(result.tick_count);
    if (!input) return input.error();
    if (!*input) break;
    if (const Status accepted = engine.accept(**input); !accepted) return accepted.error();
    const Clock::time_point start = Clock::now();
    const Status did = engine.step(**input, nullptr);
    const double step_s = std::chrono::duration<double>(Clock::now() - start).count();
    if (!did) return did.error();
    result.non_finite = find_non_finite_of(engine, result.tick_count);
    if (result.non_finite) break;
    result.times.add(step_s);  // only ticks with finite values count
    ++result.tick_count;
    if (progress && !progress(result.tick_count)) {
      result.stopped = true;
      break;
    }
  }
  result.root_hash = root_hash(engine.state());
  return result;
}

}  // namespace ticktrue::tool
