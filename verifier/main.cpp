// ticktrue: the command line tool.
// SPDX-License-Identifier: MIT
#include "verifier/cli/command_line.h"

int main(int argc, char** argv) {
  return ticktrue::cli::run_command_line(argc, argv);
}
