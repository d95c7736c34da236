// Built-in scenes with parameters: `pyramid?base=20&precision=f64`.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// A parameter of a built-in scene: a whole number or a real number within limits.
struct SceneParameter {
  std::string_view name;
  double value;  // default
  double min;
  double max;
  bool whole;
  std::string_view summary;  // with unit
};

struct SceneArguments;

struct BuiltinScene {
  std::string_view name;
  std::string_view summary;
  std::span<const SceneParameter> parameters;
  Scene (*build)(const SceneArguments& arguments);
  /// The budget of the automatic substeps that the scene has if `substeps` is not given: so that they take less than
  /// 1.5 times as long as 4 substeps, or a tick less than 0.1 ms. 0: the scene has 4 substeps, or a number of its own.
  int automatic_budget = 0;
};

/// The only list of built-in scenes.
std::span<const BuiltinScene> builtin_scenes();
/// The parameters that every scene has besides its own.
std::span<const std::string_view> scene_setting_names();

/// `name` or `name?key=value&key=value`. Besides its own parameters each scene takes the names of Settings:
/// precision, dt, substeps, solver, integrator, broad_phase, and gravity (m/s^2 downwards). Without `substeps`, those
/// of BuiltinScene::automatic_budget; a solver that does not substep has one.
/// Errors: usage (unknown name or key, value out of range), and what check_scene refuses.
Result<Scene> make_builtin_scene(std::string_view text);

}  // namespace ticktrue::engine
