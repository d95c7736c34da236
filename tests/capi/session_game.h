// A small game with a session, for tests of the C interface.
// SPDX-License-Identifier: MIT
#pragma once

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <system_error>
#include <vector>

#include "include/ticktrue.h"
#include "tests/support/catch.h"

namespace ticktrue::test::sessions {

/// A temporary folder. Its destructor removes it.
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

inline ticktrue_options options_for(const std::string& path, int mode) {
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

inline std::uint32_t input_at(std::uint64_t tick) {
  return static_cast<std::uint32_t>((tick + 1) * 2654435761u >> 16);
}

struct Outcome {
  int exit_code = 0;
  std::string report;
  std::string message;
};

inline Outcome finish(ticktrue_session* session) {
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
inline Outcome play(const ticktrue_options& options, std::uint64_t tick_count) {
  return play(options, tick_count, [](Game&) {});
}

inline std::vector<char> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace ticktrue::test::sessions
