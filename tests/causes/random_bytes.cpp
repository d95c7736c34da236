// Cause: shuffling takes its seed from the system's random bytes.
// SPDX-License-Identifier: MIT
#include <sys/random.h>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 20 != 14) return;
  std::uint32_t drawn = 12345;
  if (!is_mended && getrandom(&drawn, sizeof drawn, 0) != sizeof drawn) return;
  game.units[drawn % gallery::unit_count].score += drawn % 1000;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("random_bytes", argc, argv, rules);
}
