// A scene as peer.mjs reads it: JSON in Box2D's units. Scenes that Box2D 3 cannot represent are refused by name.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

struct Box2d3Options {
  int substeps = 4;  // of a step: Box2D's recommendation
  int steps_per_tick = 1;
  double time_max_s = 300;                               // of node; then it is killed
  std::size_t answer_size_max = std::size_t{256} << 20;  // bytes
};

/// What a run reports. A run takes all of its ticks at once.
struct Box2d3Plan {
  std::uint64_t tick_count = 0;
  std::uint64_t body_interval = 1;     // bodies are reported after each tick that is a multiple
  std::uint64_t contact_window = 0;    // contacts are reported within so many ticks before the end,
  std::uint64_t contact_interval = 1;  // at the last of them and so many ticks apart
  bool warm_up = false;                // runs the scene once before, so that node has compiled all that is timed
};

/// `length_scale`: Box2D lengths over scene lengths. Errors: unsupported, with the place in the scene.
Result<std::string> box2d3_scene_text(const engine::Scene& scene, const Box2d3Options& options, const Box2d3Plan& plan,
                                      double length_scale);

}  // namespace ticktrue::tool
