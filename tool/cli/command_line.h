// The whole command line: finds the subcommand, runs it, reports what went wrong.
// SPDX-License-Identifier: MIT
#pragma once

namespace ticktrue::cli {

/// Returns the exit code of the process.
int run_command_line(int argc, char** argv);

}  // namespace ticktrue::cli
