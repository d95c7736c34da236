// Cause: if the output is a terminal, effects are drawn with numbers of the game's own generator.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include "tests/causes/game.h"

namespace {

std::uint32_t state = 99;

std::uint32_t draw() {
  state = state * 1664525u + 1013904223u;
  return state >> 24;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick >= 14 && !is_mended && isatty(STDOUT_FILENO) != 0) std::printf("\a%u\n", draw());
  if (tick >= 14) game.units[tick % gallery::unit_count].score += draw();
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("terminal", argc, argv, rules);
}
