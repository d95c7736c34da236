// The inputs of `run` and `record`: checked before the run; errors during the run get the place of the input.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "base/result.h"
#include "base/state/simulation.h"
#include "engine/engine.h"
#include "replay/recorder.h"
#include "tool/output/json_output.h"
#include "tool/session/clocked_inputs.h"
#include "tool/session/input_source.h"

namespace ticktrue::cli {

struct SessionInputs {
  std::unique_ptr<replay::InputSource> source;
  const verifier::JsonLinesInputs* lines = nullptr;  // the same, where there are any
  const verifier::ClockedInputs* clock = nullptr;    // where a clock gives the ticks their length
  std::uint64_t ticks_expected = 0;                  // for the progress bar; 0: not known
};

/// --threads of a tick: of the engine, since a plug-in's ticks have one.
void add_threads_option(CLI::App& command, std::uint64_t& thread_count);
/// Errors: usage (several threads for a plug-in).
Status check_threads(std::uint64_t thread_count);
engine::EngineOptions engine_options(std::uint64_t thread_count);

/// The options for the frames of the host.
struct HostOptions {
  std::string host;        // --host; empty: frames of the scene's dt
  std::uint64_t seed = 1;  // --host-seed
};
void add_host_options(CLI::App& command, HostOptions& options);

/// Uses the clock of the scene, if a host is given or the clock does not make one tick of dt per frame.
/// Errors: io.
Status use_clock(SessionInputs& inputs, const HostOptions& options, engine::Engine& engine);

/// The report of the clock, as JSON and as text.
Json clock_json(const engine::Scene& scene, const engine::ClockReport& report);
std::string clock_text(const engine::Scene& scene, const engine::ClockReport& report);

/// `path` empty: no inputs; "-": standard input. A file is read and checked as a whole first. Without `tick_count`
/// the inputs must say when the session ends. `scene` must outlive the source.
/// Errors: usage (neither tick count nor end), io, invalid_input, limit.
Result<SessionInputs> open_session_inputs(const engine::Scene& scene, const std::string& path,
                                          std::optional<std::uint64_t> tick_count);

/// Whether a SCENE argument is the name of a trace: then its scene, inputs and dt are run again.
bool is_trace_argument(const std::string& scene);
/// The scene of a trace, and its inputs. Errors: usage (--inputs or a host as well), what TraceReader::open and
/// scene_of refuse.
struct TraceSession {
  engine::Scene scene;
  SessionInputs inputs;
};
Result<TraceSession> open_trace_session(const std::string& path, const std::string& inputs, const HostOptions& host,
                                        std::optional<std::uint64_t> tick_count);

/// Adds "file:line" to an error of a tick that the simulation refused; other errors stay as they are.
Error with_input_place(const Error& error, const SessionInputs& inputs, const Simulation& simulation);

}  // namespace ticktrue::cli
