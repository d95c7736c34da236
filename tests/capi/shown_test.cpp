// Shown columns: stored and printed, never judged.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "include/ticktrue.h"
#include "replay/format/shown_image.h"
#include "replay/trace_reader.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/compare/diff.h"

namespace ticktrue::test {
namespace {

struct ShownUnit {
  std::uint32_t id = 0;
  std::int32_t hp = 100;
  float glow[2] = {0, 0};
  std::uint64_t address = 0;
};

struct ShownRun {
  int mode = TICKTRUE_RECORD;
  std::string path;
  int detail = TICKTRUE_DETAIL_FULL;
  bool shows = true;
  bool shows_address = false;
  float glow = 0.5F;
  std::int32_t fault = 0;  // of unit 2 in tick 13
  std::uint32_t rollback_max = 0;
};

struct ShownOutcome {
  int exit_code = 0;
  std::string report;
};

struct ShownState {
  std::uint64_t tick = 0;
  std::vector<ShownUnit> units = std::vector<ShownUnit>(3);
};

void show_units(ticktrue_session* session, ShownState& state, const ShownRun& run) {
  std::vector<ticktrue_member> members;
  if (run.shows) members.push_back(TICKTRUE_MEMBER(ShownUnit, glow, TICKTRUE_F32 | TICKTRUE_SHOWN));
  members.push_back(TICKTRUE_MEMBER(ShownUnit, id, TICKTRUE_U32));
  if (run.shows_address) members.push_back(TICKTRUE_MEMBER(ShownUnit, address, TICKTRUE_U64 | TICKTRUE_SHOWN));
  members.push_back(TICKTRUE_MEMBER(ShownUnit, hp, TICKTRUE_I32));
  const std::uint32_t table =
      ticktrue_table(session, "units", sizeof(ShownUnit), members.data(), static_cast<std::uint32_t>(members.size()));
  ticktrue_rows(session, table, state.units.data(), static_cast<std::uint32_t>(state.units.size()));
  ticktrue_key(session, "units", 1);
  ticktrue_column(session, "world", "tick", &state.tick, TICKTRUE_U64, 1, 1, 0);
  if (run.shows) ticktrue_column(session, "world", "cost", &state.tick, TICKTRUE_U64 | TICKTRUE_SHOWN, 1, 1, 0);
}

void step_units(ShownState& state, const ShownRun& run) {
  if (state.tick == 5) state.units.emplace_back();
  for (std::size_t i = 0; i < state.units.size(); ++i) {
    ShownUnit& unit = state.units[i];
    unit.id = static_cast<std::uint32_t>(i);
    unit.hp -= static_cast<std::int32_t>(i + state.tick % 3);
    if (state.tick == 13 && i == 2) unit.hp += run.fault;
    unit.glow[0] = run.glow * static_cast<float>(state.tick);
    unit.glow[1] = std::numeric_limits<float>::quiet_NaN();
    unit.address = reinterpret_cast<std::uintptr_t>(&unit);
  }
  ++state.tick;
}

ShownOutcome run_shown(const ShownRun& run) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = run.mode;
  options.path = run.path.c_str();
  options.name = "shown";
  options.detail = run.detail;
  options.full_first = 10;
  options.full_last = 14;
  options.checkpoint_interval = 8;
  options.rollback_max = run.rollback_max;
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC | TICKTRUE_OVERWRITE;
  if (run.detail != TICKTRUE_DETAIL_FULL) options.full_first = options.full_last = 0;
  ticktrue_session* session = ticktrue_open(&options);
  ShownState state;
  for (std::uint32_t i = 0; i < state.units.size(); ++i) state.units[i].id = i;
  show_units(session, state, run);
  std::mt19937 random(3);
  std::uint64_t confirmed = 0;
  std::vector<ShownState> saved;
  while (state.tick < 30) {
    saved.resize(state.tick);
    saved.push_back(state);
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
    step_units(state, run);
    show_units(session, state, run);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
    if (run.rollback_max == 0 || state.tick == 30) continue;
    confirmed = std::max(confirmed, state.tick > 4 ? state.tick - 4 : 0);
    ticktrue_confirm(session, confirmed);
    if (random() % 3 != 0) continue;
    const std::uint64_t back = state.tick - random() % (state.tick - confirmed + 1);
    if (back == state.tick) continue;
    state = saved[back];
    show_units(session, state, run);
    ticktrue_rewind(session, back);
  }
  ticktrue_confirm(session, ticktrue_tick(session));
  ShownOutcome outcome;
  outcome.exit_code = ticktrue_finish(session);
  outcome.report = std::string(ticktrue_report(session)) + ticktrue_message(session);
  ticktrue_close(session);
  return outcome;
}

std::vector<std::uint64_t> roots_of(const std::string& path) {
  auto reader = replay::TraceReader::open(path);
  REQUIRE(reader);
  std::vector<std::uint64_t> roots;
  for (;;) {
    const auto& item = reader->next();
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) roots.push_back(tick->root_hash);
    if (std::holds_alternative<std::monostate>(item)) return roots;
  }
}

TEST_CASE("shown columns change no hash and no verdict, whatever they hold", "[capi][shown][equivalence]") {
  const TracePath path;
  for (const int detail : {TICKTRUE_DETAIL_ROOT, TICKTRUE_DETAIL_CELLS, TICKTRUE_DETAIL_FULL}) {
    ShownRun plain;
    plain.path = path("plain.ttr");
    plain.detail = detail;
    plain.shows = false;
    REQUIRE(run_shown(plain).exit_code == 0);
    ShownRun shown = plain;
    shown.path = path("shown.ttr");
    shown.shows = shown.shows_address = true;
    const ShownOutcome recorded = run_shown(shown);
    CAPTURE(recorded.report);
    REQUIRE(recorded.exit_code == 0);
    CHECK(path.bytes("plain.ttr")[8] == (detail == TICKTRUE_DETAIL_CELLS ? 2 : 1));
    CHECK(path.bytes("shown.ttr")[8] == 3);
    CHECK(roots_of(plain.path) == roots_of(shown.path));
    for (const std::string& file : {plain.path, shown.path}) {
      for (const bool shows : {false, true}) {
        ShownRun verify = shown;
        verify.mode = TICKTRUE_VERIFY;
        verify.path = file;
        verify.shows = verify.shows_address = shows;
        verify.glow = 7;
        const ShownOutcome verified = run_shown(verify);
        CAPTURE(detail, file, shows, verified.report);
        CHECK(verified.exit_code == 0);
        CHECK(contains(verified.report, "shown columns: recorded ") == (shows != (file == shown.path)));
      }
    }
    ShownRun rolled = shown;
    rolled.path = path("rolled.ttr");
    rolled.shows_address = false;
    rolled.rollback_max = 8;
    REQUIRE(run_shown(rolled).exit_code == 0);
    shown.shows_address = false;
    REQUIRE(run_shown(shown).exit_code == 0);
    CHECK((path.bytes("rolled.ttr") == path.bytes("shown.ttr")));
  }
}

TEST_CASE("shown values are stored in checkpoints and full ticks, and a red report has those of the rows it names",
          "[capi][shown][injection]") {
  const TracePath path;
  ShownRun run;
  run.path = path("shown.ttr");
  REQUIRE(run_shown(run).exit_code == 0);
  auto reader = replay::TraceReader::open(run.path);
  REQUIRE(reader);
  REQUIRE(reader->setup().whole_schema);
  const StateSchema& whole = *reader->setup().whole_schema;
  std::size_t count = 0;
  const auto check = [&](std::uint64_t ticks_done, const std::optional<ByteView>& shown) {
    REQUIRE(shown);
    ++count;
    const auto tables = replay::decode_shown(whole, *shown);
    REQUIRE(tables);
    REQUIRE(tables->size() == 2);
    CHECK((*tables)[0].rows.row_count == (ticks_done > 5 ? 4 : 3));
    const std::string text = replay::shown_row_text(whole.tables[0], (*tables)[0], 1);
    if (ticks_done == 14) CHECK(text == "glow (6.5, nan)");
    CHECK(contains(replay::shown_row_text(whole.tables[1], (*tables)[1], 0), "cost " + std::to_string(ticks_done)));
  };
  for (;;) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* tick = std::get_if<replay::TickRecord>(&item);
    const auto* checkpoint = std::get_if<replay::CheckpointRecord>(&item);
    if (checkpoint != nullptr) check(checkpoint->tick, checkpoint->shown);
    if (tick != nullptr && tick->image) check(tick->tick + 1, tick->shown);
    if (tick != nullptr && !tick->image) CHECK_FALSE(tick->shown);
  }
  CHECK(count == 4 + 5);
  CHECK(reader->tail().message.empty());

  run.mode = TICKTRUE_VERIFY;
  run.fault = 1;
  run.glow = 2;
  const ShownOutcome outcome = run_shown(run);
  CAPTURE(outcome.report);
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.report, "units.hp"));
  CHECK(contains(outcome.report, "note    shown of units row 2: recorded glow (6.5, nan); here glow (26, nan)"));
}

TEST_CASE("diff tells the first difference of shown values, and is equal", "[capi][shown][equivalence]") {
  const TracePath path;
  ShownRun run;
  run.path = path("a.ttr");
  REQUIRE(run_shown(run).exit_code == 0);
  run.path = path("b.ttr");
  run.glow = 2;
  REQUIRE(run_shown(run).exit_code == 0);
  auto a = replay::TraceReader::open(path("a.ttr"));
  auto b = replay::TraceReader::open(path("b.ttr"));
  REQUIRE(a);
  REQUIRE(b);
  const verifier::DiffReport report = verifier::diff(*a, *b, {});
  CHECK(report.verdict == verifier::DiffVerdict::equal);
  REQUIRE(report.notes.size() == 1);
  CHECK(report.notes[0] ==
        "shown values differ first before tick 8, at units row 0 (a glow (3.5, nan); b glow (14, nan)): no verdict "
        "depends on them");
  CHECK(path.bytes("a.ttr") != path.bytes("b.ttr"));
}

TEST_CASE("what is shown is registered once and beside a judged column", "[capi][shown][corruption]") {
  const TracePath path;
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = TICKTRUE_RECORD;
  const std::string file = path("x.ttr");
  options.path = file.c_str();
  options.name = "shown";
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC | TICKTRUE_OVERWRITE;
  std::uint32_t values[4] = {1, 2, 3, 4};
  const auto said = [&](auto register_all) {
    ticktrue_session* session = ticktrue_open(&options);
    register_all(session);
    for (int i = 0; i < 3; ++i) {
      ticktrue_begin_tick(session, nullptr);
      ++values[0];
      ticktrue_end_tick(session);
    }
    ticktrue_finish(session);
    const std::string message = ticktrue_message(session);
    ticktrue_close(session);
    return message;
  };
  const auto judged = [&](ticktrue_session* s) { ticktrue_column(s, "a", "id", values, TICKTRUE_U32, 1, 2, 0); };
  const auto shown = [&](ticktrue_session* s, const char* name, std::uint32_t rows) {
    ticktrue_column(s, "a", name, values, TICKTRUE_U32 | TICKTRUE_SHOWN, 1, rows, 0);
  };
  CHECK(said([&](ticktrue_session* s) { judged(s), shown(s, "glow", 2); }).empty());
  CHECK(said([&](ticktrue_session* s) { shown(s, "glow", 2), judged(s); }).empty());
  CHECK(contains(said([&](ticktrue_session* s) { shown(s, "glow", 2); }), "table a: found shown columns alone"));
  CHECK(contains(said([&](ticktrue_session* s) { judged(s), shown(s, "id", 2); }), "found another type"));
  CHECK(contains(said([&](ticktrue_session* s) { judged(s), shown(s, "glow", 3); }),
                 "table a: rows: column glow has 3, column id has 2"));
  CHECK(contains(said([&](ticktrue_session* s) {
                   judged(s), shown(s, "to", 2);
                   ticktrue_reference(s, "a", "to", "a");
                 }),
                 "found a shown column, expected a judged one"));
  CHECK(contains(said([&](ticktrue_session* s) {
                   judged(s);
                   ticktrue_column(s, "a", "wrong", values, TICKTRUE_SHOWN, 1, 2, 0);
                 }),
                 "type: found 0"));
  CHECK(contains(said([&](ticktrue_session* s) {
                   judged(s);
                   ticktrue_column(s, "a", "wrong", values, 0x203, 1, 2, 0);
                 }),
                 "type: found 0"));
}

TEST_CASE("a shown image is read whole or refused", "[capi][shown][corruption]") {
  StateSchema whole;
  for (const char* name : {"a", "b", "c"}) {
    TableSchema& table = whole.tables.emplace_back();
    table.name = name;
    table.row_size = 4;
    table.columns.push_back({"id", ScalarType::u32});
    if (name[0] == 'b') continue;
    Column column{"glow", ScalarType::u16};
    column.is_shown = true;
    table.columns.push_back(column);
    table.shown_row_size = 2;
  }
  const Bytes rows{1, 0, 2, 0, 3, 0};
  Bytes bytes;
  const ShownRows tables[] = {{0, {rows, 3}}, {2, {ByteView(rows).first(2), 1}}};
  replay::encode_shown(tables, bytes);
  const auto read = replay::decode_shown(whole, bytes);
  REQUIRE(read);
  REQUIRE(read->size() == 2);
  CHECK((*read)[1].table == 2);
  CHECK(replay::shown_row_text(whole.tables[0], (*read)[0], 2) == "glow 3");
  for (std::size_t size = 0; size < bytes.size(); ++size)
    CHECK_FALSE(replay::decode_shown(whole, ByteView(bytes).first(size)));
  Bytes longer = bytes;
  longer.push_back(0);
  CHECK_FALSE(replay::decode_shown(whole, longer));
  // Table b has nothing to show; 2^32 - 1 rows; no rows; more tables than there are.
  const std::pair<std::size_t, std::uint8_t> changes[] = {{1, 1}, {5, 0xff}, {2, 0}, {0, 9}, {0, 0xff}};
  for (const auto& [at, value] : changes) {
    CAPTURE(at);
    Bytes changed = bytes;
    changed[at] = value;
    const auto refused = replay::decode_shown(whole, changed);
    REQUIRE_FALSE(refused);
    CHECK(contains(refused.error().message, "shown image: "));
  }
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      Bytes changed = bytes;
      changed[at] = static_cast<std::uint8_t>(changed[at] ^ (1 << bit));
      if (const auto other = replay::decode_shown(whole, changed))
        for (const ShownRows& table : *other)
          CHECK(table.rows.rows.size() == table.rows.row_count * whole.tables[table.table].shown_row_size);
    }
}

}  // namespace
}  // namespace ticktrue::test
