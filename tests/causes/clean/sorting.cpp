// Clean: sorts by keys that end with an id, and stable sorts of equal keys.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <numeric>
#include <tuple>
#include <vector>

#include "tests/causes/game.h"

namespace {

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  std::vector<std::uint32_t> ids(gallery::unit_count);
  std::iota(ids.begin(), ids.end(), 0u);
  std::stable_sort(ids.begin(), ids.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return game.units[a].score / 4 < game.units[b].score / 4; });
  game.units[ids[tick % gallery::unit_count]].score += 3;
  std::sort(ids.begin(), ids.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(game.units[a].score, a) < std::tuple(game.units[b].score, b);
  });
  double sum = 0;
  for (const std::uint32_t id : ids) sum = 0.5 * sum + game.units[id].position;
  game.units[ids.front()].velocity += 1e-3 * sum;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("sorting", argc, argv, rules);
}
