// Cause: the time since the machine started decides which unit is lucky today.
// SPDX-License-Identifier: MIT
#include <ctime>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick != 21) return;
  timespec now{};
  if (!is_mended) clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t days = now.tv_sec / 86400;
  game.units[days % gallery::unit_count].score += 5;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("steady_clock", argc, argv, rules);
}
