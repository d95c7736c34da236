// Random worlds: a scene and a session from a seed, each with a random subset of everything that scenes can have.
// SPDX-License-Identifier: MIT
// Source: Groce, Zhang, Eide, Chen and Regehr, "Swarm testing", 2012 (random subsets of features find more than all).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/scene/scene.h"

namespace ticktrue::engine {

struct RandomWorldOptions {
  std::uint32_t body_count_max = 3000;
  std::uint32_t tick_count_max = 600;
};

struct RandomWorld {
  Scene scene;                // check_scene accepts the scene
  std::vector<Input> inputs;  // ascending (tick, player, sequence). The last one may be `end`, at tick_count
  std::uint64_t tick_count = 0;
  std::vector<std::string> rows;  // rows_of_world
};

/// The world of a seed: the same on every platform.
RandomWorld random_world(std::uint64_t seed, const RandomWorldOptions& options = {});

/// All rows that a world can have, as "table/row", in table order: "shape/capsule", "joint/weld", "input/spawn". Every
/// row of every table of choices is included. The table "feature" lists features without a table.
std::vector<std::string> random_world_rows();

/// The rows that a world has, in the order of random_world_rows: read from the scene and the inputs.
std::vector<std::string> rows_of_world(const RandomWorld& world);

/// The world without a row: shapes become circles or boxes, joints and inputs of a kind go, a choice falls back to its
/// The world without a row: shapes become circles or boxes, and joints and inputs of the kind are removed. A choice
/// falls back to its default or, if the row is the default, to the first other choice that check_scene accepts.
/// Nothing if the world does not have the row, or if no legal world without the row exists.
std::optional<RandomWorld> without_row(const RandomWorld& world, const std::string& row);

/// Whether a row may change the bits of a state. Broad phases, clocks and `end` never do. Neither does a solver that
/// solves nothing: where it may be chosen, other solvers have nothing to solve either.
bool row_changes_bits(const std::string& row);

}  // namespace ticktrue::engine
