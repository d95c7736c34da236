// Cause: a product and a sum in one expression. A compiler may round once (FMA) or twice.
// SPDX-License-Identifier: MIT
#include "tests/causes/game.h"

namespace {

/// A spring with friction. The compiler may round a product and its sum once or twice.
__attribute__((noinline)) void pull(gallery::Unit& unit) {
  unit.velocity = unit.velocity * 0.999 + unit.position * -0.01;
}

/// The same spring, but the products are stored before the sum.
__attribute__((noinline)) void pull_in_steps(gallery::Unit& unit) {
  const volatile double kept = unit.velocity * 0.999;
  const volatile double added = unit.position * -0.01;
  unit.velocity = kept + added;
}

void rules(gallery::Game& game, std::uint64_t, bool is_mended) {
  for (gallery::Unit& unit : game.units) is_mended ? pull_in_steps(unit) : pull(unit);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("fused_products", argc, argv, rules);
}
