// Cause: a signed sum overflows. An optimiser may assume that signed sums never overflow.
// SPDX-License-Identifier: MIT
#include <climits>

#include "tests/causes/game.h"

namespace {

/// Whether the next value is larger. An optimiser may assume that it always is.
__attribute__((noinline)) bool grows(int value, bool is_mended) {
  if (is_mended) return value != INT_MAX;
  const int next = value + 1;
  return next > value;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  const int value = tick == 31 ? INT_MAX : static_cast<int>(tick);
  if (grows(value, is_mended)) game.units[tick % gallery::unit_count].score += 1;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("overflow", argc, argv, rules);
}
