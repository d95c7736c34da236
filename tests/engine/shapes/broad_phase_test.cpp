// Broad phases against the definition: every pair that may touch is listed once, in order. All broad phases give equal
// bits.
// SPDX-License-Identifier: MIT
#define TICKTRUE_PRECISION f64
#include "engine/broad_phase/broad_phase.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/build_info.h"
#include "base/parallel/workers.h"
#include "base/random.h"
#include "engine/broad_phase/aabb_tree.h"
#include "engine/broad_phase/neighbour_cells.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

namespace f64 = engine::f64;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

/// Overwrites the workspace, as a build with TICKTRUE_POISON does between two ticks.
void poison(f64::TickLists& lists) {
  list_fields(lists, engine::Poison{});
  begin_tick(lists);
}

/// The lists of a broad phase, and its workspace.
struct Listing : f64::TickLists {
  f64::BroadPhaseWork work;
};
/// The lists of a tree that runs for several ticks.
struct Following : f64::TickLists {
  f64::AabbTree tree;

  void list(const f64::Model& model, f64::State& state, double dt) { tree.run(model, state, *this, dt); }
  void spoil() {
    poison(*this);
    tree.poison();
  }
};

Pairs pairs_of(const f64::TickLists& listing) {
  Pairs pairs;
  for (const f64::Pair& pair : listing.pairs) pairs.emplace_back(pair.first, pair.second);
  return pairs;
}

struct Case {
  std::string name;
  Scene scene;
};

Scene scattered(std::uint64_t seed, int count, double half_width, double size_min, double size_max, Point origin) {
  Random random(seed);
  Scene scene = empty_scene();
  for (int i = 0; i < count; ++i) {
    const double size = size_min * std::pow(size_max / size_min, random.real(0, 1));
    const double x = origin.x + random.real(-half_width, half_width);
    const double y = origin.y + random.real(-half_width, half_width);
    const BodyType type = engine::body_types[random.below(3)].kind;
    scene.bodies.push_back(body_of(i % 2 == 0 ? disc_shape(size) : box_shape(size, size / 3), {x, y}, type));
    scene.bodies.back().angle = random.real(-3, 3);
  }
  scene.bodies.push_back(unit_box(origin));
  scene.bodies.back().shapes.push_back(disc_shape(0.6));
  return scene;
}

/// Boxes at one place. The order of ids is dynamic, static, dynamic.
Scene coincident(int static_count, int dynamic_count) {
  Scene scene = empty_scene();
  for (int i = 0; i < static_count + dynamic_count; ++i) {
    const bool is_static = i >= dynamic_count / 2 && i < dynamic_count / 2 + static_count;
    scene.bodies.push_back(
        body_of(box_shape(0.5, 0.5), {3, 4}, is_static ? BodyType::static_body : BodyType::dynamic_body));
  }
  return scene;
}

Scene tiny_on_huge(int count) {
  Scene scene = empty_scene();
  scene.bodies.push_back(body_of(box_shape(1e5, 10), {0, -10}, BodyType::static_body));
  for (int i = 0; i < count; ++i)
    scene.bodies.push_back(body_of(disc_shape(0.01), {0.019 * (i % 40), 0.01 + 0.02 * (i / 40)}));
  return scene;
}

/// Half of the bodies get up to `speed` m/s; every seventh body is a bullet.
Scene flung(Scene scene, double speed) {
  Random random(9);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    Body& body = scene.bodies[i];
    if (body.type == BodyType::static_body) continue;
    body.bullet = body.type == BodyType::dynamic_body && i % 7 == 0;
    if (i % 2 == 0) body.velocity = {random.real(-speed, speed), random.real(-speed, speed)};
  }
  return scene;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"nothing", empty_scene()});
  all.push_back({"one body", stack_scene(0)});
  all.push_back({"two bodies", stack_scene(1)});
  all.push_back({"equal sizes", scattered(1, 800, 20, 0.4, 0.5, {})});
  all.push_back({"very different sizes", scattered(2, 800, 100, 1e-3, 1e2, {})});
  all.push_back({"mostly large", scattered(3, 300, 1, 10, 1e3, {})});
  all.push_back({"far from the origin", scattered(4, 800, 20, 0.1, 2, {1e6, -1e6})});
  Scene apart = scattered(5, 300, 20, 0.1, 2, {1e6, 0});
  for (const Body& body : scattered(6, 300, 20, 0.1, 2, {-1e6, 1e6}).bodies) apart.bodies.push_back(body);
  all.push_back({"two crowds far apart", apart});
  Scene beyond = scattered(7, 100, 1e-3, 1e-4, 1e-3, {1e6, 1e6});
  for (const Body& body : scattered(8, 100, 1e-3, 1e-4, 1e-3, {-1e6, 0}).bodies) beyond.bodies.push_back(body);
  all.push_back({"more cells across than can be counted", beyond});
  all.push_back({"coincident dynamic bodies", coincident(0, 700)});
  all.push_back({"5,000 coincident bodies, most of them static", coincident(4998, 2)});
  all.push_back({"tiny bodies on a huge ground", tiny_on_huge(1000)});
  all.push_back({"fast bodies", flung(scattered(1, 800, 20, 0.4, 0.5, {}), 30)});
  all.push_back({"very fast bodies", flung(scattered(1, 800, 20, 0.4, 0.5, {}), 100)});
  all.push_back({"fast bodies far from the origin", flung(scattered(10, 800, 20, 0.4, 0.5, {1e6, -1e6}), 30)});
  all.push_back({"a few fast bodies of very different sizes", flung(scattered(2, 800, 100, 1e-3, 1e2, {}), 1e3)});
  all.push_back({"bodies faster than any number", flung(scattered(11, 300, 20, 0.4, 0.5, {}), 1e200)});
  return all;
}

constexpr double dt = 0.02;

}  // namespace

TEST_CASE("every broad phase gives each pair of overlapping boxes once, in order", "[engine][broad_phase]") {
  for (const Case& c : cases()) {
    const f64::Model model = f64::make_model(c.scene);
    f64::State state = f64::initial_state(model);
    Listing expected;
    f64::brute_force(model, state, expected, expected.work, dt);
    const Pairs touching = pairs_of(expected);
    for (const auto& info : engine::broad_phases) {
      if (info.kind == engine::BroadPhaseKind::bounding_circle)
        continue;  // this broad phase lists another superset of the touching pairs
      CAPTURE(c.name, info.name);
      const std::unique_ptr<f64::Stage> stage = f64::make_broad_phase(info.kind);
      f64::TickLists found;
      for (int again = 0; again < 2; ++again) {
        stage->run(model, state, found, dt);
        const bool same = pairs_of(found) == touching;
        CHECK(same);
        poison(found);
        stage->poison();
      }
    }
  }
}

/// Whether the cached pairs are those of brute force, plus some pairs whose boxes nearly overlap.
bool contain_those_of(const f64::Model& model, const f64::State& state, const f64::TickLists& cached,
                      const Listing& expected) {
  const Pairs found = pairs_of(cached);
  const Pairs wanted = pairs_of(expected);
  if (!std::is_sorted(found.begin(), found.end()) ||
      !std::includes(found.begin(), found.end(), wanted.begin(), wanted.end()))
    return false;
  const auto grown = [&](std::uint32_t i) {
    const double room = model.bodies[state.bodies[expected.proxies[i].body].source].size / 512;
    const f64::Box& box = expected.work.boxes[i];
    return f64::Box{{box.lower.x - 2 * room, box.lower.y - 2 * room}, {box.upper.x + 2 * room, box.upper.y + 2 * room}};
  };
  return std::all_of(found.begin(), found.end(), [&](const auto& pair) {
    return f64::may_touch(expected.proxies[pair.first], expected.proxies[pair.second]) &&
           f64::overlaps(grown(pair.first), grown(pair.second));
  });
}

TEST_CASE("the cached tree gives the pairs of brute force while bodies crawl, jump, come and go",
          "[engine][broad_phase][caches]") {
  Random random(12);
  std::size_t more = 0;
  std::size_t unchanged_count = 0;
  for (Case& c : cases()) {
    if (c.scene.bodies.size() > 1000) continue;
    if (random.below(2) == 0) c.scene.gravity = {0, -500};  // bodies that fall far in a tick count as fast
    const f64::Model model = f64::make_model(c.scene);
    f64::State state = f64::initial_state(model);
    Following cached;
    std::size_t moved_proxies = 0;
    for (int tick = 0; tick < 90; ++tick) {
      for (f64::BodyRow& body : state.bodies) {
        if (model.bodies[body.source].type == BodyType::static_body) continue;
        const double size = model.bodies[body.source].extent;
        // Most bodies rest or move within the margins of their boxes. Some move slowly, and a few jump far.
        const double crawl = random.below(3) == 0 ? 0.02 : random.below(2) == 0 ? 1e-4 : 0;
        const double step = tick % 60 >= 57 ? 0.5 : tick % 7 == 3 ? 1e-5 : random.below(40) == 0 ? 3 : crawl;
        body.position = {body.position.x + size * step * random.real(-1, 1),
                         body.position.y + size * step * random.real(-1, 1)};
        body.rotation = f64::rotation_by(step * random.real(-1, 1)) * body.rotation;
        const double speed = size * std::pow(10, random.real(0, 2.3));
        if (random.below(20) == 0) body.velocity = {random.real(-1, 1) * speed, random.real(-1, 1) * speed};
        if (random.below(5) == 0) body.velocity = {0, 0};
      }
      if (tick % 25 == 24 && state.bodies.size() > 2) f64::erase_body_row(state, random.below(state.bodies.size()));
      Listing expected;
      f64::brute_force(model, state, expected, expected.work, 0.01);
      cached.list(model, state, 0.01);
      moved_proxies += cached.tree.pair_list().moved_proxy_count();
      const bool same = contain_those_of(model, state, cached, expected);
      CAPTURE(c.name, tick);
      REQUIRE(same);
      more += cached.pairs.size() - expected.pairs.size();
      unchanged_count += cached.changes.same_pairs ? 1 : 0;
      cached.spoil();
    }
    if (c.scene.bodies.size() > 100) CHECK(moved_proxies > 0);
  }
  CHECK(more > 0);
  CHECK(unchanged_count > 100);
}

TEST_CASE("the margin of boxes does not count against the limit of pairs", "[engine][broad_phase][caches][hostile]") {
  Random random(3);
  const f64::Model model = f64::make_model(scattered(1, 600, 8, 0.4, 0.5, {}));
  f64::State state = f64::initial_state(model);
  Following cached;
  std::size_t more = 0;
  for (int tick = 0; tick < 40; ++tick) {
    for (f64::BodyRow& body : state.bodies)
      if (random.below(2) == 0 && model.bodies[body.source].type != BodyType::static_body)
        body.position.x += random.real(-1e-3, 1e-3);
    Listing expected;
    f64::brute_force(model, state, expected, expected.work, dt);
    for (const bool by_cells : {false, true})
      for (const std::size_t too_few : {0, 1}) {
        Following limited = cached;
        limited.pair_count_max = expected.pairs.size() - too_few;
        limited.tree.pair_list().invalidate();  // the list must be rebuilt
        if (by_cells) limited.tree.pair_list().suspend();
        limited.list(model, state, dt);
        CAPTURE(tick, by_cells, too_few);
        CHECK(limited.has_too_many_pairs == (too_few > 0));
      }
    cached.list(model, state, dt);
    more += cached.pairs.size() - expected.pairs.size();
  }
  CHECK(more > 10);
}

TEST_CASE("when the last body goes, so does the last pair", "[engine][broad_phase][caches]") {
  const f64::Model model = f64::make_model(coincident(0, 2));
  f64::State state = f64::initial_state(model);
  Following cached;
  for (int tick = 0; tick < 3; ++tick) {
    cached.list(model, state, dt);
    CHECK(cached.pairs.size() == 1);
    cached.spoil();
  }
  while (!state.bodies.empty()) f64::erase_body_row(state, 0);
  cached.list(model, state, dt);
  CHECK(cached.pairs.empty());
}

TEST_CASE("while everything moves, pairs are listed anew; at rest they are cached again",
          "[engine][broad_phase][caches]") {
  Random random(5);
  Scene scene = scattered(1, 500, 20, 0.4, 0.5, {});
  const f64::Model model = f64::make_model(scene);
  f64::State state = f64::initial_state(model);
  Following cached;
  int high_churn_count = 0;
  for (int tick = 0; tick < 200; ++tick) {
    for (f64::BodyRow& body : state.bodies) {
      if (tick >= 100 || model.bodies[body.source].type == BodyType::static_body) continue;
      body.position = {body.position.x + random.real(-0.5, 0.5), body.position.y + random.real(-0.5, 0.5)};
    }
    if (tick == 50) f64::erase_body_row(state, 7);
    Listing expected;
    f64::brute_force(model, state, expected, expected.work, 0.01);
    cached.list(model, state, 0.01);
    const bool same = pairs_of(cached) == pairs_of(expected);
    CAPTURE(tick);
    REQUIRE(same);
    if (cached.tree.pair_list().is_suspended()) ++high_churn_count;
    cached.spoil();
  }
  CHECK(high_churn_count > 90);
  CHECK(!cached.tree.pair_list().is_suspended());
  CHECK(cached.tree.pair_list().ticks_held() > 30);
}

TEST_CASE("neighbouring cells give the pairs of brute force where they suit", "[engine][broad_phase][cells]") {
  const auto workers = *make_workers(build_info().has_threads ? 3 : 1);
  std::set<std::string> suited;
  for (const Case& c : cases()) {
    const f64::Model model = f64::make_model(c.scene);
    f64::State state = f64::initial_state(model);
    Listing expected;
    f64::brute_force(model, state, expected, expected.work, dt);
    for (const std::size_t chunk_size : {std::size_t{0}, std::size_t{1}, std::size_t{37}}) {
      Listing scratch;
      if (workers != nullptr && chunk_size > 0) scratch.parallel = {workers.get(), chunk_size};
      double side = 0;
      const f64::CellListing listing =
          f64::list_by_cells(scratch, scratch.work, expected.proxies, expected.work.boxes, side);
      CAPTURE(c.name, chunk_size);
      REQUIRE(listing != f64::CellListing::too_many);
      if (listing != f64::CellListing::done) continue;
      suited.insert(c.name);
      f64::list_sorted(scratch, scratch.work, expected.proxies.size());
      const bool same = pairs_of(scratch) == pairs_of(expected);
      CHECK(same);
      if (expected.pairs.size() < 2) continue;
      scratch.pair_count_max = expected.pairs.size();
      CHECK(f64::list_by_cells(scratch, scratch.work, expected.proxies, expected.work.boxes, side) ==
            f64::CellListing::done);
      scratch.pair_count_max = expected.pairs.size() - 1;
      CHECK(f64::list_by_cells(scratch, scratch.work, expected.proxies, expected.work.boxes, side) ==
            f64::CellListing::too_many);
    }
  }
  CHECK(suited.count("equal sizes") == 1);
  CHECK(suited.count("coincident dynamic bodies") == 1);
  CHECK(suited.count("fast bodies") == 1);
  CHECK(suited.count("fast bodies far from the origin") == 1);
  CHECK(suited.count("tiny bodies on a huge ground") == 1);
  CHECK(suited.count("very different sizes") == 0);
  CHECK(suited.count("two crowds far apart") == 0);
}

TEST_CASE("neighbouring cells bear boxes without numbers", "[engine][broad_phase][cells]") {
  const double nan = std::nan("");
  const f64::Model model = f64::make_model(scattered(1, 800, 20, 0.4, 0.5, {}));
  f64::State state = f64::initial_state(model);
  Listing all;
  f64::brute_force(model, state, all, all.work, 0);
  std::vector<f64::Box> boxes = all.work.boxes;
  for (const std::size_t spoilt : {3u, 100u, 101u, 790u}) boxes[spoilt].lower.x = boxes[spoilt].upper.x = nan;
  boxes[4].lower.y = boxes[4].upper.y = nan;
  boxes[5] = {{nan, nan}, {nan, nan}};
  boxes[6] = {{HUGE_VAL, 0}, {HUGE_VAL, 1}};
  boxes[7] = {{-HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, HUGE_VAL}};
  Pairs expected;
  for (std::uint32_t i = 0; i < boxes.size(); ++i)
    for (std::uint32_t j = i + 1; j < boxes.size(); ++j)
      if (f64::overlaps(boxes[i], boxes[j]) && f64::may_touch(all.proxies[i], all.proxies[j]))
        expected.emplace_back(i, j);
  double side = 0;
  REQUIRE(f64::list_by_cells(all, all.work, all.proxies, boxes, side) == f64::CellListing::done);
  f64::list_sorted(all, all.work, all.proxies.size());
  const bool same = pairs_of(all) == expected;
  CHECK(same);
  for (std::size_t i = 200; i < 400; ++i) boxes[i].lower.x = nan;  // more boxes than may be large
  side = 0;
  CHECK(f64::list_by_cells(all, all.work, all.proxies, boxes, side) == f64::CellListing::unsuited);
}

TEST_CASE("shapes that can meet nothing have no proxies", "[engine][broad_phase][analytic]") {
  Scene scene = empty_scene();
  for (int i = 0; i < 4; ++i) {
    scene.bodies.push_back(unit_box({0, 0.25 * i}));
    scene.bodies.back().shapes[0].filter = {2, 0xfffffffd, 0};
  }
  const auto proxy_count = [&] {
    const f64::Model model = f64::make_model(scene);
    f64::State state = f64::initial_state(model);
    Following found;
    found.list(model, state, 0);
    return found.proxies.size();
  };
  CHECK(proxy_count() == 0);
  scene.bodies[3].shapes[0].filter = {};
  CHECK(proxy_count() == 4);
  scene.bodies[3].type = BodyType::static_body;
  scene.bodies[0].type = BodyType::static_body;
  CHECK(proxy_count() == 3);
}

TEST_CASE("every broad phase gives the same bits in crowded, huge and far scenes",
          "[engine][broad_phase][equivalence]") {
  std::vector<Session> sessions;
  for (const engine::Choice<Precision>& precision : engine::precisions) {
    const auto add = [&](const std::string& name, Scene scene) {
      scene.settings.precision = precision.kind;
      sessions.push_back({name + " " + std::string(precision.name), std::move(scene), {}});
    };
    add("different sizes", scattered(2, 300, 20, 0.02, 5, {}));
    add("far away", scattered(4, 200, 8, 0.3, 1, {1e6, 1e6}));
    add("coincident", coincident(4998, 2));
    add("tiny on huge", tiny_on_huge(400));
  }
  for (const Session& session : sessions) {
    const std::vector<std::uint64_t> expected = tick_hashes(session, 4, {false, engine::BroadPhaseKind::brute_force});
    for (const auto& info : engine::broad_phases) {
      CAPTURE(session.name, info.name);
      CHECK(tick_hashes(session, 4, {false, info.kind}) == expected);
    }
  }
}

TEST_CASE("cells keep the order of coordinates and are bounded", "[engine][broad_phase]") {
  const double limit = 1 << 30;
  CHECK(f64::clamped_floor(-0.5, limit) == -1);
  CHECK(f64::clamped_floor(-1.0, limit) == -1);
  CHECK(f64::clamped_floor(0.0, limit) == 0);
  CHECK(f64::clamped_floor(2.999, limit) == 2);
  CHECK(f64::clamped_floor(1e300, limit) == 1 << 30);
  CHECK(f64::clamped_floor(-HUGE_VAL, limit) == -(1 << 30));
  CHECK(f64::clamped_floor(std::nan(""), limit) == 0);
}

}  // namespace ticktrue::test
