// `run` and `record` of a plug-in's simulation: setup and inputs as bytes, since only the plug-in knows what they mean.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/state/non_finite.h"
#include "replay/recorder.h"
#include "replay/trace_reader.h"
#include "tool/session/session.h"

namespace ticktrue::cli {

struct PluginSession {
  std::string
      scene;  // the setup: the bytes of this file, or of the word itself; or a trace, whose session is run again
  std::string inputs;  // JSON Lines {"tick": N, "bytes": "hex"}, ticks ascending; "dt": s, from that tick on; or empty
  std::optional<std::uint64_t> tick_count;
  verifier::TraceChoices choices;  // record
  std::string output;              // record
  bool compress = true;
  bool force = false;
  bool json = false;
};

/// Whether SCENE is meant for a plug-in.
bool has_plugin();
/// The session, made and not yet run.
struct OpenPluginSession {
  const SimulationInfo* info = nullptr;
  Bytes setup;
  double dt = 0;  // s
  std::uint64_t tick_count = 0;
  std::unique_ptr<Simulation> simulation;
  std::unique_ptr<replay::InputSource> inputs;
};
/// Errors: usage (several plug-ins, no number of ticks), io, invalid_input, and what the plug-in refuses.
/// Requires: has_plugin().
Result<OpenPluginSession> open_plugin_session(const PluginSession& session);
/// The setup for a trace of it. Its checkpoints hold saves where the plug-in has save and load.
replay::TraceSetup plugin_trace_setup(const OpenPluginSession& made, const verifier::TraceChoices& choices);

/// The exit code. Require: has_plugin().
int run_plugin(const PluginSession& session);
int record_plugin(const PluginSession& session);

/// What came of the ticks of a simulation.
struct PluginRun {
  std::uint64_t tick_count = 0;
  double time_s = 0;               // simulated
  std::optional<NonFinite> found;  // in the last tick
  verifier::TickTimes times;       // wall time of the steps
};
/// Runs at most so many ticks, to the end of the inputs, a stop signal or a value that is not finite.
/// Errors: those of the source, of Simulation::accept and of Simulation::step.
Result<PluginRun> run_ticks(Simulation& simulation, replay::InputSource& inputs, std::uint64_t tick_count);

/// `replay` of a plug-in's trace: after each of the ticks first..last, every n-th, its tables as lines of text, or as
/// one JSON object. Whether the trace is one of a loaded plug-in says is_plugin_trace.
bool is_plugin_trace(const replay::TraceSetup& setup);
int replay_plugin(replay::TraceReader& reader, std::uint64_t first, std::uint64_t last, std::uint64_t every, bool json);
/// The same with a simulation that is in the state where the reader stands: that of the setup, or of a save at
/// `time_s`.
int replay_with(Simulation& simulation, replay::TraceReader& reader, std::uint64_t first, std::uint64_t last,
                std::uint64_t every, bool json, double time_s = 0);

}  // namespace ticktrue::cli
