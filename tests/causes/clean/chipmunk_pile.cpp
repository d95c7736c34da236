// Clean: a pile of boxes in Chipmunk 7.
// SPDX-License-Identifier: MIT
#include <chipmunk/chipmunk.h>

#include "tests/causes/game.h"

namespace {

constexpr std::uint32_t body_count = gallery::unit_count * 4;

struct Pile {
  cpSpace* space = cpSpaceNew();
  cpBody* bodies[body_count] = {};

  Pile() {
    cpSpaceSetGravity(space, cpv(0, -10));
    cpShape* ground = cpSegmentShapeNew(cpSpaceGetStaticBody(space), cpv(-20, 0), cpv(20, 0), 0.1);
    cpShapeSetFriction(ground, 0.6);
    cpSpaceAddShape(space, ground);
    for (std::uint32_t i = 0; i < body_count; ++i) {
      bodies[i] = cpSpaceAddBody(space, cpBodyNew(1, cpMomentForBox(1, 1, 0.8)));
      cpBodySetPosition(bodies[i], cpv(0.3 * (i % 5), 2 + 0.9 * i));
      cpBodySetAngle(bodies[i], 0.25 * i);
      cpShape* box = cpSpaceAddShape(space, cpBoxShapeNew(bodies[i], 1, 0.8, 0));
      cpShapeSetFriction(box, 0.6);
    }
  }
};

void rules(gallery::Game& game, std::uint64_t, bool) {
  static Pile pile;
  for (int i = 0; i < 4; ++i) cpSpaceStep(pile.space, 1.0 / 60);
  for (std::uint32_t i = 0; i < gallery::unit_count; ++i) {
    game.units[i].position = cpBodyGetPosition(pile.bodies[i * 4]).y;
    game.units[i].velocity = cpBodyGetAngularVelocity(pile.bodies[i * 4]);
  }
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("chipmunk_pile", argc, argv, rules);
}
