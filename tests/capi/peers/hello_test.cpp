// Hello: 20 planted mismatches are refused by name, the same game is not, and damaged bytes change nothing.
// SPDX-License-Identifier: MIT
#include "capi/peers/hello.h"

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "base/hash.h"
#include "include/ticktrue.h"
#include "replay/format/identity.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

using ticktrue::Bytes;
using ticktrue::test::contains;

namespace {

/// A game as one player has it; each mismatch changes one of these.
struct GameSide {
  std::string name = "hello-game";
  std::uint32_t version = 3;
  double dt = 1.0 / 60;
  std::string setup = "level 1";
  std::string facts = "compiler=gcc 12\nfused=no\nfast_math=no\nunsafe_math=no\nfinite_math=no\nflt_eval_method=0\n";
  std::string physics_facts = "fused=no\n";
  std::string build;
  int type = TICKTRUE_F32;
  std::uint32_t lanes = 2;
  std::string column = "place";
  std::string table = "units";
  std::uint32_t keys = 1;
  bool has_random = true;
  bool has_more = false;
  bool has_reference = true;
  bool is_first_last = false;
  bool has_shown = false;
  std::uint32_t player = 0;
};

ticktrue_session* open_side(const GameSide& side) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = TICKTRUE_LIVE;
  options.name = side.name.c_str();
  options.version = side.version;
  options.dt = side.dt;
  options.setup = side.setup.data();
  options.setup_size = side.setup.size();
  options.caller_facts = side.facts.c_str();
  options.build = side.build.empty() ? nullptr : side.build.c_str();
  options.flags = TICKTRUE_QUIET;
  options.player = side.player;
  ticktrue_session* session = ticktrue_open(&options);
  static const std::uint64_t values[16] = {1, 2, 3};
  if (side.has_random && side.is_first_last) ticktrue_column(session, "random", "state", values, TICKTRUE_U64, 1, 1, 0);
  ticktrue_column(session, side.table.c_str(), "id", values, TICKTRUE_U32, 1, 1, 0);
  ticktrue_column(session, side.table.c_str(), side.column.c_str(), values, side.type, side.lanes, 1, 0);
  if (side.has_more) ticktrue_column(session, side.table.c_str(), "more", values, TICKTRUE_U8, 1, 1, 0);
  if (side.has_shown)
    ticktrue_column(session, side.table.c_str(), "glow", values, TICKTRUE_F32 | TICKTRUE_SHOWN, 1, 1, 0);
  if (side.has_random && !side.is_first_last)
    ticktrue_column(session, "random", "state", values, TICKTRUE_U64, 1, 1, 0);
  ticktrue_column(session, "aims", "unit", values, TICKTRUE_U32, 1, 1, 0);
  if (side.keys > 0) ticktrue_key(session, side.table.c_str(), side.keys);
  if (side.has_reference) ticktrue_reference(session, "aims", "unit", side.table.c_str());
  if (!side.physics_facts.empty()) ticktrue_build_facts(session, "physics", side.physics_facts.c_str());
  return session;
}

Bytes hello_bytes(ticktrue_session* session) {
  Bytes bytes(ticktrue_hello(session, nullptr, 0));
  CAPTURE(ticktrue_message(session));
  REQUIRE(!bytes.empty());
  CHECK(ticktrue_hello(session, bytes.data(), bytes.size()) == bytes.size());
  return bytes;
}

struct HelloAnswer {
  int status = 0;
  std::string text;
};
HelloAnswer answer_to(ticktrue_session* session, const Bytes& bytes) {
  HelloAnswer answer;
  char text[4096];
  answer.status = ticktrue_hello_check(session, 1, bytes.data(), bytes.size(), text, sizeof text);
  answer.text = text;
  return answer;
}

/// The report of player 0, who has `here`, on player 1, who has `there`.
HelloAnswer answer_of_meeting(GameSide here, GameSide there) {
  there.player = 1;
  ticktrue_session* one = open_side(here);
  ticktrue_session* other = open_side(there);
  const HelloAnswer answer = answer_to(one, hello_bytes(other));
  CHECK(ticktrue_status(one) == TICKTRUE_OK);
  ticktrue_close(one);
  ticktrue_close(other);
  return answer;
}

}  // namespace

TEST_CASE("hello refuses 20 mismatches by name, on both sides", "[capi][peers][injection]") {
  const struct {
    const char* what;
    std::function<void(GameSide&)> change;
    const char* line;  // the report of the side with the usual game
    const char* back;  // the report of the other side
  } mismatches[] = {
      {"simulation", [](GameSide& s) { s.name = "other-game"; }, "simulation: here hello-game, there other-game",
       "simulation: here other-game, there hello-game"},
      {"version", [](GameSide& s) { s.version = 4; }, "version: here 3, there 4", "version: here 4, there 3"},
      {"dt", [](GameSide& s) { s.dt = 1.0 / 30; }, "dt: here 0.016666666666666666 s, there 0.03333333333333333 s",
       "dt: here 0.03333333333333333 s"},
      {"setup of another size", [](GameSide& s) { s.setup = "level 10"; }, "setup: here 7 bytes, there 8",
       "setup: here 8 bytes, there 7"},
      {"setup", [](GameSide& s) { s.setup = "level 2"; }, "setup: byte 6 of 7: here 31, there 32",
       "setup: byte 6 of 7: here 32, there 31"},
      {"no setup", [](GameSide& s) { s.setup = ""; }, "setup: here 7 bytes, there 0", "setup: here 0 bytes, there 7"},
      {"type", [](GameSide& s) { s.type = TICKTRUE_F64; }, "units.place: here f32, there f64",
       "units.place: here f64, there f32"},
      {"lanes", [](GameSide& s) { s.lanes = 3; }, "units.place: here 2 lanes, there 3 lanes",
       "units.place: here 3 lanes, there 2 lanes"},
      {"column", [](GameSide& s) { s.column = "position"; }, "column 1 of units: here place, there position",
       "column 1 of units: here position, there place"},
      {"more columns", [](GameSide& s) { s.has_more = true; }, "units.more: here no such column, there a column",
       "units.more: here a column, there no such column"},
      {"a table less", [](GameSide& s) { s.has_random = false; }, "table random: only here",
       "table random: only there"},
      {"another table", [](GameSide& s) { s.table = "balls"; },
       "aims.unit: refers to: here units, there balls\ntable balls: only there",
       "aims.unit: refers to: here balls, there units\ntable units: only there"},
      {"key", [](GameSide& s) { s.keys = 0, s.has_reference = false; }, "units: here 12 bytes a row, 1 key columns",
       "0 key columns, there 12 bytes"},
      {"reference", [](GameSide& s) { s.has_reference = false; }, "aims.unit: refers to: here units, there none",
       "aims.unit: refers to: here none, there units"},
      {"order of tables", [](GameSide& s) { s.is_first_last = true; }, "tables: here units is number 0, there random",
       "tables: here random is number 0, there units"},
      {"fused", [](GameSide& s) { s.facts.replace(s.facts.find("fused=no"), 8, "fused=yes"); },
       "fused: here no, there yes (changes bits)", "fused: here yes, there no (changes bits)"},
      {"fast_math", [](GameSide& s) { s.facts.replace(s.facts.find("fast_math=no"), 12, "fast_math=yes"); },
       "fast_math: here no, there yes (changes bits)", "fast_math: here yes, there no (changes bits)"},
      {"flt_eval_method", [](GameSide& s) { s.facts.replace(s.facts.find("method=0"), 8, "method=2"); },
       "flt_eval_method: here 0, there 2 (changes bits)", "flt_eval_method: here 2, there 0"},
      {"unsafe_math", [](GameSide& s) { s.facts.replace(s.facts.find("unsafe_math=no"), 14, "unsafe_math=yes"); },
       "unsafe_math: here no, there yes (changes bits)", "unsafe_math: here yes, there no"},
      {"unit", [](GameSide& s) { s.physics_facts = "fused=yes\n"; }, "physics.fused: here no, there yes (changes bits)",
       "physics.fused: here yes, there no (changes bits)"},
  };
  static_assert(std::size(mismatches) == 20);
  for (const auto& mismatch : mismatches) {
    CAPTURE(mismatch.what);
    GameSide other;
    mismatch.change(other);
    const HelloAnswer here = answer_of_meeting(GameSide(), other);
    CAPTURE(here.text);
    CHECK(here.status == TICKTRUE_DIVERGED);
    CHECK(contains(here.text, mismatch.line));
    const HelloAnswer back = answer_of_meeting(other, GameSide());
    CAPTURE(back.text);
    CHECK(back.status == TICKTRUE_DIVERGED);
    CHECK(contains(back.text, mismatch.back));
  }
}

TEST_CASE("hello takes the same game, and tells what may matter", "[capi][peers]") {
  const HelloAnswer same = answer_of_meeting(GameSide(), GameSide());
  CHECK(same.status == TICKTRUE_OK);
  CHECK(same.text.empty());
  GameSide other;
  other.has_shown = true;  // decides nothing
  CHECK(answer_of_meeting(GameSide(), other).status == TICKTRUE_OK);
  other.build = "r2";
  other.facts.replace(other.facts.find("gcc 12"), 6, "gcc 13");
  GameSide here;
  here.build = "r1";
  const HelloAnswer told = answer_of_meeting(here, other);
  CAPTURE(told.text);
  CHECK(told.status == TICKTRUE_OK);
  CHECK(told.text == "compiler: here gcc 12, there gcc 13\nbuild: here r1, there r2");
}

TEST_CASE("a damaged hello is refused and changes nothing", "[capi][peers][corruption]") {
  ticktrue_session* one = open_side(GameSide());
  GameSide side;
  side.player = 1;
  ticktrue_session* other = open_side(side);
  const Bytes whole = hello_bytes(other);
  for (std::size_t size = 0; size < whole.size(); ++size)
    if (answer_to(one, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size))).status !=
        TICKTRUE_REFUSED)
      FAIL("a hello of " << size << " bytes was taken");
  for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
    Bytes bytes = whole;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1u << (bit % 8));
    if (answer_to(one, bytes).status != TICKTRUE_REFUSED) FAIL("a hello with bit " << bit << " turned over was taken");
  }
  CHECK(contains(answer_to(one, Bytes(whole.begin(), whole.end() - 1)).text, "hello: check: found "));
  CHECK(answer_to(one, {}).text == "hello: found other bytes, expected those of ticktrue_hello");
  CHECK(answer_to(one, Bytes(std::size_t{2} << 20, 1)).status == TICKTRUE_REFUSED);
  CHECK(answer_to(one, whole).status == TICKTRUE_OK);
  ticktrue_close(one);
  ticktrue_close(other);
}

TEST_CASE("a forged hello with a right check is read or refused, never a crash", "[capi][peers][corruption]") {
  ticktrue_session* one = open_side(GameSide());
  GameSide side;
  side.player = 1;
  ticktrue_session* other = open_side(side);
  const Bytes whole = hello_bytes(other);
  int refused = 0;
  for (std::size_t at = 0; at + 8 < whole.size(); ++at)
    for (const unsigned value : {0x00u, 0x01u, 0x7fu, 0xffu}) {
      Bytes bytes = whole;
      bytes[at] = static_cast<std::uint8_t>(value);
      const std::uint64_t sum = ticktrue::hash64(ticktrue::ByteView(bytes).first(bytes.size() - 8));
      for (std::size_t i = 0; i < 8; ++i) bytes[bytes.size() - 8 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
      const HelloAnswer answer = answer_to(one, bytes);
      refused += answer.status == TICKTRUE_REFUSED ? 1 : 0;
      if (answer.status == TICKTRUE_OK && bytes != whole && at < 12) FAIL("byte " << at << " was not looked at");
    }
  CHECK(refused > 100);
  ticktrue_close(one);
  ticktrue_close(other);
}

TEST_CASE("the session identity is that of the judged part of a setup", "[replay][peers]") {
  using ticktrue::replay::session_identity;
  ticktrue::replay::TraceSetup setup;
  setup.simulation = "game";
  setup.physics_version = 1;
  setup.dt = 0.5;
  setup.schema.tables = {{"units", {{"id", ticktrue::ScalarType::u32}}, 4, 1}};
  setup.setup = {1, 2};
  const std::uint64_t identity = session_identity(setup);
  const auto with = [&](const std::function<void(ticktrue::replay::TraceSetup&)>& change) {
    ticktrue::replay::TraceSetup other = setup;
    change(other);
    return session_identity(other);
  };
  CHECK(with([](auto& s) { s.title = "title"; }) == identity);
  CHECK(with([](auto& s) { s.detail = ticktrue::replay::Detail::full; }) == identity);
  CHECK(with([](auto& s) { s.features = 1, s.checkpoint_interval = 3, s.stages = {"a"}; }) == identity);
  CHECK(with([](auto& s) { s.schema.tables[0].columns[0].max = 7; }) == identity);
  CHECK(with([](auto& s) {
          s.whole_schema = s.schema;
          ticktrue::TableSchema& table = s.whole_schema->tables[0];
          table.columns.push_back({"glow", ticktrue::ScalarType::f32});
          table.columns[1].is_shown = true;
          table.shown_row_size = 4;
        }) == identity);
  CHECK(with([](auto& s) { s.simulation = "games"; }) != identity);
  CHECK(with([](auto& s) { s.physics_version = 2; }) != identity);
  CHECK(with([](auto& s) { s.dt = 0.25; }) != identity);
  CHECK(with([](auto& s) { s.setup.push_back(0); }) != identity);
  CHECK(with([](auto& s) { s.schema.tables[0].columns[0].name = "key"; }) != identity);
  CHECK(with([](auto& s) { s.schema.tables[0].key_column_count = 0; }) != identity);
}
