// The scenes of `ticktrue crosscheck --suite`: structures whose outcome a person can foretell, small enough that an
// ensemble of each in both engines takes seconds.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include "engine/scene/scene.h"

namespace ticktrue::verifier {

struct SuiteScene {
  std::string_view name;
  std::string_view outcome;  // what a person expects to see, in a few words
  double seconds;            // simulated
  engine::Scene (*make)();
};

/// In the order in which they are run.
std::span<const SuiteScene> crosscheck_suite();

}  // namespace ticktrue::verifier
