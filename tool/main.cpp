// ticktrue: the command line tool.
// SPDX-License-Identifier: MIT
#include "tool/cli/command_line.h"

int main(int argc, char** argv) {
  return ticktrue::cli::run_command_line(argc, argv);
}
