// Clean: a pile of boxes in Bullet.
// SPDX-License-Identifier: MIT
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "tests/causes/game.h"

namespace {

constexpr std::uint32_t body_count = gallery::unit_count * 4;

struct Pile {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broad_phase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broad_phase, &solver, &configuration};
  btBoxShape ground_shape{btVector3(20, 1, 20)};
  btBoxShape box_shape{btVector3(btScalar(0.5), btScalar(0.4), btScalar(0.3))};
  std::vector<std::unique_ptr<btRigidBody>> bodies;

  Pile() {
    world.setGravity(btVector3(0, -10, 0));
    bodies.push_back(std::make_unique<btRigidBody>(btScalar(0), nullptr, &ground_shape));
    for (std::uint32_t i = 0; i < body_count; ++i) {
      btVector3 inertia(0, 0, 0);
      box_shape.calculateLocalInertia(1, inertia);
      btRigidBody::btRigidBodyConstructionInfo info(1, nullptr, &box_shape, inertia);
      info.m_startWorldTransform.setIdentity();
      info.m_startWorldTransform.setOrigin(
          btVector3(btScalar(0.3) * btScalar(i % 5), btScalar(2 + 0.9 * i), btScalar(0.1) * btScalar(i % 3)));
      bodies.push_back(std::make_unique<btRigidBody>(info));
    }
    for (const auto& body : bodies) world.addRigidBody(body.get());
  }
  ~Pile() {
    for (const auto& body : bodies) world.removeRigidBody(body.get());
  }
};

void rules(gallery::Game& game, std::uint64_t, bool) {
  static Pile pile;
  for (int i = 0; i < 4; ++i) pile.world.stepSimulation(btScalar(1) / 60, 0);
  for (std::uint32_t i = 0; i < gallery::unit_count; ++i) {
    game.units[i].position = pile.bodies[1 + i * 4]->getWorldTransform().getOrigin().y();
    game.units[i].velocity = pile.bodies[1 + i * 4]->getAngularVelocity().z();
  }
}

}  // namespace

int main(int argc, char** argv) {
  return gallery::play("bullet_pile", argc, argv, rules);
}
