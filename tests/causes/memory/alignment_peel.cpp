// Cause: a sum begins at the first aligned address, so its order depends on where the array lies.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

/// Sums like vector code: single values up to an aligned address, then four sums side by side.
double sum_of(const float* values, std::size_t count, bool is_mended) {
  std::size_t i = 0;
  float single = 0;
  if (!is_mended)
    while (i < count && reinterpret_cast<std::uintptr_t>(values + i) % 64 != 0) single += values[i++];
  float sums[4] = {};
  for (; i + 4 <= count; i += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) sums[lane] += values[i + lane];
  for (; i < count; ++i) single += values[i];
  return static_cast<double>(single + ((sums[0] + sums[1]) + (sums[2] + sums[3])));
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 16 != 13) return;
  constexpr std::size_t count = 1000;
  auto* values = static_cast<float*>(std::aligned_alloc(32, count * sizeof(float)));
  for (std::size_t i = 0; i < count; ++i)
    values[i] = static_cast<float>(game.units[i % gallery::unit_count].position) / static_cast<float>(i + 1);
  game.units[0].velocity += 1e-3 * sum_of(values, count, is_mended);
  std::free(values);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("alignment_peel", argc, argv, rules);
}
