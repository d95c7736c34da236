// Contacts solved in blocks of islands, and updated in place, give the bits of a single solver set without caches.
// SPDX-License-Identifier: MIT
//
// Verified: enough pyramids for several blocks. Boxes are removed and thrown between pyramids, and discs fall in, so
// that islands merge and split. The runs include sleep. threads_test.cpp forces blocks of a few contacts on every
// scene.
#include <vector>

#include "base/build_info.h"
#include "base/parallel/chunk_order.h"
#include "base/random.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/input.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

constexpr std::uint64_t blocks_tick_count = 80;

/// Resting pyramids. Some of their boxes are then thrown, some are removed, and discs fall in.
Session disturbed_pyramids(Precision precision, bool sleeps) {
  Result<engine::Scene> scene = engine::make_builtin_scene("many_pyramids?rows=4&columns=4");
  REQUIRE(scene.has_value());
  scene->settings.precision = precision;
  if (sleeps) {
    scene->settings.sleep.emplace();
    scene->settings.sleep->after_s = 0.2;
  }
  scene->prototypes = {body_of(disc_shape(0.4), {})};
  scene->prototypes[0].name = "disc";
  scene->inputs = {engine::InputKind::spawn, engine::InputKind::remove, engine::InputKind::set_velocity};
  Session session{"disturbed pyramids", *scene, {}};
  Random random(7);
  for (std::uint64_t tick = 0; tick < blocks_tick_count; ++tick) {
    std::vector<engine::Input> inputs;
    engine::Input input;
    input.body = 1 + static_cast<std::uint32_t>(random.below(scene->bodies.size() - 1));
    if (tick >= 24 && tick % 8 == 0) {
      input.kind = engine::InputKind::set_velocity;
      input.values[0] = random.real(-40, 40);
      input.values[1] = random.real(0, 10);
      inputs.push_back(input);
    } else if (tick == 22 || tick % 16 == 10) {  // falls for some ticks before the first contact
      input.kind = engine::InputKind::spawn;
      input.values[0] = random.real(-40, 40);
      input.values[1] = 30;
      inputs.push_back(input);
    } else if (tick >= 24 && tick % 16 == 5) {
      input.kind = engine::InputKind::remove;
      inputs.push_back(input);
    }
    Bytes bytes;
    engine::encode_inputs(inputs, bytes);
    session.inputs.push_back(bytes);
  }
  return session;
}

/// Thirty ticks. `change` fills the input of a tick, and returns whether the tick has one.
template <typename Change>
Session thirty_ticks(const Scene& scene, Change change) {
  Session session{"thirty ticks", scene, {}};
  for (std::uint64_t tick = 0; tick < 30; ++tick) {
    engine::Input input;
    input.kind = scene.inputs[0];
    Bytes bytes;
    if (change(tick, input)) engine::encode_inputs({input}, bytes);
    session.inputs.push_back(bytes);
  }
  return session;
}

/// Checks that caches change no bit.
void check_cached(const Session& session) {
  engine::EngineOptions cached, anew;
  cached.broad_phase = engine::BroadPhaseKind::aabb_tree;
  anew.broad_phase = engine::BroadPhaseKind::brute_force;
  CHECK(tick_hashes(session, 30, cached) == tick_hashes(session, 30, anew));
}

/// The bodies and contacts after every fifth tick.
std::vector<Bytes> run_of(const Session& session, const engine::EngineOptions& options) {
  std::vector<Bytes> out;
  const auto engine = make_engine_or_fail(session.scene, options);
  for (std::uint64_t tick = 0; tick < blocks_tick_count; ++tick) {
    REQUIRE(engine->step(input_of(session, tick), nullptr));
    if (tick % 5 != 4) continue;
    Bytes& bytes = out.emplace_back();
    const StateView& state = engine->state();
    for (const char* name : {"bodies", "contacts"}) {
      const std::size_t table = state.schema->find_table(name).value();
      const TableRows& rows = state.tables[table];
      bytes.insert(bytes.end(), rows.data, rows.data + rows.row_count * state.schema->tables[table].row_size);
    }
  }
  return out;
}

}  // namespace

TEST_CASE("blocks of islands that meet and part give the bits of one set", "[engine][blocks][equivalence]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const bool sleeps : {false, true}) {
      CAPTURE(precision, sleeps);
      const Session session = disturbed_pyramids(precision, sleeps);
      engine::EngineOptions general, anew;
      general.full_pipeline = true;                                // restitution is possible, so blocks are off
      anew.broad_phase = engine::BroadPhaseKind::sweep_and_prune;  // this broad phase has no cache
      const std::vector<Bytes> expected = run_of(session, general);
      CHECK((run_of(session, {}) == expected));
      CHECK((run_of(session, anew) == expected));
      ChunkOrder order(true);
      engine::EngineOptions reversed;
      reversed.parallel = {&order, 0};
      CHECK((run_of(session, reversed) == expected));
      if (!build_info().has_threads) {
        WARN("skipped on threads: a build without threads");
        continue;
      }
      engine::EngineOptions threads;
      threads.thread_count = 2;
      CHECK((run_of(session, threads) == expected));
    }
}

TEST_CASE("a pair that was away for some ticks is tested anew", "[engine][blocks][caches]") {
  Scene scene = empty_scene(Precision::f32);
  scene.settings.continuous = false;  // no swept AABB that would keep the pair
  scene.inputs = {engine::InputKind::set_velocity};
  scene.bodies = {ground(200)};
  for (int i = 0; i < 64; ++i) {  // a block holds this many pairs
    scene.bodies.push_back(body_of(disc_shape(0.5), {1.5 * i - 100, 0.5}));
    scene.bodies.back().velocity = {1, 0};
  }
  scene.bodies.push_back(body_of(box_shape(0.5, 0.5), {10, 0.5}));  // the only pair in its block
  check_cached(thirty_ticks(scene, [](std::uint64_t tick, engine::Input& input) {
    input.body = 65;
    input.values[1] = tick == 10 ? 60 : tick == 12 ? -60 : 0;
    return tick >= 10 && tick <= 12;
  }));
}

TEST_CASE("bodies follow a gravity that changes in one direction alone", "[engine][caches]") {
  Scene scene = empty_scene(Precision::f32);
  scene.inputs = {engine::InputKind::set_gravity};
  scene.bodies = {ground(20), body_of(box_shape(0.5, 0.5), {0, 0.5}), body_of(disc_shape(0.5), {3, 2})};
  check_cached(thirty_ticks(scene, [](std::uint64_t tick, engine::Input& input) {
    input.values[0] = tick < 20 ? 3 : -3;
    input.values[1] = tick < 25 ? -9.81 : -4;
    return tick % 10 == 5 || tick == 20;
  }));
}

TEST_CASE("a press ends the solution in blocks, and a release lets it begin again", "[engine][blocks][caches]") {
  Scene scene = empty_scene(Precision::f32);
  scene.inputs = {engine::InputKind::press, engine::InputKind::drag, engine::InputKind::release};
  scene.pointer.emplace();
  scene.bodies = {ground(40)};
  for (int stack = 0; stack < 6; ++stack)
    for (int i = 0; i < 3; ++i) scene.bodies.push_back(body_of(box_shape(0.5, 0.5), {4.0 * stack - 10, 0.5 + i}));
  const Session session = thirty_ticks(scene, [](std::uint64_t tick, engine::Input& input) {
    input.kind = tick == 25 ? engine::InputKind::release : engine::InputKind::press;
    input.values[0] = -10;
    input.values[1] = 2.5;
    return tick == 15 || tick == 25;
  });
  ChunkOrder order(false);
  engine::EngineOptions blocks;
  blocks.parallel = {&order, 4};  // blocks of a few contacts in this small scene
  blocks.check_caches = true;
  const auto engine = make_engine_or_fail(scene, blocks);
  for (std::uint64_t tick = 0; tick < 30; ++tick) {
    CAPTURE(tick);
    const Status done = engine->step(input_of(session, tick), nullptr);
    INFO((done ? "" : done.error().message));
    REQUIRE(done.has_value());
  }
  constexpr auto kind = static_cast<std::size_t>(engine::CacheKind::contact_blocks);
  CHECK(engine->cache_report()[kind].hits > 10);
  CHECK(tick_hashes(session, 30, blocks) == tick_hashes(session, 30));
}

TEST_CASE("contacts in their places go on after a load", "[engine][blocks][restore]") {
  const Session session = disturbed_pyramids(Precision::f32, false);
  const auto original = make_engine_or_fail(session.scene);
  for (std::uint64_t tick = 0; tick < 30; ++tick) REQUIRE(original->step(input_of(session, tick), nullptr));
  const auto restored = make_engine_or_fail(session.scene);
  for (std::uint64_t tick = 0; tick < 12; ++tick)
    REQUIRE(restored->step(input_of(session, tick), nullptr));  // the restored engine now caches other contacts
  REQUIRE(restored->load(image_of(*original)).has_value());
  for (std::uint64_t tick = 30; tick < blocks_tick_count; ++tick) {
    REQUIRE(original->step(input_of(session, tick), nullptr));
    REQUIRE(restored->step(input_of(session, tick), nullptr));
    CAPTURE(tick);
    REQUIRE(image_of(*restored) == image_of(*original));
  }
}
