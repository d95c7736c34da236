// docs/experiments.md shows what its commands print: those that are the same everywhere and take seconds.
// SPDX-License-Identifier: MIT
//
// ./dev experiments writes all of them again, ./dev experiments --check compares those that are the same everywhere.
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
