// `ticktrue scenes`: the built-in scenes with their parameters, or one of them as JSON.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "engine/builtin_scenes.h"
#include "engine/scene_json.h"
#include "verifier/cli/commands.h"
#include "verifier/cli/json_output.h"

namespace ticktrue::cli {
namespace {

struct ScenesOptions {
  std::string name;
  bool json = false;
  bool print = false;
};

std::string number_text(double value) {
  return fmt::format("{:.6g}", value);
}

void print_scene_text(const engine::BuiltinScene& scene) {
  print(fmt::format("{:<16} {}\n", scene.name, scene.summary));
  for (const engine::SceneParameter& parameter : scene.parameters)
    print(fmt::format("  {:<14} {:<8} {} ({}{} .. {})\n", parameter.name, number_text(parameter.value),
                      parameter.summary, parameter.whole ? "whole, " : "", number_text(parameter.min),
                      number_text(parameter.max)));
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
  return {{"name", scene.name}, {"summary", scene.summary}, {"parameters", std::move(parameters)}};
}

int run_scenes(const ScenesOptions& options) {
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
        "clock, and as 0 or 1 sleep, locate_impacts and continuous.\n");
  return exit_ok;
}

}  // namespace

void add_scenes(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ScenesOptions>();
  CLI::App* command =
      app.add_subcommand("scenes", "List the built-in scenes and their parameters, or print one")->group(group_upkeep);
  command->add_option("NAME", options->name, "Only this one; with --print also with parameters, or a file");
  command->add_flag("--print", options->print, "The scene as JSON: a start for one's own");
  command->add_flag("--json", options->json, "The list as one JSON object");
  set_examples(*command,
               "ticktrue scenes\n"
               "ticktrue scenes 'stack?boxes=3' --print > mine.json");
  command->callback([options, &context] { context.exit_code = run_scenes(*options); });
}

}  // namespace ticktrue::cli
