// Cause: the rules draw from rand, and sound and particles draw from it as well.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

std::uint32_t own = 42;

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick == 0) std::srand(42);
  if (tick % 12 != 11) return;
  own = own * 1664525u + 1013904223u;
  game.units[3].score += is_mended ? own >> 28 : static_cast<std::uint32_t>(std::rand()) % 16;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("shared_generator", argc, argv, rules);
}
