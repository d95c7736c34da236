// Cause: the number of a match follows from the name of the machine.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick != 27) return;
  char name[256] = "match";
  if (!is_mended && gethostname(name, sizeof name) != 0) return;
  std::int64_t number = 0;
  for (const char* at = name; *at != 0; ++at) number = (number * 131 + *at) % 1'000'003;
  game.units[2].score = number;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("host_name", argc, argv, rules);
}
