// The plug-in options: loading, and reporting a crash or a hang.
// SPDX-License-Identifier: MIT
#include "tool/cli/plugins.h"

#include <CLI/CLI.hpp>

#include "tool/output/cli.h"
#include "tool/session/simulations.h"
#include "verifier/plugins/plugin.h"
#include "verifier/runs/plugin_isolation.h"

namespace ticktrue::cli {

std::shared_ptr<PluginOptions> add_plugin_options(CLI::App& app) {
  auto options = std::make_shared<PluginOptions>();
  app.add_option(
         "--plugin", options->libraries,
         "A simulation from a shared library, for run, record, replay, verify, reduce, diff and inject; may stand "
         "more than once")
      ->type_name("LIB.so")
      ->expected(1)
      ->allow_extra_args(false)  // the next word is the scene
      ->take_all();
  add_number(app, "--plugin-timeout", options->timeout_s, "Seconds after which a call of a plug-in hangs (default 10)",
             {1, 86'400});
  return options;
}

std::optional<int> begin_plugins(const PluginOptions& options) {
  if (options.libraries.empty()) return std::nullopt;
  if (!verifier::can_load_plugins())
    return fail_usage(Error{ErrorCode::usage, "--plugin: this system loads no plug-ins", ""});
  std::string names;
  for (const std::string& library : options.libraries) names += (names.empty() ? "" : ", ") + library;
  if (!verifier::can_isolate_plugins()) {
    print_note("plug-in " + names +
               ": runs in the process of ticktrue, because this system does not isolate plug-ins: a crash ends the "
               "command, and --plugin-timeout has no effect");
  } else if (const auto end = verifier::run_isolated(names, options.timeout_s)) {
    if (end->dropped_output_size > 0)
      print_note("plug-in " + names + ": " + std::to_string(end->dropped_output_size) +
                 " more bytes that it printed are not shown");
    if (!end->escaped.empty())
      print_warning("plug-in " + names + ": left running, outside of the process group of the command: " +
                    verifier::escaped_text(end->escaped));
    if (end->stop_signal != 0) verifier::end_by_signal(end->stop_signal);
    if (!end->message.empty())
      print_error(Error{ErrorCode::usage, end->message,
                        "run the same under a debugger: the command runs in a child process (gdb: set follow-fork-mode "
                        "child)"});
    return end->exit_code;
  }
  use_data_output(verifier::isolated_output());
  for (const std::string& library : options.libraries)
    if (const Status loaded = verifier::load_plugin(
            library, [](std::string_view name) { return tool::find_simulation(name) != nullptr; });
        !loaded)
      return fail_usage(loaded.error());
  return std::nullopt;
}

}  // namespace ticktrue::cli
