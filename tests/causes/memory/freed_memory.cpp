// Cause: a unit looks at its target one tick after the target was deleted.
// SPDX-License-Identifier: MIT
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

struct Target {
  std::int64_t links[2];
  std::int64_t health;
};
Target* target = nullptr;

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick == 10) {
    target = static_cast<Target*>(std::malloc(sizeof(Target)));
    target->health = 7;
  }
  const std::uint64_t last = is_mended ? 20 : 21;
  if (tick >= 10 && tick <= last) {
    // Volatile hides from the compiler that the block may be freed.
    const volatile Target* seen = target;
    game.units[2].score += seen->health;
  }
  if (tick == 20) std::free(target);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("freed_memory", argc, argv, rules);
}
