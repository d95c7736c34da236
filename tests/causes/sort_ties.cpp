// Cause: units are sorted by score with qsort, and some scores are equal.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

struct Entry {
  std::int64_t score;
  std::uint32_t id;
};

int by_score(const void* a, const void* b) {
  const auto* left = static_cast<const Entry*>(a);
  const auto* right = static_cast<const Entry*>(b);
  return left->score < right->score ? -1 : left->score > right->score;
}
int by_score_and_id(const void* a, const void* b) {
  if (const int order = by_score(a, b); order != 0) return order;
  return static_cast<const Entry*>(a)->id < static_cast<const Entry*>(b)->id ? -1 : 1;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  game.units[tick % 5].score += 1;
  if (tick != 29) return;
  Entry entries[gallery::unit_count];
  for (std::uint32_t i = 0; i < gallery::unit_count; ++i) entries[i] = {game.units[i].score, i};
  std::qsort(entries, gallery::unit_count, sizeof(Entry), is_mended ? by_score_and_id : by_score);
  game.units[entries[gallery::unit_count - 1].id].score += 100;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("sort_ties", argc, argv, rules);
}
