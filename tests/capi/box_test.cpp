// Black boxes: what a killed session leaves verifies alone, and damage never gives a wrong green.
// SPDX-License-Identifier: MIT
//
// Verified: kill -9 at any time, boxes of several sizes, sessions with and without rollback; single damaged bytes, cut
// files, mixed boxes. Not verified: loss of power.
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "include/ticktrue.h"
#include "replay/box/box_layout.h"
#include "replay/box/recover_box.h"
#include "replay/trace_reader.h"
#include "tests/capi/trace_path.h"
#include "tests/replay/toy_traces.h"
#include "tests/support/catch.h"

namespace {

using namespace ticktrue;
using ticktrue::test::TracePath;

constexpr std::uint64_t endless = ~std::uint64_t{0};
constexpr std::size_t cell_count = 300;

/// Every member is saved, half of them are registered.
struct World {
  std::uint64_t tick = 0;
  std::uint64_t generator = 1;  // not registered: without the save, the ticks cannot go on
  std::uint32_t cells[cell_count] = {};

  void step(std::uint8_t input) {
    for (int i = 0; i < 3; ++i) {
      generator = generator * 6364136223846793005u + 1442695040888963407u;
      cells[(generator >> 33) % cell_count] += static_cast<std::uint32_t>(generator >> 40) + input;
    }
    ++tick;
  }
};

std::size_t save_world(void* user, void* buffer, std::size_t size) {
  if (size >= sizeof(World)) std::memcpy(buffer, user, sizeof(World));
  return sizeof(World);
}
int load_world(void* user, const void* bytes, std::size_t size) {
  if (size != sizeof(World)) return 1;
  std::memcpy(user, bytes, size);
  return 0;
}

struct Game {
  std::uint32_t box_kib = 0;
  std::uint32_t rollback_max = 0;
  std::uint32_t interval = 100;
  std::int32_t detail = TICKTRUE_DETAIL_CELLS;
  bool saves = true;
  bool forgets = false;  // the bug: a verification that does not load the generator
};

std::uint8_t input_of(std::uint64_t tick) {
  return static_cast<std::uint8_t>(tick * 7 % 5);
}

/// Runs up to so many ticks; returns the exit code. `report`: what the session printed.
int play(const Game& game, int mode, const std::string& path, std::uint64_t tick_count, std::string* report = nullptr) {
  World world;
  ticktrue_options options = {};
  options.struct_size = sizeof options;
  options.mode = mode;
  options.path = path.c_str();
  options.name = "box-game";
  options.flags = TICKTRUE_QUIET;
  options.detail = game.detail;
  options.checkpoint_interval = game.interval;
  options.rollback_max = game.rollback_max;
  options.box_kib = mode == TICKTRUE_RECORD ? game.box_kib : 0;
  if (game.saves) {
    options.save = save_world;
    options.load = load_world;
    options.user = &world;
  }
  ticktrue_session* session = ticktrue_open(&options);
  ticktrue_column(session, "world", "tick", &world.tick, TICKTRUE_U64, 1, 1, 0);
  ticktrue_column(session, "cells", "value", world.cells, TICKTRUE_U32, 1, cell_count, sizeof world.cells[0]);
  while (world.tick < tick_count || mode == TICKTRUE_VERIFY) {
    std::uint8_t input = input_of(world.tick);
    if (ticktrue_input(session, &input, 1) != TICKTRUE_OK || ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK)
      break;
    world.step(input);
    if (game.forgets) world.generator = 1;
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
    if (game.rollback_max > 0 && world.tick > 4 && ticktrue_confirm(session, world.tick - 4) != TICKTRUE_OK) break;
  }
  const int code = ticktrue_finish(session);
  if (report != nullptr) *report = std::string(ticktrue_report(session)) + ticktrue_message(session);
  ticktrue_close(session);
  return code;
}

/// The same in a fresh process.
int play_alone(const Game& game, const std::string& path) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(play(game, TICKTRUE_VERIFY, path, endless));
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void record_until_killed(const Game& game, const std::string& path, int after_us) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) ::_exit(play(game, TICKTRUE_RECORD, path, endless));
  while (::access(path.c_str(), F_OK) != 0) ::usleep(200);
  ::usleep(static_cast<useconds_t>(after_us));
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  REQUIRE(WIFSIGNALED(status));
}

TEST_CASE("what a killed session leaves in its black box verifies alone, 20 of 20", "[capi][box]") {
  const Game games[] = {{128}, {256, 8}, {1024, 0, 37}, {600, 0, 600, TICKTRUE_DETAIL_ROOT}, {512, 16, 50}};
  std::mt19937 random(20261125);
  std::uint64_t latest = 0;
  for (int run = 0; run < 20; ++run) {
    const Game& game = games[run % 5];
    const int after_us = static_cast<int>(random() % 150000);
    CAPTURE(run, game.box_kib, game.rollback_max, after_us);
    const TracePath path;
    record_until_killed(game, path("f.ttb"), after_us);
    const auto box = replay::recover_box(path("f.ttb"), path("f.ttr"), false);
    INFO((box ? std::string() : box.error().message));
    REQUIRE(box);
    CHECK_FALSE(box->was_closed);
    CHECK(box->left_out.empty());
    CHECK((box->has_save || box->result.ticks_written == 0));
    if (box->result.ticks_written == 0) continue;  // killed before the first tick
    latest = std::max(latest, box->first_tick);
    CHECK(play_alone(game, path("f.ttr")) == 0);
    Game other = game;
    other.forgets = true;
    CHECK(play_alone(other, path("f.ttr")) == 1);
  }
  CHECK(latest > 1000);  // the box has overwritten its oldest ticks
}

TEST_CASE("a box that was closed holds its last ticks with the recorded roots", "[capi][box]") {
  const TracePath path;
  Game game{128};
  REQUIRE(play({}, TICKTRUE_RECORD, path("whole.ttr"), 3000) == 0);
  std::string report;
  REQUIRE(play(game, TICKTRUE_RECORD, path("f.ttb"), 3000, &report) == 0);
  CHECK(report.find("..2999; `ticktrue recover") != std::string::npos);
  const auto box = replay::recover_box(path("f.ttb"), path("f.ttr"), false);
  REQUIRE(box);
  CHECK(box->was_closed);
  CHECK(box->first_tick > 0);
  CHECK(box->first_tick + box->result.ticks_written == 3000);
  REQUIRE(box->result.tail.end);
  CHECK(box->result.tail.end->reason == replay::EndReason::complete);
  CHECK(play_alone(game, path("f.ttr")) == 0);
}

std::map<std::uint64_t, std::uint64_t> roots_of(const std::string& file) {
  std::map<std::uint64_t, std::uint64_t> roots;
  auto reader = replay::TraceReader::open(file);
  REQUIRE(reader);
  for (;;) {
    const auto& item = reader->next();
    if (std::holds_alternative<std::monostate>(item)) return roots;
    if (const auto* tick = std::get_if<replay::TickRecord>(&item)) roots[tick->tick] = tick->root_hash;
  }
}

TEST_CASE("a damaged box gives an error or ticks as they were recorded", "[capi][box][corruption]") {
  const TracePath path;
  REQUIRE(play({}, TICKTRUE_RECORD, path("whole.ttr"), 2000) == 0);
  const auto roots = roots_of(path("whole.ttr"));
  REQUIRE(play({128}, TICKTRUE_RECORD, path("f.ttb"), 2000) == 0);
  REQUIRE(play({128}, TICKTRUE_RECORD, path("g.ttb"), 1200) == 0);
  const Bytes bytes = test::read_file(path("f.ttb"));
  const Bytes others = test::read_file(path("g.ttb"));
  std::mt19937 random(7);
  int recovered = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    Bytes damaged = bytes;
    const std::size_t at = i % 4 == 0 ? random() % 200 : random() % bytes.size();
    if (i % 4 == 0) damaged[at] ^= static_cast<std::uint8_t>(1 + random() % 255);
    if (i % 4 == 1) damaged.resize(at);
    if (i % 4 == 2)
      for (std::size_t n = 0; n < 400 && at + n < damaged.size(); ++n)
        damaged[at + n] = static_cast<std::uint8_t>(random());
    if (i % 4 == 3)
      std::copy(others.begin() + static_cast<std::ptrdiff_t>(at), others.end(),
                damaged.begin() + static_cast<std::ptrdiff_t>(at));
    test::write_file(path("d.ttb"), damaged);
    CAPTURE(i, at);
    const auto box = replay::recover_box(path("d.ttb"), path("d.ttr"), true);
    if (!box || box->result.ticks_written == 0) {
      ++refused;
      if (!box) CHECK_FALSE(box.error().message.empty());
      continue;
    }
    ++recovered;
    for (const auto& [tick, root] : roots_of(path("d.ttr"))) REQUIRE(roots.at(tick) == root);
  }
  CHECK(recovered > 50);
  CHECK(refused > 50);
}

TEST_CASE("a box without saves names the place, and says that it cannot be run again", "[capi][box]") {
  const TracePath path;
  Game game{128};
  game.saves = false;
  std::string report;
  REQUIRE(play(game, TICKTRUE_RECORD, path("f.ttb"), 3000, &report) == 0);
  CHECK(report.find("names the place and cannot be run again") != std::string::npos);
  const auto box = replay::recover_box(path("f.ttb"), path("f.ttr"), false);
  REQUIRE(box);
  CHECK_FALSE(box->has_save);
  REQUIRE(box->first_tick > 0);
  CHECK(play(game, TICKTRUE_VERIFY, path("f.ttr"), endless, &report) == 5);
  CHECK(report.find("holds no state that this program can load") != std::string::npos);
}

TEST_CASE("an older box is replaced, one of a crash is set aside, any other file is refused", "[capi][box]") {
  const TracePath path;
  const Game game{128};
  record_until_killed(game, path("f.ttb"), 5000);
  std::string report;
  REQUIRE(play(game, TICKTRUE_RECORD, path("f.ttb"), 10, &report) == 0);
  CHECK(report.find("the box of a session that did not end is") != std::string::npos);
  CHECK(replay::is_box_file(path("f.ttb.crashed")));
  REQUIRE(play(game, TICKTRUE_RECORD, path("f.ttb"), 10, &report) == 0);
  CHECK(report.find("did not end") == std::string::npos);
  test::write_file(path("letter.txt"), Bytes(100, 'x'));
  CHECK(play(game, TICKTRUE_RECORD, path("letter.txt"), 10, &report) == 2);
  CHECK(report.find("exists and is no black box") != std::string::npos);
  CHECK(test::read_file(path("letter.txt")) == Bytes(100, 'x'));
  const auto reader = replay::TraceReader::open(path("f.ttb"));
  REQUIRE_FALSE(reader);
  CHECK(reader.error().message.find("a black box, expected a trace") != std::string::npos);
}

TEST_CASE("settings that do not go with a black box are refused", "[capi][box]") {
  const TracePath path;
  std::string report;
  Game game{128};
  game.detail = TICKTRUE_DETAIL_FULL;
  CHECK(play(game, TICKTRUE_RECORD, path("f.ttb"), 10, &report) == 2);
  CHECK(report.find("found full with a black box") != std::string::npos);
  CHECK(play({100}, TICKTRUE_RECORD, path("f.ttb"), 10, &report) == 2);
  CHECK(report.find("black box: size: found 102400 bytes") != std::string::npos);
}

}  // namespace
