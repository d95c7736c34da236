// Cause: a number comes from an instruction of the processor, which no library can replace.
// SPDX-License-Identifier: MIT
#include <immintrin.h>

#include "tests/causes/game.h"

namespace {

__attribute__((target("rdrnd"), noinline)) unsigned draw() {
  unsigned value = 0;
  while (_rdrand32_step(&value) == 0) {
  }
  return value;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick >= 8) game.units[2].score += is_mended ? 5 : draw() % 1000;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("hardware_random", argc, argv, rules);
}
