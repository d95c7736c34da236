// Cause: the colour of a player's units follows from the number of the user.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick == 15) game.units[3].score += is_mended ? 7 : getuid() % 1000;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("user_name", argc, argv, rules);
}
