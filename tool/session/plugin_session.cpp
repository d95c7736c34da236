// Runs and records the simulation of a plug-in.
// SPDX-License-Identifier: MIT
#include "tool/session/plugin_session.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "base/count_text.h"
#include "base/hash.h"
#include "base/limits.h"
#include "replay/file/file.h"
#include "replay/recorder.h"
#include "tool/output/cli.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/session/session_inputs.h"
#include "tool/session/simulations.h"
#include "verifier/plugins/plugin.h"
#include "verifier/runs/data_file.h"
#include "verifier/verify/trace_inputs.h"

namespace ticktrue::cli {
namespace {

constexpr double dt_default_s = 1.0 / 60;

std::optional<Bytes> bytes_of_hex(const std::string& text) {
  if (text.size() % 2 != 0) return std::nullopt;
  Bytes bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const int digit = c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
    if (digit < 0) return std::nullopt;
    if (i % 2 == 0)
      bytes.push_back(static_cast<std::uint8_t>(digit << 4));
    else
      bytes.back() = static_cast<std::uint8_t>(bytes.back() | digit);
  }
  return bytes;
}

/// Inputs as bytes. Reads the whole file at once.
class ByteInputs : public replay::InputSource {
 public:
  Status read(const std::string& path) {
    const Result<std::string> text = read_text_file(path, limits::scene_file_size_max);
    if (!text) return text.error();
    std::istringstream in(*text);
    std::uint64_t number = 0;
    for (std::string line; std::getline(in, line);) {
      const std::string place = path + ":" + std::to_string(++number);
      if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
      const Json object = Json::parse(line, nullptr, false);
      if (!object.is_object() || !object.contains("tick") || !object["tick"].is_number_unsigned())
        return refused(place, "found no object with a tick, expected {\"tick\": N, \"bytes\": \"hex\"}");
      Line parsed;
      parsed.tick = object["tick"].get<std::uint64_t>();
      if (!lines_.empty() && parsed.tick <= lines_.back().tick)
        return refused(place, "tick: found " + std::to_string(parsed.tick) + ", expected more than " +
                                  std::to_string(lines_.back().tick));
      if (object.contains("dt")) {
        if (!object["dt"].is_number() || !(object["dt"].get<double>() >= 0) ||
            object["dt"].get<double>() > limits::dt_max_s)
          return refused(place, "dt: expected a number from 0 to 1 s");
        parsed.dt = object["dt"].get<double>();
      }
      const auto bytes = bytes_of_hex(
          object.contains("bytes") && object["bytes"].is_string() ? object["bytes"].get<std::string>() : std::string());
      if (!bytes) return refused(place, "bytes: expected pairs of the digits 0-9 a-f");
      parsed.bytes = *bytes;
      lines_.push_back(std::move(parsed));
    }
    return {};
  }

  Result<std::optional<TickInput>> next(std::uint64_t tick) override {
    TickInput input{dt_, {}};
    if (at_ < lines_.size() && lines_[at_].tick == tick) {
      if (lines_[at_].dt) input.dt = dt_ = *lines_[at_].dt;
      input.inputs = lines_[at_].bytes;
      ++at_;
    }
    return std::optional<TickInput>(input);
  }
  bool repeatable() const override { return true; }

 private:
  struct Line {
    std::uint64_t tick = 0;
    std::optional<double> dt;
    Bytes bytes;
  };
  static Status refused(const std::string& place, const std::string& what) {
    return Error{ErrorCode::invalid_input, place + ": " + what, ""};
  }
  std::vector<Line> lines_;
  std::size_t at_ = 0;
  double dt_ = dt_default_s;
};

/// Takes setup, inputs and length of the session from a trace. Errors: usage (--inputs as well, another simulation);
/// those of TraceReader::open.
Status take_trace(const PluginSession& session, OpenPluginSession& made) {
  if (!session.inputs.empty())
    return Error{ErrorCode::usage, "--inputs: found a trace to run again, expected none: a trace has its own", ""};
  auto reader = replay::TraceReader::open(session.scene);
  if (!reader) return reader.error();
  if (const Status whole = reader->check_from_start(); !whole) return whole;
  const replay::TraceSetup& setup = reader->setup();
  if (setup.simulation != made.info->name)
    return Error{
        ErrorCode::usage,
        session.scene + ": found simulation " + setup.simulation + ", expected " + std::string(made.info->name), ""};
  if (!session.tick_count && !reader->tick_count_hint())
    return Error{ErrorCode::usage, "--ticks: found none, expected how many: the trace does not say",
                 "ticktrue recover makes a trace that does"};
  made.setup = setup.setup;
  made.dt = setup.dt;
  made.tick_count = session.tick_count.value_or(reader->tick_count_hint().value_or(0));
  made.inputs = std::make_unique<verifier::TraceInputs>(std::move(*reader));
  return {};
}

Status take_scene(const PluginSession& session, OpenPluginSession& made) {
  if (!session.tick_count)
    return Error{ErrorCode::usage, "--ticks: found none, expected how many: a plug-in's inputs do not say", ""};
  made.tick_count = *session.tick_count;
  std::error_code failure;
  if (std::filesystem::is_regular_file(session.scene, failure)) {
    const Result<std::string> text = read_text_file(session.scene, limits::setup_size_max);
    if (!text) return text.error();
    made.setup.assign(text->begin(), text->end());
  } else {
    made.setup.assign(session.scene.begin(), session.scene.end());
  }
  auto inputs = std::make_unique<ByteInputs>();
  if (!session.inputs.empty())
    if (const Status status = inputs->read(session.inputs); !status) return status;
  made.inputs = std::move(inputs);
  return {};
}

}  // namespace

Result<OpenPluginSession> open_plugin_session(const PluginSession& session) {
  const auto plugins = verifier::plugin_simulations();
  if (plugins.size() != 1)
    return Error{ErrorCode::usage,
                 "--plugin: found " + std::to_string(plugins.size()) + ", expected one to simulate with", ""};
  OpenPluginSession made;
  made.dt = dt_default_s;
  made.info = plugins[0];
  const Status taken = is_trace_argument(session.scene) ? take_trace(session, made) : take_scene(session, made);
  if (!taken) return taken.error();
  auto simulation = made.info->make(made.setup);
  if (!simulation) return simulation.error();
  made.simulation = std::move(*simulation);
  return made;
}

replay::TraceSetup plugin_trace_setup(const OpenPluginSession& made, const tool::TraceChoices& choices) {
  replay::TraceSetup setup;
  setup.simulation = std::string(made.info->name);
  setup.physics_version = made.info->physics_version;
  setup.title = std::string(made.info->name);
  setup.dt = made.dt;
  setup.detail = choices.detail;
  setup.full_first = choices.full_first;
  setup.full_last = choices.full_last;
  setup.checkpoint_interval = choices.checkpoint_interval;
  setup.schema = *made.simulation->state().schema;
  setup.stages.assign(made.simulation->stage_names().begin(), made.simulation->stage_names().end());
  setup.setup = made.setup;
  if (made.info->has_saves) setup.features = static_cast<std::uint32_t>(replay::Feature::saves);
  return setup;
}

bool has_plugin() {
  return !verifier::plugin_simulations().empty();
}

Result<PluginRun> run_ticks(Simulation& simulation, replay::InputSource& inputs, std::uint64_t tick_count) {
  PluginRun run;
  for (; run.tick_count < tick_count && !stop_requested() && !run.found; ++run.tick_count) {
    const auto input = inputs.next(run.tick_count);
    if (!input) return input.error();
    if (!*input) break;
    if (const Status accepted = simulation.accept(**input); !accepted) return accepted.error();
    const auto start = std::chrono::steady_clock::now();
    if (const Status did = simulation.step(**input, nullptr); !did) return did.error();
    run.times.add(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    run.time_s += (*input)->dt;
    run.found = find_non_finite_of(simulation, run.tick_count);
  }
  return run;
}

int run_plugin(const PluginSession& session) {
  const auto made = open_plugin_session(session);
  if (!made) return fail_usage(made.error());
  catch_stop_signals();
  const auto run = run_ticks(*made->simulation, *made->inputs, made->tick_count);
  if (!run) return fail_usage(run.error());
  const std::string hash = hex64(root_hash(made->simulation->state()));
  if (session.json) {
    Json object;
    object["schema"] = "ticktrue.run/1";
    object["scene"] = made->info->name;
    object["ticks"] = run->tick_count;
    object["time_s"] = run->time_s;
    object["ms_per_tick"] = run->times.median_s() * 1e3;
    object["hash"] = hash;
    print_json(object);
  } else {
    print(fmt::format("{}  {}  {} ticks ({:.3f} s)\n", run->found ? "not finite" : "ran", made->info->name,
                      run->tick_count, run->time_s));
    if (run->found) print(fmt::format("  where     {}\n", non_finite_text(*run->found)));
    print(fmt::format("  time      {:.4g} ms/tick (median), {:.3f} s in all\n", run->times.median_s() * 1e3,
                      run->times.sum_s()));
    print(fmt::format("  hash      {}\n", hash));
  }
  return run->found ? exit_finding : exit_ok;
}

int record_plugin(const PluginSession& session) {
  const auto made = open_plugin_session(session);
  if (!made) return fail_usage(made.error());
  if (const Status status = replay::check_output(session.output); !status) return fail_usage(status.error());
  if (const Status status = verifier::check_writable_target(session.output, session.force); !status)
    return fail_usage(status.error());
  if (const Status status = verifier::check_not_read(session.output, {session.scene, session.inputs}); !status)
    return fail_usage(status.error());
  catch_stop_signals();
  Progress progress("record " + session.output, made->tick_count);
  replay::RecordOptions options;
  options.tick_count = made->tick_count;
  options.writer.overwrite = session.force;
  options.writer.compress = session.compress;
  options.progress = [&](std::uint64_t done) {
    progress.update(done);
    return !stop_requested();
  };
  const auto result =
      replay::record(*made->simulation, *made->inputs, session.output, plugin_trace_setup(*made, session.choices),
                     tool::make_build_facts(made->info->name), options);
  progress.finish();
  if (!result) return fail_usage(result.error());
  if (result->reason == replay::EndReason::interrupted && result->tick_count == 0) {
    print_note("stopped before the first tick: nothing was written");
    return exit_ok;
  }
  if (result->saves_missing > 0)
    print_warning(session.output + ": " + count_text(result->saves_missing, "checkpoint") +
                  " without a save: save returned TICKTRUE_SAVE_FAILED");
  std::string_view reason;
  for (const replay::EndReasonInfo& info : replay::end_reasons)
    if (info.reason == result->reason) reason = info.name;
  const double tick_ms =
      result->tick_count == 0 ? 0 : result->simulate_s * 1e3 / static_cast<double>(result->tick_count);
  if (session.json) {
    Json object;
    object["schema"] = "ticktrue.record/1";
    object["file"] = session.output;
    object["scene"] = made->info->name;
    object["ticks"] = result->tick_count;
    object["size"] = result->size;
    object["reason"] = reason;
    object["note"] = result->note;
    object["ms_per_tick"] = tick_ms;
    object["hash"] = hex64(result->root_hash);
    print_json(object);
  } else {
    print(fmt::format("recorded  {}  {} ticks, {} bytes\n", session.output, result->tick_count, result->size));
    print(fmt::format("  time    {:.4g} ms/tick (mean, without writing)\n", tick_ms));
    print(fmt::format("  hash    {}\n", hex64(result->root_hash)));
    if (result->reason != replay::EndReason::complete) print(fmt::format("  ended   {}: {}\n", reason, result->note));
  }
  return result->reason == replay::EndReason::non_finite ? exit_finding : exit_ok;
}

}  // namespace ticktrue::cli
