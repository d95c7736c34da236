// Saves of sessions: what a recording holds, where a verification begins, callbacks that misbehave.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "include/ticktrue.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

constexpr std::uint64_t saved_tick_count = 100;

/// Every member is state, and is saved.
struct SavedGame {
  struct State {
    std::uint64_t tick = 0;
    double place[3] = {0, 1, 2};
    std::uint32_t generator = 9;
    std::uint32_t unused = 0;  // in place of padding
  };
  State state;
  std::uint32_t secret = 0;  // of no column and no save
  double fault = 0;          // added in tick 40
  bool reads_secret = false;
  std::size_t save_count = 0;
  std::size_t load_count = 0;
  std::uint64_t loaded_tick = 0;
  std::string path;
  std::function<std::size_t(SavedGame&, void*, std::size_t)> save = [](SavedGame& game, void* buffer,
                                                                       std::size_t size) {
    if (size >= sizeof game.state) std::memcpy(buffer, &game.state, sizeof game.state);
    return sizeof game.state;
  };
  std::function<int(SavedGame&, const void*, std::size_t)> load = [](SavedGame& game, const void* bytes,
                                                                     std::size_t size) {
    if (size != sizeof game.state) return 7;
    std::memcpy(&game.state, bytes, size);
    return 0;
  };
  ticktrue_session* session = nullptr;

  void show() {
    ticktrue_column(session, "world", "tick", &state.tick, TICKTRUE_U64, 1, 1, 0);
    ticktrue_column(session, "world", "generator", &state.generator, TICKTRUE_U32, 1, 1, 0);
    ticktrue_column(session, "balls", "place", state.place, TICKTRUE_F64, 1, 3, 0);
  }
  void step(std::uint32_t input, double dt) {
    state.generator = state.generator * 1664525u + 1013904223u + input;
    state.place[input % 3] += dt * (state.generator >> 24);
    if (reads_secret) state.place[0] += ++secret % 3;
    if (state.tick == 40) state.place[2] += fault;
    ++state.tick;
  }
};

std::size_t save_game(void* user, void* buffer, std::size_t size) {
  auto& game = *static_cast<SavedGame*>(user);
  ++game.save_count;
  return game.save(game, buffer, size);
}
int load_game(void* user, const void* bytes, std::size_t size) {
  auto& game = *static_cast<SavedGame*>(user);
  ++game.load_count;
  const int loaded = game.load(game, bytes, size);
  game.loaded_tick = game.state.tick;
  return loaded;
}

ticktrue_options saved_options(SavedGame& game, int mode, const std::string& path) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = mode;
  game.path = path;  // must outlive the options
  options.path = game.path.c_str();
  options.name = "saved-game";
  options.detail = TICKTRUE_DETAIL_CELLS;
  options.checkpoint_interval = 16;
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC | TICKTRUE_OVERWRITE;
  options.save = save_game;
  options.load = load_game;
  options.user = &game;
  return options;
}

struct SavedOutcome {
  int exit_code = 0;
  std::string report;
  std::string json;
};

std::uint32_t saved_input(std::uint64_t tick) {
  return static_cast<std::uint32_t>((tick + 1) * 2654435761u >> 16);
}

SavedOutcome close(SavedGame& game) {
  SavedOutcome outcome;
  outcome.exit_code = ticktrue_finish(game.session);
  outcome.report = std::string(ticktrue_report(game.session)) + ticktrue_message(game.session);
  outcome.json = ticktrue_report_json(game.session);
  CHECK(ticktrue_close(game.session) == outcome.exit_code);
  return outcome;
}

bool run_one_tick(SavedGame& game) {
  std::uint32_t input = saved_input(game.state.tick);
  double dt = game.state.tick % 5 == 0 ? 0.25 : 0.125;
  if (ticktrue_input(game.session, &input, sizeof input) != TICKTRUE_OK) return false;
  if (ticktrue_begin_tick(game.session, &dt) != TICKTRUE_OK) return false;
  game.step(input, dt);
  return ticktrue_end_tick(game.session) == TICKTRUE_OK;
}

SavedOutcome play(SavedGame& game, const ticktrue_options& options, std::uint64_t tick_count = saved_tick_count) {
  game.session = ticktrue_open(&options);
  game.show();
  while (game.state.tick < tick_count && run_one_tick(game)) continue;
  return close(game);
}

void record_saved(const std::string& path) {
  SavedGame game;
  const SavedOutcome outcome = play(game, saved_options(game, TICKTRUE_RECORD, path));
  CAPTURE(outcome.report);
  REQUIRE(outcome.exit_code == 0);
  CHECK(game.save_count == 7);
  CHECK(game.load_count == 0);
}

TEST_CASE("a trace states version 3 where its program saves, and no other does", "[capi][saves][version]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  SavedGame game;
  ticktrue_options options = saved_options(game, TICKTRUE_RECORD, path("plain.ttr"));
  options.save = nullptr;
  options.load = nullptr;
  REQUIRE(play(game, options).exit_code == 0);
  CHECK(path.bytes("saves.ttr")[8] == 3);
  CHECK(path.bytes("plain.ttr")[8] == 2);
  // Each is verified by a program with the callbacks and by one without.
  for (const char* file : {"saves.ttr", "plain.ttr"}) {
    for (const bool has_calls : {false, true}) {
      SavedGame again;
      options = saved_options(again, TICKTRUE_VERIFY, path(file));
      if (!has_calls) options.save = nullptr, options.load = nullptr;
      const SavedOutcome outcome = play(again, options);
      CAPTURE(file, has_calls, outcome.report);
      CHECK(outcome.exit_code == 0);
      CHECK(contains(outcome.report, "100 of 100 ticks compared"));
      CHECK(again.load_count == 0);
    }
  }
}

TEST_CASE("any schedule of rollbacks writes the saves of a straight run", "[capi][saves][rollback][property]") {
  const TracePath path;
  record_saved(path("straight.ttr"));
  for (std::uint32_t seed = 0; seed < 25; ++seed) {
    for (const std::uint32_t sync_test : {0u, 1u, 4u}) {
      CAPTURE(seed, sync_test);
      std::mt19937 random(seed);
      SavedGame game;
      ticktrue_options options = saved_options(game, TICKTRUE_RECORD, path("rolled.ttr"));
      options.rollback_max = 8;
      options.sync_test = sync_test;
      game.session = ticktrue_open(&options);
      game.show();
      std::vector<SavedGame::State> saved(saved_tick_count + 1);
      std::uint64_t confirmed = 0;
      while (confirmed < saved_tick_count) {
        const std::uint64_t now = game.state.tick;
        REQUIRE(ticktrue_tick(game.session) == now);
        saved[now] = game.state;
        const auto action = random() % 6;
        if (action == 0 && now > confirmed) {
          const std::uint64_t back = confirmed + random() % (now - confirmed + 1);
          game.state = saved[back];
          REQUIRE(ticktrue_rewind(game.session, back) == TICKTRUE_OK);
        } else if (action == 1 || now - std::min(now, confirmed) >= 8 || now == saved_tick_count) {
          if (now > confirmed) confirmed += 1 + random() % (now - confirmed);
          REQUIRE(ticktrue_confirm(game.session, confirmed) == TICKTRUE_OK);
        } else {
          REQUIRE(run_one_tick(game));
        }
      }
      const SavedOutcome outcome = close(game);
      CAPTURE(outcome.report);
      CHECK(outcome.exit_code == 0);
      CHECK((path.bytes("rolled.ttr") == path.bytes("straight.ttr")));
      CHECK(contains(outcome.report, "ran twice") == (sync_test > 0));
    }
  }
}

TEST_CASE("a verification begins at the last save before `from` and ends at `to`", "[capi][saves][seek]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  const struct {
    std::uint64_t from, to, begin;
    const char* compared;
  } cases[] = {{0, 0, 0, "100 of 100"},   {1, 0, 0, "99 of 100"},   {15, 0, 0, "85 of 100"},
               {16, 0, 16, "84 of 100"},  {50, 0, 48, "50 of 100"}, {99, 0, 96, "1 of 100"},
               {40, 49, 32, "10 of 100"}, {0, 9, 0, "10 of 100"},   {96, 99, 96, "4 of 100"}};
  for (const auto& one : cases) {
    SavedGame game;
    game.state.generator = one.begin > 0 ? 12345 : 9;  // not the recorded begin: the save brings it back
    ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("saves.ttr"));
    options.from = one.from;
    options.to = one.to;
    const SavedOutcome outcome = play(game, options);
    CAPTURE(one.from, one.to, outcome.report);
    CHECK(outcome.exit_code == 0);
    CHECK(contains(outcome.report, one.compared));
    CHECK(game.load_count == (one.from > 0 ? 1 : 0));
    CHECK(game.loaded_tick == one.begin);
  }
  SavedGame game;
  ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("saves.ttr"));
  options.from = 1'000;
  SavedOutcome outcome = play(game, options, 2'000);
  CHECK(outcome.exit_code == 3);
  CHECK(contains(outcome.report, "no tick was compared"));
  // Without saves, the run begins at tick 0 and counts from there on.
  SavedGame plain;
  options = saved_options(plain, TICKTRUE_RECORD, path("plain.ttr"));
  options.save = nullptr;
  options.load = nullptr;
  REQUIRE(play(plain, options).exit_code == 0);
  SavedGame again;
  options = saved_options(again, TICKTRUE_VERIFY, path("plain.ttr"));
  options.from = 50;
  outcome = play(again, options);
  CHECK(outcome.exit_code == 0);
  CHECK(again.load_count == 0);
  CHECK(contains(outcome.report, "50 of 100 ticks compared"));
  options.from = 0;
  options.flags |= TICKTRUE_RESTORE;
  SavedGame third;
  options.user = &third;
  outcome = play(third, options);
  CHECK(outcome.exit_code == 5);
  CHECK(contains(outcome.report, "holds no saves"));
}

TEST_CASE("a fault is found from every save, and its verdict names the load", "[capi][saves][injection]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  for (const std::uint64_t from : {0, 20, 40}) {
    SavedGame game;
    game.fault = 0.5;
    ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("saves.ttr"));
    options.from = from;
    const SavedOutcome outcome = play(game, options);
    CAPTURE(from, outcome.report);
    CHECK(outcome.exit_code == 1);
    CHECK(contains(outcome.report, "diverged  "));
    CHECK(contains(outcome.report, "tick 40 of 100"));
    CHECK(contains(outcome.report, "balls.place"));
    CHECK(contains(outcome.report, "the load callback brought the program back") == (from > 0));
  }
  // A value that is not saved: the run from the setup is as recorded, the run after load is not.
  SavedGame recorded;
  recorded.reads_secret = true;
  REQUIRE(play(recorded, saved_options(recorded, TICKTRUE_RECORD, path("secret.ttr"))).exit_code == 0);
  for (const std::uint32_t flags : {0u, static_cast<std::uint32_t>(TICKTRUE_RESTORE)}) {
    SavedGame game;
    game.reads_secret = true;
    ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("secret.ttr"));
    options.flags |= flags;
    const SavedOutcome outcome = play(game, options);
    CAPTURE(flags, outcome.report);
    CHECK(outcome.exit_code == (flags == 0 ? 0 : 1));
    CHECK(contains(outcome.report, "state_incomplete  ") == (flags != 0));
    CHECK(contains(outcome.json, "\"verdict\": \"state_incomplete\"") == (flags != 0));
  }
}

TEST_CASE("a session goes to any save while it verifies", "[capi][saves][seek]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  SavedGame game;
  const auto open = [&] {
    game = SavedGame();
    const ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("saves.ttr"));
    game.session = ticktrue_open(&options);
    game.show();
    REQUIRE(run_one_tick(game));
  };
  const auto run_to_end = [&] {
    while (run_one_tick(game)) continue;
  };
  open();
  for (const std::uint64_t tick : {70, 5, 99, 16, 0}) {
    REQUIRE(ticktrue_seek(game.session, tick) == TICKTRUE_OK);
    CHECK(game.state.tick == tick / 16 * 16);
    CHECK(ticktrue_tick(game.session) == game.state.tick);
    for (int i = 0; i < 3; ++i) REQUIRE(run_one_tick(game));
  }
  run_to_end();
  CHECK(ticktrue_status(game.session) == TICKTRUE_END);
  // The same behind the end.
  REQUIRE(ticktrue_seek(game.session, 64) == TICKTRUE_OK);
  run_to_end();
  SavedOutcome outcome = close(game);
  CAPTURE(outcome.report);
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.report, "100 of 100 ticks compared"));

  open();
  REQUIRE(ticktrue_seek(game.session, 70) == TICKTRUE_OK);
  run_to_end();
  outcome = close(game);
  CHECK(outcome.exit_code == 3);
  CHECK(contains(outcome.report, "ticks 1..63 were not compared"));

  open();
  game.load = [](SavedGame& one, const void* bytes, std::size_t) {
    std::memcpy(&one.state, bytes, sizeof one.state);
    one.state.place[1] += 1;
    return 0;
  };
  CHECK(ticktrue_seek(game.session, 70) == TICKTRUE_DIVERGED);
  outcome = close(game);
  CHECK(outcome.exit_code == 1);
  CHECK(contains(outcome.report, "stage   load "));
  CHECK(contains(outcome.report, "balls.place"));
}

/// An action of a callback, and the message about it.
struct Misbehaviour {
  const char* name;
  std::function<std::size_t(SavedGame&, void*, std::size_t)> save;
  std::function<int(SavedGame&, const void*, std::size_t)> load;
  const char* said;
};

TEST_CASE("a callback that misbehaves is told by name, and nothing is green", "[capi][saves][corruption]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  const auto good_save = SavedGame().save;
  const auto good_load = SavedGame().load;
  const Misbehaviour cases[] = {
      {"no bytes", [](SavedGame&, void*, std::size_t) { return std::size_t{0}; }, good_load,
       "save callback: tick 0: found 0 bytes, expected at least 1"},
      {"more than was said",
       [](SavedGame&, void* buffer, std::size_t size) {
         std::memset(buffer, 1, size + 5);
         return size;
       },
       good_load, "save callback: tick 0: found bytes written behind its buffer of "},
      {"always more than there is room for", [](SavedGame&, void*, std::size_t size) { return size + 1; }, good_load,
       "save callback: tick 0: found more bytes than it had asked for"},
      {"an error code", [](SavedGame&, void*, std::size_t) { return static_cast<std::size_t>(-5); }, good_load,
       "save callback: tick 0: bytes: found "},
      {"an exception",
       [](SavedGame&, void*, std::size_t) -> std::size_t { throw std::runtime_error("disk of the game"); }, good_load,
       "save callback: tick 0: found an exception that left it: disk of the game"},
      {"another exception", [](SavedGame&, void*, std::size_t) -> std::size_t { throw 3; }, good_load,
       "save callback: tick 0: found an exception that left it"},
      {"a changed state",
       [=](SavedGame& game, void* buffer, std::size_t size) {
         game.state.place[1] += 1;
         return good_save(game, buffer, size);
       },
       good_load, "save callback: tick 0: it changes the state: balls.place, row 1: hash before "},
      {"never a save", [](SavedGame&, void*, std::size_t) { return TICKTRUE_SAVE_FAILED; }, good_load,
       "the save callback returned TICKTRUE_SAVE_FAILED"},
      {"a call from inside",
       [=](SavedGame& game, void* buffer, std::size_t size) {
         ticktrue_end_tick(game.session);
         return good_save(game, buffer, size);
       },
       good_load, "end_tick: found a call from inside the save or load callback"},
      {"closing from inside", good_save,
       [](SavedGame& game, const void*, std::size_t) { return ticktrue_close(game.session) == 2 ? 0 : 1; },
       "close: found a call from inside the save or load callback"},
      {"finishing from inside", good_save,
       [](SavedGame& game, const void*, std::size_t) { return ticktrue_finish(game.session) == 2 ? 0 : 1; },
       "finish: found a call from inside the save or load callback"},
      {"load refuses", good_save, [](SavedGame&, const void*, std::size_t) { return 7; },
       "load callback: tick 0: returned 7 for a save of "},
      {"load throws", good_save, [](SavedGame&, const void*, std::size_t) -> int { throw std::logic_error("no"); },
       "load callback: tick 0: found an exception that left it: no"},
      {"load changes nothing", good_save, [](SavedGame&, const void*, std::size_t) { return 0; },
       "the load callback does not bring back the state at tick 0"},
      {"load leaves another state", good_save,
       [=](SavedGame& game, const void* bytes, std::size_t size) {
         good_load(game, bytes, size);
         game.state.generator ^= 1;
         return 0;
       },
       "the load callback does not bring back the state at tick 0"},
      {"load registers other columns", good_save,
       [=](SavedGame& game, const void* bytes, std::size_t size) {
         good_load(game, bytes, size);
         ticktrue_column(game.session, "world", "more", &game.secret, TICKTRUE_U32, 1, 1, 0);
         return 0;
       },
       "found a new column after the first tick"},
      {"load leaves columns of other lengths", good_save,
       [=](SavedGame& game, const void* bytes, std::size_t size) {
         good_load(game, bytes, size);
         ticktrue_column(game.session, "world", "tick", &game.state.tick, TICKTRUE_U64, 1, 0, 0);
         return 0;
       },
       "load callback: tick 0: behind it: table world: rows: column "},
  };
  for (const Misbehaviour& one : cases) {
    for (const int mode : {TICKTRUE_RECORD, TICKTRUE_VERIFY}) {
      SavedGame game;
      game.save = one.save;
      game.load = one.load;
      const std::string file = mode == TICKTRUE_RECORD ? path("x.ttr") : path("saves.ttr");
      ticktrue_options options = saved_options(game, mode, file);
      options.sync_test = 1;
      const SavedOutcome outcome = play(game, options);
      CAPTURE(one.name, mode, outcome.report);
      CHECK(outcome.exit_code != 0);
      CHECK(contains(outcome.report, one.said));
    }
    // The same with the saves of the trace.
    for (const std::uint32_t flags : {0u, static_cast<std::uint32_t>(TICKTRUE_RESTORE)}) {
      SavedGame game;
      game.state.generator = flags == 0 ? 1 : 9;
      game.save = one.save;
      game.load = one.load;
      ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("saves.ttr"));
      options.flags |= flags;
      options.from = flags == 0 ? 50 : 0;
      const SavedOutcome outcome = play(game, options);
      CAPTURE(one.name, flags, outcome.report);
      const bool is_good_load = std::string(one.name).find("load") == std::string::npos &&
                                std::string(one.name).find("ing from inside") == std::string::npos;
      CHECK((outcome.exit_code == 0) == is_good_load);
    }
  }
}

TEST_CASE("a save that fails once leaves a checkpoint without save, which is told and passed",
          "[capi][saves][corruption]") {
  const TracePath path;
  SavedGame game;
  const auto good_save = game.save;
  game.save = [=](SavedGame& one, void* buffer, std::size_t size) {
    return one.state.tick == 48 ? TICKTRUE_SAVE_FAILED : good_save(one, buffer, size);
  };
  SavedOutcome outcome = play(game, saved_options(game, TICKTRUE_RECORD, path("gap.ttr")));
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.report, "1 checkpoint without a save"));
  SavedGame again;
  ticktrue_options options = saved_options(again, TICKTRUE_VERIFY, path("gap.ttr"));
  options.from = 50;
  outcome = play(again, options);
  CHECK(outcome.exit_code == 0);
  CHECK(again.loaded_tick == 32);
  SavedGame restored;
  options = saved_options(restored, TICKTRUE_VERIFY, path("gap.ttr"));
  options.flags |= TICKTRUE_RESTORE;
  outcome = play(restored, options);
  CAPTURE(outcome.report);
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.report, "100 ticks ran twice"));
}

TEST_CASE("a damaged or missing save is told, and another one is taken", "[capi][saves][corruption]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  const std::string whole = path.bytes("saves.ttr");
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    std::string bytes = whole;
    const std::size_t at = random() % bytes.size();
    const bool is_cut = round % 2 == 0;
    if (is_cut)
      bytes.resize(at);
    else
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
    std::ofstream(path("broken.ttr"), std::ios::binary) << bytes;
    for (const std::uint64_t from : {0, 50}) {
      SavedGame game;
      ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("broken.ttr"));
      options.from = from;
      if (from == 0) options.flags |= TICKTRUE_RESTORE;
      const SavedOutcome outcome = play(game, options, 200);
      CAPTURE(round, at, from, outcome.report);
      // The bytes before the chosen save are not read.
      if (from == 0 || is_cut) CHECK(outcome.exit_code >= 2);
      CHECK(outcome.exit_code != 1);
      CHECK(outcome.report.size() > 20);
    }
  }
}

TEST_CASE("options of saves are checked, and words of the command line are read where there is a load callback",
          "[capi][saves][options]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  SavedGame game;
  const auto message_of = [&](int mode, void (*change)(ticktrue_options&)) {
    ticktrue_options options = saved_options(game, mode, mode == TICKTRUE_RECORD ? path("x.ttr") : path("saves.ttr"));
    change(options);
    ticktrue_session* session = ticktrue_open(&options);
    const std::string message = ticktrue_message(session);
    CHECK(ticktrue_close(session) == 2);
    return message;
  };
  CHECK(contains(message_of(TICKTRUE_VERIFY, [](ticktrue_options& o) { o.load = nullptr; }),
                 "save: found it without load"));
  CHECK(contains(message_of(TICKTRUE_VERIFY, [](ticktrue_options& o) { o.save = nullptr; }),
                 "load: found it without save"));
  CHECK(
      contains(message_of(TICKTRUE_RECORD, [](ticktrue_options& o) { o.from = 3; }), "from: found it in a recording"));
  CHECK(contains(message_of(TICKTRUE_RECORD, [](ticktrue_options& o) { o.flags |= TICKTRUE_RESTORE; }),
                 "TICKTRUE_RESTORE: found it in a recording"));
  CHECK(contains(
      message_of(TICKTRUE_VERIFY, [](ticktrue_options& o) { o.save = nullptr, o.load = nullptr, o.sync_test = 1; }),
      "sync_test: found it without the callbacks"));
  CHECK(contains(message_of(TICKTRUE_VERIFY, [](ticktrue_options& o) { o.reserved = 1; }), "reserved: found 1"));
  CHECK(contains(message_of(TICKTRUE_VERIFY, [](ticktrue_options& o) { o.from = 9, o.to = 8; }), "to: found 8"));
  CHECK(contains(message_of(TICKTRUE_VERIFY, [](ticktrue_options& o) { o.sync_test = 1u << 20; }), "sync_test: found"));
  CHECK(contains(message_of(TICKTRUE_VERIFY, [](ticktrue_options& o) { o.sync_test = 1, o.flags |= TICKTRUE_RESTORE; }),
                 "sync_test: found it with TICKTRUE_RESTORE"));

  const auto with_words = [&](std::vector<std::string> words, bool has_calls) {
    words.insert(words.begin(), {"game", "--verify", path("saves.ttr")});
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    game = SavedGame();
    ticktrue_options options = saved_options(game, 0, "");
    if (!has_calls) options.save = nullptr, options.load = nullptr;
    game.session = ticktrue_open_arguments(&options, static_cast<int>(words.size()), argv.data());
    game.show();
    while (run_one_tick(game)) continue;
    return close(game);
  };
  CHECK(contains(with_words({"--from", "50", "--to", "59"}, true).report, "10 of 100 ticks compared"));
  CHECK(contains(with_words({"--sync-test", "2"}, true).report, "sync test: 100 ticks ran twice"));
  CHECK(contains(with_words({"--mode", "restore"}, true).report, "restore: 100 ticks ran twice"));
  CHECK(contains(with_words({"--mode", "replay"}, true).report, "match"));
  CHECK(contains(with_words({"--mode", "hard"}, true).report,
                 "--mode: found hard behind it, expected replay or restore"));
  CHECK(contains(with_words({"--from", "-1"}, true).report, "--from: found -1 behind it, expected a number"));
  CHECK(contains(with_words({"--sync-test"}, true).report, "--sync-test: found nothing behind it"));
  // A program without load may use these words for itself.
  CHECK(contains(with_words({"--mode", "hard", "--from", "x"}, false).report, "100 of 100 ticks compared"));
}

TEST_CASE("a loop that counts its own ticks is told that it ended early", "[capi][saves][equivalence]") {
  const TracePath path;
  record_saved(path("saves.ttr"));
  for (const bool restores : {false, true}) {
    SavedGame game;
    ticktrue_options options = saved_options(game, TICKTRUE_VERIFY, path("saves.ttr"));
    options.sync_test = restores ? 0 : 1;
    if (restores) options.flags |= TICKTRUE_RESTORE;
    game.session = ticktrue_open(&options);
    game.show();
    for (std::uint64_t i = 0; i < saved_tick_count && run_one_tick(game); ++i) continue;
    const SavedOutcome outcome = close(game);
    CAPTURE(outcome.report);
    CHECK(outcome.exit_code == 3);
  }
}

}  // namespace
}  // namespace ticktrue::test
