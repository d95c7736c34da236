// A program built with the header of an older interface version, as it was: it must run unchanged with the library of
// today.
// SPDX-License-Identifier: MIT
//
// tests/capi/header_1/ticktrue.h to header_4/ticktrue.h are copies of the headers of versions 1 to 4 and are never
// edited. TICKTRUE_OLD_VERSION says which of them this is built with. The program includes nothing else of this tree,
// is linked to the shared library, and checks itself: every case prints what it found and the exit code is 1.
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>

#if TICKTRUE_OLD_VERSION == 1
#include "tests/capi/header_1/ticktrue.h"
#elif TICKTRUE_OLD_VERSION == 2
#include "tests/capi/header_2/ticktrue.h"
#elif TICKTRUE_OLD_VERSION == 3
#include "tests/capi/header_3/ticktrue.h"
#else
#include "tests/capi/header_4/ticktrue.h"
#endif

static_assert(TICKTRUE_API_VERSION == TICKTRUE_OLD_VERSION, "the copy of the header was edited");
static_assert(sizeof(void*) != 8 || sizeof(ticktrue_options) == (TICKTRUE_OLD_VERSION == 1   ? 104
                                                                 : TICKTRUE_OLD_VERSION == 2 ? 112
                                                                 : TICKTRUE_OLD_VERSION == 3 ? 160
                                                                                             : 176),
              "the copy of the header was edited");
static_assert(sizeof(void*) != 8 || sizeof(ticktrue_host) == 48, "the copy of the header was edited");
static_assert(sizeof(void*) != 8 || sizeof(ticktrue_plugin) == 112, "the copy of the header was edited");

namespace {

int failure_count = 0;

void expect(bool holds, const char* what, const std::string& found) {
  if (holds) return;
  std::printf("old_program: error: %s: found %s\n", what, found.c_str());
  ++failure_count;
}

/// Options as an old program has them: whatever lies behind them is not theirs.
struct GuardedOptions {
  ticktrue_options options;
  unsigned char behind[256];

  GuardedOptions(int mode, const std::string& path, int detail) : options() {
    std::memset(behind, 0xff, sizeof behind);
    options.struct_size = sizeof options;
    options.mode = mode;
    options.detail = detail;
    options.path = path.c_str();
    options.name = "old-program";
    options.version = 7;
    options.flags = TICKTRUE_OVERWRITE | TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
    options.title = "an old program";
    options.build = "r1";
    options.dt = 0.25;
    options.full_first = 3;
    options.full_last = 20;
    options.checkpoint_interval = 10;
#if TICKTRUE_OLD_VERSION >= 2
    options.caller_facts = TICKTRUE_CALLER_FACTS;
#endif
  }
};

struct Game {
  float position[3] = {0, 1, 2};
  std::uint8_t kind[3] = {0, 1, 2};
  std::uint32_t id[3] = {4, 5, 6};
};

void name_row(void*, std::uint32_t row, char* text, std::size_t size) {
  std::snprintf(text, size, "ball %u", static_cast<unsigned>(row));
}

struct Outcome {
  int exit_code = 0;
  std::string report;
  std::string json;
};

Outcome play(ticktrue_session* session, std::uint32_t rollback_max, float fault) {
  Game game;
  ticktrue_column(session, "balls", "id", game.id, TICKTRUE_U32, 1, 3, 0);
  ticktrue_column(session, "balls", "position", game.position, TICKTRUE_F32, 1, 3, sizeof(float));
  ticktrue_column(session, "balls", "kind", game.kind, TICKTRUE_U8, 1, 3, 0);
#if TICKTRUE_OLD_VERSION >= 2
  const ticktrue_member members[] = {TICKTRUE_MEMBER(Game, kind, TICKTRUE_U8)};
  const std::uint32_t table = ticktrue_table(session, "game", sizeof game, members, 1);
  expect(table != TICKTRUE_NO_TABLE && ticktrue_rows(session, table, &game, 1) == TICKTRUE_OK, "table", "a refusal");
  ticktrue_build_facts(session, "unit", TICKTRUE_CALLER_FACTS);
#endif
  ticktrue_key(session, "balls", 1);
  ticktrue_row_names(session, "balls", name_row, nullptr);
  ticktrue_add_stage(session, "move");
  for (std::uint64_t tick = 0; tick < 50; ++tick) {
    std::uint8_t button = tick % 3 == 0;
    double dt = 0.5;
    ticktrue_input(session, &button, sizeof button);
    if (ticktrue_begin_tick(session, &dt) != TICKTRUE_OK) break;
    game.position[1] += button != 0 ? static_cast<float>(dt) : 0.125f;
    if (tick == 12) game.position[2] += fault;
    ++game.kind[tick % 3];
    ticktrue_stage(session, "move");
    ticktrue_end_tick(session);
    if (rollback_max > 0 && tick % 4 == 3) ticktrue_confirm(session, tick);
  }
  if (rollback_max > 0) ticktrue_confirm(session, ticktrue_tick(session));
  Outcome outcome;
  outcome.exit_code = ticktrue_finish(session);
  outcome.report = ticktrue_report(session);
  outcome.report += ticktrue_message(session);
  outcome.json = ticktrue_report_json(session);
  expect(ticktrue_close(session) == outcome.exit_code, "close", outcome.report);
  return outcome;
}

Outcome run(int mode, const std::string& path, int detail, float fault, std::uint32_t rollback_max = 0) {
  GuardedOptions guarded(mode, path, detail);
  guarded.options.rollback_max = rollback_max;
  static const char setup[] = "level 1";
  if (mode == TICKTRUE_RECORD) {
    guarded.options.setup = setup;
    guarded.options.setup_size = sizeof setup;
  }
  ticktrue_session* session = ticktrue_open(&guarded.options);
  std::size_t size = 0;
  const void* given = ticktrue_setup(session, &size);
  expect(size == sizeof setup && std::memcmp(given, setup, sizeof setup) == 0, "setup", std::to_string(size));
  return play(session, rollback_max, fault);
}

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void check_recordings(const std::string& path) {
  const struct {
    int detail;
    char format_version;
  } cases[] = {{TICKTRUE_DETAIL_ROOT, 1}, {TICKTRUE_DETAIL_CELLS, 2}, {TICKTRUE_DETAIL_FULL, 1}};
  for (const auto& a_case : cases) {
    Outcome outcome = run(TICKTRUE_RECORD, path, a_case.detail, 0);
    expect(outcome.exit_code == 0, "record", outcome.report);
    const std::string straight = bytes_of(path);
    expect(straight.size() > 100 && straight[8] == a_case.format_version, "format version", outcome.report);
    outcome = run(TICKTRUE_VERIFY, path, a_case.detail, 0);
    expect(outcome.exit_code == 0 && outcome.report.find("50 of 50 ticks compared") != std::string::npos, "verify",
           outcome.report);
    outcome = run(TICKTRUE_VERIFY, path, a_case.detail, 1e-3f);
    expect(outcome.exit_code == 1 && outcome.report.find("tick 12 of 50") != std::string::npos, "verify with a fault",
           outcome.report);
    const bool names = outcome.report.find("balls.position") != std::string::npos;
    expect(names || a_case.detail == TICKTRUE_DETAIL_ROOT, "verify with a fault: column", outcome.report);
    expect(outcome.json.find("\"verdict\": \"diverged\"") != std::string::npos, "JSON", outcome.json);
    outcome = run(TICKTRUE_RECORD, path, a_case.detail, 0, 8);
    expect(outcome.exit_code == 0 && bytes_of(path) == straight, "record with rollback", outcome.report);
  }
}

void check_arguments(const std::string& path) {
  char program[] = "game", verify[] = "--verify", other[] = "--fast";
  std::string file = path;
  char* const arguments[] = {program, other, verify, file.data(), nullptr};
  GuardedOptions guarded(0, "", TICKTRUE_DETAIL_CELLS);
  guarded.options.path = nullptr;
  ticktrue_session* session = ticktrue_open_arguments(&guarded.options, 4, arguments);
  const Outcome outcome = play(session, 0, 0);
  expect(outcome.exit_code == 0, "--verify", outcome.report);
  expect(ticktrue_open_arguments(&guarded.options, 2, arguments) == nullptr, "arguments without a session", "one");
}

void check_no_session() {
  std::uint8_t button = 1;
  double dt = 0.5;
  expect(ticktrue_input(nullptr, &button, 1) == TICKTRUE_OK && ticktrue_begin_tick(nullptr, &dt) == TICKTRUE_OK &&
             ticktrue_end_tick(nullptr) == TICKTRUE_OK && ticktrue_close(nullptr) == 0,
         "calls without a session", "a failure");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string path = argc > 1 ? argv[1] : "old_program.ttr";
  expect(ticktrue_api_version() >= TICKTRUE_API_VERSION, "interface version", std::to_string(ticktrue_api_version()));
  expect(ticktrue_version()[0] != 0, "version", ticktrue_version());
  check_recordings(path);
  check_arguments(path);
  check_no_session();
  std::remove(path.c_str());
  if (failure_count == 0)
    std::printf("old_program: interface version %u runs with the library of today\n", TICKTRUE_API_VERSION);
  return failure_count == 0 ? 0 : 1;
}
