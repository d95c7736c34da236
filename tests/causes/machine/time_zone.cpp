// Cause: the night of the game begins by the local hour of a recorded time.
// SPDX-License-Identifier: MIT
#include <ctime>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  const std::time_t time = 1'700'000'000 + static_cast<std::time_t>(600 * tick);  // recorded time of the game
  std::tm parts{};
  if (is_mended)
    gmtime_r(&time, &parts);
  else
    localtime_r(&time, &parts);
  if (parts.tm_hour < 3) game.units[0].score += 1;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("time_zone", argc, argv, rules);
}
