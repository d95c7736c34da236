// Cause: the generator is seeded with the time of day, which is not in the setup.
// SPDX-License-Identifier: MIT
#include <ctime>

#include "tests/causes/game.h"

namespace {

std::uint64_t state = 0;

std::uint64_t next() {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return state >> 40;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick == 0) {
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    state = is_mended ? 1 : static_cast<std::uint64_t>(now.tv_nsec);
  }
  if (tick >= 7) game.units[tick % gallery::unit_count].score += static_cast<std::int64_t>(next() % 6);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("wall_clock_seed", argc, argv, rules);
}
