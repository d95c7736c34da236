// Plays a trace of the engine: re-simulates it and shows each state, as far as the trace goes.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "base/result.h"
#include "engine/engine.h"
#include "replay/trace_reader.h"

namespace ticktrue::verifier {

struct PlaybackResult {
  std::uint64_t tick_count = 0;                   // ticks simulated
  std::optional<std::uint64_t> first_difference;  // first tick whose state is not the recorded one, bit for bit
  std::optional<std::string> refused;             // the simulation did not take the inputs of a tick: why
  std::optional<replay::TraceTail> tail;          // absent: the end of the trace was not reached
};

/// The scene inside a trace. Errors: unsupported (recorded from another simulation), and what decode_scene refuses.
Result<engine::Scene> scene_of(const replay::TraceSetup& setup);

/// Calls `show` with the state after each of the ticks first..last (tick 0 is the first tick), beginning at the last
/// checkpoint before them. `show` returning false ends it.
/// Errors: what scene_of and make_engine refuse.
Result<PlaybackResult> play_trace(replay::TraceReader& reader, std::uint64_t first, std::uint64_t last,
                                  const std::function<bool(const engine::Engine& engine, std::uint64_t tick)>& show);

}  // namespace ticktrue::verifier
