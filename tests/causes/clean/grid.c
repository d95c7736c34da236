// Clean: a cellular automaton on a grid from the heap that is written before it is read, in C.
// SPDX-License-Identifier: MIT
#include <stdlib.h>
#include <string.h>

#include "tests/causes/clean/game_c.h"

enum { side = 32 };

static void rules(struct unit* units, uint64_t tick) {
  static unsigned char cells[side * side];
  unsigned char* next = malloc(sizeof cells);
  if (next == NULL) abort();
  if (tick == 0)
    for (int i = 0; i < side * side; ++i) cells[i] = (unsigned char)(i * i % 7 < 3);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      int around = 0;
      for (int k = 0; k < 9; ++k)
        if (k != 4) around += cells[(y + k / 3 + side - 1) % side * side + (x + k % 3 + side - 1) % side];
      next[y * side + x] = (unsigned char)(around == 3 || (around == 2 && cells[y * side + x] != 0));
    }
  memcpy(cells, next, sizeof cells);
  free(next);
  for (int i = 0; i < side * side; ++i) units[i % unit_count].score += cells[i];
}

int main(int argc, char** argv) {
  return play("grid", argc, argv, rules);
}
