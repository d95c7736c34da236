// Clean: qsort with a comparison that ends with the id, aligned blocks, memory that grows.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

struct Entry {
  std::int64_t score;
  std::uint32_t id;
};

int compare(const void* a, const void* b) {
  const auto* left = static_cast<const Entry*>(a);
  const auto* right = static_cast<const Entry*>(b);
  if (left->score != right->score) return left->score < right->score ? -1 : 1;
  return left->id < right->id ? -1 : left->id > right->id;
}

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  Entry* entries = nullptr;
  for (std::uint32_t i = 0; i < gallery::unit_count; ++i) {
    entries = static_cast<Entry*>(std::realloc(entries, (i + 1) * sizeof(Entry)));
    entries[i] = {game.units[i].score / 3, i};
  }
  std::qsort(entries, gallery::unit_count, sizeof(Entry), compare);
  game.units[entries[tick % gallery::unit_count].id].score += 1;
  std::free(entries);
  auto* lanes = static_cast<double*>(std::aligned_alloc(64, 64 * sizeof(double)));
  for (std::size_t i = 0; i < 64; ++i) lanes[i] = static_cast<double>(i) * 0.5;
  game.units[0].velocity += 1e-4 * lanes[tick];
  std::free(lanes);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("qsort_ids", argc, argv, rules);
}
