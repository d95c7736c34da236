// Clean: a pile of boxes in Box2D 2.4.
// SPDX-License-Identifier: MIT
#include <box2d/box2d.h>

#include "tests/causes/game.h"

namespace {

struct Pile {
  b2World world{b2Vec2(0.0f, -10.0f)};
  b2Body* bodies[gallery::unit_count * 4] = {};

  Pile() {
    b2BodyDef ground;
    b2PolygonShape shape;
    shape.SetAsBox(20.0f, 1.0f);
    world.CreateBody(&ground)->CreateFixture(&shape, 0.0f);
    for (std::uint32_t i = 0; i < gallery::unit_count * 4; ++i) {
      b2BodyDef body;
      body.type = b2_dynamicBody;
      body.position.Set(0.3f * static_cast<float>(i % 5), 2.0f + 0.9f * static_cast<float>(i));
      body.angle = 0.25f * static_cast<float>(i);
      shape.SetAsBox(0.5f, 0.4f);
      bodies[i] = world.CreateBody(&body);
      bodies[i]->CreateFixture(&shape, 1.0f);
    }
  }
};

void rules(gallery::Game& game, std::uint64_t, bool) {
  static Pile pile;
  for (int i = 0; i < 4; ++i) pile.world.Step(1.0f / 60, 8, 3);
  for (std::uint32_t i = 0; i < gallery::unit_count; ++i) {
    game.units[i].position = static_cast<double>(pile.bodies[i * 4]->GetPosition().y);
    game.units[i].velocity = static_cast<double>(pile.bodies[i * 4]->GetAngularVelocity());
  }
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("box2d_pile", argc, argv, rules);
}
