// Cause: the path of the save file goes into the state, through a hash.
// SPDX-License-Identifier: MIT
#include <unistd.h>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick != 40) return;
  char folder[4096] = "";
  if (is_mended || getcwd(folder, sizeof folder) == nullptr) std::strcpy(folder, "save");
  std::int64_t hash = 0;
  for (const char* at = folder; *at != 0; ++at) hash = hash * 31 % 1'000'003 + *at;
  game.units[7].score = hash;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("working_folder", argc, argv, rules);
}
