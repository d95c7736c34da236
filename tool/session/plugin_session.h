// `run` and `record` for the simulation of a plug-in. Setup and inputs are bytes, because only the plug-in knows their
// meaning.
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
  tool::TraceChoices choices;  // record
  std::string output;          // record
  bool compress = true;
  bool force = false;
  bool json = false;
};

/// Whether SCENE is the setup of a plug-in.
bool has_plugin();
/// A session that is made but has not run.
struct OpenPluginSession {
  const SimulationInfo* info = nullptr;
  Bytes setup;
  double dt = 0;  // s
  std::uint64_t tick_count = 0;
  std::unique_ptr<Simulation> simulation;
  std::unique_ptr<replay::InputSource> inputs;
};
/// Errors: usage (several plug-ins, no number of ticks), io, invalid_input, those of the plug-in. Requires:
/// has_plugin().
Result<OpenPluginSession> open_plugin_session(const PluginSession& session);
/// The setup for a trace of this session. Its checkpoints hold saves if the plug-in has save and load.
replay::TraceSetup plugin_trace_setup(const OpenPluginSession& made, const tool::TraceChoices& choices);

/// Returns the exit code. Requires: has_plugin().
int run_plugin(const PluginSession& session);
int record_plugin(const PluginSession& session);

/// The result of the ticks of a simulation.
struct PluginRun {
  std::uint64_t tick_count = 0;
  double time_s = 0;               // simulated
  std::optional<NonFinite> found;  // not finite after the last tick
  tool::TickTimes times;           // wall time of the steps
};
/// Runs at most `tick_count` ticks. Stops earlier at the end of the inputs, at a stop signal, or at a value that is not
/// finite. Errors: those of the source, of Simulation::accept and of Simulation::step.
Result<PluginRun> run_ticks(Simulation& simulation, replay::InputSource& inputs, std::uint64_t tick_count);

/// Whether a trace is from a loaded plug-in. `replay` of such a trace shows the tables after every n-th of the ticks
/// first..last, as lines of text or as one JSON object.
bool is_plugin_trace(const replay::TraceSetup& setup);
int replay_plugin(replay::TraceReader& reader, std::uint64_t first, std::uint64_t last, std::uint64_t every, bool json);
/// The same with a simulation in the state where the reader stands: the state of the setup, or of a save at `time_s`.
int replay_with(Simulation& simulation, replay::TraceReader& reader, std::uint64_t first, std::uint64_t last,
                std::uint64_t every, bool json, double time_s = 0);

}  // namespace ticktrue::cli
