// --plugin and --plugin-timeout: simulations from shared libraries, for every command that makes one.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace ticktrue::cli {

struct PluginOptions {
  std::vector<std::string> libraries;
  std::uint64_t timeout_s = 10;  // of one call: what a tick of any simulation stays far below
};

/// Adds both options to the top level.
std::shared_ptr<PluginOptions> add_plugin_options(CLI::App& app);

/// Without libraries: nothing. Else the command goes on in a child process with the libraries loaded (nothing is
/// returned there), or its end is returned as an exit code.
std::optional<int> begin_plugins(const PluginOptions& options);

}  // namespace ticktrue::cli
