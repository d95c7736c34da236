// The answer of peer.mjs, read within limits. A damaged answer is an error and never a result.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"
#include "tool/box2d3/box2d3_scene.h"

namespace ticktrue::tool {

/// A body that is not static, after a tick. Box2D's units.
struct Box2d3Body {
  std::uint32_t id = 0;  // index in Scene::bodies
  engine::Point origin;
  double cosine = 1;
  double sine = 0;
  engine::Point velocity;  // dynamic: of the centre of mass; kinematic: of the origin
  double spin = 0;         // rad/s
};

/// A touching pair after a tick. Box2D's units.
struct Box2d3Contact {
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  engine::Point normal;  // from A to B
  int point_count = 0;
  engine::Point point[2];
  double separation[2]{};
  double force[2]{};
};

struct Box2d3Tick {
  std::vector<Box2d3Body> bodies;  // ascending by id; without static and removed bodies
  std::vector<Box2d3Contact> contacts;
};

struct Box2d3Answer {
  std::string package;            // version of box2d3-wasm
  std::vector<Box2d3Tick> ticks;  // those that the plan asks for, in order
  std::uint64_t clamped_tick = 0;
  double ms_per_tick = 0;  // processor time of the steps alone
};

/// `from` begins messages. Errors: corrupt (not what peer.mjs writes for this scene and plan), unsupported (Box2D 3
/// refuses the scene; the message begins with the scene's name).
Result<Box2d3Answer> read_box2d3_answer(std::string_view text, const engine::Scene& scene, const Box2d3Plan& plan,
                                        const std::string& from = "box2d3: the answer of node");

}  // namespace ticktrue::tool
