// The built-in scenes, their parameters, and how `name?key=value&key=value` is read.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/builtin_scenes.h"

#include <array>
#include <optional>
#include <utility>

#include "base/limits.h"
#include "engine/builtin_scenes/families.h"
#include "engine/builtin_scenes/pieces.h"
#include "engine/json/number_text.h"

namespace ticktrue::engine {
namespace {

const std::array<BuiltinScene, 25> scenes{{
    {"thesis",
     "the thesis' window: fixed disc, block, floor and walls; a mouse adds circles, boxes, polygons",
     {},
     build_thesis},
    {"stack", "boxes on top of each other", stack_parameters, build_stack, default_substep_budget},
    {"pyramid", "a pyramid of 1 m boxes", pyramid_parameters, build_pyramid, default_substep_budget},
    {"large_pyramid",
     "a pyramid of 5,050 boxes, as benchmarked in Box2D",
     {},
     build_large_pyramid,
     default_substep_budget},
    {"many_pyramids", "400 pyramids of 55 boxes, as benchmarked in Box2D", many_pyramids_parameters,
     build_many_pyramids, default_substep_budget},
    {"circles", "a grid of circles falls into a tub made of circles", circles_parameters, build_circles, 12},
    {"mixed_pile", "circles, boxes and polygons fall into a container", mixed_pile_parameters, build_mixed_pile,
     default_substep_budget},
    {"projectile", "balls in free flight", projectile_parameters, build_projectile},
    {"billiards", "a disc hits fifteen, elastic and without friction", billiards_parameters, build_billiards,
     default_substep_budget},
    {"slide", "a box slides to rest", slide_parameters, build_slide, default_substep_budget},
    {"shapes", "every shape falls into a tub made of a chain", shapes_parameters, build_shapes, default_substep_budget},
    {"sensors", "balls fall through two sensors onto a conveyor; events are told", sensors_parameters, build_sensors,
     default_substep_budget},
    {"pendulum", "a disc on a rod of 1 m", pendulum_parameters, build_pendulum, default_substep_budget},
    {"chain", "links hang from a peg, or swing down", chain_parameters, build_chain, default_substep_budget},
    {"bridge", "planks pinned end to end between two pegs", bridge_parameters, build_bridge, 12},
    {"joint_grid", "a net of discs hangs from seven of its own; columns=100 is benchmarked in Box2D",
     joint_grid_parameters, build_joint_grid},
    {"card_house", "thin cards lean against each other, floor upon floor", card_house_parameters, build_card_house,
     default_substep_budget},
    {"thesis_mix", "circles, boxes and polygons of the thesis fall into its window, widened for more than 150 of them",
     thesis_mix_parameters, build_thesis_mix},
    {"tumbler", "2,025 boxes in a turning drum, as benchmarked in Box2D", tumbler_parameters, build_tumbler},
    {"smash", "a ram hits a wall of 9,600 boxes without gravity, as benchmarked in Box2D", smash_parameters,
     build_smash},
    {"spinner", "a bar stirs 6,076 bodies in a ring, as benchmarked in Box2D", spinner_parameters, build_spinner},
    {"rain", "a thousand jointed figures fall onto five floors, after Box2D's benchmark", rain_parameters, build_rain},
    {"gas", "discs without friction fly about between four walls", gas_parameters, build_gas},
    {"loose", "boxes drift and hardly ever touch", loose_parameters, build_loose, default_substep_budget},
    {"resting", "many boxes sleep, a few discs go on bouncing", resting_parameters, build_resting,
     default_substep_budget},
}};

// ---- Reading `name?key=value` ----

constexpr std::array<std::string_view, 14> setting_names{
    "precision", "dt",    "substeps",       "solver",     "integrator", "broad_phase",   "gravity",
    "clock",     "sleep", "locate_impacts", "continuous", "joints",     "substep_loads", "substep_budget"};

Error usage(std::string_view text, const std::string& what, std::string hint = {}) {
  return Error{ErrorCode::usage, std::string(text) + ": " + what, std::move(hint)};
}

/// Reads one number of a parameter; checks its range and whether it is whole. `value` "1/60" is read as a quotient.
Result<double> read_number(std::string_view text, std::string_view key, std::string_view value, double min, double max,
                           bool whole) {
  const std::size_t slash = value.find('/');
  std::optional<double> number = parse_number(value.substr(0, slash));
  if (number && slash != std::string_view::npos) {
    const std::optional<double> below = parse_number(value.substr(slash + 1));
    number = below && *below > 0 ? std::optional(*number / *below) : std::nullopt;
  }
  const std::string expected = (whole ? "a whole number " : "") + number_text(min) + ".." + number_text(max);
  if (!number)
    return usage(text, std::string(key) + ": not a number: found \"" + std::string(value) + "\", expected " + expected);
  // The range is checked first: a number out of range has no conversion to an integer.
  if (!(*number >= min && *number <= max) ||
      (whole && static_cast<double>(static_cast<std::int64_t>(*number)) != *number))
    return usage(text, std::string(key) + ": out of range: found " + number_text(*number) + ", expected " + expected);
  return *number;
}

template <typename Table, typename Kind>
Status read_choice(std::string_view text, std::string_view key, std::string_view value, const Table& table,
                   std::optional<Kind>& out) {
  const auto* row = find_choice(table, value);
  if (row == nullptr)
    return usage(text,
                 std::string(key) + ": unknown: found \"" + std::string(value) + "\", expected " + choice_names(table));
  out = row->kind;
  return {};
}

Status read_argument(std::string_view text, std::string_view key, std::string_view value, SceneArguments& out) {
  const auto number = [&](double min, double max, bool whole, auto& target) -> Status {
    const Result<double> result = read_number(text, key, value, min, max, whole);
    if (!result) return result.error();
    target = static_cast<typename std::decay_t<decltype(target)>::value_type>(*result);
    return {};
  };
  if (key == "precision") return read_choice(text, key, value, precisions, out.precision);
  if (key == "dt") return number(limits::dt_min_s, limits::dt_max_s, false, out.dt);
  if (key == "substeps" && value == "auto") {
    out.auto_substeps = true;
    return {};
  }
  if (key == "substeps") return number(1, limits::substep_count_max, true, out.substeps);
  if (key == "solver") return read_choice(text, key, value, solvers, out.solver);
  if (key == "integrator") return read_choice(text, key, value, integrators, out.integrator);
  if (key == "broad_phase") return read_choice(text, key, value, broad_phases, out.broad_phase);
  if (key == "joints") return read_choice(text, key, value, joint_solvers, out.joints);
  if (key == "substep_loads") return read_choice(text, key, value, substep_loads, out.substep_loads);
  if (key == "substep_budget") return number(0, ranges::substep_budget.max, true, out.substep_budget);
  if (key == "clock") return read_choice(text, key, value, clock_kinds, out.clock);
  if (key == "sleep") return number(0, 1, true, out.sleep);
  if (key == "locate_impacts") return number(0, 1, true, out.locate_impacts);
  if (key == "continuous") return number(0, 1, true, out.continuous);
  if (key == "gravity") return number(-limits::speed_max, limits::speed_max, false, out.gravity);
  std::string known;
  for (std::size_t i = 0; i < out.parameters.size(); ++i) {
    const SceneParameter& parameter = out.parameters[i];
    if (key == parameter.name) {
      const Result<double> result = read_number(text, key, value, parameter.min, parameter.max, parameter.whole);
      if (!result) return result.error();
      out.values[i] = *result;
      return {};
    }
    known += std::string(parameter.name) + ", ";
  }
  for (std::size_t i = 0; i < setting_names.size(); ++i)
    known += std::string(i == 0 ? "" : i + 1 == setting_names.size() ? " or " : ", ") + std::string(setting_names[i]);
  return usage(text, "unknown parameter: found \"" + std::string(key) + "\", expected " + known);
}

void apply_settings(const SceneArguments& arguments, int automatic_budget, Scene& scene) {
  Settings& settings = scene.settings;
  if (arguments.precision) settings.precision = *arguments.precision;
  if (arguments.dt) settings.dt = *arguments.dt;
  if (arguments.solver) settings.solver = *arguments.solver;
  const bool has_substeps = info_of(solvers, settings.solver).substeps;
  if (!has_substeps) settings.substeps = 1;
  if (arguments.substeps) settings.substeps = *arguments.substeps;
  if (arguments.auto_substeps) {
    choose_substeps(settings);
  } else if (automatic_budget > 0 && has_substeps && !arguments.substeps) {
    choose_substeps(settings);
    settings.substep_budget = automatic_budget;
  }
  if (arguments.sleep) settings.sleep.reset();
  if (arguments.sleep && *arguments.sleep == 1) settings.sleep.emplace();
  if (arguments.locate_impacts) settings.locate_impacts = *arguments.locate_impacts == 1;
  if (arguments.continuous) settings.continuous = *arguments.continuous == 1;
  if (arguments.integrator) settings.integrator = *arguments.integrator;
  if (arguments.broad_phase) settings.broad_phase = *arguments.broad_phase;
  if (arguments.joints) settings.joints = *arguments.joints;
  if (arguments.substep_loads) settings.substep_loads = *arguments.substep_loads;
  if (arguments.substep_budget) settings.substep_budget = *arguments.substep_budget;
  if (arguments.clock) settings.clock.kind = *arguments.clock;
  if (arguments.gravity) scene.gravity = {0, 0 - *arguments.gravity};  // 0 - 0 is 0, not -0
}

}  // namespace

std::span<const BuiltinScene> builtin_scenes() {
  return scenes;
}
std::span<const std::string_view> scene_setting_names() {
  return setting_names;
}

Result<Scene> make_builtin_scene(std::string_view text) {
  if (text.size() > limits::name_size_max)
    return Error{ErrorCode::usage,
                 "scene: name too long: found " + std::to_string(text.size()) + " bytes, expected at most " +
                     std::to_string(limits::name_size_max),
                 ""};
  const std::size_t question = text.find('?');
  const std::string_view name = text.substr(0, question);
  const BuiltinScene* builtin = nullptr;
  std::string known;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (scenes[i].name == name) builtin = &scenes[i];
    known += std::string(i == 0 ? "" : i + 1 == scenes.size() ? " or " : ", ") + std::string(scenes[i].name);
  }
  if (builtin == nullptr)
    return usage(text, "no built-in scene has this name: found \"" + std::string(name) + "\", expected " + known,
                 "a scene of your own is the path of a JSON file");

  SceneArguments arguments;
  arguments.parameters = builtin->parameters;
  for (const SceneParameter& parameter : builtin->parameters) arguments.values.push_back(parameter.value);
  std::string_view rest = question == std::string_view::npos ? std::string_view() : text.substr(question + 1);
  std::vector<std::string_view> seen;
  while (!rest.empty()) {
    const std::size_t end = rest.find('&');
    const std::string_view part = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view() : rest.substr(end + 1);
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos)
      return usage(text, "parameter without value: found \"" + std::string(part) + "\", expected key=value");
    const std::string_view key = part.substr(0, equals);
    for (const std::string_view other : seen)
      if (other == key) return usage(text, "parameter given twice: found \"" + std::string(key) + "\" again");
    seen.push_back(key);
    if (Status status = read_argument(text, key, part.substr(equals + 1), arguments); !status) return status.error();
  }

  Scene scene = builtin->build(arguments);
  scene.name = text;
  apply_settings(arguments, builtin->automatic_budget, scene);
  if (Status status = check_scene(scene, std::string(text)); !status) return status.error();
  return scene;
}

}  // namespace ticktrue::engine
