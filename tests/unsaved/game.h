// The frame of the programs for tests of `ticktrue unsaved`: a small game whose save holds only its columns.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "include/ticktrue.h"

struct Game {
  std::uint32_t tick = 0;
  std::vector<std::int32_t> x{10, 20, 30, 40};
  ticktrue_session* session = nullptr;

  void show() {
    ticktrue_column(session, "world", "tick", &tick, TICKTRUE_U32, 1, 1, 0);
    ticktrue_column(session, "units", "x", x.data(), TICKTRUE_I32, 1, static_cast<std::uint32_t>(x.size()), 0);
  }
};

inline std::size_t save_game(void* user, void* buffer, std::size_t size) {
  const auto* game = static_cast<const Game*>(user);
  const std::size_t values = game->x.size() * sizeof game->x[0];
  const std::size_t whole = sizeof game->tick + values;
  if (size < whole) return whole;
  std::memcpy(buffer, &game->tick, sizeof game->tick);
  std::memcpy(static_cast<char*>(buffer) + sizeof game->tick, game->x.data(), values);
  return whole;
}

/// Loads a game, and moves its rows to other memory.
inline int load_game(void* user, const void* bytes, std::size_t size) {
  auto* game = static_cast<Game*>(user);
  std::memcpy(&game->tick, bytes, sizeof game->tick);
  std::vector<std::int32_t> fresh((size - sizeof game->tick) / sizeof game->x[0]);
  std::memcpy(fresh.data(), static_cast<const char*>(bytes) + sizeof game->tick, size - sizeof game->tick);
  game->x = std::move(fresh);
  game->show();
  return 0;
}

/// Runs `step` with a button for TICKS ticks (from the environment; 150), or for as many ticks as are verified.
/// Returns the exit code.
template <typename Step>
int play(Game& game, int argc, char** argv, bool has_saves, Step step) {
  ticktrue_options options{};
  options.struct_size = sizeof options;
  options.name = "unsaved-game";
  options.flags = TICKTRUE_OVERWRITE;
  if (has_saves) {
    options.save = save_game;
    options.load = load_game;
    options.user = &game;
  }
  game.session = ticktrue_open_arguments(&options, argc, argv);
  game.show();
  const char* ticks = std::getenv("TICKS");
  const std::uint64_t end = ticks != nullptr ? std::strtoull(ticks, nullptr, 10) : 150;
  while (game.tick < end) {
    auto button = static_cast<std::uint8_t>((game.tick * 2654435761u) >> 30 == 0);
    if (ticktrue_input(game.session, &button, sizeof button) != TICKTRUE_OK) break;
    if (ticktrue_begin_tick(game.session, nullptr) != TICKTRUE_OK) break;
    step(button);
    ++game.tick;
    if (ticktrue_end_tick(game.session) != TICKTRUE_OK) break;
  }
  return ticktrue_close(game.session);
}
