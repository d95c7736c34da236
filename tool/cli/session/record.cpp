// `ticktrue record`: simulates a scene and writes a trace.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/file/file.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/output/scene_notes.h"
#include "tool/output/trace_text.h"
#include "tool/session/plugin_session.h"
#include "tool/session/session.h"
#include "tool/session/session_inputs.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

struct RecordCommand {
  std::string scene;
  std::string inputs;
  std::optional<std::uint64_t> tick_count;
  std::uint64_t thread_count = 1;
  HostOptions host;
  std::string detail = "cells";
  std::uint64_t checkpoint_interval = 600;  // 10 s at 60 Hz: seeking re-simulates less than a second's work
  bool no_compress = false;
  bool force = false;
  bool json = false;
  std::string output;
};

int run_record(const RecordCommand& options) {
  tool::TraceChoices choices;
  choices.checkpoint_interval = static_cast<std::uint32_t>(options.checkpoint_interval);
  if (const Status status = parse_detail(options.detail, choices); !status) return fail_usage(status.error());
  if (const Status status = check_threads(options.thread_count); !status) return fail_usage(status.error());
  if (has_plugin())
    return record_plugin({options.scene, options.inputs, options.tick_count, choices, options.output,
                          !options.no_compress, options.force, options.json});
  const bool runs_trace = is_trace_argument(options.scene);
  Result<TraceSession> again = TraceSession();
  if (runs_trace) again = open_trace_session(options.scene, options.inputs, options.host, options.tick_count);
  if (!again) return fail_usage(again.error());
  const Result<engine::Scene> scene = runs_trace ? std::move(again->scene) : load_scene_argument(options.scene);
  if (!scene) return fail_usage(scene.error());
  const auto made = engine::make_engine(*scene, engine_options(options.thread_count));
  if (!made) return fail_usage(made.error());
  engine::Engine& engine = **made;
  if (options.output == "-")
    return fail_usage(
        Error{ErrorCode::usage, "--output: found -, expected a file: a trace is not written to a pipe", ""});
  if (const Status status = replay::check_output(options.output); !status) return fail_usage(status.error());
  if (const Status status = verifier::check_writable_target(options.output, options.force); !status)
    return fail_usage(status.error());
  if (const Status status = verifier::check_not_read(options.output, {options.scene, options.inputs}); !status)
    return fail_usage(status.error());
  const std::vector<std::string> notes = tool::scene_notes(*scene);
  for (const std::string& note : notes) print_note(note);
  catch_stop_signals();
  Result<SessionInputs> inputs =
      runs_trace ? std::move(again->inputs) : open_session_inputs(*scene, options.inputs, options.tick_count);
  if (!inputs) return fail_usage(inputs.error());
  if (!runs_trace)
    if (const Status status = use_clock(*inputs, options.host, engine); !status) return fail_usage(status.error());
  if (stop_requested()) {
    print_note("stopped before the first tick: nothing was written");
    return exit_ok;
  }

  Progress progress("record " + options.output, inputs->ticks_expected);
  replay::RecordOptions record_options;
  record_options.tick_count = options.tick_count;
  record_options.writer.overwrite = options.force;
  record_options.writer.compress = !options.no_compress;
  record_options.progress = [&](std::uint64_t done) {
    progress.update(done);
    return !stop_requested();
  };
  const auto result = replay::record(engine, *inputs->source, options.output, tool::make_trace_setup(engine, choices),
                                     tool::make_build_facts(), record_options);
  progress.finish();
  if (!result) return fail_usage(with_input_place(result.error(), *inputs, engine));
  if (result->reason == replay::EndReason::interrupted && result->tick_count == 0) {
    print_note("stopped before the first tick: nothing was written");
    return exit_ok;
  }

  const std::uint64_t input_count = inputs->lines == nullptr ? 0 : inputs->lines->count();
  const double time_s =
      inputs->clock != nullptr ? engine.time_s() : static_cast<double>(result->tick_count) * scene->settings.dt;
  const double tick_ms =
      result->tick_count == 0 ? 0 : result->simulate_s * 1e3 / static_cast<double>(result->tick_count);
  if (options.json) {
    Json object;
    object["schema"] = "ticktrue.record/1";
    object["file"] = options.output;
    object["scene"] = scene->name;
    object["ticks"] = result->tick_count;
    object["time_s"] = time_s;
    object["size"] = result->size;
    object["detail"] = options.detail;
    object["checkpoint_interval"] = options.checkpoint_interval;
    object["reason"] = end_reason_name(result->reason);
    object["note"] = result->note;
    object["scene_notes"] = notes;
    object["inputs"] = input_count;
    object["ignored_inputs"] = engine.ignored_inputs();
    if (const auto budget = engine.budget_report())
      object["budget"] = {{"cut_ticks", budget->cut_ticks}, {"limited_ticks", budget->limited_ticks}};
    object["ms_per_tick"] = tick_ms;
    object["hash"] = hex64(result->root_hash);
    if (inputs->clock != nullptr) object["clock"] = clock_json(*scene, inputs->clock->report());
    print_json(object);
  } else {
    print(fmt::format("recorded  {}  {} ticks ({:.3f} s), {} bytes\n", options.output, result->tick_count, time_s,
                      result->size));
    if (inputs->lines != nullptr)
      print(fmt::format("  inputs  {}, of which {} to bodies already removed\n", input_count, engine.ignored_inputs()));
    const std::string budget = tool::budget_text(engine.budget_report(), result->tick_count);
    if (!budget.empty()) print(fmt::format("  budget  {}\n", budget));
    if (inputs->clock != nullptr) print(fmt::format("  clock   {}\n", clock_text(*scene, inputs->clock->report())));
    print(fmt::format("  time    {:.4g} ms/tick (mean, without writing)\n", tick_ms));
    print(fmt::format("  hash    {}\n", hex64(result->root_hash)));
    if (result->reason != replay::EndReason::complete)
      print(fmt::format("  ended   {}{}{}\n", end_reason_name(result->reason), result->note.empty() ? "" : ": ",
                        result->note));
  }
  if (result->reason == replay::EndReason::interrupted)
    print_note(options.output + ": stopped as asked after " + std::to_string(result->tick_count) +
               " ticks; the trace is whole");
  return result->reason == replay::EndReason::non_finite ? exit_finding : exit_ok;
}

}  // namespace

Status parse_detail(const std::string& text, tool::TraceChoices& choices) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  for (const replay::DetailInfo& info : replay::details) {
    if (info.name != name) continue;
    choices.detail = info.detail;
    if (info.detail != replay::Detail::full) break;
    choices.full_last = std::numeric_limits<std::uint64_t>::max();
    if (colon == std::string::npos) return {};
    const Result<TickRange> range = parse_tick_range(text.substr(colon + 1), "--detail");
    if (!range) return range.error();
    choices.full_first = range->first;
    choices.full_last = range->last;
    return {};
  }
  if (colon == std::string::npos && replay::detail_info(choices.detail).name == text) return {};
  return Error{ErrorCode::usage, "--detail: found \"" + text + "\", expected root, cells, full or full:A..B", ""};
}

void add_record(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<RecordCommand>();
  CLI::App* command =
      app.add_subcommand("record", "Simulate a scene and write a trace (a replay file)")->group(group_session);
  command
      ->add_option("SCENE", options->scene,
                   "Scene file (.json), built-in scene with parameters (stack?boxes=20), or a trace (.ttr): "
                   "its session is run again")
      ->required();
  command->add_option("-o,--output", options->output, "The trace to write")->type_name("OUT.ttr")->required();
  command->add_option("--inputs", options->inputs, "Inputs as JSON Lines, - for standard input (live)")
      ->type_name("FILE");
  add_number(*command, "--ticks", options->tick_count,
             "How many ticks at most; without it: up to the `end` input. An earlier `end` wins",
             {1, limits::tick_count_max});
  add_threads_option(*command, options->thread_count);
  add_host_options(*command, options->host);
  command
      ->add_option(
          "--detail", options->detail,
          "root: a hash per tick. cells (default): also what names columns and bodies that differ. full[:A..B]: "
          "the state and a hash after each stage, of ticks A to B")
      ->type_name("D");
  add_number(*command, "--checkpoint-interval", options->checkpoint_interval,
             "Ticks between full states, 0: only the first (default 600)", {0, 0xffffffffu});
  command->add_flag("--no-compress", options->no_compress, "Checkpoints without zstd, readable by every build");
  command->add_flag("--force", options->force, "Replace an existing file");
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command,
               "ticktrue record 'stack?boxes=10' --ticks 600 -o stack.ttr\n"
               "ticktrue import mouse --model 1 --seconds 20 --scene thesis -o session.jsonl\n"
               "ticktrue record thesis --inputs session.jsonl --detail full:100..160 -o session.ttr\n"
               "cat session.jsonl | ticktrue record thesis --inputs - -o live.ttr",
               "Inputs are checked before anything is written: a file with a wrong line gives no trace. Live ones are\n"
               "recorded as they come: a tick runs when a line of a later tick, an `end` or the end of input is read.\n"
               "Ctrl-C, SIGTERM or SIGHUP closes the trace: it is whole, marked interrupted, exit 0.");
  command->callback([options, &context] { context.exit_code = run_record(*options); });
}

}  // namespace ticktrue::cli
