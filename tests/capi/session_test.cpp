// Sessions of the C interface: record, verify, rollback, wrong calls.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "include/ticktrue.h"
#include "replay/trace_reader.h"
#include "tests/support/catch.h"
#include "tests/support/forging.h"
#include "tests/support/text.h"

using ticktrue::test::contains;

namespace {

/// A folder of its own, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("ticktrue_capi_" + std::to_string(::getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  std::uint32_t operator()() { return static_cast<std::uint32_t>(engine_()); }

 private:
  std::mt19937 engine_;
};

/// A game with scattered state: rows of a struct with padding, a growing table, one global.
struct Game {
  struct Ball {
    std::uint8_t owner = 0;
    double position[2] = {0, 0};
    float speed = 0;
  };
  std::uint64_t tick = 0;
  std::vector<Ball> balls = std::vector<Ball>(3);
  std::vector<std::uint32_t> ids{0, 1, 2};

  void step(std::uint32_t input, double dt) {
    for (std::size_t i = 0; i < balls.size(); ++i) {
      balls[i].speed += static_cast<float>(dt * (input % 7));
      balls[i].position[i % 2] += static_cast<double>(balls[i].speed) * dt;
      balls[i].owner = static_cast<std::uint8_t>(balls[i].owner + input);
    }
    if (input % 31 == 0) {
      balls.emplace_back();
      ids.push_back(ids.empty() ? 0 : ids.back() + 1);
    }
    if (input % 37 == 0 && !balls.empty()) {
      balls.erase(balls.begin());
      ids.erase(ids.begin());
    }
    ++tick;
  }
  void show(ticktrue_session* session) {
    const auto rows = static_cast<std::uint32_t>(balls.size());
    const Ball* first = balls.data();
    ticktrue_column(session, "world", "tick", &tick, TICKTRUE_U64, 1, 1, 0);
    ticktrue_column(session, "balls", "id", ids.data(), TICKTRUE_U32, 1, rows, 0);
    ticktrue_column(session, "balls", "owner", first == nullptr ? nullptr : &first->owner, TICKTRUE_U8, 1, rows,
                    sizeof(Ball));
    ticktrue_column(session, "balls", "position", first == nullptr ? nullptr : first->position, TICKTRUE_F64, 2, rows,
                    sizeof(Ball));
    ticktrue_column(session, "balls", "speed", first == nullptr ? nullptr : &first->speed, TICKTRUE_F32, 1, rows,
                    sizeof(Ball));
    ticktrue_key(session, "balls", 1);
  }
};

ticktrue_options options_for(const std::string& path, int mode) {
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = mode;
  options.path = path.c_str();
  options.name = "test-game";
  options.version = 3;
  options.detail = TICKTRUE_DETAIL_FULL;
  options.checkpoint_interval = 16;
  options.flags = TICKTRUE_QUIET | TICKTRUE_NO_SYNC;
  return options;
}

std::uint32_t input_at(std::uint64_t tick) {
  return static_cast<std::uint32_t>((tick + 1) * 2654435761u >> 16);
}

struct Outcome {
  int exit_code = 0;
  std::string report;
  std::string message;
};

Outcome finish(ticktrue_session* session) {
  Outcome outcome;
  outcome.exit_code = ticktrue_finish(session);
  outcome.report = ticktrue_report(session);
  outcome.message = ticktrue_message(session);
  CHECK(ticktrue_close(session) == outcome.exit_code);
  return outcome;
}

/// The loop that both modes share. `disturb` is called after each step, before the state is shown.
template <typename Disturb>
Outcome play(const ticktrue_options& options, std::uint64_t tick_count, Disturb disturb) {
  ticktrue_session* session = ticktrue_open(&options);
  Game game;
  game.show(session);
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    std::uint32_t input = input_at(tick);
    double dt = tick % 5 == 0 ? 1.0 / 30 : 1.0 / 60;
    if (options.mode == TICKTRUE_VERIFY) input = 0, dt = 0;  // they come from the trace
    ticktrue_input(session, &input, sizeof input);
    if (ticktrue_begin_tick(session, &dt) != TICKTRUE_OK) break;
    game.step(input, dt);
    disturb(game);
    game.show(session);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  return finish(session);
}
Outcome play(const ticktrue_options& options, std::uint64_t tick_count) {
  return play(options, tick_count, [](Game&) {});
}

std::vector<char> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

TEST_CASE("a program that owns its loop records itself and verifies itself", "[capi][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  const Outcome recorded = play(options_for(path, TICKTRUE_RECORD), 200);
  CHECK(recorded.exit_code == 0);
  CHECK(contains(recorded.report, "200 ticks"));
  for (const std::uint64_t tick_count : {200, 100'000}) {
    const Outcome verified = play(options_for(path, TICKTRUE_VERIFY), tick_count);
    CAPTURE(verified.report, verified.message);
    CHECK(verified.exit_code == 0);
    CHECK(contains(verified.report, "match"));
    CHECK(contains(verified.report, "200 of 200 ticks compared"));
  }
}

TEST_CASE("a verification appends its report to the file of TICKTRUE_RESULT, a recording does not", "[capi][result]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr"), result = folder.file("result.json");
  ::setenv("TICKTRUE_RESULT", result.c_str(), 1);
  play(options_for(path, TICKTRUE_RECORD), 40);
  CHECK(bytes_of(result).empty());
  play(options_for(path, TICKTRUE_VERIFY), 40);
  play(options_for(path, TICKTRUE_VERIFY), 40, [](Game& game) { game.balls[0].owner ^= game.tick == 20; });
  play(options_for(folder.file("missing.ttr"), TICKTRUE_VERIFY), 40);
  ::unsetenv("TICKTRUE_RESULT");
  const std::vector<char> bytes = bytes_of(result);
  std::istringstream lines(std::string(bytes.begin(), bytes.end()));
  std::vector<std::string> reports;
  for (std::string line; std::getline(lines, line);) reports.push_back(line);
  REQUIRE(reports.size() == 3);
  CHECK(contains(reports[0], "\"verdict\": \"match\""));
  CHECK(contains(reports[1], "\"verdict\": \"diverged\""));
  CHECK(contains(reports[1], "\"tick\": 19"));
  CHECK(contains(reports[2], "\"verdict\": \"error\""));
  CHECK(contains(reports[2], "missing.ttr"));
}

TEST_CASE("a loop that ends before its trace is incomplete, not a match", "[capi][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  REQUIRE(play(options_for(path, TICKTRUE_RECORD), 50).exit_code == 0);
  const Outcome verified = play(options_for(path, TICKTRUE_VERIFY), 49);
  CHECK(verified.exit_code == 3);
  CHECK(contains(verified.report, "ended its loop after 49 ticks"));
}

TEST_CASE("a session finds a forged image, cells or checkpoint whose tick has the right hash", "[capi][corruption]") {
  using ticktrue::verifier::StoredCheckpoint;
  using ticktrue::verifier::StoredTick;
  struct Case {
    const char* name;
    int detail;
    ticktrue::test::Forgery forgery;
    const char* said;
  };
  const auto change_checkpoint = [](StoredCheckpoint& checkpoint) {
    if (checkpoint.tick == 32) checkpoint.image.back() ^= 1;
  };
  const Case cases[] = {
      {"image",
       TICKTRUE_DETAIL_FULL,
       {[](StoredTick& tick) {
         if (tick.tick == 20) tick.image->back() ^= 1;
       }},
       "tick 20: the root hash agrees, the state image does not"},
      {"cells",
       TICKTRUE_DETAIL_CELLS,
       {[](StoredTick& tick) {
         if (tick.tick == 20) tick.cells->cells.back() ^= 0x100;
       }},
       "tick 20: the root hash agrees, the cells do not"},
      {"checkpoint", TICKTRUE_DETAIL_ROOT, {{}, change_checkpoint}, "diverged  "},
      {"checkpoint of a full tick",
       TICKTRUE_DETAIL_FULL,
       {{}, change_checkpoint},
       "checkpoint        the hash of the tick"},
  };
  for (const Case& one : cases) {
    const TemporaryFolder folder;
    const std::string path = folder.file("game.ttr");
    ticktrue_options options = options_for(path, TICKTRUE_RECORD);
    options.detail = one.detail;
    REQUIRE(play(options, 60).exit_code == 0);
    const std::string forged = folder.file("forged.ttr");
    ticktrue::test::forge_trace(path, forged, {});
    CHECK(play(options_for(forged, TICKTRUE_VERIFY), 60).exit_code == 0);
    std::filesystem::remove(forged);
    ticktrue::test::forge_trace(path, forged, one.forgery);
    const Outcome verified = play(options_for(forged, TICKTRUE_VERIFY), 60);
    CAPTURE(one.name, verified.report, verified.message);
    CHECK(verified.exit_code == 1);
    CHECK(contains(verified.report, one.said));
    CHECK(contains(verified.report,
                   one.detail == TICKTRUE_DETAIL_CELLS ? "none: the hash of every column agrees" : "balls.speed"));
  }
}

TEST_CASE("one changed bit is named with tick, table, column, row and values", "[capi][injection]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  REQUIRE(play(options_for(path, TICKTRUE_RECORD), 100).exit_code == 0);
  Random random(7);
  for (int round = 0; round < 60; ++round) {
    const std::uint64_t tick = random() % 100;
    std::size_t row = 0;
    const int what = static_cast<int>(random() % 3);
    bool is_done = false;
    const Outcome verified = play(options_for(path, TICKTRUE_VERIFY), 100, [&](Game& game) {
      if (game.tick != tick + 1 || game.balls.empty()) return;
      is_done = true;
      row = random() % game.balls.size();
      Game::Ball& ball = game.balls[row];
      if (what == 0) ball.owner ^= 1;
      if (what == 1) ball.position[1] += 0.5;
      if (what == 2) ball.speed += 0.5F;
    });
    if (!is_done) continue;
    const std::string column = what == 0 ? "owner" : what == 1 ? "position" : "speed";
    CAPTURE(verified.report, tick, row, column);
    CHECK(verified.exit_code == 1);
    CHECK(contains(verified.report, "  tick " + std::to_string(tick) + " of 100"));
    CHECK(contains(verified.report, "column  balls." + column));
    CHECK(contains(verified.report, "row " + std::to_string(row) + " (id "));
    CHECK(contains(verified.report, "value   expected "));
    CHECK(contains(verified.report, what == 1 ? ", lane 1" : "value"));
  }
}

TEST_CASE("any schedule of rollbacks records the bytes of a straight run", "[capi][rollback][property]") {
  const TemporaryFolder folder;
  const std::string straight = folder.file("straight.ttr");
  constexpr std::uint64_t tick_count = 120;
  REQUIRE(play(options_for(straight, TICKTRUE_RECORD), tick_count).exit_code == 0);
  const std::vector<char> expected = bytes_of(straight);
  for (std::uint32_t seed = 0; seed < 40; ++seed) {
    CAPTURE(seed);
    const std::string path = folder.file("rolled" + std::to_string(seed) + ".ttr");
    ticktrue_options options = options_for(path, TICKTRUE_RECORD);
    options.rollback_max = 8;
    ticktrue_session* session = ticktrue_open(&options);
    Random random(seed);
    Game game;
    std::vector<Game> saved{game};           // [tick], before it
    std::uint64_t confirmed = 0;             // ticks
    std::uint64_t guessed = tick_count + 1;  // first tick that ran with a wrong input
    game.show(session);
    while (confirmed < tick_count) {
      const auto action = random() % 4;
      if (action == 0 && game.tick > confirmed) {
        const std::uint64_t back = confirmed + random() % (game.tick - confirmed + 1);
        game = saved[back];
        REQUIRE(ticktrue_rewind(session, back) == TICKTRUE_OK);
        if (back <= guessed) guessed = tick_count + 1;
      } else if (action == 1) {
        const std::uint64_t final_count = game.tick < guessed ? game.tick : guessed;
        if (final_count > confirmed) confirmed += random() % (final_count - confirmed + 1);
        REQUIRE(ticktrue_confirm(session, confirmed) == TICKTRUE_OK);
      } else if (game.tick < tick_count && game.tick - confirmed < options.rollback_max) {
        const bool is_guess = random() % 3 == 0;
        std::uint32_t input = input_at(game.tick) + (is_guess ? 1 : 0);
        if (is_guess && game.tick < guessed) guessed = game.tick;
        double dt = game.tick % 5 == 0 ? 1.0 / 30 : 1.0 / 60;
        saved.resize(game.tick + 1);
        saved[game.tick] = game;
        REQUIRE(ticktrue_input(session, &input, sizeof input) == TICKTRUE_OK);
        REQUIRE(ticktrue_begin_tick(session, &dt) == TICKTRUE_OK);
        game.step(input, dt);
        game.show(session);
        REQUIRE(ticktrue_end_tick(session) == TICKTRUE_OK);
        saved.resize(game.tick + 1);
        saved[game.tick] = game;
      } else if (guessed < game.tick) {
        game = saved[guessed];
        REQUIRE(ticktrue_rewind(session, guessed) == TICKTRUE_OK);
        guessed = tick_count + 1;
      }
    }
    CHECK(finish(session).exit_code == 0);
    CHECK((bytes_of(path) == expected));
    std::filesystem::remove(path);
  }
}

TEST_CASE("a verification may roll back too, and is given the recorded inputs again", "[capi][rollback][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  REQUIRE(play(options_for(path, TICKTRUE_RECORD), 90).exit_code == 0);
  for (const bool forgets : {false, true}) {
    ticktrue_options options = options_for(path, TICKTRUE_VERIFY);
    options.rollback_max = 6;
    ticktrue_session* session = ticktrue_open(&options);
    Game game;
    game.show(session);
    bool is_open = true;
    while (is_open) {
      const Game before = game;
      for (int pass = 0; pass < 2 && is_open; ++pass) {
        if (pass == 1) {
          const auto speeds = game.balls;
          game = before;
          if (forgets && !speeds.empty() && game.balls.size() == speeds.size()) game.balls[0].speed = speeds[0].speed;
          ticktrue_rewind(session, game.tick);
        }
        for (int i = 0; i < 3 && is_open; ++i) {
          std::uint32_t input = 0;
          double dt = 0;
          ticktrue_input(session, &input, sizeof input);
          is_open = ticktrue_begin_tick(session, &dt) == TICKTRUE_OK;
          if (!is_open) break;
          game.step(input, dt);
          game.show(session);
          ticktrue_end_tick(session);
        }
      }
      if (is_open) ticktrue_confirm(session, game.tick);
    }
    const Outcome verified = finish(session);
    CAPTURE(forgets, verified.report, verified.message);
    CHECK(verified.exit_code == (forgets ? 1 : 0));
    CHECK(contains(verified.report, forgets ? "balls.speed" : "90 of 90 ticks compared"));
  }
}

TEST_CASE("ticks that were never confirmed are not in the trace, and that is said", "[capi][rollback][equivalence]") {
  const TemporaryFolder folder;
  ticktrue_options options = options_for(folder.file("game.ttr"), TICKTRUE_RECORD);
  const std::string path = folder.file("game.ttr");
  options.path = path.c_str();
  options.rollback_max = 8;
  ticktrue_session* session = ticktrue_open(&options);
  Game game;
  game.show(session);
  for (int i = 0; i < 8; ++i) {
    REQUIRE(ticktrue_begin_tick(session, nullptr) == TICKTRUE_OK);
    game.step(1, 0.1);
    game.show(session);
    REQUIRE(ticktrue_end_tick(session) == TICKTRUE_OK);
  }
  REQUIRE(ticktrue_confirm(session, 5) == TICKTRUE_OK);
  const Outcome outcome = finish(session);
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.report, "5 ticks"));
  CHECK(contains(outcome.report, "ticks 5..7 were never confirmed"));
}

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

TEST_CASE("a trace of another program, version or schema is not comparable", "[capi][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  REQUIRE(play(options_for(path, TICKTRUE_RECORD), 20).exit_code == 0);
  ticktrue_options name = options_for(path, TICKTRUE_VERIFY);
  name.name = "other-game";
  ticktrue_options version = options_for(path, TICKTRUE_VERIFY);
  version.version = 4;
  for (const auto& [options, reason] :
       {std::pair(name, "simulation: recorded with test-game, this program is other-game"),
        std::pair(version, "version: recorded with 3, here 4")}) {
    const Outcome outcome = play(options, 20);
    CAPTURE(outcome.report);
    CHECK(outcome.exit_code == 5);
    CHECK(contains(outcome.report, reason));
  }
  // Fewer and more bytes of inputs than recorded, another column.
  for (const int what : {0, 1, 2}) {
    const ticktrue_options options = options_for(path, TICKTRUE_VERIFY);
    ticktrue_session* session = ticktrue_open(&options);
    Game game;
    game.show(session);
    if (what == 2) ticktrue_column(session, "world", "more", &game.tick, TICKTRUE_U64, 1, 1, 0);
    std::uint64_t wide = 0;
    CHECK(ticktrue_input(session, &wide,
                         what == 0   ? 8
                         : what == 1 ? 2
                                     : 4) == (what == 0 ? TICKTRUE_DIVERGED : TICKTRUE_OK));
    CHECK(ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK);
    const Outcome outcome = finish(session);
    CAPTURE(outcome.report, outcome.message);
    CHECK(outcome.exit_code == 5);
    CHECK(contains(outcome.report, what == 2 ? "schema: world.more" : "tick 0: inputs: recorded 4 bytes"));
  }
}

TEST_CASE("a value that is not finite closes the trace before its tick, and is found again", "[capi][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  const auto poison = [](Game& game) {
    if (game.tick == 18 && !game.balls.empty()) game.balls[0].speed = std::numeric_limits<float>::infinity();
  };
  const Outcome recorded = play(options_for(path, TICKTRUE_RECORD), 40, poison);
  CHECK(recorded.exit_code == 1);
  CHECK(contains(recorded.report, "non_finite: tick 17: balls row 0, column speed"));
  const Outcome again = play(options_for(path, TICKTRUE_VERIFY), 40, poison);
  CAPTURE(again.report);
  CHECK(again.exit_code == 0);
  CHECK(contains(again.report, "tick 17 is not finite, as recorded"));
  const Outcome repaired = play(options_for(path, TICKTRUE_VERIFY), 40);
  CAPTURE(repaired.report);
  CHECK(repaired.exit_code == 1);
  CHECK(contains(repaired.report, "here it is finite"));
}

TEST_CASE("a trace cut anywhere is never a match", "[capi][corruption]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  REQUIRE(play(options_for(path, TICKTRUE_RECORD), 20).exit_code == 0);
  const std::vector<char> whole = bytes_of(path);
  const std::string cut = folder.file("cut.ttr");
  for (std::size_t size = 0; size < whole.size(); size += 41) {
    std::ofstream(cut, std::ios::binary).write(whole.data(), static_cast<std::streamsize>(size));
    const Outcome outcome = play(options_for(cut, TICKTRUE_VERIFY), 20);
    CAPTURE(size, outcome.report, outcome.message);
    CHECK(outcome.exit_code >= 3);
    CHECK(outcome.exit_code <= 4);
  }
}

TEST_CASE("stages are hashed where the tick is stored in full, and the first that differs is named",
          "[capi][stages][injection]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  for (const bool is_record : {true, false}) {
    const ticktrue_options options = options_for(path, is_record ? TICKTRUE_RECORD : TICKTRUE_VERIFY);
    ticktrue_session* session = ticktrue_open(&options);
    Game game;
    game.show(session);
    for (const char* stage : {"move", "collide", "score"}) ticktrue_add_stage(session, stage);
    for (int tick = 0; tick < 10; ++tick) {
      if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
      game.step(1, 0.5);
      game.show(session);
      ticktrue_stage(session, "move");
      if (!is_record && tick == 6) game.balls[1].owner ^= 4;
      ticktrue_stage(session, "collide");
      ticktrue_stage(session, "score");
      ticktrue_end_tick(session);
    }
    const Outcome outcome = finish(session);
    CAPTURE(outcome.report, outcome.message);
    CHECK(outcome.exit_code == (is_record ? 0 : 1));
    if (!is_record) CHECK(contains(outcome.report, "collide           first stage whose output differs; move agrees"));
  }
}

TEST_CASE("a recording whose registered values never change warns", "[capi][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  const ticktrue_options options = options_for(path, TICKTRUE_RECORD);
  ticktrue_session* session = ticktrue_open(&options);
  const double copy = 4;
  ticktrue_column(session, "world", "copy", &copy, TICKTRUE_F64, 1, 1, 0);
  for (int tick = 0; tick < 5; ++tick) {
    ticktrue_begin_tick(session, nullptr);
    ticktrue_end_tick(session);
  }
  CHECK(contains(finish(session).report, "no registered value changed in 5 ticks"));
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

TEST_CASE("two sessions on one trace: the second is refused, and the first is whole", "[capi][session][corruption]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  ticktrue_options options = options_for(path, TICKTRUE_RECORD);
  options.flags |= TICKTRUE_OVERWRITE;
  Outcome second;
  const Outcome first = play(options, 20, [&](Game& game) {
    if (game.tick == 10) second = play(options, 5, [](Game&) {});
  });
  CHECK(second.exit_code == 2);
  CHECK(contains(second.message, path + ": cannot write: "));
  CHECK(contains(second.message, " is recording to it"));
  CHECK(first.exit_code == 0);
  CHECK(play(options_for(path, TICKTRUE_VERIFY), 20, [](Game&) {}).exit_code == 0);
}

TEST_CASE("a trace that is replaced while a session records it is an error", "[capi][session][corruption]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("x.ttr");
  const Outcome outcome = play(options_for(path, TICKTRUE_RECORD), 20, [&](Game& game) {
    if (game.tick != 10) return;
    std::ofstream(path + ".new") << "mine";
    std::filesystem::rename(path + ".new", path);
  });
  CHECK(outcome.exit_code == 2);
  CHECK(contains(outcome.message, path + ": was replaced by another file while it was written"));
  std::ifstream in(path);
  CHECK(std::string(std::istreambuf_iterator<char>(in), {}) == "mine");
}

TEST_CASE("the layout of the structs is the one that programs were built with", "[capi][abi][golden]") {
  SKIP_UNLESS(sizeof(void*) == 8, "a platform of 32 bits");
  CHECK(TICKTRUE_API_VERSION == 4);
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
  CHECK(sizeof(ticktrue_host) == 48);
  CHECK(offsetof(ticktrue_plugin, name) == 16);
  CHECK(offsetof(ticktrue_plugin, create) == 40);
  CHECK(offsetof(ticktrue_plugin, inputs_text) == 104);
  CHECK(sizeof(ticktrue_plugin) == 112);
}
