// Plays a trace of the engine: re-simulates the trace and shows each state, as far as the trace goes.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/result.h"
#include "engine/engine.h"
#include "replay/trace_reader.h"

namespace ticktrue::tool {

struct PlaybackResult {
  std::uint64_t tick_count = 0;                   // ticks simulated
  std::optional<std::uint64_t> first_difference;  // first tick whose state differs from the recorded state in any bit
  std::optional<std::string> refused;             // the reason why the simulation refused the inputs of a tick
  std::optional<replay::TraceTail> tail;          // absent: playback did not reach the end of the trace
};

/// The scene inside a trace. Errors: unsupported (recorded from another simulation); those of decode_scene.
Result<engine::Scene> scene_of(const replay::TraceSetup& setup);

/// Calls `show` with the state after each of the ticks first..last (0 is the first tick). Simulation begins at the last
/// checkpoint before them. If `show` returns false, playback ends. Errors: those of scene_of and make_engine.
Result<PlaybackResult> play_trace(replay::TraceReader& trace, std::uint64_t first, std::uint64_t last,
                                  const std::function<bool(const engine::Engine& engine, std::uint64_t tick)>& show);

}  // namespace ticktrue::tool
