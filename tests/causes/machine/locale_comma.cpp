// Cause: a number in a level file is parsed with the user's locale, which expects a comma.
// SPDX-License-Identifier: MIT
#include <clocale>
#include <cstdlib>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  if (tick == 12) game.units[4].velocity = std::strtod("1.5", nullptr);
}

}  // namespace

int main(int argc, char** argv) {
  bool is_mended = false;
  for (int i = 1; i < argc; ++i) is_mended = is_mended || std::strcmp(argv[i], "mended") == 0;
  std::setlocale(is_mended ? LC_MESSAGES : LC_ALL, "");
  return gallery::play("locale_comma", argc, argv, rules);
}
