// Caches change no bit: a tick is equal with any cache dropped.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/input.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;

namespace {

/// Two resting discs near each other, beside pairs of gliding boxes. In tick 10 one disc is pushed towards the other.
Session sent_at_each_other(Precision precision) {
  Scene scene = empty_scene(precision);
  scene.gravity = {0, 0};
  scene.inputs = {engine::InputKind::set_velocity};
  scene.bodies.push_back(body_of(disc_shape(0.5), {0, 0}));
  scene.bodies.push_back(body_of(disc_shape(0.5), {0.9, 0.9}));
  for (int i = 0; i < 5; ++i)
    for (int above = 0; above < 2; ++above) {
      scene.bodies.push_back(body_of(box_shape(0.5, 0.5), {0, 5.0 + 3 * i + above}));
      scene.bodies.back().velocity = {0.5, 0};
    }
  engine::Input input;
  input.kind = engine::InputKind::set_velocity;
  input.values[0] = input.values[1] = 2;
  Session session{"sent at each other", scene, {}};
  session.inputs.resize(11);
  engine::encode_inputs({input}, session.inputs[10]);
  return session;
}

/// The tick hashes of a run that drops some caches before each tick.
std::vector<std::uint64_t> hashes_forgetting(const Session& session, std::uint64_t tick_count,
                                             engine::CacheSet caches) {
  const auto engine = make_engine_or_fail(session.scene);
  std::vector<std::uint64_t> hashes;
  for (std::uint64_t tick = 0; tick < tick_count; ++tick) {
    engine->forget_caches(caches);
    REQUIRE(engine->step(input_of(session, tick), nullptr));
    hashes.push_back(root_hash(engine->state()));
  }
  return hashes;
}

}  // namespace

TEST_CASE("bodies that rested near each other do not pass through each other",
          "[engine][narrow_phase][caches][regression]") {
  for (const auto& precision : engine::precisions) {
    const Session session = sent_at_each_other(precision.kind);
    const auto engine = make_engine_or_fail(session.scene);
    for (std::uint64_t tick = 0; tick < 90; ++tick) REQUIRE(engine->step(input_of(session, tick), nullptr));
    const std::vector<engine::BodyReport> bodies = engine->bodies();
    CAPTURE(precision.name);
    CHECK(bodies[0].center.x < bodies[1].center.x);
    for (const auto& info : engine::broad_phases) {
      engine::EngineOptions options;
      options.broad_phase = info.kind;
      CAPTURE(info.name);
      CHECK(tick_hashes(session, 90, options) == tick_hashes(session, 90));
    }
  }
}

TEST_CASE("a tick without any one of the cached structures gives the same bits", "[engine][caches][determinism]") {
  constexpr std::uint64_t tick_count = 40;
  std::vector<Session> sessions = property_sessions();
  for (const auto& precision : engine::precisions) sessions.push_back(sent_at_each_other(precision.kind));
  engine::CacheReport total{};
  for (const Session& session : sessions) {
    CAPTURE(session.name);
    const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
    const bool all_same = hashes_forgetting(session, tick_count, engine::all_caches) == expected;
    CHECK(all_same);
    for (const engine::CacheInfo& info : engine::cache_kinds) {
      CAPTURE(info.name);
      const bool same = hashes_forgetting(session, tick_count, engine::cache_bit(info.kind)) == expected;
      CHECK(same);
    }
    const auto engine = make_engine_or_fail(session.scene);
    for (std::uint64_t tick = 0; tick < tick_count; ++tick) REQUIRE(engine->step(input_of(session, tick), nullptr));
    for (std::size_t i = 0; i < total.size(); ++i) {
      total[i].hits += engine->cache_report()[i].hits;
      total[i].invalidations += engine->cache_report()[i].invalidations;
    }
  }
  for (const engine::CacheInfo& info : engine::cache_kinds) {
    CAPTURE(info.name);
    if (info.kind == engine::CacheKind::contact_blocks || info.kind == engine::CacheKind::cell_side) continue;  // below
    CHECK(total[static_cast<std::size_t>(info.kind)].hits > 0);
    CHECK(total[static_cast<std::size_t>(info.kind)].invalidations > 0);
  }
}

TEST_CASE("a forgotten structure is made anew, and is hit again in the tick after", "[engine][caches]") {
  const Session session{"pyramid", *engine::make_builtin_scene("pyramid?base=6&substeps=4"), {}};
  const auto engine = make_engine_or_fail(session.scene);
  run_ticks(*engine, 120);
  for (const engine::CacheKind kind :
       {engine::CacheKind::pair_list, engine::CacheKind::present_pairs, engine::CacheKind::pair_blocks,
        engine::CacheKind::velocity_steps, engine::CacheKind::free_motion, engine::CacheKind::contact_colors}) {
    CAPTURE(engine::cache_kinds[static_cast<std::size_t>(kind)].name);
    const auto counts = [&] { return engine->cache_report()[static_cast<std::size_t>(kind)]; };
    const engine::CacheCounts before = counts();
    engine->forget_caches(engine::cache_bit(kind));
    run_ticks(*engine, 1);
    CHECK(counts().invalidations > before.invalidations);
    const engine::CacheCounts cold = counts();
    run_ticks(*engine, 1);
    CHECK(counts().hits > cold.hits);
    CHECK(counts().invalidations == cold.invalidations);
  }
}

TEST_CASE("an engine that checks its caches gives the same bits and finds nothing", "[engine][caches]") {
  engine::EngineOptions checking;
  checking.check_caches = true;
  for (const Session& session : property_sessions()) {
    CAPTURE(session.name);
    const bool same = tick_hashes(session, 20, checking) == tick_hashes(session, 20);
    CHECK(same);
  }
}

TEST_CASE("a body that sleeps beside a spring leaves nothing behind for implicit_midpoint",
          "[engine][restore][regression]") {
  for (const auto& precision : engine::precisions) {
    CAPTURE(precision.name);
    Scene scene = empty_scene(precision.kind);
    scene.gravity = {0, -0.0625};
    scene.settings.integrator = engine::IntegratorKind::implicit_midpoint;
    scene.settings.sleep.emplace();
    scene.settings.sleep->speed_max = 0.125;
    for (const double x : {5.0, -18.0, -15.5}) {
      scene.bodies.push_back(body_of(box_shape(0.5, 0.5), {x, 0.5}));
      scene.bodies.back().shapes[0].filter.mask = 0;  // no shapes collide
      scene.bodies.back().velocity = {0, x > 0 ? -1.0 : 0.03125};
    }
    engine::Force spring;
    spring.kind = engine::ForceKind::spring;
    spring.body = 1;
    spring.other = 0;
    spring.stiffness = 20;
    spring.damping = 2.5;
    spring.rest_length = 1.75;
    scene.forces.push_back(spring);
    const auto straight = make_engine_or_fail(scene);
    run_ticks(*straight, 100);
    const auto restored = make_engine_or_fail(scene);
    REQUIRE(restored->load(image_of(*straight)).has_value());
    for (int tick = 0; tick < 20; ++tick) {
      run_ticks(*straight, 1);
      run_ticks(*restored, 1);
      REQUIRE(root_hash(restored->state()) == root_hash(straight->state()));
    }
  }
}
