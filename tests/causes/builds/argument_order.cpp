// Cause: two draws are arguments of one call. The language does not define which draw comes first.
// SPDX-License-Identifier: MIT
#include "tests/causes/game.h"

namespace {

std::uint32_t state = 7;

__attribute__((noinline)) std::uint32_t draw() {
  state = state * 1664525u + 1013904223u;
  return state >> 24;
}

__attribute__((noinline)) void hit(gallery::Unit& unit, std::uint32_t strength, std::uint32_t chance) {
  unit.score += strength > chance ? strength : -static_cast<std::int64_t>(chance);
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  gallery::Unit& unit = game.units[tick % gallery::unit_count];
  if (!is_mended) return hit(unit, draw(), draw());
  const std::uint32_t strength = draw();
  const std::uint32_t chance = draw();
  hit(unit, strength, chance);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("argument_order", argc, argv, rules);
}
