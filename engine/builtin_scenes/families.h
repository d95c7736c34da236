// The builders of the built-in scenes, by family, and their parameters; builtin_scenes.cpp has the table.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "engine/builtin_scenes/builtin_scenes.h"

namespace ticktrue::engine {

// thesis.cpp
extern const std::array<SceneParameter, 2> thesis_mix_parameters;
Scene build_thesis(const SceneArguments& arguments);
Scene build_thesis_mix(const SceneArguments& arguments);

// stacks.cpp
extern const std::array<SceneParameter, 4> stack_parameters;
extern const std::array<SceneParameter, 1> pyramid_parameters;
extern const std::array<SceneParameter, 1> card_house_parameters;
extern const std::array<SceneParameter, 2> many_pyramids_parameters;
Scene build_stack(const SceneArguments& arguments);
Scene build_pyramid(const SceneArguments& arguments);
Scene build_large_pyramid(const SceneArguments& arguments);
Scene build_card_house(const SceneArguments& arguments);
Scene build_many_pyramids(const SceneArguments& arguments);

// piles.cpp
extern const std::array<SceneParameter, 5> circles_parameters;
extern const std::array<SceneParameter, 2> mixed_pile_parameters;
extern const std::array<SceneParameter, 2> shapes_parameters;
Scene build_circles(const SceneArguments& arguments);
Scene build_mixed_pile(const SceneArguments& arguments);
Scene build_shapes(const SceneArguments& arguments);

// motions.cpp
extern const std::array<SceneParameter, 3> projectile_parameters;
extern const std::array<SceneParameter, 3> billiards_parameters;
extern const std::array<SceneParameter, 2> slide_parameters;
extern const std::array<SceneParameter, 2> sensors_parameters;
Scene build_projectile(const SceneArguments& arguments);
Scene build_billiards(const SceneArguments& arguments);
Scene build_slide(const SceneArguments& arguments);
Scene build_sensors(const SceneArguments& arguments);

// linked.cpp
extern const std::array<SceneParameter, 1> pendulum_parameters;
extern const std::array<SceneParameter, 3> chain_parameters;
extern const std::array<SceneParameter, 1> bridge_parameters;
extern const std::array<SceneParameter, 1> joint_grid_parameters;
Scene build_pendulum(const SceneArguments& arguments);
Scene build_chain(const SceneArguments& arguments);
Scene build_bridge(const SceneArguments& arguments);
Scene build_joint_grid(const SceneArguments& arguments);

// benchmarks.cpp
extern const std::array<SceneParameter, 1> tumbler_parameters;
extern const std::array<SceneParameter, 2> smash_parameters;
extern const std::array<SceneParameter, 1> spinner_parameters;
extern const std::array<SceneParameter, 4> rain_parameters;
extern const std::array<SceneParameter, 3> gas_parameters;
extern const std::array<SceneParameter, 3> loose_parameters;
extern const std::array<SceneParameter, 2> resting_parameters;
Scene build_tumbler(const SceneArguments& arguments);
Scene build_smash(const SceneArguments& arguments);
Scene build_spinner(const SceneArguments& arguments);
Scene build_rain(const SceneArguments& arguments);
Scene build_gas(const SceneArguments& arguments);
Scene build_loose(const SceneArguments& arguments);
Scene build_resting(const SceneArguments& arguments);

}  // namespace ticktrue::engine
