// Cause: Chipmunk reports separating bodies in the order of their shapes' addresses, and the first one scores most.
// SPDX-License-Identifier: MIT
#include <chipmunk/chipmunk.h>

#include <algorithm>
#include <vector>

#include "tests/causes/game.h"

namespace {

struct Court {
  cpSpace* space = cpSpaceNew();
  cpBody* balls[gallery::unit_count] = {};
  std::vector<std::uint32_t> parted;  // in this tick
};

void note(cpArbiter* arbiter, cpSpace*, void* with) {
  CP_ARBITER_GET_BODIES(arbiter, one, other);
  auto& court = *static_cast<Court*>(with);
  for (std::uint32_t i = 0; i < gallery::unit_count; ++i)
    if (court.balls[i] == one || court.balls[i] == other) court.parted.push_back(i);
}

Court* make_court() {
  auto* court = new Court;
  cpSpaceSetGravity(court->space, cpv(0, -10));
  cpSpaceAddShape(court->space, cpSegmentShapeNew(cpSpaceGetStaticBody(court->space), cpv(-20, 0), cpv(20, 0), 0));
  for (std::uint32_t i = 0; i < gallery::unit_count; ++i) {
    court->balls[i] = cpSpaceAddBody(court->space, cpBodyNew(1, 1));
    cpBodySetPosition(court->balls[i], cpv(2.0 * i, 0.5));
    cpSpaceAddShape(court->space, cpCircleShapeNew(court->balls[i], 0.5, cpv(0, 0)));
  }
  cpCollisionHandler* handler = cpSpaceAddDefaultCollisionHandler(court->space);
  handler->separateFunc = note;
  handler->userData = court;
  return court;
}

void rules(gallery::Game& game, std::uint64_t tick, bool is_mended) {
  static Court* court = make_court();
  if (tick % 20 == 10)
    for (cpBody* ball : court->balls) cpBodySetVelocity(ball, cpv(0, 3));
  court->parted.clear();
  cpSpaceStep(court->space, 1.0 / 64);
  if (is_mended) std::sort(court->parted.begin(), court->parted.end());
  std::int64_t score = gallery::unit_count;
  for (const std::uint32_t i : court->parted) game.units[i].score += score--;
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("chipmunk_separate", argc, argv, rules);
}
