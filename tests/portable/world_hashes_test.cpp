// Random worlds end in the states of tests/worlds/hashes.tsv, in every build and on every platform.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/world_hashes.h"

#include <fstream>
#include <iterator>

#include "base/hash.h"
#include "tests/support/catch.h"

namespace ticktrue::test {

TEST_CASE("random worlds have the hashes of every platform", "[portable][worlds][determinism]") {
  std::ifstream in(std::string(TICKTRUE_SOURCE_DIR) + "/tests/worlds/hashes.tsv");
  REQUIRE(in.good());
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto expected = engine::parse_world_hashes(text, "tests/worlds/hashes.tsv");
  REQUIRE(expected.has_value());
  CHECK(expected->size() >= 100);
  for (const engine::WorldHash& world : *expected) {
    const engine::WorldHash found = engine::hash_world(world.seed);
    CAPTURE(world.seed);
    CHECK(found.tick_count == world.tick_count);
    CHECK(hex64(found.hash) == hex64(world.hash));
  }
}

TEST_CASE("hashes of worlds are printed and read back", "[portable][worlds][corruption]") {
  const std::vector<engine::WorldHash> worlds{{7, 60, 0x0123456789abcdef}, {18446744073709551615u, 0, 0}};
  const std::string text = engine::print_world_hashes(worlds);
  const auto read = engine::parse_world_hashes(text, "x.tsv");
  REQUIRE(read.has_value());
  CHECK(*read == worlds);
  for (const char* bad : {"7\t60", "7 60 0", "seven\t60\t0", "7\t60\t0\t1", "7\t60\txyz", ""})
    CHECK_FALSE(engine::parse_world_hashes(bad, "x.tsv").has_value());
}

}  // namespace ticktrue::test
