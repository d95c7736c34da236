// The list of all simulations that this build can make from a trace, including the simulations of loaded plug-ins.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/state/simulation.h"
#include "engine/engine.h"
#include "replay/format/trace.h"

namespace ticktrue::tool {

std::vector<const SimulationInfo*> simulations();

/// The simulation with this name, or null.
const SimulationInfo* find_simulation(std::string_view name);

/// If this environment variable is 1, every engine made for a session or a trace checks its caches in every tick
/// (EngineOptions::check_caches). The variable is read once.
inline constexpr const char* check_caches_variable = "TICKTRUE_CHECK_CACHES";
engine::EngineOptions engine_options_of_environment();

/// Whether several simulations of this kind may run on several threads. Only simulations of this build are known to
/// share nothing.
bool runs_on_threads(const SimulationInfo& info);

/// The facts about this build that go into traces, and those of the library that brought the simulation, if one did.
replay::BuildFacts make_build_facts(std::string_view simulation);

/// The beginning of commands for traces of this simulation: "ticktrue", with --plugin for a simulation of a plug-in.
std::string tool_command(std::string_view simulation);

/// "a, b or c", for error messages.
std::string simulation_names();

/// Names the command that verifies a trace of a simulation that this build lacks: with the plug-in, or by the program
/// that recorded the trace. `facts`: of the trace.
std::string other_simulation_hint(const std::string& file, const replay::BuildFacts& facts);

}  // namespace ticktrue::tool
