// Cause: the names of new units begin with the number of the process.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick % 10 != 6) return;
  game.units[tick / 10].score = (is_mended ? 100 : getpid()) * 100 + static_cast<std::int64_t>(tick);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("process_number", argc, argv, rules);
}
