// A rollback game on Box2D 2.4 that saves the positions and speeds of its bodies. Box2D keeps more state in its own
// blocks, such as contacts with their starting impulses. With `mended`, each tick rebuilds the world from saved values.
// SPDX-License-Identifier: MIT
#include <box2d/box2d.h>

#include <cstring>
#include <memory>

#include "include/ticktrue.h"

namespace {

constexpr std::uint32_t box_count = 4;
constexpr std::uint64_t tick_count = 48;

struct Box {
  float x, y, angle, vx, vy, spin;
};

/// The recorded and saved values.
struct State {
  std::uint64_t tick = 0;
  Box boxes[box_count];
};

struct Game {
  State state;
  std::unique_ptr<b2World> world;
  b2Body* bodies[box_count] = {};

  void make_world() {
    world = std::make_unique<b2World>(b2Vec2(0.0f, -10.0f));
    b2BodyDef ground;
    b2PolygonShape shape;
    shape.SetAsBox(20.0f, 1.0f);
    world->CreateBody(&ground)->CreateFixture(&shape, 0.0f);
    for (std::uint32_t i = 0; i < box_count; ++i) {
      const Box& box = state.boxes[i];
      b2BodyDef body;
      body.type = b2_dynamicBody;
      body.position.Set(box.x, box.y);
      body.angle = box.angle;
      body.linearVelocity.Set(box.vx, box.vy);
      body.angularVelocity = box.spin;
      shape.SetAsBox(0.5f, 0.4f);
      bodies[i] = world->CreateBody(&body);
      bodies[i]->CreateFixture(&shape, 1.0f);
    }
  }

  void step(std::uint8_t button) {
    if (button != 0) bodies[box_count - 1]->ApplyLinearImpulseToCenter(b2Vec2(0.5f, 0.0f), true);
    world->Step(1.0f / 60, 8, 3);
    for (std::uint32_t i = 0; i < box_count; ++i)
      state.boxes[i] = {
          bodies[i]->GetPosition().x,       bodies[i]->GetPosition().y,       bodies[i]->GetAngle(),
          bodies[i]->GetLinearVelocity().x, bodies[i]->GetLinearVelocity().y, bodies[i]->GetAngularVelocity()};
    ++state.tick;
  }
};

std::size_t save(void* user, void* buffer, std::size_t size) {
  if (size >= sizeof(State)) std::memcpy(buffer, &static_cast<const Game*>(user)->state, sizeof(State));
  return sizeof(State);
}

int load(void* user, const void* bytes, std::size_t size) {
  auto& game = *static_cast<Game*>(user);
  if (size != sizeof(State)) return 1;
  std::memcpy(&game.state, bytes, size);
  for (std::uint32_t i = 0; i < box_count; ++i) {
    const Box& box = game.state.boxes[i];
    game.bodies[i]->SetTransform(b2Vec2(box.x, box.y), box.angle);
    game.bodies[i]->SetLinearVelocity(b2Vec2(box.vx, box.vy));
    game.bodies[i]->SetAngularVelocity(box.spin);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  static Game game;
  bool is_mended = false;
  for (int i = 1; i < argc; ++i) is_mended = is_mended || std::strcmp(argv[i], "mended") == 0;
  for (std::uint32_t i = 0; i < box_count; ++i)
    game.state.boxes[i] = {0.25f * static_cast<float>(i), 1.5f + 0.875f * static_cast<float>(i), 0, 0, 0, 0};
  game.make_world();
  ticktrue_options options{};
  options.struct_size = sizeof options;
  options.name = "box2d-rollback";
  options.save = save;
  options.load = load;
  options.user = &game;
  ticktrue_session* session = ticktrue_open_arguments(&options, argc, argv);
  ticktrue_column(session, "world", "tick", &game.state.tick, TICKTRUE_U64, 1, 1, 0);
  Box* boxes = game.state.boxes;
  ticktrue_column(session, "boxes", "position", &boxes->x, TICKTRUE_F32, 3, box_count, sizeof *boxes);
  ticktrue_column(session, "boxes", "velocity", &boxes->vx, TICKTRUE_F32, 3, box_count, sizeof *boxes);
  while (game.state.tick < tick_count) {
    std::uint8_t button = game.state.tick % 40 == 30 ? 1 : 0;
    if (ticktrue_input(session, &button, sizeof button) != TICKTRUE_OK) break;
    if (ticktrue_begin_tick(session, nullptr) != TICKTRUE_OK) break;
    if (is_mended) game.make_world();
    game.step(button);
    if (ticktrue_end_tick(session) != TICKTRUE_OK) break;
  }
  return ticktrue_close(session);
}
