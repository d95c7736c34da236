// What a session says when it closes: tables that stayed empty, columns that never changed; detail from the command
// line; a disk that took no more.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "include/ticktrue.h"
#include "replay/trace_reader.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/full_disk.h"
#include "tests/support/text.h"

using ticktrue::test::contains;
using ticktrue::test::TracePath;

namespace {

/// Three tables: ducks move, stones and visitors never change.
struct Pond {
  struct Duck {
    std::uint32_t id = 0;
    float place = 0;
    std::uint8_t colour = 3;
  };
  std::vector<Duck> ducks = std::vector<Duck>(3);
  float stones[2] = {1, 2};
  std::uint32_t visitors[1] = {0};
  std::uint64_t tick = 0;

  void step() {
    for (Duck& duck : ducks) duck.place += 0.5f;
    if (tick == 7) ducks[1].colour = 4;
    ++tick;
  }
  void show(ticktrue_session* session) {
    for (std::size_t i = 0; i < ducks.size(); ++i) ducks[i].id = static_cast<std::uint32_t>(i);
    const ticktrue_member members[] = {TICKTRUE_MEMBER(Duck, id, TICKTRUE_U32),
                                       TICKTRUE_MEMBER(Duck, place, TICKTRUE_F32),
                                       TICKTRUE_MEMBER(Duck, colour, TICKTRUE_U8)};
    const std::uint32_t table = ticktrue_table(session, "ducks", sizeof(Duck), members, 3);
    ticktrue_key(session, "ducks", 1);
    ticktrue_rows(session, table, ducks.data(), static_cast<std::uint32_t>(ducks.size()));
    ticktrue_column(session, "stones", "place", stones, TICKTRUE_F32, 1, 2, 0);
    ticktrue_column(session, "bench", "visitor", visitors, TICKTRUE_U32, 1, 0, 0);
  }
};

ticktrue_options pond_options(int mode, const std::string& path) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = mode;
  options.path = mode == TICKTRUE_LIVE ? nullptr : path.c_str();
  options.name = "pond";
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
  return options;
}

void run_pond(ticktrue_session* session, Pond& pond, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    std::uint8_t input = 1;
    ticktrue_input(session, &input, 1);
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) return;
    pond.step();
    ticktrue_end_tick(session);
  }
}

std::string pond_report(ticktrue_session* session, int& exit_code) {
  exit_code = ticktrue_finish(session);
  std::string text = ticktrue_report(session);
  text += ticktrue_message(session);
  return text;
}

/// Opens a session with these words of a command line.
ticktrue_session* open_pond(std::vector<std::string> words, ticktrue_options options) {
  words.insert(words.begin(), "pond");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return ticktrue_open_arguments(&options, static_cast<int>(words.size()), arguments.data());
}

}  // namespace

TEST_CASE("a session that closes tells what had no part in it", "[capi][closing]") {
  const TracePath path;
  for (const int mode : {TICKTRUE_RECORD, TICKTRUE_LIVE})
    for (const int ticks : {5, 12}) {
      const std::string file = path("pond" + std::to_string(ticks) + ".ttr");
      const ticktrue_options options = pond_options(mode, file);
      ticktrue_session* session = ticktrue_open(&options);
      Pond pond;
      pond.show(session);
      run_pond(session, pond, ticks);
      int exit_code = 0;
      const std::string text = pond_report(session, exit_code);
      CAPTURE(text);
      CHECK(exit_code == 0);
      CHECK(contains(text, "  note    tables that stayed empty: bench\n"));
      // In tick 7 a colour changes. Unchanged keys are never named.
      CHECK(contains(text, ticks < 8 ? "  note    columns that never changed: ducks.colour, stones.place\n"
                                     : "  note    columns that never changed: stones.place\n"));
      ticktrue_close(session);
    }
}

TEST_CASE("a column that changed and changed back is not named", "[capi][closing]") {
  const ticktrue_options options = pond_options(TICKTRUE_LIVE, "");
  ticktrue_session* session = ticktrue_open(&options);
  std::uint32_t gates[2] = {1, 1};
  std::vector<float> wall(5'000, 1.0f);  // more than one block of 16 KiB
  std::uint32_t crowd[3] = {7, 8, 9}, stones[2] = {1, 2};
  ticktrue_column(session, "gates", "open", gates, TICKTRUE_U32, 1, 2, 0);
  ticktrue_column(session, "wall", "height", wall.data(), TICKTRUE_F32, 1, 5'000, 0);
  ticktrue_column(session, "crowd", "name", crowd, TICKTRUE_U32, 1, 2, 0);
  ticktrue_column(session, "stones", "place", stones, TICKTRUE_U32, 1, 2, 0);
  for (int tick = 0; tick < 6; ++tick) {
    REQUIRE(ticktrue_begin_tick(session, nullptr) == TICKTRUE_OK);
    gates[1] = tick == 2 ? 0 : 1;
    wall.back() = tick == 3 ? 0.5f : 1.0f;
    ticktrue_column(session, "crowd", "name", crowd, TICKTRUE_U32, 1, tick == 4 ? 3 : 2, 0);
    REQUIRE(ticktrue_end_tick(session) == TICKTRUE_OK);
  }
  int exit_code = 0;
  const std::string text = pond_report(session, exit_code);
  CAPTURE(text);
  CHECK(contains(text, "  note    columns that never changed: stones.place\n"));
  ticktrue_close(session);
}

TEST_CASE("detail and range come from the command line", "[capi][closing]") {
  const TracePath path;
  const struct {
    const char* detail;
    ticktrue::replay::Detail found;
    std::uint64_t first, last;
  } cases[] = {{"root", ticktrue::replay::Detail::root, 0, 0},
               {"cells", ticktrue::replay::Detail::cells, 0, 0},
               {"full", ticktrue::replay::Detail::full, 0, UINT64_MAX},
               {"full:10..20", ticktrue::replay::Detail::full, 10, 20},
               {"full:7", ticktrue::replay::Detail::full, 7, 7}};
  for (const auto& a_case : cases) {
    CAPTURE(a_case.detail);
    const std::string file = path("detail.ttr");
    ticktrue_session* session =
        open_pond({"--record", file, "--detail", a_case.detail, "--force"}, pond_options(TICKTRUE_LIVE, ""));
    Pond pond;
    pond.show(session);
    run_pond(session, pond, 25);
    int exit_code = 0;
    const std::string text = pond_report(session, exit_code);
    CAPTURE(text);
    REQUIRE(exit_code == 0);
    ticktrue_close(session);
    auto reader = ticktrue::replay::TraceReader::open(file);
    REQUIRE(reader.has_value());
    CHECK(reader->setup().detail == a_case.found);
    std::uint64_t full_count = 0;
    for (;;) {
      const auto& item = reader->next();
      if (std::holds_alternative<ticktrue::replay::CheckpointRecord>(item)) continue;
      const auto* tick = std::get_if<ticktrue::replay::TickRecord>(&item);
      if (tick == nullptr) break;
      const bool is_full =
          a_case.found == ticktrue::replay::Detail::full && a_case.first <= tick->tick && tick->tick <= a_case.last;
      CHECK(tick->image.has_value() == is_full);
      full_count += is_full ? 1 : 0;
    }
    CHECK((a_case.last == 20) == (full_count == 11));
  }
}

TEST_CASE("a wrong detail is told, and an older program keeps its own word", "[capi][closing]") {
  const TracePath path;
  for (const char* detail : {"fine", "full:", "full:a..b", "full:20..10", "root:3", "full:1..x", "", "full:0..0"}) {
    ticktrue_session* session =
        open_pond({"--record", path("no.ttr"), "--detail", detail}, pond_options(TICKTRUE_LIVE, ""));
    CAPTURE(detail);
    CHECK(ticktrue_status(session) == TICKTRUE_FAILED);
    CHECK(contains(ticktrue_message(session), "command line: --detail: found "));
    ticktrue_close(session);
  }
  ticktrue_session* verify = open_pond({"--verify", "x.ttr", "--detail", "full"}, pond_options(TICKTRUE_LIVE, ""));
  CHECK(contains(ticktrue_message(verify), "--detail: found it with --verify"));
  ticktrue_close(verify);
  ticktrue_session* live = open_pond({"--detail", "high"}, pond_options(TICKTRUE_LIVE, ""));
  CHECK(ticktrue_status(live) == TICKTRUE_OK);  // it records nothing
  ticktrue_close(live);
  ticktrue_options old = pond_options(0, "");
  old.path = nullptr;
  old.struct_size = offsetof(ticktrue_options, peer_bytes);
  ticktrue_session* session = open_pond({"--detail", "high", "--record", path("old.ttr")}, old);
  CHECK(ticktrue_status(session) == TICKTRUE_OK);
  ticktrue_close(session);
}

#ifndef _WIN32
TEST_CASE("a full disk ends the recording, and the game goes on", "[capi][closing]") {
  const TracePath path;
  for (const std::uint32_t rollback_max : {0u, 4u}) {
    const std::string file = path("full" + std::to_string(rollback_max) + ".ttr");
    ticktrue_options options = pond_options(TICKTRUE_RECORD, file);
    options.rollback_max = rollback_max;
    ticktrue_session* session = ticktrue_open(&options);
    Pond pond;
    pond.show(session);
    const auto run_some = [&](int ticks) {
      for (int i = 0; i < ticks; ++i) {
        run_pond(session, pond, 1);
        if (rollback_max > 0) ticktrue_confirm(session, ticktrue_tick(session));
      }
    };
    run_some(6);
    CHECK(std::string(ticktrue_message(session)).empty());
    {
      const ticktrue::test::FullDisk full;
      run_some(4);
    }
    run_some(10);  // room again: the gap stays, so the recording stays ended
    CHECK(ticktrue_status(session) == TICKTRUE_OK);
    CHECK(pond.tick == 20);
    std::uint64_t root = 0;
    CHECK(ticktrue_root(session, 19, &root) == TICKTRUE_OK);
    int exit_code = 0;
    const std::string text = pond_report(session, exit_code);
    CAPTURE(text);
    CHECK(exit_code == 2);
    CHECK(contains(text, "live  pond  20 ticks"));
    CHECK(contains(text, file));
    CHECK(contains(text, ": recording ends, the game goes on"));
    ticktrue_close(session);
    // The file is a truncated trace.
    auto reader = ticktrue::replay::TraceReader::open(file);
    REQUIRE(reader.has_value());
    while (!std::holds_alternative<std::monostate>(reader->next())) continue;
    CHECK(reader->tail().condition == ticktrue::replay::TraceCondition::truncated);
    CHECK(reader->tail().ticks_intact >= 6);
  }
}
#endif
