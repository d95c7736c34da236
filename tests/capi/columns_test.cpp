// The C++ layer: every kind of member, containers that grow and move, differences at their place, and what is refused.
// SPDX-License-Identifier: MIT
#include <array>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/capi/cpp_units.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

using ticktrue_example::ExpectedColumn;
using ticktrue_example::make_unit;
using ticktrue_example::Unit;

constexpr std::uint32_t columns_ticks = 24;

ticktrue::Options columns_options(const std::string& path, int mode) {
  ticktrue::Options options("columns-test", nullptr);
  options.mode = mode;
  options.path = path.c_str();
  options.detail = TICKTRUE_DETAIL_FULL;
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
  options.checkpoint_interval = 8;
  return options;
}

/// Units come and go, so that the rows move. Keys ascend.
void step_units(std::vector<Unit>& units, std::uint32_t tick, int filler, std::mt19937& random) {
  for (Unit& unit : units) step(unit, tick);
  if (random() % 3 == 0 && units.size() > 2) units.erase(units.begin() + static_cast<long>(random() % units.size()));
  units.push_back(make_unit(100 + tick, filler));
  if (random() % 4 == 0) units.shrink_to_fit();
}

struct BitChange {
  std::uint32_t tick = 0;
  std::size_t row = 0;
  std::size_t byte = 0;  // of the unit
  unsigned char mask = 0;
};

struct CppOutcome {
  int exit_code = 0;
  std::string report;
};

CppOutcome play_cpp(const std::string& path, int mode, int filler = 0x55, const BitChange* change = nullptr) {
  std::mt19937 random(11);
  ticktrue::Session session(columns_options(path, mode));
  std::vector<Unit> units;
  session.table("units", units);
  for (std::uint32_t tick = 0; tick < columns_ticks; ++tick) {
    if (!session.begin_tick()) break;
    step_units(units, tick, filler, random);
    if (change != nullptr && change->tick == tick)
      reinterpret_cast<unsigned char*>(&units[change->row])[change->byte] ^= change->mask;
    session.end_tick();
  }
  CHECK(std::string(session.error()).empty());
  const int exit_code = ticktrue_finish(session.handle());
  return {exit_code, ticktrue_report(session.handle())};
}

/// The same program in words of the C interface.
int play_c(const std::string& path, int mode) {
  std::mt19937 random(11);
  const ticktrue::Options options = columns_options(path, mode);
  ticktrue_session* session = ticktrue_open(&options);
  std::vector<ticktrue_member> members;
  for (const ExpectedColumn& column : ticktrue_example::expected_columns())
    members.push_back({column.name, column.type, column.lanes, column.offset, 0});
  const std::uint32_t table =
      ticktrue_table(session, "units", sizeof(Unit), members.data(), static_cast<std::uint32_t>(members.size()));
  ticktrue_key(session, "units", 1);
  ticktrue_reference(session, "units", "target", "units");
  std::vector<Unit> units;
  for (std::uint32_t tick = 0; tick < columns_ticks; ++tick) {
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
    step_units(units, tick, 0x33, random);
    ticktrue_rows(session, table, units.data(), static_cast<std::uint32_t>(units.size()));
    ticktrue_end_tick(session);
  }
  CHECK(std::string(ticktrue_message(session)).empty());
  return ticktrue_close(session);
}

/// Runs of blanks as one.
std::string single_spaced(const std::string& text) {
  std::string result;
  for (const char c : text)
    if (c != ' ' || result.empty() || result.back() != ' ') result += c;
  return result;
}

TEST_CASE("a struct that names its members records the bytes of the same program in C",
          "[capi][columns][equivalence]") {
  const TracePath path;
  REQUIRE(play_cpp(path("cpp.ttr"), TICKTRUE_RECORD).exit_code == 0);
  REQUIRE(play_c(path("c.ttr"), TICKTRUE_RECORD) == 0);
  CHECK(path.bytes("cpp.ttr") == path.bytes("c.ttr"));
  CHECK(play_c(path("cpp.ttr"), TICKTRUE_VERIFY) == 0);
  CHECK(play_cpp(path("c.ttr"), TICKTRUE_VERIFY).exit_code == 0);
}

TEST_CASE("padding is in no trace", "[capi][columns][determinism]") {
  const TracePath path;
  REQUIRE(play_cpp(path("a.ttr"), TICKTRUE_RECORD, 0x00).exit_code == 0);
  REQUIRE(play_cpp(path("b.ttr"), TICKTRUE_RECORD, 0xff).exit_code == 0);
  CHECK(path.bytes("a.ttr") == path.bytes("b.ttr"));
}

TEST_CASE("a bit that is changed in any column is named by tick, table, column and row",
          "[capi][columns][corruption]") {
  const TracePath path;
  REQUIRE(play_cpp(path("x.ttr"), TICKTRUE_RECORD).exit_code == 0);
  std::mt19937 random(7);
  for (const ExpectedColumn& column : ticktrue_example::expected_columns()) {
    const std::string name = column.name;
    const std::size_t scalar = ticktrue_example::scalar_size(column.type);
    const std::size_t lane = random() % column.lanes;
    BitChange change;
    change.tick = 6 + static_cast<std::uint32_t>(random() % 12);
    change.row = 1;
    // The lowest bit: floats stay finite, a bool stays one.
    change.byte = column.offset + lane * scalar;
    change.mask = 1;
    if (name == "id" || name == "target") continue;  // the key names rows, and a reference names what it refers to
    CAPTURE(name, lane, change.tick);
    const CppOutcome outcome = play_cpp(path("x.ttr"), TICKTRUE_VERIFY, 0x55, &change);
    const std::string report = single_spaced(outcome.report);
    if (name == "glow") {
      CHECK(outcome.exit_code == 0);
      continue;
    }
    CHECK(outcome.exit_code == 1);
    CHECK(contains(report, "tick " + std::to_string(change.tick) + " of 24"));
    CHECK(contains(report, "column units." + name + " row 1"));
    if (column.lanes > 1) CHECK(contains(report, "lane " + std::to_string(lane)));
  }
}

TEST_CASE("arrays, spans and single structs are tables", "[capi][columns]") {
  const TracePath path;
  struct World {
    std::array<Unit, 2> pair;
    Unit three[3];
    Unit grid[2][2];
    Unit one;
    std::vector<Unit> pool;
    std::array<std::int32_t, 4> scores{};
    std::uint64_t seed = 5;
    ticktrue_example::Vec2 wind{0, 0};
  };
  const auto play = [](const std::string& file, int mode, const char* fault) {
    World world;
    std::uint32_t id = 0;
    const auto renew = [&id](Unit& unit) { unit = make_unit(id++, 0x11); };
    for (Unit& unit : world.pair) renew(unit);
    for (Unit& unit : world.three) renew(unit);
    for (auto& line : world.grid)
      for (Unit& unit : line) renew(unit);
    renew(world.one);
    for (int i = 0; i < 8; ++i) renew(world.pool.emplace_back());
    std::span<Unit> active(world.pool.data(), 2);
    ticktrue::Session session(columns_options(file, mode));
    session.table("pair", world.pair);
    session.table("three", world.three);
    session.table("grid", world.grid);
    session.table("one", world.one);
    session.table("active", active);
    session.table("scores", world.scores);
    session.table("seed", world.seed);
    session.table("wind", world.wind);
    session.table("units", world.pool);
    for (std::uint32_t tick = 0; tick < 6; ++tick) {
      if (!session.begin_tick()) break;
      active = std::span<Unit>(world.pool.data() + tick, 3);
      world.seed += tick;
      world.scores[tick % 4] -= 3;
      world.wind.x += 1;
      const auto is = [&](const char* name) { return tick == 4 && std::string(fault) == name; };
      if (is("pair")) world.pair[1].gold ^= 1;
      if (is("three")) world.three[2].gold ^= 1;
      if (is("grid")) world.grid[1][0].gold ^= 1;
      if (is("one")) world.one.gold ^= 1;
      if (is("active")) active = active.subspan(1);
      if (is("scores")) world.scores[3] ^= 1;
      if (is("seed")) world.seed ^= 1;
      if (is("wind")) world.wind.y += 1;
      session.end_tick();
    }
    CHECK(std::string(session.error()).empty());
    const int exit_code = ticktrue_finish(session.handle());
    return CppOutcome{exit_code, single_spaced(ticktrue_report(session.handle()))};
  };
  REQUIRE(play(path("x.ttr"), TICKTRUE_RECORD, "").exit_code == 0);
  CHECK(play(path("x.ttr"), TICKTRUE_VERIFY, "").exit_code == 0);
  const struct {
    const char* fault;
    const char* place;
  } faults[] = {{"pair", "column pair.gold row 1"},
                {"three", "column three.gold row 2"},
                {"grid", "column grid.gold row 2"},
                {"one", "column one.gold row 0"},
                {"active", "active"},
                {"scores", "column scores.value row 3"},
                {"seed", "column seed.value row 0"},
                {"wind", "column wind.value row 0, lane 1"}};
  for (const auto& [fault, place] : faults) {
    const CppOutcome outcome = play(path("x.ttr"), TICKTRUE_VERIFY, fault);
    CAPTURE(fault, outcome.report);
    CHECK(outcome.exit_code == 1);
    CHECK(contains(outcome.report, "tick 4 of 6"));
    CHECK(contains(outcome.report, place));
  }
}

TEST_CASE("a reference of the macro is a reference of the table, also to one registered later", "[capi][columns]") {
  const TracePath path;
  std::vector<Unit> units{make_unit(3, 0)};
  {
    ticktrue::Session session(columns_options(path("x.ttr"), TICKTRUE_RECORD));
    session.table("scouts", units);  // refers to "units"
    session.table("units", units);
    CHECK(session.begin_tick());
    CHECK(session.end_tick());
    CHECK(std::string(session.error()).empty());
    CHECK(session.close() == 0);
  }
  ticktrue::Session session(columns_options(path("y.ttr"), TICKTRUE_RECORD));
  session.table("scouts", units);
  CHECK(session.begin_tick());
  CHECK(contains(session.error(), "reference: table units: found none of this name"));
}

TEST_CASE("a recording that fails never ends the game", "[capi][columns]") {
  const TracePath path;
  const auto play = [](const std::string& file, float heat) {
    std::vector<Unit> units{make_unit(0, 0)};
    ticktrue::Session session(columns_options(file, TICKTRUE_RECORD));
    session.table("units", units);
    std::uint32_t ticks = 0;
    while (session.tick() < 40) {
      std::uint8_t button = 3;
      if (!session.input(button) || !session.begin_tick()) break;
      CHECK(button == 3);
      units[0].heat = session.tick() == 20 ? heat : 1;
      if (!session.end_tick()) break;
      ++ticks;
    }
    CHECK(ticks == 40);
    const int exit_code = session.close();
    CHECK(session.tick() == 40);
    return std::pair(exit_code, std::string(session.error()));
  };
  CHECK(play(path("good.ttr"), 1) == std::pair(0, std::string()));
  const auto [exists, exists_text] = play(path("good.ttr"), 1);
  CHECK(exists == 2);
  CHECK(contains(exists_text, "exists"));
  CHECK(play(path("no/such/folder.ttr"), 1).first == 2);
  CHECK(play(path("nan.ttr"), std::numeric_limits<float>::quiet_NaN()).first == 1);
}

TEST_CASE("a session without words is off, and all calls succeed", "[capi][columns]") {
  char word[] = "game";
  char* words[] = {word, nullptr};
  ticktrue::Session session(1, words, "columns-test");
  std::vector<Unit> units;
  std::vector<std::uint16_t> orders{1, 2};
  double dt = 0.5;
  std::uint32_t level = 4;
  CHECK_FALSE(session.is_on());
  CHECK(session.table("units", units));
  CHECK(session.setup(level));
  while (session.tick() < 5) {
    CHECK(session.input(orders));
    REQUIRE(session.begin_tick(dt));
    REQUIRE(session.end_tick());
  }
  CHECK(session.rewind(2));
  CHECK(session.tick() == 2);
  CHECK(dt == 0.5);
  CHECK(session.close() == 0);
}

}  // namespace
}  // namespace ticktrue::test
