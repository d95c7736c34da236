// Opens the inputs of a session.
// SPDX-License-Identifier: MIT
#include "tool/session/session_inputs.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/parallel/workers.h"
#include "tool/output/cli.h"
#include "tool/output/progress.h"
#include "tool/session/playback.h"
#include "tool/session/plugin_session.h"
#include "tool/session/simulations.h"
#include "verifier/verify/trace_inputs.h"

namespace ticktrue::cli {

Result<SessionInputs> open_session_inputs(const engine::Scene& scene, const std::string& path,
                                          std::optional<std::uint64_t> tick_count) {
  SessionInputs session;
  session.ticks_expected = tick_count.value_or(0);
  if (path.empty()) {
    if (!tick_count)
      return Error{ErrorCode::usage, "--ticks: found neither --ticks nor --inputs, expected one that ends the session",
                   "give --ticks N, or --inputs FILE with an `end` input"};
    session.source = std::make_unique<replay::NoInputs>(scene.settings.dt);
    return session;
  }

  tool::JsonLinesInputs::Options options;
  options.needs_end = !tick_count;
  options.stop = stop_requested;
  auto source = tool::JsonLinesInputs::open(scene, path, options);
  if (!source) return source.error();
  session.lines = source->get();
  session.source = std::move(*source);
  if (!session.source->repeatable()) return session;

  Progress progress("check " + path, 0, "bytes");
  const auto summary =
      tool::check_inputs(scene, path, [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); });
  progress.finish();
  if (!summary) return summary.error();
  if (!summary->end_tick && !tick_count)
    return Error{
        ErrorCode::usage, path + ": found neither --ticks nor an `end` input, expected one that ends the session",
        "give --ticks N, or append {\"tick\":" + std::to_string(summary->last_tick + 1) + ",\"kind\":\"end\"}"};
  if (summary->end_tick) session.ticks_expected = std::min(tick_count.value_or(*summary->end_tick), *summary->end_tick);
  if (tick_count && summary->count > 0 && summary->last_tick >= *tick_count)
    print_note(path + ": inputs from tick " + std::to_string(*tick_count) + " on are not used (--ticks " +
               std::to_string(*tick_count) + ")");
  return session;
}

bool is_trace_argument(const std::string& scene) {
  constexpr std::string_view extension = ".ttr";
  return scene.size() > extension.size() &&
         scene.compare(scene.size() - extension.size(), extension.size(), extension) == 0;
}

Result<TraceSession> open_trace_session(const std::string& path, const std::string& inputs, const HostOptions& host,
                                        std::optional<std::uint64_t> tick_count) {
  if (!inputs.empty() || !host.host.empty())
    return Error{ErrorCode::usage, path + ": a trace has its own inputs and lengths of ticks: found --inputs or --host",
                 "give the scene instead of the trace, or leave them out"};
  Result<replay::TraceReader> reader = replay::TraceReader::open(path);
  if (!reader) return reader.error();
  if (const Status whole = reader->check_from_start(); !whole) return whole.error();
  Result<engine::Scene> scene = tool::scene_of(reader->setup());
  if (!scene) return scene.error();
  TraceSession session;
  session.scene = std::move(*scene);
  session.inputs.ticks_expected = reader->tick_count_hint().value_or(0);
  if (tick_count) session.inputs.ticks_expected = std::min(*tick_count, session.inputs.ticks_expected);
  session.inputs.source = std::make_unique<verifier::TraceInputs>(std::move(*reader));
  return session;
}

void add_threads_option(CLI::App& command, std::uint64_t& thread_count) {
  add_number(command, "--threads", thread_count, "Threads of a tick; the results are those of one",
             {1, thread_count_max});
}

Status check_threads(std::uint64_t thread_count) {
  if (thread_count == 1 || !has_plugin()) return {};
  return Error{ErrorCode::usage,
               "--threads: found " + std::to_string(thread_count) + ", expected 1: a plug-in's ticks have one thread",
               ""};
}

engine::EngineOptions engine_options(std::uint64_t thread_count) {
  engine::EngineOptions options = tool::engine_options_of_environment();
  options.thread_count = static_cast<unsigned>(thread_count);
  return options;
}

void add_host_options(CLI::App& command, HostOptions& options) {
  std::string names;
  for (const tool::HostInfo& info : tool::hosts) names += std::string(info.name) + ", ";
  command
      .add_option("--host", options.host,
                  "Frames that the scene's clock makes ticks of: " + names +
                      "or a file of one frame time a line, in seconds. Without it: frames of the scene's dt")
      ->type_name("H");
  add_number(command, "--host-seed", options.seed, "Of jitter_60 and stutter (default 1)",
             {0, std::numeric_limits<std::uint64_t>::max()});
}

Status use_clock(SessionInputs& inputs, const HostOptions& options, engine::Engine& engine) {
  const engine::Settings& settings = engine.scene().settings;
  if (options.host.empty() && settings.clock.kind != engine::ClockKind::adaptive) return {};
  std::unique_ptr<tool::HostFrames> frames = tool::steady_frames(settings.dt);
  if (!options.host.empty()) {
    auto opened = tool::open_host(options.host, options.seed);
    if (!opened) return opened.error();
    frames = *std::move(opened);
  }
  auto clock = std::make_unique<tool::ClockedInputs>(engine, std::move(inputs.source), std::move(frames));
  inputs.clock = clock.get();
  inputs.source = std::move(clock);
  return {};
}

Json clock_json(const engine::Scene& scene, const engine::ClockReport& report) {
  Json object;
  object["kind"] = info_of(engine::clock_kinds, scene.settings.clock.kind).name;
  object["frames"] = report.frame_count;
  object["frame_time_s"] = report.frame_time_s;
  object["ticks"] = report.tick_count;
  object["tick_time_s"] = report.tick_time_s;
  object["dropped_s"] = report.dropped_s;
  object["cut_s"] = report.cut_s;
  object["trials"] = report.trial_count;
  object["inaccurate_ticks"] = report.inaccurate_count;
  return object;
}

std::string clock_text(const engine::Scene& scene, const engine::ClockReport& report) {
  std::string text = fmt::format("{}: {} frames ({:.3f} s) gave {} ticks ({:.3f} s)",
                                 info_of(engine::clock_kinds, scene.settings.clock.kind).name, report.frame_count,
                                 report.frame_time_s, report.tick_count, report.tick_time_s);
  if (report.dropped_s > 0) text += fmt::format("; {:.3f} s dropped", report.dropped_s);
  if (report.cut_s > 0) text += fmt::format("; {:.3f} s cut", report.cut_s);
  if (report.inaccurate_count > 0) text += fmt::format("; {} ticks above the tolerance", report.inaccurate_count);
  return text;
}

Error with_input_place(const Error& error, const SessionInputs& inputs, const Simulation& simulation) {
  // Errors of the source already begin with the place.
  if (inputs.clock != nullptr && inputs.clock->frames_failed()) return error;
  if (error.code != ErrorCode::invalid_input || inputs.lines == nullptr || inputs.lines->gave_error()) return error;
  return Error{error.code, inputs.lines->place_of_refused(simulation) + ": " + error.message, error.hint};
}

}  // namespace ticktrue::cli
