// Workspaces: the fields that poison overwrites, and the caches that a solver lists.
// SPDX-License-Identifier: MIT
#define TICKTRUE_PRECISION f64
#include <cstring>
#include <vector>

#include "engine/joints/direct/direct_components.h"
#include "engine/model/poison.h"
#include "engine/random_worlds/random_world.h"
#include "engine/solvers/solver_work.h"
#include "tests/support/catch.h"

using namespace ticktrue;
namespace f64 = engine::f64;

namespace {

template <typename T>
bool is_poisoned(const T& field) {
  unsigned char bytes[sizeof(T)];
  std::memcpy(bytes, &field, sizeof(T));
  bool all = true;
  for (const unsigned char byte : bytes) all = all && byte == 0xff;
  return all;
}

}  // namespace

TEST_CASE("poison overwrites scalars, rows and what workspaces hold inside", "[engine][caches]") {
  f64::SolverWork work;
  work.bodies.masses.resize(3);
  work.motion.newton[4].resize(2);
  work.contacts.batches.batches.resize(2);
  work.contacts.block_batches.resize(2);
  work.joints.revolutes.arms.resize(1);
  work.shock.step.velocity.resize(5);
  const bool used_wavefront = work.joints.uses_wavefront;
  list_fields(work, engine::Poison{});
  CHECK(work.bodies.masses.empty());
  CHECK(work.motion.newton[4].empty());
  CHECK(is_poisoned(work.motion.unconverged));
  CHECK(work.joints.uses_wavefront != used_wavefront);  // a bool is inverted, because other bits are not valid
  CHECK(is_poisoned(work.joints.revolutes.soft));
  CHECK(is_poisoned(work.contacts.batches.batch_count));
  REQUIRE(work.contacts.batches.batches.size() == 2);  // these rows keep their count
  CHECK(is_poisoned(work.contacts.batches.batches[1]));
  REQUIRE(work.contacts.block_batches.size() == 2);
  CHECK(is_poisoned(work.contacts.block_batches[1].batch_count));
  REQUIRE(work.joints.revolutes.arms.size() == 1);
  CHECK(is_poisoned(work.joints.revolutes.arms[0]));
  CHECK(work.shock.step.velocity.empty());
}

TEST_CASE("poison overwrites the lists of a tick, and begin_tick gives what stages may leave out", "[engine][caches]") {
  f64::TickLists tick;
  tick.pair_count_max = 7;
  tick.load.resize(3);
  const bool had_solver_sets = tick.has_solver_sets;
  list_fields(tick, engine::Poison{});
  CHECK(tick.pair_count_max == 7);
  CHECK(tick.load.empty());
  CHECK(tick.has_solver_sets != had_solver_sets);
  CHECK(is_poisoned(tick.shock_work_left));
  begin_tick(tick);
  CHECK_FALSE(tick.has_solver_sets);
  CHECK_FALSE(tick.has_too_many_pairs);
  CHECK_FALSE(tick.changes.is_known);
}

TEST_CASE("a solver lists each of its caches once, and poison leaves them", "[engine][caches]") {
  f64::SolverWork work;
  std::vector<engine::TickCache*> caches;
  list_fields(work, engine::ListCaches{caches});
  engine::CacheSet kinds = 0;
  for (const engine::TickCache* cache : caches) kinds |= engine::cache_bit(cache->kind());
  CHECK(caches.size() == 6);
  CHECK(kinds ==
        (engine::cache_bit(engine::CacheKind::free_motion) | engine::cache_bit(engine::CacheKind::velocity_steps) |
         engine::cache_bit(engine::CacheKind::joint_plan) | engine::cache_bit(engine::CacheKind::joint_graph) |
         engine::cache_bit(engine::CacheKind::contact_colors) | engine::cache_bit(engine::CacheKind::contact_blocks)));
  const f64::VelocityStepKey key{1, {0, -10}, 0.25};
  const auto follow = [&] {
    work.motion.velocity_steps.follow(key, true, Parallel{}, 1, [](std::size_t) { return f64::VelocityStep{}; });
  };
  follow();
  list_fields(work, engine::Poison{});
  follow();
  CHECK(work.motion.velocity_steps.hits() == 1);
}

TEST_CASE("the marks of direct joints are the joints of the direct components, in random worlds",
          "[engine][joints][direct][worlds]") {
  int direct_count = 0;
  int iterative_count = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    engine::Scene scene = engine::random_world(seed, {60, 1}).scene;
    if (scene.joints.empty()) continue;
    const f64::Model model = f64::make_model(scene);
    const f64::State state = f64::initial_state(model);
    f64::DirectComponents components;
    std::vector<f64::DirectPlace> places;
    components.follow(model, state, places);
    f64::DirectMarks marks;
    f64::mark_direct_joints(model, state, marks);
    CAPTURE(seed);
    REQUIRE(marks.is_direct.size() == state.joints.size());
    REQUIRE(std::vector<std::uint8_t>(components.direct_joints().begin(), components.direct_joints().end()) ==
            marks.is_direct);
    for (const std::uint8_t is_direct : marks.is_direct) ++(is_direct != 0 ? direct_count : iterative_count);
  }
  CHECK(direct_count > 500);
  CHECK(iterative_count > 100);
}
