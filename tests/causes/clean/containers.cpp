// Clean: maps, sets and lists by id, built and destroyed in every tick.
// SPDX-License-Identifier: MIT
#include <list>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tests/causes/game.h"

namespace {

struct Effect {
  std::uint32_t target;
  std::string name;
};

void rules(gallery::Game& game, std::uint64_t tick, bool) {
  static std::map<std::uint32_t, std::unique_ptr<Effect>> effects;
  static std::set<std::string> names;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const auto id = static_cast<std::uint32_t>((tick * 31 + i * 7) % 101);
    effects[id] =
        std::make_unique<Effect>(Effect{id % gallery::unit_count, "effect of a long name " + std::to_string(id)});
    names.insert(effects[id]->name);
  }
  std::list<std::vector<std::int64_t>> history;
  for (const auto& [id, effect] : effects) {
    history.emplace_back(id + 1, static_cast<std::int64_t>(effect->name.size()));
    game.units[effect->target].score += history.back().back();
  }
  if (tick % 9 == 8) effects.clear();
  game.units[0].score += static_cast<std::int64_t>(names.size());
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("containers", argc, argv, rules);
}
