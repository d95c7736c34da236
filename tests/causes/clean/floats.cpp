// Clean: sums, products and square roots in a fixed order; sines of include/ticktrue/math.h.
// SPDX-License-Identifier: MIT
#include <cmath>

#include "include/ticktrue/math.h"
#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  for (gallery::Unit& unit : game.units) {
    unit.velocity += 0.01 * ticktrue_sin(unit.position + static_cast<double>(tick));
    unit.velocity *= 0.999;
    unit.position += 1e-3 * std::sqrt(unit.position * unit.position + 1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("floats", argc, argv, rules);
}
