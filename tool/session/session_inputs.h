// The inputs of `run` and `record`. They are checked before the run; an error during the run gets the place of the
// input.
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
  const tool::JsonLinesInputs* lines = nullptr;  // the JSON Lines among `source`; null: none
  const tool::ClockedInputs* clock = nullptr;    // the clock that sets the length of ticks; null: none
  std::uint64_t ticks_expected = 0;              // for the progress bar; 0: unknown
};

/// Adds --threads, the number of threads in a tick of the engine. A plug-in's tick always has one.
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

/// Uses the scene's clock if a host is given, or if the clock does not make one tick of dt per frame.
/// Errors: io.
Status use_clock(SessionInputs& inputs, const HostOptions& options, engine::Engine& engine);

/// The report of the clock, as JSON and as text.
Json clock_json(const engine::Scene& scene, const engine::ClockReport& report);
std::string clock_text(const engine::Scene& scene, const engine::ClockReport& report);

/// Empty `path`: no inputs. "-": standard input. A file is first read and checked as a whole. Without `tick_count` the
/// inputs must end with `end`. `scene` must outlive the source. Errors: usage (neither tick count nor end), io,
/// invalid_input, limit.
Result<SessionInputs> open_session_inputs(const engine::Scene& scene, const std::string& path,
                                          std::optional<std::uint64_t> tick_count);

/// Whether a SCENE argument is the name of a trace. The scene, inputs and dt of a trace run again.
bool is_trace_argument(const std::string& scene);
/// The scene of a trace, and its inputs. Errors: usage (--inputs or a host as well); those of TraceReader::open and
/// scene_of.
struct TraceSession {
  engine::Scene scene;
  SessionInputs inputs;
};
Result<TraceSession> open_trace_session(const std::string& path, const std::string& inputs, const HostOptions& host,
                                        std::optional<std::uint64_t> tick_count);

/// Adds "file:line" to the error of a tick that the simulation refused. Other errors stay unchanged.
Error with_input_place(const Error& error, const SessionInputs& inputs, const Simulation& simulation);

}  // namespace ticktrue::cli
