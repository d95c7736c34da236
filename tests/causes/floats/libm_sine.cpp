// Cause: ships steer by sin of the C library, whose last bit depends on the library and on the processor.
// SPDX-License-Identifier: MIT
#include <cmath>

#include "include/ticktrue/math.h"
#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick < 16) return;
  for (gallery::Unit& unit : game.units) {
    // Some of these many angles have different results in different libraries.
    for (int i = 0; i < 200; ++i) {
      const double angle = unit.position * (3 + i) + static_cast<double>(tick);
      unit.velocity += is_mended ? ticktrue_sin(angle) : std::sin(angle);
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("libm_sine", argc, argv, rules);
}
