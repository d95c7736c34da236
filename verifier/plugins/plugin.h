// Simulations from shared libraries: loads a plug-in of include/ticktrue.h and makes it available as a Simulation.
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

/// A plug-in's step, columns or destroy reported a failure: its simulation cannot continue. The command line catches
/// this exception, and `verify` catches it for each of several files.
class PluginFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Whether this system loads shared libraries into a running program.
bool can_load_plugins();

/// Loads a library and adds its simulation to simulations(). The library stays loaded until the process ends.
/// Errors: io (no such library, no entry), incompatible (another version of the interface), usage (its description is
/// wrong, or its name is taken).
Status load_plugin(const std::string& path, const std::function<bool(std::string_view)>& is_taken);

/// The loaded simulations, in the order of loading.
std::span<const SimulationInfo* const> plugin_simulations();
/// The library of a simulation, as named in load_plugin; empty: it is not from a library.
std::string plugin_path(std::string_view simulation);
/// Facts about this library as build facts of a trace: plugin.path, and plugin.build if the plug-in states its build.
/// Empty: the simulation is not from a library.
std::vector<std::pair<std::string, std::string>> plugin_facts(std::string_view simulation);

}  // namespace ticktrue::verifier
