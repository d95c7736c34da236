// Structures that arrangements never make: a row of many links, a body with many contacts.
// SPDX-License-Identifier: MIT
//
// They reach what only many constraints of one body or one island reach: batches of joints in serial order, the last
// colours of contacts.
#include "engine/builtin_scenes/pieces.h"
#include "engine/random_worlds/world_builder.h"

namespace ticktrue::engine {
namespace {

/// From `least` on, or 0 where there is no room.
std::uint32_t draw_count(Draw& draw, std::uint32_t least, std::uint32_t more, std::uint32_t room) {
  const std::uint32_t count = least + draw.below(more);
  return count <= room ? count : 0;
}

}  // namespace

void draw_structures(Draw draw, const RandomWorldOptions& options, WorldPlan& plan) {
  if (!plan.collides || plan.is_plain() || plan.body_count >= options.body_count_max) return;
  std::uint32_t room = options.body_count_max - plan.body_count;
  if (plan.carries_joints() && draw.chance(10)) plan.link_count = draw_count(draw, 9, 72, room);
  room -= plan.link_count;
  if (draw.chance(6)) plan.plate_body_count = draw_count(draw, 34, 30, room);
}

void WorldBuilder::add_structures() {
  if (plan.link_count > 0) add_links(plan.link_count);
  if (plan.plate_body_count > 0) add_plate(plan.plate_body_count);
}

void WorldBuilder::add_links(std::uint32_t count) {
  const Point start{lower.x, upper.y + 2 * size};
  const bool is_pinned = scene.bodies[0].type == BodyType::static_body && scene.bodies[0].angle == 0 && draw.half();
  const bool is_disc = draw.half();
  const auto first = static_cast<std::uint32_t>(scene.bodies.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    Body body;
    body.type = BodyType::dynamic_body;
    body.shapes.push_back(is_disc ? circle(size / 4) : box(size / 2, size / 8));
    push(std::move(body), {{start.x + size * i, start.y}, 0, {}, 0});
    scene.bodies.back().angle = 0;
    if (i == 0 && !is_pinned) continue;
    Joint joint;
    joint.kind = JointKind::revolute;
    joint.body_b = first + i;
    joint.body_a = i == 0 ? 0 : joint.body_b - 1;
    joint.anchor_b = {-size / 2, 0};
    joint.anchor_a = {size / 2, 0};
    if (i == 0)
      joint.anchor_a = {start.x - size / 2 - scene.bodies[0].position.x, start.y - scene.bodies[0].position.y};
    scene.joints.push_back(joint);
  }
}

void WorldBuilder::add_plate(std::uint32_t count) {
  const Point start{lower.x, upper.y + 2 * size};
  const double half = size * count / 2;
  Body plate;
  plate.type = BodyType::dynamic_body;
  plate.shapes.push_back(box(half, size / 4));
  push(std::move(plate), {{start.x + half, start.y}, 0, {}, 0});
  scene.bodies.back().angle = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    Body body;
    body.type = BodyType::dynamic_body;
    body.shapes.push_back(circle(size / 2));
    push(std::move(body), {{start.x + size * (i + 0.5), start.y + size * 0.75}, 0, {}, 0});
  }
}

}  // namespace ticktrue::engine
