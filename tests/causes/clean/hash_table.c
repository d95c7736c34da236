// Clean: a custom hash table whose keys are ids, with linked blocks of the heap, in C.
// SPDX-License-Identifier: MIT
#include <stdlib.h>

#include "tests/causes/clean/game_c.h"

enum { bucket_count = 16 };
struct entry {
  uint32_t id;
  int64_t hits;
  struct entry* next;
};
static struct entry* buckets[bucket_count];

static struct entry* entry_of(uint32_t id) {
  struct entry** at = &buckets[(id * 2654435761u) >> 28];
  while (*at != NULL && (*at)->id != id) at = &(*at)->next;
  if (*at == NULL) {
    *at = calloc(1, sizeof **at);
    if (*at == NULL) abort();
    (*at)->id = id;
  }
  return *at;
}

static void rules(struct unit* units, uint64_t tick) {
  for (uint32_t i = 0; i < 12; ++i) ++entry_of((uint32_t)(tick * 17 + i * i) % 91)->hits;
  for (int b = 0; b < bucket_count; ++b)
    for (const struct entry* at = buckets[b]; at != NULL; at = at->next) units[at->id % unit_count].score += at->hits;
}

int main(int argc, char** argv) {
  return play("hash_table", argc, argv, rules);
}
