// Cause: the generator is seeded with the cycle counter of the processor, which no library can replace.
// SPDX-License-Identifier: MIT
#ifdef __x86_64__
#include <x86intrin.h>
#endif

#include "tests/causes/game.h"

namespace {

__attribute__((noinline)) std::uint64_t seed_of_counter() {
#ifdef __x86_64__
  return __rdtsc();
#else
  return 0;
#endif
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick != 11) return;
  const std::uint64_t seed = is_mended ? 5 : seed_of_counter();
  game.units[seed % gallery::unit_count].score += static_cast<std::int64_t>(seed >> 3 & 0xff);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("cycle_counter", argc, argv, rules);
}
