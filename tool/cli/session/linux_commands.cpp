// Stand-ins for the commands that start programs and look into them: on this system they say where they run.
// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <string>

#include "base/build_info.h"
#include "tool/cli/commands.h"

namespace ticktrue::cli {
namespace {

void add_stand_in(CLI::App& app, const std::string& name, const char* group, const std::string& description) {
  CLI::App* command = app.add_subcommand(name, description + " (runs on Linux)")->group(group);
  // Before its words are looked at, whatever they are.
  command->preparse_callback([name](std::size_t) {
    throw CLI::RuntimeError(fail_usage(
        Error{ErrorCode::unsupported, name + ": runs on Linux: found a build for " + build_info().target,
              "copy the trace to Linux, or to the Windows Subsystem for Linux, and build the program there"}));
  });
}

}  // namespace

void add_shake(CLI::App& app, CliContext&) {
  add_stand_in(app, "shake", group_session,
               "Run a recorded program again, with one source of differences changed at a time");
}

void add_trail(CLI::App& app, CliContext&) {
  add_stand_in(app, "trail", group_session,
               "Name the first call that a program makes otherwise, by the marks of each tick");
}

void add_unsaved(CLI::App& app, CliContext&) {
  add_stand_in(app, "unsaved", group_session,
               "Name the variables and heap blocks that a save forgets and that move a column");
}

void add_campaign(CLI::App& app, CliContext&) {
  add_stand_in(app, "campaign", group_session, "Record a program with many seeds, and verify each trace");
}

void add_bisect(CLI::App& app, CliContext&) {
  add_stand_in(app, "bisect", group_upkeep, "Find the commit from which on a trace no longer runs as recorded");
}

}  // namespace ticktrue::cli
