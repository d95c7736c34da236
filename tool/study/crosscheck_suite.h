// The scenes of `ticktrue crosscheck --suite`: structures whose outcome a person can predict. The scenes are so small
// that an ensemble of each takes seconds in both engines.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include "engine/scene/scene.h"

namespace ticktrue::tool {

struct SuiteScene {
  std::string_view name;
  std::string_view outcome;  // the expected outcome
  double seconds;            // s, simulated
  engine::Scene (*make)();
  // The scene falls here with its 4 substeps, but stands with Box2D's finest steps: `differ` is the right verdict.
  bool falls_short = false;
};

std::span<const SuiteScene> crosscheck_suite();

}  // namespace ticktrue::tool
