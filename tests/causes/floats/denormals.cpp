// Cause: a speed decays into denormal numbers, which a library may have switched off.
// SPDX-License-Identifier: MIT
#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  double& speed = game.units[5].velocity;
  if (tick == 0) speed = 1e-300;
  speed *= 0.5;
  if (tick < 30) speed *= 0.5;
  if (is_mended && speed < 1e-306) speed = 0;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("denormals", argc, argv, rules);
}
