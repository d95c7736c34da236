// Tables of structs behind the C interface: the same state as column by column, with fewer words, and what is refused.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "include/ticktrue.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

struct Spot {
  float x = 0;
  float y = 0;
};
struct Soldier {
  std::uint8_t kind = 0;
  std::uint32_t id = 0;
  double position[2] = {0, 0};
  Spot place;
  std::uint16_t hits = 0;
};

const std::vector<ticktrue_member> unit_members{
    TICKTRUE_MEMBER(Soldier, id, TICKTRUE_U32),          TICKTRUE_MEMBER(Soldier, kind, TICKTRUE_U8),
    TICKTRUE_MEMBER(Soldier, position, TICKTRUE_F64),    TICKTRUE_MEMBER(Soldier, place.y, TICKTRUE_F32),
    TICKTRUE_MEMBER(Soldier, position[1], TICKTRUE_F64), TICKTRUE_MEMBER(Soldier, hits, TICKTRUE_U16)};

ticktrue_session* open(const std::string& path, int mode) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = mode;
  options.path = path.c_str();
  options.name = "tables-test";
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
  options.detail = TICKTRUE_DETAIL_FULL;
  options.checkpoint_interval = 8;
  return ticktrue_open(&options);
}

std::uint32_t unit_table(ticktrue_session* session) {
  return ticktrue_table(session, "units", sizeof(Soldier), unit_members.data(),
                        static_cast<std::uint32_t>(unit_members.size()));
}

/// The same columns one by one.
void show_columns(ticktrue_session* session, const std::vector<Soldier>& units) {
  const auto rows = static_cast<std::uint32_t>(units.size());
  const Soldier none;
  const Soldier* u = units.empty() ? &none : units.data();
  ticktrue_column(session, "units", "id", &u->id, TICKTRUE_U32, 1, rows, sizeof(Soldier));
  ticktrue_column(session, "units", "kind", &u->kind, TICKTRUE_U8, 1, rows, sizeof(Soldier));
  ticktrue_column(session, "units", "position", u->position, TICKTRUE_F64, 2, rows, sizeof(Soldier));
  ticktrue_column(session, "units", "place.y", &u->place.y, TICKTRUE_F32, 1, rows, sizeof(Soldier));
  ticktrue_column(session, "units", "position[1]", &u->position[1], TICKTRUE_F64, 1, rows, sizeof(Soldier));
  ticktrue_column(session, "units", "hits", &u->hits, TICKTRUE_U16, 1, rows, sizeof(Soldier));
}

/// Units that come, go and move in memory. Returns the exit code.
int play(const std::string& path, int mode, bool by_column) {
  std::mt19937 random(5);
  ticktrue_session* session = open(path, mode);
  std::vector<Soldier> units;
  const std::uint32_t table = by_column ? 0 : unit_table(session);
  if (by_column) show_columns(session, units);
  ticktrue_key(session, "units", 1);
  for (std::uint32_t tick = 0; tick < 40; ++tick) {
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
    if (random() % 3 == 0) units.emplace_back().id = 2 + tick;
    if (random() % 7 == 0 && !units.empty()) units.erase(units.begin());
    for (Soldier& unit : units) {
      unit.kind = static_cast<std::uint8_t>(random());
      unit.position[random() % 2] += 0.5;
      unit.place.y += 0.25f;
      unit.hits = static_cast<std::uint16_t>(unit.hits + random());
    }
    if (by_column)
      show_columns(session, units);
    else
      ticktrue_rows(session, table, units.data(), static_cast<std::uint32_t>(units.size()));
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  CHECK(std::string(ticktrue_message(session)).empty());
  return ticktrue_close(session);
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_CASE("a table of structs records the bytes of its columns registered one by one", "[capi][tables][equivalence]") {
  const TracePath path;
  REQUIRE(play(path("columns.ttr"), TICKTRUE_RECORD, true) == 0);
  REQUIRE(play(path("tables.ttr"), TICKTRUE_RECORD, false) == 0);
  CHECK(bytes_of(path("columns.ttr")) == bytes_of(path("tables.ttr")));
  CHECK(play(path("columns.ttr"), TICKTRUE_VERIFY, false) == 0);
}

TEST_CASE("a table that is registered again keeps its number, and no session has tables", "[capi][tables]") {
  const TracePath path;
  ticktrue_session* session = open(path("x.ttr"), TICKTRUE_RECORD);
  std::vector<Soldier> units(3);
  for (std::uint32_t i = 0; i < 3; ++i) units[i].id = i;
  ticktrue_column(session, "world", "count", &units[0].id, TICKTRUE_U32, 1, 1, 0);
  const std::uint32_t table = unit_table(session);
  CHECK(table == 1);
  REQUIRE(ticktrue_begin_tick(session, nullptr) == TICKTRUE_OK);
  CHECK(unit_table(session) == table);
  CHECK(ticktrue_rows(session, table, units.data(), 3) == TICKTRUE_OK);
  CHECK(ticktrue_end_tick(session) == TICKTRUE_OK);
  CHECK(ticktrue_close(session) == 0);
  CHECK(unit_table(nullptr) == 0);
  CHECK(ticktrue_rows(nullptr, 7, nullptr, 9) == TICKTRUE_OK);
}

TEST_CASE("tables that are wrong are refused with the member to mend", "[capi][tables][corruption]") {
  using Call = void (*)(ticktrue_session*);
  static const auto add = [](ticktrue_session* session, std::vector<ticktrue_member> members,
                             std::size_t stride = sizeof(Soldier)) {
    const std::uint32_t number =
        ticktrue_table(session, "t", stride, members.data(), static_cast<std::uint32_t>(members.size()));
    CHECK(number == TICKTRUE_NO_TABLE);
  };
  static Soldier unit;
  const struct {
    Call call;
    const char* message;
  } wrongs[] = {
      {[](ticktrue_session* s) { CHECK(ticktrue_table(s, "t", 8, nullptr, 1) == TICKTRUE_NO_TABLE); },
       "table t: members: found null, expected 1..256"},
      {[](ticktrue_session* s) { add(s, {}); }, "table t: members: found "},
      {[](ticktrue_session* s) { CHECK(ticktrue_table(s, "", 8, unit_members.data(), 1) == TICKTRUE_NO_TABLE); },
       "table: name: found 0 bytes"},
      {[](ticktrue_session* s) { add(s, std::vector<ticktrue_member>(257, unit_members[0])); },
       "table t: members: found 257, expected 1..256"},
      {[](ticktrue_session* s) {
         add(s, {unit_members[0], unit_members[1], unit_members[0]});
       },
       "table t: column id: stands twice: as member 0 and as member 2, counted from 0"},
      {[](ticktrue_session* s) { add(s, {TICKTRUE_MEMBER(Soldier, kind, TICKTRUE_U32)}); },
       "table t: column kind: bytes in the struct: found 1, expected a multiple of 4 (u32)"},
      {[](ticktrue_session* s) {
         add(s, {{"position", TICKTRUE_F64, 3, offsetof(Soldier, position), 16}});
       },
       "table t: column position: bytes in the struct: found 16, expected 24 (f64)"},
      {[](ticktrue_session* s) {
         add(s, {{"x", TICKTRUE_F64, 0, 0, 8 * 256}});
       },
       "lanes: found 256, expected 1..255"},
      {[](ticktrue_session* s) {
         add(s, {{"x", TICKTRUE_F64, 0, 0, 0}});
       },
       "lanes: found 0, expected 1..255"},
      {[](ticktrue_session* s) {
         add(s, {{"x", 9, 1, 0, 0}});
       },
       "table t: column x: type: found 9"},
      {[](ticktrue_session* s) {
         add(s, {{nullptr, TICKTRUE_F64, 1, 0, 0}});
       },
       "table t: column: name: found 0 bytes"},
      {[](ticktrue_session* s) { add(s, unit_members, 8); }, "expected both inside the 8 bytes of a row"},
      {[](ticktrue_session* s) {
         add(s, {{"x", TICKTRUE_U8, 1, std::size_t(-1), 0}});
       },
       "table t: column x: offset: found "},
      {[](ticktrue_session* s) { ticktrue_rows(s, 0, &unit, 1); }, "rows: table 0: found no such number"},
      {[](ticktrue_session* s) { ticktrue_rows(s, unit_table(s), nullptr, 1); },
       "table units: pointer: found null, expected the first of 1 rows"},
      {[](ticktrue_session* s) { ticktrue_rows(s, unit_table(s), &unit, 0xffffffffu); },
       "table units: rows: found 4294967295, expected at most"},
      {[](ticktrue_session* s) {
         ticktrue_column(s, "t", "x", &unit.id, TICKTRUE_U32, 1, 1, 0);
         ticktrue_rows(s, 0, &unit, 1);
       },
       "rows: table 0: found columns that were registered one by one"},
      {[](ticktrue_session* s) {
         ticktrue_column(s, "t", "x", &unit.id, TICKTRUE_U32, 1, 1, 0);
         add(s, unit_members);
       },
       "table t: found other members than before"},
      {[](ticktrue_session* s) {
         unit_table(s);
         ticktrue_column(s, "units", "id", &unit.id, TICKTRUE_U32, 1, 1, 0);
       },
       "table units: column id: found a table whose columns are members of a struct"},
      {[](ticktrue_session* s) {
         unit_table(s);
         ticktrue_begin_tick(s, nullptr);
         add(s, unit_members);
       },
       "table t: found a new table after the first tick"},
  };
  const TracePath path;
  for (const auto& wrong : wrongs) {
    ticktrue_session* session = open(path("x.ttr"), TICKTRUE_RECORD);
    wrong.call(session);
    const std::string message = ticktrue_message(session);
    CAPTURE(message, wrong.message);
    CHECK(contains(message, wrong.message));
    CHECK(ticktrue_finish(session) == 2);
    CHECK(ticktrue_rows(session, 0, &unit, 1) == TICKTRUE_FAILED);
    ticktrue_finish(session);
    ticktrue_close(session);
    std::filesystem::remove(path("x.ttr"));
  }
}

TEST_CASE("thousands of tables register, and a trace says how many it can hold", "[capi][tables][corruption]") {
  const TracePath path;
  std::vector<std::uint32_t> values(20);
  const auto register_tables = [&](ticktrue_session* session, int table_count) {
    for (int t = 0; t < table_count; ++t)
      for (std::size_t c = 0; c < values.size(); ++c)
        ticktrue_column(session, ("t" + std::to_string(t)).c_str(), ("c" + std::to_string(c)).c_str(), &values[c],
                        TICKTRUE_U32, 1, 1, 0);
  };
  ticktrue_session* session = open(path("x.ttr"), TICKTRUE_RECORD);
  register_tables(session, 300);
  CHECK(ticktrue_status(session) == TICKTRUE_OK);
  CHECK(ticktrue_key(session, "t299", 1) == TICKTRUE_OK);
  CHECK(ticktrue_reference(session, "t0", "c19", "t299") == TICKTRUE_OK);
  CHECK(ticktrue_begin_tick(session, nullptr) == TICKTRUE_FAILED);
  CHECK(contains(ticktrue_message(session), "tables: found 300, expected at most 64: a trace holds no more"));
  CHECK(ticktrue_close(session) == 2);
  session = open(path("x.ttr"), TICKTRUE_RECORD);
  register_tables(session, 4'000);
  CHECK(contains(ticktrue_message(session), "columns of all tables: expected at most 65536"));
  ticktrue_close(session);
  session = open(path("x.ttr"), TICKTRUE_RECORD);
  values.resize(1);
  register_tables(session, 4'097);
  CHECK(contains(ticktrue_message(session), "table t4096: tables: expected at most 4096"));
  ticktrue_close(session);
  // 64 tables are recorded as before.
  session = open(path("x.ttr"), TICKTRUE_RECORD);
  register_tables(session, 64);
  CHECK(ticktrue_begin_tick(session, nullptr) == TICKTRUE_OK);
  CHECK(ticktrue_end_tick(session) == TICKTRUE_OK);
  CHECK(ticktrue_close(session) == 0);
}

}  // namespace
}  // namespace ticktrue::test
