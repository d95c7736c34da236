// Cached contacts are valid only as long as nothing that determines contacts changes.
// SPDX-License-Identifier: MIT
#include <vector>

#include "base/random.h"
#include "engine/scene/input.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

/// Boxes and discs float in a grid without moving, so that their poses keep their bits until a push.
Scene still_grid(Precision precision, bool bullets) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.settings.auto_substeps.emplace();
  scene.inputs = {engine::InputKind::set_velocity};
  scene.bodies.push_back(ground(20));
  for (int i = 0; i < 20; ++i) {
    const Point place{1.3 * (i % 5), 0.6 + 1.3 * (i / 5)};
    scene.bodies.push_back(i % 3 == 0 ? body_of(disc_shape(0.5), place) : body_of(box_shape(0.5, 0.5), place));
    scene.bodies.back().bullet = bullets && i % 4 == 0;
  }
  return scene;
}

/// Bodies are pushed at times, and most are stopped again. The tick lengths differ.
Session pushes(const Scene& scene, std::uint64_t seed, int tick_count) {
  Random random(seed);
  Session session{"pushes", scene, {}};
  for (int tick = 0; tick < tick_count; ++tick) {
    std::vector<engine::Input> inputs;
    engine::Input input;
    input.kind = engine::InputKind::set_velocity;
    if (tick % 6 == 5)  // some bodies stay in exactly the place where they stopped
      for (std::uint32_t body = 1; body < scene.bodies.size(); ++body) {
        input.body = body;
        input.sequence = body;
        inputs.push_back(input);
      }
    if (tick % 3 == 2 && tick % 6 != 5) {
      input.body = 1 + static_cast<std::uint32_t>(random.below(scene.bodies.size() - 1));
      input.values[0] = random.real(-30, 30);
      input.values[1] = random.real(-30, 30);
      input.values[2] = random.real(-5, 5);
      inputs.push_back(input);
    }
    Bytes bytes;
    engine::encode_inputs(inputs, bytes);
    session.inputs.push_back(bytes);
    session.dts.push_back(random.below(4) == 0 ? 1.0 / 20 : 1.0 / 60);
  }
  return session;
}

}  // namespace

TEST_CASE("cached contacts are those found anew, with speculative contacts",
          "[engine][broad_phase][caches][resting_impacts]") {
  constexpr int tick_count = 90;
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const bool bullets : {false, true})
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        CAPTURE(precision, bullets, seed);
        const Session session = pushes(still_grid(precision, bullets), seed, tick_count);
        engine::EngineOptions cached, anew;
        cached.broad_phase = engine::BroadPhaseKind::aabb_tree;
        anew.broad_phase = engine::BroadPhaseKind::brute_force;  // this broad phase has no cache
        CHECK(tick_hashes(session, tick_count, cached) == tick_hashes(session, tick_count, anew));
      }
}
