// Structures that arrangements never make: rows and nets of links, crowded bodies, rings that close in, shots.
// SPDX-License-Identifier: MIT
//
// Each structure reaches code that arrangements do not. Many constraints of one body or island reach serial batches of
// joints and the last colours of contacts. Rings bring bodies of unequal sizes together from every side, in touch with
// others. Shots send a body that hardly moves through a wall within a tick. Nets, on whose bodies only joints act,
// reach the wavefront sweep.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "engine/builtin_scenes/pieces.h"
#include "engine/random_worlds/world_builder.h"

namespace ticktrue::engine {
namespace {

/// At least `least`, or 0 if there is no room.
std::uint32_t draw_count(Draw& draw, std::uint32_t least, std::uint32_t more, std::uint32_t room) {
  const std::uint32_t count = least + draw.below(more);
  return count <= room ? count : 0;
}

/// The net becomes the whole world. Its shapes collide with nothing.
void draw_net(Draw& draw, const RandomWorldOptions& options, WorldPlan& plan) {
  if (plan.settings.solver != SolverKind::tgs_soft || !plan.carries_joints() || !draw.chance(12)) return;
  const std::uint32_t columns = 2 + draw.below(9), rows = 2 + draw.below(9);
  if (columns * rows > options.body_count_max) return;
  plan.net_columns = columns;
  plan.net_rows = rows;
  plan.collides = false;
  if (draw.chance(80)) {
    // Only these settings allow the wavefront sweep.
    plan.settings.integrator = IntegratorKind::semi_implicit_euler;
    plan.settings.auto_substeps.reset();
    plan.settings.sleep.reset();
    plan.forces.clear();
    plan.joints.clear();
  }
  plan.body_count = plan.link_count = plan.plate_body_count = plan.ring_body_count = plan.shot_count = 0;
}

void draw_shots(Draw& draw, std::uint32_t room, WorldPlan& plan) {
  // With other settings the boxes of all bodies are swept, and a shot shows no error.
  const Settings& settings = plan.settings;
  const bool sweeps_fast_alone = settings.continuous && !settings.locate_impacts && !settings.auto_substeps;
  if (!draw.chance(sweeps_fast_alone ? 40 : 4)) return;
  plan.shot_count = draw_count(draw, 3, 5, room);  // the wall is one of them
  const auto shoots = [](InputKind kind) { return kind == InputKind::set_velocity || kind == InputKind::impulse; };
  if (plan.shot_count > 0 && std::none_of(plan.inputs.begin(), plan.inputs.end(), shoots))
    plan.inputs.push_back(InputKind::set_velocity);
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
  // The contacts of a body that bounces are solved again at the same pose.
  if (plan.ring_body_count > 0 && plan.settings.integrator == IntegratorKind::semi_implicit_euler && draw.half()) {
    plan.features[static_cast<std::size_t>(WorldFeature::locate_impacts)] = true;
    plan.settings.locate_impacts = true;
  }
  room -= plan.ring_body_count;
  draw_shots(draw, room, plan);
  draw_net(draw, options, plan);
}

void WorldBuilder::add_structures() {
  if (plan.link_count > 0) add_links(plan.link_count);
  if (plan.plate_body_count > 0) add_plate(plan.plate_body_count);
  if (plan.ring_body_count > 0) add_ring(plan.ring_body_count);
  if (plan.shot_count > 0) add_shots(plan.shot_count);
  if (plan.net_columns > 0) add_net(plan.net_columns, plan.net_rows);
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

void WorldBuilder::add_net(std::uint32_t columns, std::uint32_t rows) {
  const bool is_mixed = draw.half();
  const auto first = static_cast<std::uint32_t>(scene.bodies.size());
  const auto join = [&](std::uint32_t a, std::uint32_t b, Point anchor) {
    const auto is_static = [&](std::uint32_t body) { return scene.bodies[body].type == BodyType::static_body; };
    if (is_static(a) && is_static(b)) return;
    Joint joint;
    joint.kind = JointKind::revolute;
    joint.body_a = a;
    joint.body_b = b;
    joint.anchor_a = anchor;
    joint.anchor_b = {-anchor.x, -anchor.y};
    const std::uint32_t choice = is_mixed ? draw.below(8) : 0;
    if (choice == 5) joint.limits = Range{-0.25, 0.25};
    if (choice == 6) joint.spring = JointSpring{false, 4, 0.5, 0, 0};
    if (choice == 7) joint.motor = JointMotor{1, 0.5};
    scene.joints.push_back(joint);
  };
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const bool is_peg = row == 0 && (column == 0 || column + 1 == columns);
      const auto body_number = static_cast<std::uint32_t>(scene.bodies.size());
      Body body;
      body.type = is_peg ? BodyType::static_body : BodyType::dynamic_body;
      body.shapes.push_back(circle(size / 4));
      body.shapes[0].filter.mask = 0;
      const Point velocity = draw.chance(20) ? Point{size * draw.part(-4, 4, 1), 0} : Point{};
      push(std::move(body), {{size * column, -size * row}, 0, is_peg ? Point{} : velocity, 0});
      scene.bodies.back().angle = 0;
      if (row > 0) join(body_number - columns, body_number, {0, -size / 2});
      if (column > 0) join(body_number - 1, body_number, {size / 2, 0});
    }
  // Slack ropes: the joints of a body are far apart in the order, and in levels.
  for (std::uint32_t i = draw.below(4); i > 0; --i) {
    Joint rope;
    rope.kind = JointKind::distance;
    rope.body_a = first + draw.below(columns * rows);
    rope.body_b = first + draw.below(columns * rows);
    rope.limits = Range{0, 4 * size * (columns + rows)};
    if (rope.body_a != rope.body_b && scene.bodies[rope.body_b].type == BodyType::dynamic_body)
      scene.joints.push_back(rope);
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
    // Bodies of one direction follow each other without touching.
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
    // m/s, along the wall: slow enough for a box with a margin. A body at rest needs no margin.
    const double drift = draw.chance(25) ? 0 : size / 256;
    push(std::move(body), {{start.x, start.y + size * i}, 0, {0, drift}, 0});
  }
}

}  // namespace ticktrue::engine
