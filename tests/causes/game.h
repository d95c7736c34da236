// The frame of the gallery's programs: eight units on a line, whose whole state is recorded or verified.
// SPDX-License-Identifier: MIT
//
// Each program is one file with one real mistake. With the argument `mended`, it does the same without the mistake.
// docs/causes.md explains them; tests/causes/causes_test.py runs `ticktrue shake` over all of them.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstring>

#include "include/ticktrue.h"

namespace gallery {

constexpr std::uint32_t unit_count = 8;
constexpr std::uint64_t tick_count = 60;

struct Unit {
  double position = 0;
  double velocity = 0;
  std::int64_t score = 0;
};

struct Game {
  Unit units[unit_count];
};

/// Opens a session, runs `rules(game, tick, is_mended)` once per tick and returns the exit code.
template <typename Rules>
int play(const char* name, int argc, char** argv, Rules&& rules) {
  bool is_mended = false;
  for (int i = 1; i < argc; ++i) is_mended = is_mended || std::strcmp(argv[i], "mended") == 0;
  ticktrue_options options{};
  options.struct_size = sizeof options;
  options.name = name;
  options.version = 1;
  options.detail = TICKTRUE_DETAIL_FULL;
  ticktrue_session* session = ticktrue_open_arguments(&options, argc, argv);
  Game game;
  for (std::uint32_t i = 0; i < unit_count; ++i) {
    // Stored before the sums, so that no compiler can round a product and a sum at once.
    const volatile double position = 0.7 * i;
    const volatile double velocity = 0.1 * i;
    game.units[i].position = 1.5 + position;
    game.units[i].velocity = 1.0 + velocity;
  }
  Unit* first = game.units;
  ticktrue_column(session, "units", "position", &first->position, TICKTRUE_F64, 1, unit_count, sizeof *first);
  ticktrue_column(session, "units", "velocity", &first->velocity, TICKTRUE_F64, 1, unit_count, sizeof *first);
  ticktrue_column(session, "units", "score", &first->score, TICKTRUE_I64, 1, unit_count, sizeof *first);
  double dt = 1.0 / 64;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    if (ticktrue_begin_tick(session, &dt) != TICKTRUE_OK) break;
    for (Unit& unit : game.units) unit.position += unit.velocity * dt;
    rules(game, tick, is_mended);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  return ticktrue_close(session);
}

}  // namespace gallery
