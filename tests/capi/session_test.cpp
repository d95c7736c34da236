// Sessions of the C interface: record, verify, rollback.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "include/ticktrue.h"
#include "tests/capi/session_game.h"
#include "tests/cli/tool_run.h"
#include "tests/support/catch.h"
#include "tests/support/forging.h"
#include "tests/support/text.h"

namespace ticktrue::test::sessions {

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

TEST_CASE("of a damaged trace a session compares the ticks that can be recovered", "[capi][corruption]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  ticktrue_options options = options_for(path, TICKTRUE_RECORD);
  options.detail = TICKTRUE_DETAIL_ROOT;
  options.checkpoint_interval = 0;  // one chunk of ticks
  REQUIRE(play(options, 200).exit_code == 0);
  const std::vector<char> whole = bytes_of(path);
  int salvaged_count = 0;
  for (std::size_t place = whole.size() / 4; place < whole.size(); place += whole.size() / 16 + 11) {
    std::vector<char> bytes = whole;
    bytes[place] ^= 1;
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    const auto recovered = ticktrue::replay::recover_trace(path, folder.file("whole.ttr"), true);
    REQUIRE(recovered);
    const Outcome verified = play(options_for(path, TICKTRUE_VERIFY), 200);
    CAPTURE(place, verified.report);
    CHECK(verified.exit_code == 4);
    CHECK(contains(verified.report, "  " + std::to_string(recovered->ticks_written) + " of 200 ticks"));
    CHECK(contains(verified.report, "ticktrue recover "));
    if (recovered->ticks_written == recovered->tail.ticks_intact) continue;
    ++salvaged_count;
    CHECK(contains(verified.report, "by the checks of their records alone"));
  }
  CHECK(salvaged_count > 4);
}

TEST_CASE("replay and verify of a session's trace refuse with the lines that work, and print nothing else",
          "[capi][cli][equivalence]") {
  const TemporaryFolder folder;
  const std::string path = folder.file("game.ttr");
  REQUIRE(play(options_for(path, TICKTRUE_RECORD), 20).exit_code == 0);
  const std::string by_program = "ticktrue verify " + path + " --command './PROGRAM --verify {}'";
  const auto run = [&](const std::vector<std::string>& words, int exit_code) {
    const std::string output = folder.file("output");
    CHECK(test::ToolRun(words, output, {}).wait() == exit_code);
    return test::text_of(output);
  };
  for (const std::vector<std::string>& format : {std::vector<std::string>{}, {"--format", "jsonl"}}) {
    std::vector<std::string> words{"replay", path};
    words.insert(words.end(), format.begin(), format.end());
    const std::string replayed = run(words, 5);
    CAPTURE(replayed);
    CHECK(replayed.compare(0, 17, "ticktrue: error: ") == 0);
    CHECK(contains(replayed, "game.ttr: simulation: found "));
    CHECK(contains(replayed, ", expected ticktrue.engine\n"));
    CHECK(contains(replayed, "`ticktrue show " + path + " --ticks 0..9`"));
    CHECK(contains(replayed, by_program));
    CHECK_FALSE(contains(replayed, "physics version"));
  }
  CHECK(contains(run({"verify", path}, 5), by_program));
  CHECK(contains(run({"show", path, "--ticks", "0..9"}, 0), "       9  "));
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

}  // namespace ticktrue::test::sessions
