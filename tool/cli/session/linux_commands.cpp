// Stand-ins for the commands that start programs and look into them: on this system they say where they run.
// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <string>

#include "base/build_info.h"
#include "tool/cli/commands.h"

namespace ticktrue::cli {
namespace {

void add_stand_in(CLI::App& app, CliContext& context, const std::string& name, const char* group,
                  const std::string& description) {
  CLI::App* command = app.add_subcommand(name, description + " (runs on Linux)")->group(group);
  command->allow_extras()->allow_windows_style_options(false);  // whatever its words are
  command->callback([&context, name] {
    context.exit_code = fail_usage(
        Error{ErrorCode::unsupported, name + ": runs on Linux: found a build for " + build_info().target,
              "copy the trace to Linux, or to the Windows Subsystem for Linux, and build the program there"});
  });
}

}  // namespace

void add_shake(CLI::App& app, CliContext& context) {
  add_stand_in(app, context, "shake", group_session,
               "Run a recorded program again, with one source of differences changed at a time");
}

void add_trail(CLI::App& app, CliContext& context) {
  add_stand_in(app, context, "trail", group_session,
               "Name the first call that a program makes otherwise, by the marks of each tick");
}

void add_unsaved(CLI::App& app, CliContext& context) {
  add_stand_in(app, context, "unsaved", group_session,
               "Name the variables and heap blocks that a save forgets and that move a column");
}

void add_campaign(CLI::App& app, CliContext& context) {
  add_stand_in(app, context, "campaign", group_session, "Record a program with many seeds, and verify each trace");
}

void add_bisect(CLI::App& app, CliContext& context) {
  add_stand_in(app, context, "bisect", group_upkeep,
               "Find the commit from which on a trace no longer runs as recorded");
}

}  // namespace ticktrue::cli
