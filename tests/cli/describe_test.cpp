// Required content of the ten descriptions. A description of a scene names no part that the scene lacks.
// SPDX-License-Identifier: MIT
#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/catch.h"

namespace ticktrue::test {
namespace {

// The output of `ticktrue describe ARGUMENT`, from tests/cli/describe.expected.
std::string description_of(const std::string& argument) {
  std::ifstream in(std::string(TICKTRUE_SOURCE_DIR) + "/tests/cli/describe.expected");
  std::string text;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line.compare(0, 2, "$ ") == 0)
      inside = line == "$ ticktrue describe " + argument;
    else if (inside)
      text += line + "\n";
  }
  REQUIRE(!text.empty());
  return text;
}

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("a projectile composes one stage, circles never mention polygons, and no joints means no joint columns",
          "[cli][describe][golden]") {
  const std::string projectile = description_of("projectile");
  CHECK(count_of(projectile, "\n  in  ") == 1);
  CHECK(count_of(projectile, "\n  in  free_flight") == 1);
  CHECK(count_of(description_of("circles?substeps=4"), "polygon") == 0);
  CHECK(count_of(description_of("stack"), "polygon x polygon") == 1);
  for (const std::string name : {"projectile", "circles?substeps=4", "stack"})
    CHECK(count_of(description_of(name), "joint") == 0);
  CHECK(count_of(description_of("bridge?substeps=4"), "\n  joints ") == 1);
}

}  // namespace ticktrue::test
