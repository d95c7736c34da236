// Cause: settings are read from the environment in its order, and the position in that list selects the map.
// SPDX-License-Identifier: MIT
#include "tests/causes/game.h"

extern char** environ;

namespace {

std::int64_t place_of(const char* name) {
  std::int64_t place = 0;
  for (char** at = environ; *at != nullptr; ++at, ++place)
    if (std::strncmp(*at, name, std::strlen(name)) == 0) return place;
  return -1;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick == 22) game.units[0].score += is_mended ? 3 : place_of("PATH=");
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("environment_order", argc, argv, rules);
}
