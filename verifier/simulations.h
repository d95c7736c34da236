// The simulations this build can make from a trace, those of loaded plug-ins with them: the only list of them.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/simulation.h"

namespace ticktrue::verifier {

std::vector<const SimulationInfo*> simulations();

/// The simulation with this name, or null.
const SimulationInfo* find_simulation(std::string_view name);

/// Whether simulations of it may run on several threads at once. Only what is part of this build is known to share
/// nothing between them.
bool runs_on_threads(const SimulationInfo& info);

/// How commands for traces of this simulation begin: "ticktrue", and --plugin where a plug-in brought it.
std::string tool_words(std::string_view simulation);

/// "a, b or c": for error messages.
std::string simulation_names();

}  // namespace ticktrue::verifier
