// The scenes of `ticktrue crosscheck --suite`: structures whose outcome a person can predict, small enough that an
// ensemble of each in both engines takes seconds.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include "engine/scene/scene.h"

namespace ticktrue::verifier {

struct SuiteScene {
  std::string_view name;
  std::string_view outcome;  // the expected outcome
  double seconds;            // simulated
  engine::Scene (*make)();
  // It runs with 4 substeps, and with these ours falls where Box2D's finest steps stand: `differ` is the right verdict.
  bool falls_short = false;
};

std::span<const SuiteScene> crosscheck_suite();

}  // namespace ticktrue::verifier
