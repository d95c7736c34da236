// Calls of the C interface in a wrong order, with wrong values, from older headers.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstring>
#include <string>

#include "include/ticktrue.h"
#include "replay/trace_reader.h"
#include "tests/capi/session_game.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test::sessions {

TEST_CASE("every wrong call is told once, with what to do, and keeps what was recorded", "[capi][order][corruption]") {
  using Call = int (*)(ticktrue_session*, Game&);
  static const auto run_tick = [](ticktrue_session* session, Game& game) {
    ticktrue_begin_tick(session, nullptr);
    game.step(1, 0.1);
    game.show(session);
    return ticktrue_end_tick(session);
  };
  struct Wrong {
    Call call;
    const char* message;
    std::uint32_t rollback_max;
  };
  static double bad_dt = -1;
  static std::uint32_t word = 0;
  const Wrong wrongs[] = {
      {[](ticktrue_session* s, Game&) { return ticktrue_end_tick(s); }, "end_tick: found no tick that runs", 0},
      {[](ticktrue_session* s, Game&) {
         ticktrue_begin_tick(s, nullptr);
         return ticktrue_begin_tick(s, nullptr);
       },
       "begin_tick: found a tick that runs already", 0},
      {[](ticktrue_session* s, Game&) {
         ticktrue_begin_tick(s, nullptr);
         return ticktrue_input(s, &word, sizeof word);
       },
       "input: found a tick that runs already", 0},
      {[](ticktrue_session* s, Game&) { return ticktrue_input(s, nullptr, 4); }, "input: found null", 0},
      {[](ticktrue_session* s, Game&) { return ticktrue_input(s, &word, std::size_t{1} << 40); },
       "input: found more than", 0},
      {[](ticktrue_session* s, Game&) { return ticktrue_begin_tick(s, &bad_dt); }, "dt: found a value that is negative",
       0},
      {[](ticktrue_session* s, Game&) { return ticktrue_rewind(s, 0); }, "without rollback", 0},
      {[](ticktrue_session* s, Game&) { return ticktrue_confirm(s, 99); }, "confirm: found tick 99", 0},
      {[](ticktrue_session* s, Game&) { return ticktrue_rewind(s, 99); }, "rewind: found tick 99, expected at most", 4},
      {[](ticktrue_session* s, Game& game) {
         run_tick(s, game);
         ticktrue_confirm(s, 2);
         return ticktrue_rewind(s, 1);
       },
       "expected at least the ticks confirmed, 2", 4},
      {[](ticktrue_session* s, Game& game) {
         for (int i = 0; i < 3; ++i) run_tick(s, game);
         return ticktrue_begin_tick(s, nullptr);
       },
       "4 ticks that wait for ticktrue_confirm", 4},
      {[](ticktrue_session* s, Game&) { return ticktrue_stage(s, "move"); }, "stage: found no tick that runs", 0},
      {[](ticktrue_session* s, Game&) { return ticktrue_add_stage(s, "late"); }, "add_stage: found a new stage", 0},
      {[](ticktrue_session* s, Game& game) {
         return ticktrue_column(s, "late", "x", &game.tick, TICKTRUE_U64, 1, 1, 0);
       },
       "a new column after the first tick", 0},
      {[](ticktrue_session* s, Game& game) {
         return ticktrue_column(s, "world", "tick", &game.tick, TICKTRUE_U32, 1, 1, 0);
       },
       "another type or lane count", 0},
      {[](ticktrue_session* s, Game& game) {
         ticktrue_column(s, "balls", "speed", &game.balls[0].speed, TICKTRUE_F32, 1, 1, sizeof(Game::Ball));
         ticktrue_begin_tick(s, nullptr);
         return ticktrue_end_tick(s);
       },
       "table balls: rows: column speed has 1, column id has 3", 0},
      {[](ticktrue_session* s, Game& game) {
         game.ids[2] = 0;
         ticktrue_begin_tick(s, nullptr);
         return ticktrue_end_tick(s);
       },
       "keys must ascend: found 0 after 1", 0},
  };
  const TemporaryFolder folder;
  for (const Wrong& wrong : wrongs) {
    CAPTURE(wrong.message);
    const std::string path = folder.file("wrong.ttr");
    ticktrue_options options = options_for(path, TICKTRUE_RECORD);
    options.rollback_max = wrong.rollback_max;
    options.flags |= TICKTRUE_OVERWRITE;
    ticktrue_session* session = ticktrue_open(&options);
    Game game;
    game.show(session);
    REQUIRE(run_tick(session, game) == TICKTRUE_OK);
    if (wrong.rollback_max > 0) REQUIRE(ticktrue_confirm(session, wrong.message[0] == '4' ? 0 : 1) == TICKTRUE_OK);
    CHECK(wrong.call(session, game) == TICKTRUE_FAILED);
    const std::string message = ticktrue_message(session);
    CAPTURE(message);
    CHECK(contains(message, wrong.message));
    // Later calls, right or wrong, change nothing.
    CHECK(run_tick(session, game) == TICKTRUE_FAILED);
    CHECK(ticktrue_confirm(session, 0) == TICKTRUE_FAILED);
    CHECK(std::string(ticktrue_message(session)) == message);
    CHECK(finish(session).exit_code == 2);
    auto reader = ticktrue::replay::TraceReader::open(path);
    REQUIRE(reader);
    while (!std::holds_alternative<std::monostate>(reader->next())) {
    }
    CHECK(reader->tail().condition == ticktrue::replay::TraceCondition::complete);
    if (wrong.message[0] != '4') CHECK(reader->tail().ticks_intact >= 1);
  }
}

TEST_CASE("calls in any order with any values never crash", "[capi][order][property]") {
  const TemporaryFolder folder;
  const std::string whole = folder.file("whole.ttr");
  REQUIRE(play(options_for(whole, TICKTRUE_RECORD), 10).exit_code == 0);
  for (std::uint32_t seed = 0; seed < 600; ++seed) {
    CAPTURE(seed);
    Random random(seed);
    const bool is_record = random() % 2 == 0;
    const std::string path = is_record ? folder.file("any.ttr") : whole;
    ticktrue_options options = options_for(path, is_record ? TICKTRUE_RECORD : TICKTRUE_VERIFY);
    options.flags |= TICKTRUE_OVERWRITE;
    options.rollback_max = random() % 2 * 3;
    ticktrue_session* session = ticktrue_open(&options);
    Game game;
    if (random() % 4 != 0) game.show(session);
    if (random() % 4 == 0) ticktrue_add_stage(session, "move");
    const auto call_count = random() % 40;
    for (std::uint32_t i = 0; i < call_count; ++i) {
      std::uint32_t value = random();
      double dt = 0.25;
      switch (random() % 14) {
        case 0:
          game.step(value, dt);
          game.show(session);
          break;
        case 1:
        case 2:
          ticktrue_input(session, random() % 20 == 0 ? nullptr : &value, 4);
          break;
        case 3:
        case 4:
        case 5:
          ticktrue_begin_tick(session, random() % 2 ? &dt : nullptr);
          break;
        case 6:
        case 7:
        case 8:
          ticktrue_end_tick(session);
          break;
        case 9:
          ticktrue_rewind(session, random() % 6);
          break;
        case 10:
          ticktrue_confirm(session, random() % 6);
          break;
        case 11:
          ticktrue_stage(session, random() % 3 ? "move" : nullptr);
          break;
        case 12:
          ticktrue_column(session, random() % 3 ? "balls" : nullptr, random() % 3 ? "id" : nullptr,
                          random() % 3 ? &value : nullptr, static_cast<int>(random() % 11) - 1, random() % 3,
                          random() % 2, random() % 9);
          game.show(session);
          break;
        default:
          if (random() % 8 == 0) ticktrue_finish(session);
          ticktrue_report(session);
          ticktrue_key(session, "balls", random() % 4);
      }
    }
    const int exit_code = ticktrue_close(session);
    CHECK(exit_code >= 0);
    CHECK(exit_code <= 5);
  }
}

TEST_CASE("without a session every call does nothing and succeeds", "[capi][order][equivalence]") {
  double dt = 0.25;
  std::uint32_t word = 7;
  std::size_t size = 3;
  CHECK(ticktrue_column(nullptr, "a", "b", &word, TICKTRUE_U32, 1, 1, 0) == TICKTRUE_OK);
  CHECK(ticktrue_input(nullptr, &word, 4) == TICKTRUE_OK);
  CHECK(ticktrue_begin_tick(nullptr, &dt) == TICKTRUE_OK);
  CHECK(ticktrue_stage(nullptr, "a") == TICKTRUE_OK);
  CHECK(ticktrue_end_tick(nullptr) == TICKTRUE_OK);
  CHECK(ticktrue_rewind(nullptr, 4) == TICKTRUE_OK);
  CHECK(ticktrue_confirm(nullptr, 4) == TICKTRUE_OK);
  CHECK(ticktrue_setup(nullptr, &size) == nullptr);
  CHECK(size == 0);
  CHECK(dt == 0.25);
  CHECK(word == 7);
  CHECK(ticktrue_close(nullptr) == 0);
  char program[] = "game";
  char* words[] = {program, nullptr};
  const ticktrue_options options = options_for("x.ttr", 0);
  CHECK(ticktrue_open_arguments(&options, 1, words) == nullptr);
}

TEST_CASE("options are those of any version of the header that the library can serve", "[capi][abi][corruption]") {
  struct Longer {
    ticktrue_options options;
    std::uint64_t added;
  };
  const auto message_of = [](const ticktrue_options& options) {
    ticktrue_session* session = ticktrue_open(&options);
    const std::string message = ticktrue_message(session);
    CHECK(ticktrue_close(session) == 2);  // also where the options are good: no tick was recorded
    return message;
  };
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  Longer longer = {options_for(path, TICKTRUE_RECORD), 0};
  longer.options.struct_size = sizeof longer;
  CHECK(message_of(longer.options).empty());
  longer.added = 1;
  CHECK(contains(message_of(longer.options), "a setting that this library"));
  ticktrue_options options = options_for(path, TICKTRUE_RECORD);
  options.struct_size = 8;
  CHECK(contains(message_of(options), "struct_size: found 8, expected sizeof(ticktrue_options): "));
  // Every size: those of the headers are taken with just their fields, and no field is read in part.
  const std::size_t size_1 = offsetof(ticktrue_options, caller_facts), size_2 = offsetof(ticktrue_options, save);
  const std::size_t size_3 = offsetof(ticktrue_options, peer_bytes);
  for (std::size_t size = 0; size <= sizeof longer; ++size) {
    longer = {options_for(path, TICKTRUE_RECORD), 0};
    longer.options.struct_size = size;
    // Behind the size, the bytes are not the options'.
    if (size == size_1) std::memset(&longer.options.caller_facts, 0xff, sizeof longer - size_1);
    if (size == size_2) std::memset(&longer.options.save, 0xff, sizeof longer - size_2);
    if (size == size_3) std::memset(&longer.options.peer_bytes, 0xff, sizeof longer - size_3);
    const std::string message = message_of(longer.options);
    CAPTURE(size, message);
    if (size == size_1 || size == size_2 || size == size_3 || size >= sizeof(ticktrue_options))
      CHECK(message.empty());
    else
      CHECK(contains(message, "struct_size: found " + std::to_string(size)));
  }
  longer = {options_for(path, TICKTRUE_RECORD), 0};
  longer.options.struct_size = std::size_t{1} << 40;
  CHECK(contains(message_of(longer.options), "struct_size: found 1099511627776"));
  const struct {
    void (*change)(ticktrue_options&);
    const char* message;
  } wrongs[] = {
      {[](ticktrue_options& o) { o.mode = 0; }, "mode: found 0"},
      {[](ticktrue_options& o) { o.path = nullptr; }, "path: found none"},
      {[](ticktrue_options& o) { o.name = nullptr; }, "name: found 0 bytes"},
      {[](ticktrue_options& o) { o.name = "a\nb"; }, "control character"},
      {[](ticktrue_options& o) { o.name = "ticktrue.engine"; }, "does not begin with ticktrue."},
      {[](ticktrue_options& o) { o.flags = 1u << 20; }, "flags: found"},
      {[](ticktrue_options& o) { o.dt = -1; }, "dt: found"},
      {[](ticktrue_options& o) { o.detail = 9; }, "detail: found 9"},
      {[](ticktrue_options& o) { o.full_first = 9, o.full_last = 8; }, "full_first: found 9"},
      {[](ticktrue_options& o) { o.rollback_max = 1u << 30; }, "rollback_max: found"},
      {[](ticktrue_options& o) { o.setup_size = 4; }, "setup: found null"},
  };
  for (const auto& wrong : wrongs) {
    options = options_for(path, TICKTRUE_RECORD);
    wrong.change(options);
    const std::string message = message_of(options);
    CAPTURE(message, wrong.message);
    CHECK(contains(message, wrong.message));
  }
  ticktrue_session* session = ticktrue_open(nullptr);
  CHECK(contains(ticktrue_message(session), "options: found null"));
  CHECK(ticktrue_finish(session) == 2);
  CHECK(ticktrue_status(session) == TICKTRUE_FAILED);
  CHECK(ticktrue_close(session) == 2);
}

TEST_CASE("the layout of the structs is the one that programs were built with", "[capi][abi][golden]") {
  SKIP_UNLESS(sizeof(void*) == 8, "a platform of 32 bits");
  CHECK(TICKTRUE_API_VERSION == 5);
  CHECK(ticktrue_api_version() == TICKTRUE_API_VERSION);
  CHECK(offsetof(ticktrue_options, path) == 16);
  CHECK(offsetof(ticktrue_options, setup) == 40);
  CHECK(offsetof(ticktrue_options, dt) == 72);
  CHECK(offsetof(ticktrue_options, rollback_max) == 100);
  CHECK(offsetof(ticktrue_options, caller_facts) == 104);
  CHECK(offsetof(ticktrue_options, save) == 112);
  CHECK(offsetof(ticktrue_options, sync_test) == 152);
  CHECK(offsetof(ticktrue_options, peer_bytes) == 160);
  CHECK(offsetof(ticktrue_options, player) == 168);
  CHECK(sizeof(ticktrue_options) == 176);
  CHECK(offsetof(ticktrue_member, offset) == 16);
  CHECK(sizeof(ticktrue_member) == 32);
  CHECK(offsetof(ticktrue_host, column) == 16);
  CHECK(offsetof(ticktrue_host, table) == 48);
  CHECK(sizeof(ticktrue_host) == 88);
  CHECK(offsetof(ticktrue_plugin, name) == 16);
  CHECK(offsetof(ticktrue_plugin, create) == 40);
  CHECK(offsetof(ticktrue_plugin, inputs_text) == 104);
  CHECK(offsetof(ticktrue_plugin, save) == 112);
  CHECK(offsetof(ticktrue_plugin, load) == 120);
  CHECK(offsetof(ticktrue_plugin, build) == 128);
  CHECK(sizeof(ticktrue_plugin) == 136);
}

}  // namespace ticktrue::test::sessions
