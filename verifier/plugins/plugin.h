// Simulations from shared libraries: loads a plug-in of include/ticktrue.h and shows it as a Simulation.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/state/simulation.h"

namespace ticktrue::verifier {

/// A plug-in's step, columns or destroy that said it failed: nothing can go on from there. The command line catches it,
/// and `verify` for each of several files.
class PluginFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether this system loads shared libraries into a running program.
bool can_load_plugins();

/// Loads a library and adds its simulation to those of simulations(). Stays loaded until the process ends.
/// Errors: io (no such library, no entry), incompatible (another version of the interface), usage (what it says of
/// itself is wrong, or a simulation of its name is there already).
Status load_plugin(const std::string& path, const std::function<bool(std::string_view)>& is_taken);

/// Those loaded, in order.
std::span<const SimulationInfo* const> plugin_simulations();
/// The library that brought a simulation, as it was named to load_plugin; empty where none did.
std::string plugin_path(std::string_view simulation);
/// What is known of that library, as build facts of a trace: plugin.path, and plugin.build where it tells of its build.
/// Empty where no library brought the simulation.
std::vector<std::pair<std::string, std::string>> plugin_facts(std::string_view simulation);

}  // namespace ticktrue::verifier
