// Clean: numbers become text and numbers again, with functions that ignore the locale. The program sets one.
// SPDX-License-Identifier: MIT
#include <charconv>
#include <clocale>
#include <string>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  for (gallery::Unit& unit : game.units) {
    char text[64];
    const auto end = std::to_chars(text, text + sizeof text, unit.position + 0.1 * static_cast<double>(tick));
    std::string line(text, end.ptr);
    double again = 0;
    std::from_chars(line.data(), line.data() + line.size(), again);
    unit.velocity += 1e-3 * again;
    unit.score += static_cast<std::int64_t>(line.size());
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::setlocale(LC_ALL, "");
  return gallery::play("texts", argc, argv, rules);
}
