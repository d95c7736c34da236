// docs/experiments.md shows the output of its commands. Tested are commands whose output is equal everywhere and takes
// seconds.
// SPDX-License-Identifier: MIT
//
// ./dev experiments rewrites every output. ./dev experiments --check compares the outputs that are equal everywhere.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/catch.h"

TEST_CASE("the quick tables of docs/experiments.md are what the tool prints, digit by digit",
          "[cli][docs][equivalence]") {
  const std::string bin = std::filesystem::path(TICKTRUE_TOOL).parent_path().string();
  const std::string command = "cd '" + std::string(TICKTRUE_SOURCE_DIR) + "' && PATH='" + bin +
                              "':\"$PATH\" sh bench/experiments.sh check quick 2>/dev/null";
  CHECK(std::system(command.c_str()) == 0);
}
