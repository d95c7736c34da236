// Clean: integers and a custom generator; all of them are state.
// SPDX-License-Identifier: MIT
#include "tests/causes/game.h"

namespace {

std::uint64_t state = 7;

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  game.units[tick % gallery::unit_count].score += static_cast<std::int64_t>(state >> 58);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("integers", argc, argv, rules);
}
