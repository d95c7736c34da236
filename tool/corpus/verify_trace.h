// Verification of one trace by the simulation it names: for `verify`, and for `corpus verify`.
// SPDX-License-Identifier: MIT
//
// What a verdict depends on is here and in the rooms below: this file counts in the digest of the engine.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "replay/trace_reader.h"
#include "verifier/report/report.h"
#include "verifier/runs/shared_count.h"
#include "verifier/verify/verify.h"

namespace ticktrue::tool {

struct TraceVerification {
  verifier::VerifyMode mode = verifier::VerifyMode::replay;
  std::uint64_t from = 0;
  std::optional<std::uint64_t> to;
  bool to_end = false;
  std::uint64_t sync_ticks = 0;
  std::optional<verifier::TracePart> part;  // of the whole trace, in segments
  bool in_segments = true;                  // where the simulation runs on threads
  unsigned thread_count = 1;                // segments at once, likewise
  unsigned engine_threads = 1;              // of a tick
  verifier::SharedCount* compared =
      nullptr;  // counts the ticks as they are compared: what a process leaves behind that crashes
  std::function<void(std::uint64_t ticks_done, std::uint64_t tick_count)> progress;
};

/// The simulation that verifies the trace; null: this build has none of its name.
const SimulationInfo* simulation_of(const replay::TraceReader& reader);
/// The same simulation with this number of threads in a tick; unchanged where it has no threads.
SimulationInfo on_engine_threads(const SimulationInfo& info, unsigned thread_count);

/// `file` is opened again for each segment.
verifier::Report verify_trace(replay::TraceReader& reader, const std::string& file, const TraceVerification& how);

/// How many parts the trace can have, at most `count_max`; see verifier/verify/parts.h.
std::size_t count_trace_parts(replay::TraceReader& reader, std::size_t count_max);

/// Whether a plug-in runs the trace.
bool needs_plugin(const std::string& file);

struct PluginVerification {
  verifier::Report report;
  bool is_verdict = true;  // false: the process ended, or a call took too long
};
/// `work` in a process of its own: what a plug-in does wrong is a finding in this file, and the next one goes on.
/// `meanwhile`: as for run_part.
PluginVerification verify_by_plugin(const std::string& file, std::string_view mode,
                                    const std::function<verifier::Report(verifier::SharedCount& compared)>& work,
                                    const std::function<void()>& meanwhile = {});

}  // namespace ticktrue::tool
