// Clean: positions and speeds in fixed point, in C.
// SPDX-License-Identifier: MIT
#include "tests/causes/clean/game_c.h"

static void rules(struct unit* units, uint64_t tick) {
  for (int i = 0; i < unit_count; ++i) {
    units[i].score += (int64_t)(i + 1) * 655 - units[i].position / 256;
    units[i].position += units[i].score / 64 + (int64_t)(tick % 3);
  }
}

int main(int argc, char** argv) {
  return play("fixed_point", argc, argv, rules);
}
