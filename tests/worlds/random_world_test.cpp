// Random worlds: equal on every platform, valid, and with every row of every table.
// SPDX-License-Identifier: MIT
//
// Verified: bytes of scenes and inputs for twenty seeds; scenes and inputs are accepted and ticks run; how often each
// row and each pair of rows occurs; a removed row is absent; most rows change the run.
// Not verified: that worlds find cache faults (a run of many worlds does).
#include "engine/random_worlds/random_world.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "base/hash.h"
#include "base/parallel/chunk_order.h"
#include "engine/engine.h"
#include "engine/random_worlds/world_features.h"
#include "engine/random_worlds/world_plan.h"
#include "engine/scene/scene_binary.h"
#include "engine/scene/scene_json.h"
#include "tests/support/catch.h"

namespace ticktrue::test {
namespace {

using engine::random_world;
using engine::RandomWorld;
using engine::RandomWorldOptions;
using engine::WorldFeature;

// ---- Runs ----

Bytes inputs_of_tick(const RandomWorld& world, std::uint64_t tick, std::size_t& next) {
  std::vector<engine::Input> inputs;
  for (; next < world.inputs.size() && world.inputs[next].tick == tick; ++next) inputs.push_back(world.inputs[next]);
  Bytes bytes;
  engine::encode_inputs(inputs, bytes);
  return bytes;
}

struct WorldRun {
  std::string refusal;  // empty: every input was accepted and every tick was done
  std::uint64_t hash = 0;
  bool is_finite = true;
};

WorldRun run_world(const RandomWorld& world) {
  WorldRun run;
  auto made = engine::make_engine(world.scene);
  if (!made) {
    run.refusal = made.error().message;
    return run;
  }
  engine::Engine& engine = **made;
  std::size_t next = 0;
  for (std::uint64_t tick = 0; tick < world.tick_count && run.refusal.empty(); ++tick) {
    const Bytes inputs = inputs_of_tick(world, tick, next);
    const TickInput input{world.scene.settings.dt, inputs};
    if (const Status status = engine.accept(input); !status) {
      run.refusal = status.error().message;
      return run;
    }
    if (const Status status = engine.step(input, nullptr); !status) run.refusal = status.error().message;
  }
  run.hash = root_hash(engine.state());
  run.is_finite = !find_non_finite(engine.state());
  return run;
}

std::uint64_t hash_of(const RandomWorld& world) {
  std::uint64_t hash = hash64(engine::encode_scene(world.scene), world.tick_count);
  std::size_t next = 0;
  for (std::uint64_t tick = 0; tick < world.tick_count; ++tick) {
    const Bytes inputs = inputs_of_tick(world, tick, next);
    if (!inputs.empty()) hash = hash64(inputs, hash + tick);
  }
  return hash;
}

// ---- Pairs of rows that no world can have, from the rules of scenes ----

std::string table_of(const std::string& row) {
  return row.substr(0, row.find('/'));
}
std::string name_of(const std::string& row) {
  return row.substr(row.find('/') + 1);
}
std::string feature_row(WorldFeature feature) {
  return "feature/" + std::string(engine::world_features()[static_cast<std::size_t>(feature)].name);
}
bool is_one_of(const std::string& row, std::initializer_list<WorldFeature> features) {
  for (const WorldFeature feature : features)
    if (row == feature_row(feature)) return true;
  return false;
}

bool needs_joints(const std::string& row) {
  const auto* input = table_of(row) == "input" ? find_choice(engine::input_kinds, name_of(row)) : nullptr;
  return table_of(row) == "joint" || table_of(row) == "joint_solver" || (input != nullptr && input->has_joint) ||
         is_one_of(row,
                   {WorldFeature::joint_limits, WorldFeature::joint_motors, WorldFeature::joint_springs,
                    WorldFeature::absolute_springs, WorldFeature::linear_springs, WorldFeature::collide_connected});
}
bool needs_pointer(const std::string& row) {
  return row == "input/press" || row == "input/drag" || row == "input/release";
}
bool needs_more_than_plain_shapes(const std::string& row) {
  const bool other = table_of(row) == "shape" && row != "shape/circle" && row != "shape/box" && row != "shape/polygon";
  return other ||
         is_one_of(row, {WorldFeature::rounded_shapes, WorldFeature::category_filters, WorldFeature::group_filters,
                         WorldFeature::tangent_speed, WorldFeature::rolling_resistance});
}

/// The reason why check_scene refuses every scene with this solver and this row; empty if none.
std::string conflict_with_solver(const engine::SolverInfo& solver, const std::string& row) {
  if (!solver.solves_joints && needs_joints(row)) return "solves no joints";
  if (!solver.chooses_joints && row == "joint_solver/direct") return "solves joints one after the other";
  if (!solver.solves_joints && is_one_of(row, {WorldFeature::sleeping, WorldFeature::never_sleeps}))
    return "has no islands";
  if (!solver.substeps && is_one_of(row, {WorldFeature::automatic_substeps, WorldFeature::tight_target_error,
                                          WorldFeature::loose_target_error, WorldFeature::many_substeps}))
    return "does not substep";
  if (!solver.substeps && (table_of(row) == "substep_loads" || table_of(row) == "substep_budget"))
    return "does not substep";
  if (!solver.reads_contacts && is_one_of(row, {WorldFeature::events, WorldFeature::sensors}))
    return "reads no contacts";
  if (!solver.solves_constraints) return needs_pointer(row) ? "moves nothing by a pointer" : "";
  if (!solver.reads_contacts && needs_more_than_plain_shapes(row)) return "knows circles and sharp polygons only";
  const auto* integrator = table_of(row) == "integrator" ? find_choice(engine::integrators, name_of(row)) : nullptr;
  return !solver.reads_contacts && integrator != nullptr && !integrator->carries_constraints
             ? "everything collides, the integrator carries no contacts"
             : "";
}

std::string conflict_with_integrator(const engine::IntegratorInfo& integrator, const std::string& row) {
  if (!integrator.carries_constraints && (needs_joints(row) || needs_pointer(row)))
    return "carries no joints, no pointer";
  if (integrator.kind != engine::IntegratorKind::semi_implicit_euler && is_one_of(row, {WorldFeature::locate_impacts}))
    return "bounces are located under semi_implicit_euler only";
  return "";
}

std::string conflict_of(const std::string& a, const std::string& b) {
  for (const char* table : {"precision", "solver", "integrator", "broad_phase", "friction_mix", "restitution_mix",
                            "clock", "joint_solver", "substep_loads"})
    if (table_of(a) == table && table_of(b) == table) return "a scene has one row of the table";
  using F = WorldFeature;
  for (const auto& [first, second] :
       {std::pair{F::one_substep, F::many_substeps}, std::pair{F::tight_target_error, F::loose_target_error},
        std::pair{F::zero_gravity, F::sideways_gravity}})
    if (a == feature_row(first) && b == feature_row(second)) return "opposites";
  for (const auto& [choice, row] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
    if (table_of(*choice) == "solver") {
      const std::string reason = conflict_with_solver(*find_choice(engine::solvers, name_of(*choice)), *row);
      if (!reason.empty()) return reason;
    }
    if (table_of(*choice) == "integrator") {
      const std::string reason = conflict_with_integrator(*find_choice(engine::integrators, name_of(*choice)), *row);
      if (!reason.empty()) return reason;
    }
  }
  return "";
}

template <typename Table>
void require_rows_of(const std::vector<std::string>& rows, const std::string& name, const Table& table) {
  for (const auto& row : table) {
    CAPTURE(name, std::string(row.name));
    CHECK(std::count(rows.begin(), rows.end(), name + "/" + std::string(row.name)) == 1);
  }
}

}  // namespace

TEST_CASE("a seed gives the same random world on every platform", "[worlds][determinism]") {
  constexpr std::array<std::uint64_t, 20> expected{
      0xea07185dcc3b1f1a, 0x657cf755b27031a5, 0xc7b56820c23be540, 0xb2cb9de1ea635161, 0xf183147f1c3491ff,
      0x6090bc7fdcc37d8f, 0x156d548126d61417, 0xc137725b5495d6e0, 0x39da2d51a0c0451c, 0xe4a46a272181511e,
      0xa55faadef1b6de43, 0x8bdd52490472fa42, 0x7e64c6d72f25ad91, 0x4ad06f81c5eb9926, 0x1cf9cab55306b269,
      0x8969635f4a8dec19, 0x93b970e295bc0970, 0x006832117790821f, 0xdf3ca0b0817cdc46, 0xc5607da0c7c178ae};
  for (std::uint64_t seed = 1; seed <= expected.size(); ++seed) {
    CAPTURE(seed);
    CHECK(hex64(hash_of(random_world(seed))) == hex64(expected[seed - 1]));
  }
}

TEST_CASE("the rows of random worlds are those of every table", "[worlds][coverage]") {
  const std::vector<std::string> rows = engine::random_world_rows();
  require_rows_of(rows, "precision", engine::precisions);
  require_rows_of(rows, "solver", engine::solvers);
  require_rows_of(rows, "integrator", engine::integrators);
  require_rows_of(rows, "broad_phase", engine::broad_phases);
  require_rows_of(rows, "friction_mix", engine::mix_rules);
  require_rows_of(rows, "restitution_mix", engine::mix_rules);
  require_rows_of(rows, "clock", engine::clock_kinds);
  require_rows_of(rows, "body", engine::body_types);
  require_rows_of(rows, "shape", engine::shape_kinds);
  require_rows_of(rows, "joint", engine::joint_kinds);
  require_rows_of(rows, "joint_solver", engine::joint_solvers);
  require_rows_of(rows, "substep_loads", engine::substep_loads);
  CHECK(std::count(rows.begin(), rows.end(), "substep_budget/some") == 1);
  require_rows_of(rows, "force", engine::force_kinds);
  require_rows_of(rows, "input", engine::input_kinds);
  require_rows_of(rows, "feature", engine::world_features());
}

TEST_CASE("of 2000 random worlds 100 have each row, one has each possible pair", "[worlds][coverage]") {
  const std::vector<std::string> names = engine::random_world_rows();
  std::map<std::string, std::size_t> place;
  for (std::size_t i = 0; i < names.size(); ++i) place[names[i]] = i;
  std::vector<std::vector<int>> counts(names.size(), std::vector<int>(names.size()));
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    std::vector<std::size_t> rows;
    for (const std::string& row : random_world(seed).rows) rows.push_back(place.at(row));
    for (const std::size_t a : rows)
      for (const std::size_t b : rows) ++counts[a][b];
  }
  for (std::size_t a = 0; a < names.size(); ++a) {
    CAPTURE(names[a]);
    CHECK(counts[a][a] >= 100);
    for (std::size_t b = a + 1; b < names.size(); ++b) {
      const std::string reason = conflict_of(names[a], names[b]);
      CAPTURE(names[b], reason);
      if ((counts[a][b] > 0) != reason.empty()) CHECK(counts[a][b] == (reason.empty() ? 1 : 0));
    }
  }
}

TEST_CASE("of 2000 random worlds 20 have a row of links, a plate, a ring, a ring with located impacts, shots, a net",
          "[worlds][coverage]") {
  int links = 0;
  int plates = 0;
  int rings = 0;
  int located_rings = 0;
  int shots = 0;
  int nets = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    engine::Draw draw(seed);
    engine::WorldPlan plan = engine::draw_plan(draw, {});
    engine::draw_structures(draw, {}, plan);
    links += plan.link_count > 0 ? 1 : 0;
    plates += plan.plate_body_count > 0 ? 1 : 0;
    rings += plan.ring_body_count > 0 ? 1 : 0;
    located_rings += plan.ring_body_count > 0 && plan.settings.locate_impacts ? 1 : 0;
    shots += plan.shot_count > 0 ? 1 : 0;
    nets += plan.net_columns > 0 ? 1 : 0;
  }
  CHECK(links >= 20);
  CHECK(plates >= 20);
  CHECK(rings >= 20);
  CHECK(located_rings >= 20);
  CHECK(shots >= 20);
  CHECK(nets >= 20);
}

TEST_CASE("of 500 random worlds 10 are solved by a wavefront sweep where chunks are small", "[worlds][coverage]") {
  int swept = 0;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    ChunkOrder order(false);
    engine::EngineOptions options;
    options.parallel = {&order, 3};
    const RandomWorld world = random_world(seed, {300, 4});
    const auto engine = engine::make_engine(world.scene, options);
    CAPTURE(seed);
    REQUIRE(engine.has_value());
    REQUIRE((*engine)->step({world.scene.settings.dt, {}}, nullptr));
    swept += order.line_run_count > 0 ? 1 : 0;
  }
  CHECK(swept >= 10);
}

TEST_CASE("2000 random worlds are legal, and fewer than one in 200 blows up", "[worlds][equivalence]") {
  RandomWorldOptions options;
  options.body_count_max = 40;
  options.tick_count_max = 30;
  int blown_up = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    const RandomWorld world = random_world(seed, options);
    CAPTURE(seed, world.scene.bodies.size(), world.tick_count);
    REQUIRE(world.scene.bodies.size() <= options.body_count_max);
    REQUIRE(world.tick_count >= 1);
    REQUIRE(world.tick_count <= options.tick_count_max);
    const WorldRun run = run_world(world);
    CHECK(run.refusal == "");
    blown_up += run.is_finite ? 0 : 1;
  }
  CHECK(blown_up < 10);
}

TEST_CASE("random worlds read back from JSON and binary are the same", "[worlds][equivalence]") {
  RandomWorldOptions options;
  options.body_count_max = 100;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const RandomWorld world = random_world(seed, options);
    CAPTURE(seed);
    const auto scene = engine::parse_scene(engine::print_scene(world.scene), "world");
    REQUIRE(scene.has_value());
    CHECK(engine::encode_scene(*scene) == engine::encode_scene(world.scene));
    CHECK(engine::decode_scene(engine::encode_scene(world.scene)).has_value());
    for (const engine::Input& input : world.inputs) {
      auto read = engine::parse_input(*scene, engine::print_input(*scene, input), "line");
      REQUIRE(read.has_value());
      read->sequence = input.sequence;
      CHECK(*read == input);
    }
  }
}

TEST_CASE("three rows in five of small random worlds change what happens", "[worlds][coverage]") {
  RandomWorldOptions options;
  options.body_count_max = 14;
  options.tick_count_max = 60;
  int active = 0, with_effect = 0;
  std::map<std::string, std::pair<int, int>> of_row;  // active, with effect
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const RandomWorld world = random_world(seed, options);
    const std::uint64_t hash = run_world(world).hash;
    for (const std::string& row : world.rows) {
      if (!engine::row_changes_bits(row)) continue;
      const auto other = engine::without_row(world, row);
      if (!other) continue;
      CAPTURE(seed, row);
      CHECK(std::count(other->rows.begin(), other->rows.end(), row) == 0);
      const WorldRun run = run_world(*other);
      CHECK(run.refusal == "");
      const int changes = run.hash != hash ? 1 : 0;
      ++active;
      with_effect += changes;
      ++of_row[row].first;
      of_row[row].second += changes;
    }
  }
  CHECK(10 * with_effect >= 6 * active);
  for (const auto& [row, count] : of_row) {
    CAPTURE(row, count.first, count.second);
    CHECK(count.second >= 1);
  }
}

}  // namespace ticktrue::test
