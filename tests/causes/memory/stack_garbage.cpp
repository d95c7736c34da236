// Cause: a local variable is used on a path that has not set it.
// SPDX-License-Identifier: MIT
#include "tests/causes/game.h"

namespace {

__attribute__((noinline)) std::int64_t damage_of(std::uint64_t tick, bool is_mended) {
  volatile std::int64_t damage[2048];  // far below what the session itself writes
  if (is_mended || tick % 10 != 7) damage[5] = 3;
  return damage[5] & 0xff;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick >= 17) game.units[1].score += damage_of(tick, is_mended);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("stack_garbage", argc, argv, rules);
}
