// `ticktrue scenes`: the built-in scenes with their parameters, one of them as JSON, or a random world.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/random_worlds/random_world.h"
#include "engine/scene/scene_json.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/output/scene_notes.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

struct ScenesOptions {
  std::string name;
  bool json = false;
  bool print = false;
  std::optional<std::uint64_t> seed;  // of a random world
  std::uint64_t body_count_max = engine::RandomWorldOptions{}.body_count_max;
  std::uint64_t tick_count_max = engine::RandomWorldOptions{}.tick_count_max;
  std::string output = "-";
  std::string inputs;
  bool force = false;
};

std::string number_text(double value) {
  return fmt::format("{:.6g}", value);
}

std::string budget_text(const engine::BuiltinScene& scene) {
  if (scene.automatic_budget == 0) return "";
  if (scene.automatic_budget == engine::default_substep_budget) return "; substeps=auto";
  return fmt::format("; substeps=auto, substep_budget={}", scene.automatic_budget);
}

void print_scene_text(const engine::BuiltinScene& scene) {
  print(fmt::format("{:<16} {}{}\n", scene.name, scene.summary, budget_text(scene)));
  for (const engine::SceneParameter& parameter : scene.parameters)
    print(fmt::format("  {:<14} {:<8} {} ({}{} .. {})\n", parameter.name, number_text(parameter.value),
                      parameter.summary, parameter.whole ? "whole, " : "", number_text(parameter.min),
                      number_text(parameter.max)));
}

/// As in a scene file.
Json default_substeps(const engine::BuiltinScene& scene) {
  if (scene.automatic_budget > 0) return "auto";
  const auto made = engine::make_builtin_scene(scene.name);
  return made ? Json(made->settings.substeps) : Json();
}

Json scene_json(const engine::BuiltinScene& scene) {
  Json parameters = Json::array();
  for (const engine::SceneParameter& parameter : scene.parameters)
    parameters.push_back({{"name", parameter.name},
                          {"default", parameter.value},
                          {"min", parameter.min},
                          {"max", parameter.max},
                          {"whole", parameter.whole},
                          {"summary", parameter.summary}});
  return {{"name", scene.name},
          {"summary", scene.summary},
          {"substeps", default_substeps(scene)},
          {"substep_budget", scene.automatic_budget},
          {"parameters", std::move(parameters)}};
}

// ---- Random worlds ----

Status write_text(const std::string& path, bool overwrite, const std::string& text) {
  if (path == "-") {
    print(text);
    return {};
  }
  auto file = verifier::DataFile::create(path, overwrite);
  if (!file) return file.error();
  if (const Status status = file->write(text); !status) return status;
  return file->close();
}

/// One line for each input, and the end of the session.
std::string input_lines(const engine::RandomWorld& world) {
  std::string lines;
  for (const engine::Input& input : world.inputs)
    if (input.kind != engine::InputKind::end) lines += engine::print_input(world.scene, input) + "\n";
  engine::Input end;
  end.tick = world.tick_count;
  return lines + engine::print_input(world.scene, end) + "\n";
}

/// Both files are checked before one is written.
Status write_world(const engine::RandomWorld& world, const ScenesOptions& options) {
  for (const std::string& path : {options.output, options.inputs})
    if (!path.empty() && path != "-")
      if (const Status status = verifier::check_writable_target(path, options.force); !status) return status;
  std::string scene = engine::print_scene(world.scene);
  if (scene.empty() || scene.back() != '\n') scene += '\n';
  if (const Status status = write_text(options.output, options.force, scene); !status) return status;
  return options.inputs.empty() ? Status{} : write_text(options.inputs, options.force, input_lines(world));
}

int run_random(const ScenesOptions& options) {
  if (options.output == options.inputs)
    return fail_usage(Error{ErrorCode::usage, "--inputs: found the file of the scene, expected another",
                            "ticktrue scenes --random 7 -o w.json --inputs w.jsonl"});
  const engine::RandomWorldOptions limits{static_cast<std::uint32_t>(options.body_count_max),
                                          static_cast<std::uint32_t>(options.tick_count_max)};
  engine::RandomWorld world = engine::random_world(*options.seed, limits);
  // The soak runs such worlds, too. A file of one would be refused.
  const bool is_too_far = !tool::check_f32_reach(world.scene, options.output);
  if (is_too_far) {
    world.scene.settings.precision = engine::Precision::f64;
    world.rows = engine::rows_of_world(world);
  }
  if (const Status status = write_world(world, options); !status) return fail_usage(status.error());
  std::string rows;
  for (const std::string& row : world.rows) rows += (rows.empty() ? "" : " ") + row;
  print_note(fmt::format("random world {}: {} bodies, {} ticks, rows: {}", *options.seed, world.scene.bodies.size(),
                         world.tick_count, rows));
  if (is_too_far) print_note("its bodies are too far from the origin for f32: the file says f64");
  if (options.output != "-" && !options.inputs.empty() && options.inputs != "-")
    print_note(fmt::format("next: ticktrue record {0} --inputs {1} -o {0}.ttr", options.output, options.inputs));
  return exit_ok;
}

int run_scenes(const ScenesOptions& options) {
  if (options.seed) return run_random(options);
  if (options.print) {
    if (options.name.empty())
      return fail_usage(
          Error{ErrorCode::usage, "--print: found no scene, expected one", "ticktrue scenes stack --print"});
    const Result<engine::Scene> scene = load_scene_argument(options.name);
    if (!scene) return fail_usage(scene.error());
    std::string text = engine::print_scene(*scene);
    if (text.empty() || text.back() != '\n') text += '\n';
    print(text);
    return exit_ok;
  }
  const std::string name = options.name.substr(0, options.name.find('?'));
  Json scenes = Json::array();
  std::vector<std::string> names;
  bool is_found = name.empty();
  for (const engine::BuiltinScene& scene : engine::builtin_scenes()) {
    names.emplace_back(scene.name);
    if (!name.empty() && scene.name != name) continue;
    is_found = true;
    if (options.json)
      scenes.push_back(scene_json(scene));
    else
      print_scene_text(scene);
  }
  if (!is_found) {
    const std::string nearest = nearest_name(name, names);
    return fail_usage(Error{ErrorCode::usage, "scene \"" + name + "\": found no built-in scene of this name",
                            nearest.empty() ? "`ticktrue scenes` lists them" : "did you mean " + nearest + "?"});
  }
  if (options.json)
    print_json({{"schema", "ticktrue.scenes/1"}, {"scenes", std::move(scenes)}});
  else
    print(
        "Each also takes precision, dt, substeps (a number or auto), solver, integrator, broad_phase, gravity,\n"
        "clock, joints, and as 0 or 1 sleep, locate_impacts and continuous.\n");
  return exit_ok;
}

}  // namespace

void add_scenes(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ScenesOptions>();
  CLI::App* command =
      app.add_subcommand("scenes", "List the built-in scenes and their parameters, print one, or make a random world")
          ->group(group_upkeep);
  command->add_option("NAME", options->name, "Only this one; with --print also with parameters, or a file");
  command->add_flag("--print", options->print, "The scene as JSON: a start for one's own");
  command->add_flag("--json", options->json, "The list as one JSON object");
  CLI::Option* random =
      add_number(*command, "--random", options->seed, "Instead: a random world with a random subset of all features")
          ->type_name("SEED");
  random->excludes("NAME")->excludes("--print")->excludes("--json");
  add_number(*command, "--bodies-max", options->body_count_max, "With --random: at most so many bodies (default 3000)",
             {2, 3000})
      ->needs(random);
  add_number(*command, "--ticks-max", options->tick_count_max, "With --random: at most so many ticks (default 600)",
             {1, 100'000})
      ->needs(random);
  command->add_option("-o,--output", options->output, "With --random: the scene file, - for standard output (default)")
      ->type_name("F.json")
      ->needs(random);
  command
      ->add_option("--inputs", options->inputs, "With --random: also the inputs as JSON Lines, - for standard output")
      ->type_name("F.jsonl")
      ->needs(random);
  command->add_flag("--force", options->force, "With --random: replace existing files")->needs(random);
  set_examples(*command,
               "ticktrue scenes\n"
               "ticktrue scenes 'stack?boxes=3' --print > mine.json\n"
               "ticktrue scenes --random 7 -o w.json --inputs w.jsonl\n"
               "ticktrue record w.json --inputs w.jsonl -o w.ttr");
  command->callback([options, &context] { context.exit_code = run_scenes(*options); });
}

}  // namespace ticktrue::cli
