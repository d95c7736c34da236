// Structures that arrangements never make: rows of links, bodies with many contacts, rings that close in, shots.
// SPDX-License-Identifier: MIT
//
// They reach what only many constraints of one body or one island reach: batches of joints in serial order, the last
// colours of contacts; what only bodies of unlike sizes reach that meet from every side, in touch with others; and what
// only a body reaches that hardly moves until one input sends it through a wall within a tick.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

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
  room -= plan.plate_body_count;
  if (draw.chance(8)) plan.ring_body_count = draw_count(draw, 8, 25, room);
  // The contacts of a body that bounces are solved again at one pose.
  if (plan.ring_body_count > 0 && plan.settings.integrator == IntegratorKind::semi_implicit_euler && draw.half()) {
    plan.features[static_cast<std::size_t>(WorldFeature::locate_impacts)] = true;
    plan.settings.locate_impacts = true;
  }
  room -= plan.ring_body_count;
  // What else sweeps every box leaves nothing to find.
  const Settings& settings = plan.settings;
  const bool sweeps_fast_alone = settings.continuous && !settings.locate_impacts && !settings.auto_substeps;
  if (!draw.chance(sweeps_fast_alone ? 40 : 4)) return;
  plan.shot_count = draw_count(draw, 3, 5, room);  // the wall is one of them
  const auto shoots = [](InputKind kind) { return kind == InputKind::set_velocity || kind == InputKind::impulse; };
  if (plan.shot_count > 0 && std::none_of(plan.inputs.begin(), plan.inputs.end(), shoots))
    plan.inputs.push_back(InputKind::set_velocity);
}

void WorldBuilder::add_structures() {
  if (plan.link_count > 0) add_links(plan.link_count);
  if (plan.plate_body_count > 0) add_plate(plan.plate_body_count);
  if (plan.ring_body_count > 0) add_ring(plan.ring_body_count);
  if (plan.shot_count > 0) add_shots(plan.shot_count);
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

void WorldBuilder::add_ring(std::uint32_t count) {
  constexpr Point directions[] = {{1, 0},  {0.8, 0.6},   {0.6, 0.8},   {0, 1},  {-0.6, 0.8}, {-0.8, 0.6},
                                  {-1, 0}, {-0.8, -0.6}, {-0.6, -0.8}, {0, -1}, {0.6, -0.8}, {0.8, -0.6}};
  const double radius = size * draw.one_of({1, 2, 4, 64});
  const double small = size * draw.one_of({0.0625, 0.125, 0.25});
  const bool is_disc = draw.half();
  const Point center{lower.x, upper.y + 4 * radius};
  Body large;
  large.type = BodyType::dynamic_body;
  large.shapes.push_back(is_disc ? circle(radius) : box(radius, radius));
  push(std::move(large), {center, 0, {}, 0});
  scene.bodies.back().angle = 0;
  for (std::uint32_t i = 0; i + 1 < count; ++i) {
    const Point to = directions[i % std::size(directions)];
    const double surface = is_disc ? radius : radius / std::max(std::abs(to.x), std::abs(to.y));
    // Those of one direction follow each other without touching.
    const std::size_t row = i / std::size(directions);
    const double distance = surface + small * (4.0 * static_cast<double>(row) + draw.part(16, 32, 16));
    const double speed = size * draw.one_of({0.5, 2, 8, 32});
    Body body;
    body.type = BodyType::dynamic_body;
    body.shapes.push_back(circle(small));
    push(std::move(body),
         {{center.x + distance * to.x, center.y + distance * to.y}, 0, {-speed * to.x, -speed * to.y}, 0});
  }
}

void WorldBuilder::add_shots(std::uint32_t count) {
  const Point start{upper.x + 4 * size, upper.y + 2 * size};
  Body wall;
  wall.type = BodyType::static_body;
  wall.shapes.push_back(box(size / 16, size * count));
  push(std::move(wall), {{start.x + size * draw.one_of({1, 2, 4}), start.y}, 0, {}, 0});
  scene.bodies.back().angle = 0;
  for (std::uint32_t i = 0; i + 1 < count; ++i) {
    Body body;
    body.type = BodyType::dynamic_body;
    body.name = shot_prefix + std::to_string(i);
    body.shapes.push_back(circle(size / 4));
    body.gravity_scale = 0;
    // m/s, along the wall: slow enough for a box with a margin, which a body at rest has no use for
    const double drift = draw.chance(25) ? 0 : size / 256;
    push(std::move(body), {{start.x, start.y + size * i}, 0, {0, drift}, 0});
  }
}

}  // namespace ticktrue::engine
