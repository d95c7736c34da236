// `ticktrue describe`: which stages and columns a scene is made of, and why.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <type_traits>

#include "base/plain_text.h"
#include "engine/scene/scene_fields.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/output/scene_notes.h"
#include "tool/study/table.h"

namespace ticktrue::cli {
namespace {

struct DescribeOptions {
  std::string scene;
  bool full = false;
  bool json = false;
};

/// The choices of a scene by name: what is set, and what could be.
struct ChoiceText {
  std::string_view key;
  std::string_view value;
  std::string_view summary;
  std::string allowed;
};

std::vector<ChoiceText> choices_of(const engine::Scene& scene) {
  const engine::Settings& settings = scene.settings;
  std::vector<ChoiceText> choices;
  const auto add = [&](std::string_view key, const auto& table, auto kind) {
    const auto& info = engine::info_of(table, kind);
    choices.push_back({key, info.name, info.summary, engine::choice_names(table)});
  };
  const engine::Settings unset;
  engine::visit_fields(
      [&](const engine::FieldInfo& field, auto value, auto default_value) {
        if (field.since > 0 && value == default_value) return;  // as in JSON
        if constexpr (std::is_same_v<decltype(value), engine::JointSolverKind>) {
          if (scene.joints.empty()) return;
        }
        if constexpr (std::is_enum_v<decltype(value)>) add(field.name, engine::Tables::of(value), value);
      },
      settings, unset);
  add("clock", engine::clock_kinds, settings.clock.kind);
  return choices;
}

std::string type_text(const Column& column) {
  const ScalarInfo* info = scalar_info(column.type);
  std::string text(info == nullptr ? "unknown" : info->name);
  if (column.lane_count > 1) text += " x " + std::to_string(column.lane_count);
  return text;
}

std::string range_text(const StateSchema& schema, const Column& column) {
  if (column.target >= 0)
    return "id of a row of " + schema.tables[static_cast<std::size_t>(column.target)].name +
           (column.optional ? ", or none" : "");
  if (!std::isfinite(column.min) && !std::isfinite(column.max)) return "";
  return fmt::format("{} .. {}", column.min, column.max);
}

void print_text(const engine::Engine& engine, const DescribeOptions& options) {
  const engine::Scene& scene = engine.scene();
  const auto& automatic = scene.settings.auto_substeps;
  print(fmt::format("{}  {} bodies, {} prototypes, dt {:.6g} s, {}{} substeps\n", plain_line(scene.name),
                    scene.bodies.size(), scene.prototypes.size(), scene.settings.dt, scene.settings.substeps,
                    automatic ? ".." + std::to_string(automatic->substeps_max) : ""));
  if (scene.settings.substep_budget > 0)
    print(
        fmt::format("  a tick costs at most about as much as with {} fixed substeps\n", scene.settings.substep_budget));
  print("choices\n");
  for (const ChoiceText& choice : choices_of(scene)) {
    print(fmt::format("  {:<16} {:<20} {}\n", choice.key, choice.value, choice.summary));
    if (options.full) print(fmt::format("  {:<16} {}\n", "", "of " + choice.allowed));
  }
  if (const std::vector<std::string> notes = tool::scene_notes(scene); !notes.empty()) {
    print("notes\n");
    for (const std::string& note : notes) print(tool::wrapped(note, 2));
  }
  print("pipeline of a tick\n");
  for (const engine::StageDescription& stage : engine.describe())
    print(fmt::format("  {:<3} {:<16} {}\n", stage.included ? "in" : "out", stage.name, stage.why));
  print("state\n");
  const StateView& state = engine.state();
  for (std::size_t i = 0; i < state.schema->tables.size(); ++i) {
    const TableSchema& table = state.schema->tables[i];
    print(fmt::format("  {:<16} {} rows of {} bytes, {} columns\n", table.name, state.tables[i].row_count,
                      table.row_size, table.columns.size()));
    if (options.full) {
      for (const Column& column : table.columns)
        print(fmt::format("    {:>4}  {:<24} {:<10} {}\n", column.offset, column.name, type_text(column),
                          range_text(*state.schema, column)));
      continue;
    }
    std::string names;
    for (const Column& column : table.columns) names += (names.empty() ? "" : ", ") + column.name;
    print(fmt::format("    {}\n", names));
  }
}

void print_object(const engine::Engine& engine) {
  const engine::Scene& scene = engine.scene();
  Json object;
  object["schema"] = "ticktrue.describe/1";
  object["scene"] = scene.name;
  object["bodies"] = scene.bodies.size();
  object["prototypes"] = scene.prototypes.size();
  object["dt"] = scene.settings.dt;
  object["substeps"] = scene.settings.substeps;
  if (scene.settings.substep_budget > 0) object["substep_budget"] = scene.settings.substep_budget;
  object["inputs"] = Json::array();
  for (const engine::InputKind kind : scene.inputs)
    object["inputs"].push_back(engine::input_kinds[static_cast<std::size_t>(kind)].name);
  object["choices"] = Json::object();
  for (const ChoiceText& choice : choices_of(scene)) object["choices"][std::string(choice.key)] = choice.value;
  object["notes"] = tool::scene_notes(scene);
  object["stages"] = Json::array();
  for (const engine::StageDescription& stage : engine.describe())
    object["stages"].push_back({{"name", stage.name}, {"included", stage.included}, {"why", stage.why}});
  object["tables"] = Json::array();
  const StateView& state = engine.state();
  for (std::size_t i = 0; i < state.schema->tables.size(); ++i) {
    const TableSchema& table = state.schema->tables[i];
    Json columns = Json::array();
    for (const Column& column : table.columns) {
      const ScalarInfo* info = scalar_info(column.type);
      Json entry;
      entry["name"] = column.name;
      entry["type"] = info == nullptr ? "unknown" : std::string(info->name);
      entry["lanes"] = column.lane_count;
      entry["offset"] = column.offset;
      // JSON has no infinity: null stands for "no limit".
      entry["min"] = std::isfinite(column.min) ? Json(column.min) : Json(nullptr);
      entry["max"] = std::isfinite(column.max) ? Json(column.max) : Json(nullptr);
      entry["target"] =
          column.target >= 0 ? Json(state.schema->tables[static_cast<std::size_t>(column.target)].name) : Json(nullptr);
      columns.push_back(std::move(entry));
    }
    object["tables"].push_back({{"name", table.name},
                                {"rows", state.tables[i].row_count},
                                {"row_size", table.row_size},
                                {"columns", std::move(columns)}});
  }
  print_json(object);
}

int run_describe(const DescribeOptions& options) {
  const Result<engine::Scene> scene = load_scene_argument(options.scene);
  if (!scene) return fail_usage(scene.error());
  const auto engine = engine::make_engine(*scene);
  if (!engine) return fail_usage(engine.error());
  if (options.json)
    print_object(**engine);
  else
    print_text(**engine, options);
  return exit_ok;
}

}  // namespace

void add_describe(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<DescribeOptions>();
  CLI::App* command =
      app.add_subcommand("describe", "Say which stages and columns a scene is made of, and why")->group(group_upkeep);
  command->add_option("SCENE", options->scene, "Scene file (.json) or built-in scene, with parameters: stack?boxes=20")
      ->required();
  command->add_flag("--full", options->full, "Every column with type, offset and valid range; every allowed choice");
  command->add_flag("--json", options->json, "One JSON object, everything in it");
  set_examples(*command,
               "ticktrue describe projectile\n"
               "ticktrue describe 'pyramid?base=20&solver=impulse' --full");
  command->callback([options, &context] { context.exit_code = run_describe(*options); });
}

}  // namespace ticktrue::cli
