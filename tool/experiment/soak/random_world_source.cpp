// Adapts the worlds of engine/random_worlds to the soak.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/random_world.h"
#include "tool/experiment/soak/soak.h"

namespace ticktrue::soak {

WorldSource random_worlds() {
  WorldSource source;
  source.make = [](std::uint64_t seed) {
    engine::RandomWorld world = engine::random_world(seed);
    return WorldSource::World{{std::move(world.scene), std::move(world.inputs), world.tick_count},
                              std::move(world.rows)};
  };
  source.without = [](std::uint64_t seed, const std::string& row) -> std::optional<SoakCase> {
    auto without = engine::without_row(engine::random_world(seed), row);
    if (!without) return std::nullopt;
    return SoakCase{std::move(without->scene), std::move(without->inputs), without->tick_count};
  };
  source.choices = engine::random_world_rows();
  source.choice_changes_bits = engine::row_changes_bits;
  return source;
}

}  // namespace ticktrue::soak
