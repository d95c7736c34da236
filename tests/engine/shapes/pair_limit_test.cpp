// Too many pairs of shapes in a tick: every broad phase stops in the same tick with the same message.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "base/limits.h"
#include "base/parallel/chunk_order.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

using engine::BroadPhaseKind;
using engine::EngineOptions;

/// Bodies without gravity that meet at one place after `tick_count` ticks.
Scene meeting(int count, int tick_count, double radius, Precision precision = Precision::f64) {
  Scene scene = empty_scene(precision);
  scene.name = "meeting";
  scene.gravity = {0, 0};
  scene.settings.continuous = false;  // the swept boxes of fast bodies would overlap from the start
  for (int i = 0; i < count; ++i) {
    const Point from{3.0 * radius * (1 + i % 70), 3.0 * radius * (1 + i / 70)};
    scene.bodies.push_back(body_of(disc_shape(radius), from));
    const double duration = tick_count * scene.settings.dt;
    scene.bodies.back().velocity = {-from.x / duration, -from.y / duration};
  }
  return scene;
}

Scene coincident_discs(int count, Precision precision) {
  Scene scene = empty_scene(precision);
  scene.bodies.push_back(ground());
  for (int i = 0; i < count; ++i) scene.bodies.push_back(body_of(disc_shape(0.3), {0, 2}));
  return scene;
}

/// The number of pairs in each of these ticks.
std::vector<std::size_t> pair_counts(Scene scene, int tick_count) {
  scene.settings.broad_phase = BroadPhaseKind::brute_force;
  const auto engine = make_engine_or_fail(scene);
  std::vector<std::size_t> counts;
  for (int tick = 0; tick < tick_count; ++tick) {
    counts.push_back(engine->broad_phase().pairs.size());
    REQUIRE(engine->step({scene.settings.dt, {}}, nullptr));
  }
  return counts;
}

struct Stop {
  int tick = -1;  // none failed
  std::string message;
};

Stop run(const Scene& scene, const EngineOptions& options, int tick_count) {
  const auto engine = make_engine_or_fail(scene, options);
  const TickInput input{scene.settings.dt, {}};
  for (int tick = 0; tick < tick_count; ++tick) {
    const Status did = engine->step(input, nullptr);
    if (did) continue;
    CHECK(did.error().code == ErrorCode::limit);
    // Later ticks fail in the same way.
    CHECK(engine->accept(input).error().message == did.error().message);
    const std::uint64_t hash = root_hash(engine->state());
    CHECK(engine->step(input, nullptr).error().message == did.error().message);
    CHECK(root_hash(engine->state()) == hash);
    return {tick, did.error().message};
  }
  return {};
}

}  // namespace

TEST_CASE("every broad phase stops in the tick that has one pair more than may be", "[engine][broad_phase][hostile]") {
  constexpr int tick_count = 24;
  Scene pile = empty_scene();
  pile.name = "pile";
  pile.bodies.push_back(ground());
  for (int i = 0; i < 30; ++i) {
    pile.bodies.push_back(unit_box({1.3 * (i % 6), 0.7 + 1.3 * (i / 6)}));
    pile.bodies.back().velocity = {0, -3.0 - i / 6};
  }
  for (const Scene& scene : {meeting(150, 12, 0.1), meeting(150, 12, 0.1, Precision::f32), pile}) {
    const std::vector<std::size_t> counts = pair_counts(scene, tick_count);
    const auto most = std::max_element(counts.begin(), counts.end());
    REQUIRE(*most > counts[0]);
    const std::size_t early = counts[0];  // the limit: the first tick with more pairs fails
    const auto first_above = [&](std::size_t allowed) {
      return static_cast<int>(
          std::find_if(counts.begin(), counts.end(), [&](std::size_t count) { return count > allowed; }) -
          counts.begin());
    };
    for (const auto& info : engine::broad_phases)
      for (const std::size_t forced : {0, 3}) {
        CAPTURE(scene.name, info.name, forced);
        ChunkOrder reversed(true);
        EngineOptions options;
        options.broad_phase = info.kind;
        if (forced > 0) options.parallel = {&reversed, forced};
        options.pair_count_max = *most;
        CHECK(run(scene, options, tick_count).tick == -1);
        for (const std::size_t allowed : {*most - 1, early, std::size_t{0}}) {
          options.pair_count_max = allowed;
          const Stop stop = run(scene, options, tick_count);
          CHECK(stop.tick == first_above(allowed));
          CHECK(stop.message == "tick " + std::to_string(stop.tick) +
                                    ": pairs of shapes near each other: found more than " + std::to_string(allowed) +
                                    ", expected at most " + std::to_string(allowed));
        }
      }
  }
}

TEST_CASE("a limit that is just enough changes no bit", "[engine][broad_phase][hostile][determinism]") {
  // The tree then lists no pairs of fat AABBs, because there are more of them than of the pairs that the limit counts.
  constexpr int tick_count = 24;
  const Scene scene = meeting(150, 12, 0.1);
  const std::vector<std::size_t> counts = pair_counts(scene, tick_count);
  const Session session{"meeting", scene, {}, {}};
  const std::vector<std::uint64_t> expected = tick_hashes(session, tick_count);
  for (const auto& info : engine::broad_phases)
    for (const std::size_t forced : {0, 3}) {
      CAPTURE(info.name, forced);
      ChunkOrder odd_first(false);
      EngineOptions options;
      options.broad_phase = info.kind;
      if (forced > 0) options.parallel = {&odd_first, forced};
      options.pair_count_max = *std::max_element(counts.begin(), counts.end());
      const bool same = tick_hashes(session, tick_count, options) == expected;
      CHECK(same);
    }
}

TEST_CASE("a limit that is just enough holds where boxes have a margin", "[engine][broad_phase][hostile]") {
  // Pairs of discs approach each other, until all discs leave their fat AABBs in one tick. The tree is then rebuilt.
  // More fat AABBs overlap than the limit allows, and the gaps are smaller than the margins. Other discs are beside a
  // static disc. Their boxes always overlap, so the limit is not too small.
  constexpr int couple_count = 12;
  constexpr double radius = 0.5;
  for (const double step : {2e-4, 3e-4, 4e-4}) {
    Scene scene = empty_scene();
    scene.gravity = {0, 0};
    const double gap = 2 * (0.02 + 0.1 * radius + 4 * step) + 1e-4;
    for (int i = 0; i < couple_count; ++i)
      for (const int side : {-1, 1}) {
        scene.bodies.push_back(body_of(disc_shape(radius), {side * (radius + gap / 2), 4.0 * i}));
        scene.bodies.back().velocity = {-side * step / scene.settings.dt, 0};
      }
    for (int i = 0; i < couple_count; ++i) {
      scene.bodies.push_back(body_of(disc_shape(radius), {10, 4.0 * i}, BodyType::static_body));
      scene.bodies.push_back(body_of(disc_shape(radius), {10.9, 4.0 * i + 0.9}));
    }
    const std::vector<std::size_t> counts = pair_counts(scene, static_cast<int>(gap / step));
    const auto meeting = std::find_if(counts.begin(), counts.end(), [](std::size_t n) { return n > couple_count; });
    REQUIRE(meeting != counts.end());
    const auto tick_count = static_cast<int>(meeting - counts.begin());
    REQUIRE(tick_count * step > 0.1 * radius);
    for (const auto& info : engine::broad_phases) {
      CAPTURE(step, info.name);
      EngineOptions options;
      options.broad_phase = info.kind;
      options.pair_count_max = couple_count;
      CHECK(run(scene, options, tick_count).tick == -1);
    }
  }
}

TEST_CASE("5,000 shapes in one place end the run in its first tick", "[engine][hostile]") {
  for (const auto& precision : engine::precisions)
    for (const auto& info : engine::broad_phases) {
      CAPTURE(precision.name, info.name);
      Scene scene = coincident_discs(5000, precision.kind);
      scene.settings.broad_phase = info.kind;
      const Stop stop = run(scene, {}, 1);
      CHECK(stop.tick == 0);
      CHECK(stop.message == "tick 0: pairs of shapes near each other: found more than 225568, expected at most 225568");
    }
  // Filtered shapes and sensors form no pairs.
  Scene scene = coincident_discs(5000, Precision::f32);
  for (Body& body : scene.bodies) body.shapes[0].filter.group = -1;
  CHECK(run(scene, {}, 2).tick == -1);
  scene = coincident_discs(5000, Precision::f32);
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) scene.bodies[i].shapes[0].sensor = true;
  CHECK(run(scene, {}, 2).tick == -1);
}

TEST_CASE("an engine that has stopped goes on from a state that is loaded", "[engine][hostile][restore]") {
  const Scene scene = meeting(150, 12, 0.1);
  const std::vector<std::size_t> counts = pair_counts(scene, 12);
  EngineOptions options;
  options.pair_count_max = counts[11] - 1;
  const auto engine = make_engine_or_fail(scene, options);
  const TickInput input{scene.settings.dt, {}};
  const Bytes start = image_of(*engine);
  std::vector<std::uint64_t> hashes;
  do hashes.push_back(root_hash(engine->state()));
  while (engine->step(input, nullptr));
  CHECK(hashes.size() > 2);
  CHECK(engine->contacts().empty());
  REQUIRE(engine->load(start).has_value());
  CHECK(engine->accept(input).has_value());
  for (std::size_t tick = 0; tick < hashes.size(); ++tick) {
    CHECK(root_hash(engine->state()) == hashes[tick]);
    CHECK(engine->step(input, nullptr).has_value() == (tick + 1 < hashes.size()));
  }
}

}  // namespace ticktrue::test
