// Cause: units are served in the order of their addresses.
// SPDX-License-Identifier: MIT
#include <map>
#include <memory>
#include <vector>

#include "tests/causes/game.h"

namespace {

struct Entity {
  std::uint32_t id;
};
std::vector<std::unique_ptr<Entity>> entities;

void serve(gallery::Game& game, std::uint32_t id, double& sum) {
  sum = sum * 0.5 + game.units[id].position;
  game.units[id].velocity += 1e-3 * sum;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  if (tick == 5)
    for (std::uint32_t id = 0; id < gallery::unit_count; ++id) entities.push_back(std::make_unique<Entity>(Entity{id}));
  if (tick < 5) return;
  double sum = 0;
  if (is_mended) {
    for (const auto& entity : entities) serve(game, entity->id, sum);
    return;
  }
  std::map<const Entity*, std::uint32_t> by_address;
  for (const auto& entity : entities) by_address[entity.get()] = entity->id;
  for (const auto& [entity, id] : by_address) serve(game, id, sum);
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("pointer_order", argc, argv, rules);
}
