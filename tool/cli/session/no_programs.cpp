// Stand-in where the tool starts no programs: it need not know its own file.
// SPDX-License-Identifier: MIT
#include "tool/cli/session/program_runs.h"

namespace ticktrue::cli {

std::string own_program() {
  return "";
}

}  // namespace ticktrue::cli
