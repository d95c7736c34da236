// Marks and notes of a session: stored, compared, and never a verdict.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "include/ticktrue.h"
#include "replay/trace_reader.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"
#include "verifier/compare/diff.h"

namespace ticktrue::test {
namespace {

constexpr std::uint64_t tick_count = 40;

/// Additional calls of the program in a tick. The tick counts from 0.
using Extra = std::function<void(ticktrue_session*, std::uint64_t tick)>;

struct MarkRun {
  int mode = TICKTRUE_RECORD;
  std::string path;
  std::uint32_t flags = TICKTRUE_MARKS;
  int detail = TICKTRUE_DETAIL_ROOT;
  std::uint32_t rollback_max = 0;
  std::uint32_t sync_test = 0;
  std::uint64_t fault_tick = ~std::uint64_t{0};
  Extra extra;
};

struct MarkOutcome {
  int exit_code = 0;
  std::string report;
  std::string json;
};

struct MarkState {
  std::uint64_t tick = 0;
  std::uint64_t sum = 0;
};

size_t save_state(void* user, void* buffer, size_t size) {
  if (size >= sizeof(MarkState)) memcpy(buffer, user, sizeof(MarkState));
  return sizeof(MarkState);
}
int load_state(void* user, const void* bytes, size_t size) {
  if (size != sizeof(MarkState)) return 1;
  memcpy(user, bytes, size);
  return 0;
}

void run_tick(ticktrue_session* session, MarkState& state, const MarkRun& run) {
  for (std::uint64_t i = 0; i < 5 + state.tick % 3; ++i) ticktrue_mark(session, "rand", state.tick * 100 + i);
  ticktrue_mark_f64(session, "sin", 0.5 * static_cast<double>(state.tick));
  if (state.tick % 4 == 0) ticktrue_note(session, "wave", ("wave " + std::to_string(state.tick)).c_str());
  if (run.extra) run.extra(session, state.tick);
  state.sum += state.tick + (state.tick == run.fault_tick ? 1 : 0);
  ++state.tick;
}

MarkOutcome run_marks(const MarkRun& run) {
  MarkState state;
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = run.mode;
  options.path = run.path.c_str();
  options.name = "marks";
  options.detail = run.detail;
  options.full_first = 10;
  options.full_last = 14;
  if (run.detail != TICKTRUE_DETAIL_FULL) options.full_first = options.full_last = 0;
  options.rollback_max = run.rollback_max;
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC | TICKTRUE_OVERWRITE;
  if (run.mode == TICKTRUE_RECORD) options.flags |= run.flags;
  options.sync_test = run.sync_test;
  if (run.sync_test > 0) {
    options.save = save_state;
    options.load = load_state;
    options.user = &state;
  }
  ticktrue_session* session = ticktrue_open(&options);
  ticktrue_column(session, "world", "tick", &state.tick, TICKTRUE_U64, 1, 1, 0);
  ticktrue_column(session, "world", "sum", &state.sum, TICKTRUE_U64, 1, 1, 0);
  std::mt19937 random(5);
  std::uint64_t confirmed = 0;
  std::vector<MarkState> saved;
  while (state.tick < tick_count) {
    saved.resize(static_cast<std::size_t>(state.tick));
    saved.push_back(state);
    ticktrue_mark(session, "between", 1);
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
    run_tick(session, state, run);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
    if (run.rollback_max == 0 || state.tick == tick_count) continue;
    confirmed = std::max(confirmed, state.tick > 4 ? state.tick - 4 : 0);
    ticktrue_confirm(session, confirmed);
    const std::uint64_t back = state.tick - random() % (state.tick - confirmed + 1);
    if (back == state.tick) continue;
    state = saved[static_cast<std::size_t>(back)];
    ticktrue_rewind(session, back);
  }
  ticktrue_confirm(session, ticktrue_tick(session));
  MarkOutcome outcome;
  outcome.exit_code = ticktrue_finish(session);
  outcome.report = std::string(ticktrue_report(session)) + ticktrue_message(session);
  outcome.json = ticktrue_report_json(session);
  ticktrue_close(session);
  return outcome;
}

MarkOutcome verify_marks(const std::string& path, const Extra& extra, std::uint64_t fault_tick = ~std::uint64_t{0}) {
  MarkRun run;
  run.mode = TICKTRUE_VERIFY;
  run.path = path;
  run.extra = extra;
  run.fault_tick = fault_tick;
  return run_marks(run);
}

struct FoundTick {
  std::optional<replay::TickMarks> marks;
  std::optional<replay::MarkList> list;
  std::vector<replay::Note> notes;
};

std::vector<FoundTick> marks_in(const std::string& path) {
  auto reader = replay::TraceReader::open(path);
  REQUIRE(reader);
  std::vector<FoundTick> ticks;
  for (;;) {
    const auto& item = reader->next();
    if (const auto* tick = std::get_if<replay::TickRecord>(&item))
      ticks.push_back({tick->marks, tick->mark_list, tick->notes});
    if (std::holds_alternative<std::monostate>(item)) return ticks;
  }
}

}  // namespace

TEST_CASE("marks and notes of each tick are stored, and lists of ticks in full", "[capi][marks][equivalence]") {
  const TracePath path;
  MarkRun run;
  run.path = path("a.ttr");
  run.detail = TICKTRUE_DETAIL_FULL;
  const MarkOutcome recorded = run_marks(run);
  CAPTURE(recorded.report);
  REQUIRE(recorded.exit_code == 0);
  const std::vector<FoundTick> ticks = marks_in(run.path);
  REQUIRE(ticks.size() == tick_count);
  for (std::uint64_t t = 0; t < tick_count; ++t) {
    CAPTURE(t);
    const FoundTick& tick = ticks[static_cast<std::size_t>(t)];
    REQUIRE(tick.marks);
    REQUIRE(tick.marks->names.size() == 2);  // what stands between two ticks is not of one
    CHECK(tick.marks->names[0].name == "rand");
    CHECK(tick.marks->names[0].count == 5 + t % 3);
    CHECK(tick.marks->names[1].name == "sin");
    CHECK(tick.notes.size() == (t % 4 == 0 ? 1 : 0));
    if (t % 4 == 0) CHECK(tick.notes[0] == replay::Note{"wave", "wave " + std::to_string(t)});
    CHECK(tick.list.has_value() == (t >= 10 && t <= 14));
    if (!tick.list) continue;
    REQUIRE(tick.list->marks.size() == 6 + t % 3);
    CHECK(tick.list->marks[2].value == t * 100 + 2);
    CHECK(tick.list->names[tick.list->marks.back().name] == "sin");
  }
  const MarkOutcome verified = verify_marks(run.path, {});
  CAPTURE(verified.report);
  CHECK(verified.exit_code == 0);
  CHECK_FALSE(contains(verified.report, "marks"));
  CHECK(contains(verified.json, "\"marks\": 40"));
}

TEST_CASE("a recording without the flag has the bytes of one without marks, and a warning", "[capi][marks][golden]") {
  const TracePath path;
  MarkRun run;
  run.path = path("a.ttr");
  run.flags = 0;
  const MarkOutcome recorded = run_marks(run);
  CHECK(contains(recorded.report, "warning marks and notes were not stored: set TICKTRUE_MARKS"));
  CHECK(path.bytes("a.ttr")[8] == 1);
  CHECK(verify_marks(run.path, {}).exit_code == 0);
  run.flags = TICKTRUE_MARKS;
  run.path = path("b.ttr");
  CHECK_FALSE(contains(run_marks(run).report, "warning"));
  CHECK(path.bytes("b.ttr")[8] == 3);
}

TEST_CASE("whatever was taken back, the trace holds the marks of a straight run", "[capi][marks][rollback]") {
  const TracePath path;
  for (const int detail : {TICKTRUE_DETAIL_ROOT, TICKTRUE_DETAIL_FULL}) {
    MarkRun run;
    run.detail = detail;
    run.path = path("straight.ttr");
    REQUIRE(run_marks(run).exit_code == 0);
    run.path = path("rolled.ttr");
    run.rollback_max = 8;
    REQUIRE(run_marks(run).exit_code == 0);
    CHECK((path.bytes("straight.ttr") == path.bytes("rolled.ttr")));
    run.rollback_max = 0;
    run.sync_test = 3;
    run.path = path("twice.ttr");
    const MarkOutcome twice = run_marks(run);
    CAPTURE(twice.report);
    CHECK(twice.exit_code == 0);
    const std::vector<FoundTick> straight = marks_in(path("straight.ttr")), second = marks_in(run.path);
    REQUIRE(straight.size() == second.size());
    for (std::size_t t = 0; t < straight.size(); ++t) CHECK(straight[t].marks == second[t].marks);
  }
}

TEST_CASE("other marks are a warning with the first tick, the name and the counts", "[capi][marks][injection]") {
  const TracePath path;
  MarkRun run;
  run.path = path("a.ttr");
  REQUIRE(run_marks(run).exit_code == 0);
  const auto at = [](std::uint64_t wanted, auto&& call) {
    return [=](ticktrue_session* session, std::uint64_t tick) {
      if (tick >= wanted) call(session);
    };
  };
  const auto report_of = [&](const Extra& extra) {
    const MarkOutcome outcome = verify_marks(run.path, extra);
    CHECK(outcome.exit_code == 0);
    return outcome.report;
  };
  const std::string warning = "warning marks differ first at tick 7: ";
  CHECK(contains(report_of(at(7,
                              [](ticktrue_session* s) {
                                for (int i = 0; i < 7; ++i) ticktrue_mark(s, "rand", 1);
                              })),
                 warning + "rand 13 times, recorded 6; they decide no verdict\n"));
  CHECK(contains(report_of(at(7, [](ticktrue_session* s) { ticktrue_mark(s, "cos", 1); })),
                 warning + "cos 1 time, recorded never;"));
  // Without marks of its own in tick 0: the first of its marks is "sin".
  CHECK(contains(report_of(at(0, [](ticktrue_session* s) { ticktrue_mark_f64(s, "sin", 0); })),
                 "first at tick 0: sin 2"));
  const MarkOutcome json = verify_marks(run.path, at(9, [](ticktrue_session* s) { ticktrue_mark(s, "cos", 1); }));
  CHECK(contains(json.json, "\"marks\": {\n    \"tick\": 9,"));
  CHECK(contains(json.json, "\"name\": \"cos\""));

  // Values and order: the counts are the same.
  MarkRun other;
  other.path = path("b.ttr");
  other.extra = at(7, [](ticktrue_session* s) { ticktrue_mark(s, "x", 1), ticktrue_mark(s, "y", 2); });
  REQUIRE(run_marks(other).exit_code == 0);
  CHECK(contains(
      verify_marks(other.path, at(7, [](ticktrue_session* s) { ticktrue_mark(s, "x", 1), ticktrue_mark(s, "y", 3); }))
          .report,
      warning + "y 1 time with other values;"));
  CHECK(contains(
      verify_marks(other.path, at(7, [](ticktrue_session* s) { ticktrue_mark(s, "y", 2), ticktrue_mark(s, "x", 1); }))
          .report,
      warning + "the same marks in another order;"));
  CHECK(contains(verify_marks(other.path, {}).report, warning + "x never, recorded 1; y never, recorded 1;"));
}

TEST_CASE("a divergence says where marks first differ, or that they do not", "[capi][marks][injection]") {
  const TracePath path;
  MarkRun run;
  run.path = path("a.ttr");
  REQUIRE(run_marks(run).exit_code == 0);
  const MarkOutcome same = verify_marks(run.path, {}, 20);
  CHECK(same.exit_code == 1);
  CHECK(contains(same.report, "  marks   as recorded, in 21 ticks up to this one\n"));
  for (const std::uint64_t first : {20, 17, 25}) {
    const MarkOutcome outcome = verify_marks(
        run.path,
        [=](ticktrue_session* s, std::uint64_t tick) {
          if (tick == first) ticktrue_mark(s, "rand", 0);
        },
        20);
    CAPTURE(outcome.report);
    CHECK(outcome.exit_code == 1);
    if (first == 20) CHECK(contains(outcome.report, "  marks   differ first in this tick: rand 8 times, recorded 7\n"));
    if (first == 17)
      CHECK(contains(outcome.report, "  marks   differ first at tick 17, 3 ticks before: rand 8 times, recorded 7\n"));
    if (first == 25) CHECK(contains(outcome.report, "as recorded, in 21 ticks"));
    CHECK_FALSE(contains(outcome.report, "warning"));
    CHECK(contains(outcome.report, "ticktrue trail ") == (first <= 20));
  }
}

TEST_CASE("diff tells the first difference of marks, and is equal", "[capi][marks][equivalence]") {
  const TracePath path;
  MarkRun run;
  run.path = path("a.ttr");
  REQUIRE(run_marks(run).exit_code == 0);
  run.path = path("b.ttr");
  run.extra = [](ticktrue_session* s, std::uint64_t tick) {
    if (tick == 8) ticktrue_mark(s, "rand", 0);
  };
  REQUIRE(run_marks(run).exit_code == 0);
  auto a = replay::TraceReader::open(path("a.ttr"));
  auto b = replay::TraceReader::open(path("b.ttr"));
  const verifier::DiffReport report = verifier::diff(*a, *b, {});
  CHECK(report.verdict == verifier::DiffVerdict::equal);
  REQUIRE(report.notes.size() == 1);
  CHECK(report.notes[0] == "marks differ first in tick 8 (b rand 8 times, a 7): no verdict depends on them");
}

TEST_CASE("wrong marks and notes are told, and crash nothing", "[capi][marks][corruption]") {
  const TracePath path;
  MarkRun run;
  run.path = path("a.ttr");
  const std::string long_name(257, 'n');
  run.extra = [&](ticktrue_session* s, std::uint64_t tick) {
    if (tick == 3) CHECK(ticktrue_mark(s, "", 1) == TICKTRUE_OK);
    if (tick == 4) CHECK(ticktrue_mark(s, nullptr, 1) == TICKTRUE_OK);
    if (tick == 5) CHECK(ticktrue_mark(s, long_name.c_str(), 1) == TICKTRUE_OK);
    if (tick == 6) ticktrue_note(s, "long", std::string(5'000, 'x').c_str());
  };
  REQUIRE(run_marks(run).exit_code == 0);
  const std::vector<FoundTick> ticks = marks_in(run.path);
  for (std::size_t t = 0; t < ticks.size(); ++t) {
    REQUIRE(ticks[t].marks);
    CHECK(ticks[t].marks->is_left_out() == (t >= 3 && t <= 5));
  }
  REQUIRE(ticks[6].notes.size() == 1);
  CHECK(ticks[6].notes[0].text.size() == 4'096);
  // Ticks without known marks are not compared.
  CHECK_FALSE(contains(verify_marks(run.path,
                                    [](ticktrue_session* s, std::uint64_t tick) {
                                      if (tick >= 3 && tick <= 5) ticktrue_mark(s, "rand", 9);
                                    })
                           .report,
                       "marks differ"));
  for (const char* topic : {"", "ticktrue.desync", static_cast<const char*>(nullptr)}) {
    run.extra = [&](ticktrue_session* s, std::uint64_t) { ticktrue_note(s, topic, "x"); };
    const MarkOutcome outcome = run_marks(run);
    CHECK(outcome.exit_code == 2);
    CHECK(contains(outcome.report, "tick 0: note: topic: found "));
  }
  CHECK(ticktrue_mark(nullptr, "rand", 1) == TICKTRUE_OK);
  CHECK(ticktrue_note(nullptr, "topic", "x") == TICKTRUE_OK);
}

}  // namespace ticktrue::test
