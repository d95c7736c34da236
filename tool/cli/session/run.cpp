// `ticktrue run`: simulates a scene and keeps nothing.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "base/hash.h"
#include "base/limits.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/output/scene_notes.h"
#include "tool/session/plugin_session.h"
#include "tool/session/session.h"
#include "tool/session/session_inputs.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::cli {
namespace {

struct RunOptions {
  std::string scene;
  std::string inputs;
  std::optional<std::uint64_t> tick_count;
  std::uint64_t thread_count = 1;
  HostOptions host;
  bool json = false;
};

Json run_json(const engine::Engine& engine, const tool::RunResult& result, std::size_t body_count,
              std::size_t contact_count, std::uint64_t input_count) {
  Json object;
  object["schema"] = "ticktrue.run/1";
  object["scene"] = engine.scene().name;
  object["precision"] = engine::info_of(engine::precisions, engine.scene().settings.precision).name;
  object["solver"] = engine::info_of(engine::solvers, engine.scene().settings.solver).name;
  object["ticks"] = result.tick_count;
  object["time_s"] = engine.time_s();
  object["stopped"] = result.stopped;
  object["bodies"] = body_count;
  object["contacts"] = contact_count;
  object["inputs"] = input_count;
  object["ignored_inputs"] = engine.ignored_inputs();
  if (const auto budget = engine.budget_report())
    object["budget"] = {{"cut_ticks", budget->cut_ticks}, {"limited_ticks", budget->limited_ticks}};
  object["ms_per_tick"] = result.times.median_s() * 1e3;
  object["simulate_s"] = result.times.sum_s();
  object["hash"] = hex64(result.root_hash);
  object["non_finite"] = result.non_finite ? verifier::non_finite_json(*result.non_finite) : Json(nullptr);
  return object;
}

int run_run(const RunOptions& options) {
  if (const Status status = check_threads(options.thread_count); !status) return fail_usage(status.error());
  if (has_plugin()) {
    PluginSession session;
    session.scene = options.scene;
    session.inputs = options.inputs;
    session.tick_count = options.tick_count;
    session.json = options.json;
    return run_plugin(session);
  }
  const Result<engine::Scene> scene = load_scene_argument(options.scene);
  if (!scene) return fail_usage(scene.error());
  const auto made = engine::make_engine(*scene, engine_options(options.thread_count));
  if (!made) return fail_usage(made.error());
  engine::Engine& engine = **made;
  for (const std::string& note : tool::scene_notes(*scene)) print_note(note);
  catch_stop_signals();
  auto inputs = open_session_inputs(*scene, options.inputs, options.tick_count);
  if (!inputs) return fail_usage(inputs.error());
  if (const Status status = use_clock(*inputs, options.host, engine); !status) return fail_usage(status.error());

  Progress progress("run " + scene->name, inputs->ticks_expected);
  const auto result = tool::run_session(engine, *inputs->source, options.tick_count, [&](std::uint64_t ticks_done) {
    progress.update(ticks_done);
    return !stop_requested();
  });
  progress.finish();
  if (!result) return fail_usage(with_input_place(result.error(), *inputs, engine));

  // A state with a NaN in it has no contacts worth finding.
  const std::size_t contact_count = result->non_finite ? 0 : engine.contacts().size();
  const std::size_t body_count = engine.bodies().size();
  const std::uint64_t input_count = inputs->lines == nullptr ? 0 : inputs->lines->count();
  if (options.json) {
    Json object = run_json(engine, *result, body_count, contact_count, input_count);
    if (inputs->clock != nullptr) object["clock"] = clock_json(*scene, inputs->clock->report());
    print_json(object);
  } else {
    print(fmt::format("{}  {}  {} ticks ({:.3f} s)\n", result->non_finite ? "not finite" : "ran", scene->name,
                      result->tick_count, engine.time_s()));
    if (result->non_finite) print(fmt::format("  where     {}\n", non_finite_text(*result->non_finite)));
    print(fmt::format("  bodies    {}\n  contacts  {}\n", body_count, contact_count));
    if (inputs->lines != nullptr)
      print(
          fmt::format("  inputs    {}, of which {} to bodies already removed\n", input_count, engine.ignored_inputs()));
    const std::string budget = tool::budget_text(engine.budget_report(), result->tick_count);
    if (!budget.empty()) print(fmt::format("  budget    {}\n", budget));
    if (inputs->clock != nullptr) print(fmt::format("  clock     {}\n", clock_text(*scene, inputs->clock->report())));
    print(fmt::format("  time      {:.4g} ms/tick (median), {:.3f} s in all\n", result->times.median_s() * 1e3,
                      result->times.sum_s()));
    print(fmt::format("  hash      {}\n", hex64(result->root_hash)));
  }
  if (result->stopped) print_note("stopped after tick " + std::to_string(result->tick_count) + " as asked");
  return result->non_finite ? exit_finding : exit_ok;
}

}  // namespace

void add_run(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* command = app.add_subcommand("run", "Simulate a scene, keep nothing")->group(group_session);
  command->add_option("SCENE", options->scene, "Scene file (.json) or built-in scene, with parameters: stack?boxes=20")
      ->required();
  command->add_option("--inputs", options->inputs, "Inputs as JSON Lines, - for standard input")->type_name("FILE");
  add_number(*command, "--ticks", options->tick_count, "How many ticks; without it: up to the `end` input",
             {1, limits::tick_count_max});
  add_threads_option(*command, options->thread_count);
  add_host_options(*command, options->host);
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command,
               "ticktrue run 'pyramid?base=20' --ticks 600\n"
               "ticktrue import mouse --model 1 --seconds 20 --scene thesis -o session.jsonl\n"
               "ticktrue run thesis --inputs session.jsonl --json");
  command->callback([options, &context] { context.exit_code = run_run(*options); });
}

}  // namespace ticktrue::cli
