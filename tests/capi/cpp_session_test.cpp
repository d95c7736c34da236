// The C++ layer: inputs, setup, ticks of any length, saves, rollback.
// SPDX-License-Identifier: MIT
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "replay/trace_reader.h"
#include "tests/capi/cpp_options.h"
#include "tests/capi/cpp_units.h"
#include "tests/capi/trace_path.h"
#include "tests/support/catch.h"
#include "tests/support/text.h"

namespace ticktrue_example {

/// An order of a player: padding and floats.
struct Command {
  std::uint8_t player;
  float strength;
  bool is_urgent;
  Vec2 goal;
};
TICKTRUE_COLUMNS(Command, player, strength, is_urgent, goal)

struct Level {
  std::uint32_t number;
  std::uint32_t seed;
};

/// A state in two parts, of which one moves.
struct Game {
  struct Counter {
    std::uint32_t ticks = 0;
    float heat = 0;
  };
  Counter counter;
  std::vector<std::uint32_t> values;
  std::uint32_t forgotten = 0;

  void step() {
    ++counter.ticks;
    counter.heat += 0.5f;
    values.push_back(counter.ticks * 3 + forgotten);
    for (std::uint32_t& value : values) value = value * 1664525u + 1013904223u;
  }
};
TICKTRUE_COLUMNS(Game::Counter, ticks, heat)

}  // namespace ticktrue_example

namespace ticktrue::test {
namespace {

using ticktrue_example::Command;
using ticktrue_example::Game;
using ticktrue_example::Level;

Command command_of(std::uint32_t tick, int filler) {
  Command command;
  std::memset(static_cast<void*>(&command), filler, sizeof command);
  command.player = static_cast<std::uint8_t>(tick % 4);
  command.strength = 0.5f * static_cast<float>(tick);
  command.is_urgent = tick % 3 == 0;
  command.goal = {1, static_cast<float>(tick)};
  return command;
}

/// Ten ticks with one command and a list of them. The verification begins with other inputs.
int play_inputs(const std::string& path, int mode, int filler, std::vector<std::uint32_t>& sizes) {
  std::vector<float> values(4);
  ticktrue::Session session(cpp_options(path, mode));
  session.table("values", values);
  for (std::uint32_t tick = 0; tick < 10; ++tick) {
    const bool is_record = mode == TICKTRUE_RECORD;
    Command command = command_of(is_record ? tick : 77, filler);
    std::vector<Command> commands;
    for (std::uint32_t i = 0; i < (is_record ? tick % 4 : 9); ++i) commands.push_back(command_of(i, filler));
    std::uint16_t raw[2] = {static_cast<std::uint16_t>(tick), 5};
    float dt = is_record ? 1 / (60.0f + static_cast<float>(tick)) : 3;
    if (!session.input(command) || !session.input(commands) || !session.input(raw, sizeof raw)) break;
    if (!session.begin_tick(dt)) break;
    values[0] += command.strength * dt;
    values[1] += command.is_urgent ? command.goal.y : 0;
    for (const Command& each : commands) values[2] += each.goal.y;
    values[3] = dt + raw[0];
    sizes.push_back(static_cast<std::uint32_t>(commands.size()));
    session.end_tick();
  }
  CHECK(std::string(session.error()).empty());
  return session.close();
}

TEST_CASE("inputs of structs, lists and steps come back from the trace, without padding", "[capi][columns]") {
  const TracePath path;
  std::vector<std::uint32_t> recorded, verified, other;
  REQUIRE(play_inputs(path("a.ttr"), TICKTRUE_RECORD, 0x00, recorded) == 0);
  REQUIRE(play_inputs(path("b.ttr"), TICKTRUE_RECORD, 0xff, other) == 0);
  CHECK(path.bytes("a.ttr") == path.bytes("b.ttr"));
  CHECK(play_inputs(path("a.ttr"), TICKTRUE_VERIFY, 0x33, verified) == 0);
  CHECK(recorded == verified);
}

TEST_CASE("a forged length of a list is refused before it is believed", "[capi][columns][corruption]") {
  const TracePath path;
  std::uint32_t value = 1;
  const auto play = [&](int mode, std::uint32_t length) {
    ticktrue::Session session(cpp_options(path("x.ttr"), mode));
    session.table("value", value);
    std::vector<std::uint64_t> list;
    bool goes_on = mode == TICKTRUE_RECORD ? session.input(length) : session.input(list);
    goes_on = goes_on && session.begin_tick() && session.end_tick();
    return std::pair(goes_on, list.size());
  };
  for (const std::uint32_t length : {0xffffffffu, 0x00100001u, 9u}) {
    CAPTURE(length);
    std::remove(path("x.ttr").c_str());
    REQUIRE(play(TICKTRUE_RECORD, length).first);
    const auto [goes_on, size] = play(TICKTRUE_VERIFY, 0);
    CHECK_FALSE(goes_on);
    CHECK(size == (length == 9u ? 9u : 0u));
  }
}

TEST_CASE("the setup of a trace replaces that of the program", "[capi][columns]") {
  const TracePath path;
  const auto play = [&](int mode, Level level) {
    std::uint32_t value = 0;
    const std::string file = path("x.ttr");
    ticktrue::Session session(cpp_options(file, mode).set_setup(level));
    std::uint64_t wide = 0;
    std::uint16_t small = 6;
    CHECK(session.setup(wide));
    CHECK_FALSE(session.setup(small));
    CHECK(small == 6);
    REQUIRE(session.setup(level));
    session.table("value", value);
    if (session.begin_tick()) {
      value = level.seed + level.number;
      session.end_tick();
    }
    return std::pair(session.close(), value);
  };
  CHECK(play(TICKTRUE_RECORD, {1, 40}) == std::pair(0, 41u));
  CHECK(play(TICKTRUE_VERIFY, {2, 50}) == std::pair(0, 41u));
}

std::vector<char> bytes_of_game(const Game& game) {
  std::vector<char> bytes(sizeof game.counter + 4 * game.values.size());
  std::memcpy(bytes.data(), &game.counter, sizeof game.counter);
  if (!game.values.empty()) std::memcpy(bytes.data() + sizeof game.counter, game.values.data(), 4 * game.values.size());
  return bytes;
}

bool game_from_bytes(Game& game, std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof game.counter) return false;
  std::memcpy(&game.counter, bytes.data(), sizeof game.counter);
  std::vector<std::uint32_t> values((bytes.size() - sizeof game.counter) / 4);  // at another address
  if (!values.empty()) std::memcpy(values.data(), bytes.data() + sizeof game.counter, 4 * values.size());
  game.values = std::move(values);
  return true;
}

std::string run_sync_test(const std::string& path, bool forgets) {
  Game game;
  ticktrue::Options options = cpp_options(path, TICKTRUE_RECORD);
  options.sync_test = 3;
  options.saves(
      game, [](const Game& g) { return bytes_of_game(g); },
      [](Game& g, std::span<const std::byte> bytes) { return game_from_bytes(g, bytes); });
  ticktrue::Session session(options);
  session.table("counter", game.counter);
  session.table("values", game.values);
  while (game.counter.ticks < 30 && ticktrue_status(session.handle()) == TICKTRUE_OK) {
    session.begin_tick();
    if (forgets) ++game.forgotten;
    game.step();
    session.end_tick();
  }
  CHECK(std::string(session.error()).empty());
  ticktrue_finish(session.handle());
  return ticktrue_report(session.handle());
}

TEST_CASE("lambdas save and load a state whose rows move, and a sync test finds what they forget",
          "[capi][columns][determinism]") {
  const TracePath path;
  const std::string good = run_sync_test(path("x.ttr"), false);
  CAPTURE(good);
  CHECK(contains(good, "ticks ran twice with the same state"));
  const std::string bad = run_sync_test(path("y.ttr"), true);
  CAPTURE(bad);
  CHECK(contains(bad, "state_incomplete"));
  CHECK(contains(bad, "values.value"));
}

struct Score {
  std::uint64_t sum = 0;
  std::uint32_t ticks = 0;
  std::uint32_t spare = 0;
};

/// 40 ticks in blocks. With `goes_back`, each block runs with guessed inputs first.
int play_rollback(const std::string& path, int mode, bool goes_back) {
  Score score;
  ticktrue::Options options = cpp_options(path, mode);
  options.rollback_max = 8;
  ticktrue::Session session(options.saves(score));
  session.table("sum", score.sum);
  session.table("ticks", score.ticks);
  const auto run_block = [&](bool is_guess) {
    for (int i = 0; i < 5; ++i) {
      auto button = static_cast<std::uint8_t>(is_guess ? 99 : score.ticks);
      if (!session.input(button) || !session.begin_tick()) return;
      score.sum = score.sum * 31 + button;
      ++score.ticks;
      session.end_tick();
    }
  };
  while (score.ticks < 40) {
    const Score before = score;
    if (goes_back) {
      run_block(true);
      CHECK(session.rewind(before.ticks));
      score = before;
      CHECK(session.tick() == before.ticks);
    }
    run_block(false);
    if (score.ticks != before.ticks + 5 || !session.confirm(score.ticks)) break;
  }
  CHECK(std::string(session.error()).empty());
  return session.close();
}

TEST_CASE("a session that goes back records the bytes of a straight run", "[capi][columns][equivalence]") {
  const TracePath path;
  REQUIRE(play_rollback(path("straight.ttr"), TICKTRUE_RECORD, false) == 0);
  REQUIRE(play_rollback(path("back.ttr"), TICKTRUE_RECORD, true) == 0);
  CHECK(path.bytes("straight.ttr") == path.bytes("back.ttr"));
  CHECK(play_rollback(path("back.ttr"), TICKTRUE_VERIFY, false) == 0);
  CHECK(play_rollback(path("straight.ttr"), TICKTRUE_VERIFY, true) == 0);
}

TEST_CASE("stages of a session in C++ are named where they differ", "[capi][columns][injection]") {
  const TracePath path;
  const std::string file = path("stages.ttr");
  const auto play = [&](int mode, bool is_wrong) {
    Score score;
    ticktrue::Options options = cpp_options(file, mode);
    options.detail = TICKTRUE_DETAIL_FULL;
    ticktrue::Session session(options);
    session.table("sum", score.sum);
    CHECK(session.add_stage("add"));
    CHECK(session.add_stage("mix"));
    for (; score.ticks < 5 && session.begin_tick(); ++score.ticks) {
      score.sum += 3;
      CHECK(session.stage("add"));
      score.sum = score.sum * 31 + (is_wrong && score.ticks == 3 ? 1 : 0);
      CHECK(session.stage("mix"));
      if (!session.end_tick()) break;
    }
    session.begin_tick();
    ticktrue_finish(session.handle());
    return std::string(ticktrue_report(session.handle()));
  };
  play(TICKTRUE_RECORD, false);
  CHECK(contains(play(TICKTRUE_VERIFY, false), "5 of 5 ticks compared"));
  const std::string report = play(TICKTRUE_VERIFY, true);
  CAPTURE(report);
  CHECK(contains(report, "tick 3 of 5"));
  CHECK(contains(report, "stage   mix"));
}

TEST_CASE("a verification in C++ goes to a save and on from there", "[capi][columns][saves]") {
  const TracePath path;
  const std::string file = path("seek.ttr");
  Score score;
  const auto open = [&](int mode) {
    score = Score();
    ticktrue::Options options = cpp_options(file, mode);
    options.checkpoint_interval = 8;
    ticktrue::Session session(options.saves(score));
    session.table("sum", score.sum);
    session.table("ticks", score.ticks);
    return session;
  };
  const auto run_one_tick = [&](ticktrue::Session& session) {
    if (!session.begin_tick()) return false;
    score.sum = score.sum * 31 + 7;
    ++score.ticks;
    return session.end_tick();
  };
  ticktrue::Session recording = open(TICKTRUE_RECORD);
  for (int i = 0; i < 30; ++i) CHECK(run_one_tick(recording));
  REQUIRE(recording.close() == 0);
  ticktrue::Session session = open(TICKTRUE_VERIFY);
  CHECK(run_one_tick(session));
  for (const std::uint64_t tick : {21, 3, 16, 0}) {
    REQUIRE(session.seek(tick));
    CHECK(score.ticks == tick / 8 * 8);
    CHECK(session.tick() == score.ticks);
    CHECK(run_one_tick(session));
  }
  while (run_one_tick(session)) continue;
  CHECK(score.ticks == 30);
  CHECK(session.close() == 0);
}

TEST_CASE("marks of a session in C++ are those of the C interface", "[capi][columns][marks]") {
  const TracePath path;
  const auto play = [&](int mode, int extra) {
    std::uint32_t value = 0;
    ticktrue::Session session(cpp_options(path("m.ttr"), mode).marks());
    session.table("value", value);
    for (int tick = 0; tick < 4; ++tick) {
      if (!session.begin_tick()) break;
      session.mark("rand", -1 - tick);
      session.mark("sin", 0.25F);
      if (tick == 2)
        for (int i = 0; i < extra; ++i) session.mark("rand", true);
      CHECK(session.note("chat", "hello"));
      if (!session.end_tick()) break;
    }
    const bool is_verified = mode == TICKTRUE_VERIFY;
    if (is_verified) session.begin_tick();
    ticktrue_finish(session.handle());
    return std::string(ticktrue_report(session.handle()));
  };
  CHECK_FALSE(contains(play(TICKTRUE_RECORD, 0), "not stored"));
  CHECK_FALSE(contains(play(TICKTRUE_VERIFY, 0), "rand"));
  const std::string other = play(TICKTRUE_VERIFY, 2);
  CAPTURE(other);
  CHECK(contains(other, "tick 2"));
  CHECK(contains(other, "rand 3 times, recorded 1"));
  auto reader = replay::TraceReader::open(path("m.ttr"));
  REQUIRE(reader);
  std::size_t tick_count = 0;
  for (;;) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) break;
    const auto* tick = std::get_if<replay::TickRecord>(&item);
    if (tick == nullptr) continue;
    ++tick_count;
    REQUIRE(tick->marks);
    REQUIRE(tick->marks->names.size() == 2);
    CHECK(tick->marks->names[1].name == "sin");
    CHECK(tick->notes.size() == 1);
  }
  CHECK(tick_count == 4);
}

TEST_CASE("a session moves, and closes what it replaces", "[capi][columns]") {
  const TracePath path;
  std::uint32_t value = 0;
  ticktrue::Session session(cpp_options(path("a.ttr"), TICKTRUE_RECORD));
  session.table("value", value);
  ticktrue::Session moved(std::move(session));
  CHECK(moved.begin_tick());
  CHECK(moved.end_tick());
  moved = ticktrue::Session(cpp_options(path("b.ttr"), TICKTRUE_RECORD));
  CHECK(path.bytes("a.ttr").size() > 100);
  CHECK(moved.table("value", value));
  CHECK(moved.begin_tick());
  CHECK(moved.end_tick());
  CHECK(moved.close() == 0);
  CHECK(moved.close() == 0);
  CHECK(moved.begin_tick());
}

}  // namespace
}  // namespace ticktrue::test
