// Cause: an address goes into a hash that picks who moves first. Addresses are random, so no two runs agree.
// SPDX-License-Identifier: MIT
#include "tests/causes/game.h"

namespace {

int anchor = 0;

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 8 != 4) return;
  const auto key =
      is_mended ? std::uint64_t{17} : static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(&anchor));
  game.units[(key * 0x9e3779b97f4a7c15u + tick) >> 61].score += 1;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("address_hash", argc, argv, rules);
}
