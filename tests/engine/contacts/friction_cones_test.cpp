// Friction of contacts stays in its cone, in random worlds, with direct joints and without.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "engine/random_worlds/random_world.h"
#include "engine/scene/input.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"

using namespace ticktrue;
using namespace ticktrue::test;
using engine::JointSolverKind;

namespace {

/// The largest excess of friction over its cone of this tick, as a share of the largest bound or friction of a point.
double friction_excess(const StateView& view, double friction) {
  const auto table = view.schema->find_table("contacts");
  if (!table) return 0;
  const TableSchema& schema = view.schema->tables[*table];
  const auto value_of = [](const std::uint8_t* row, const Column& column, std::size_t lane) {
    double wide = 0;
    float narrow = 0;
    if (column.type == ScalarType::f64) std::memcpy(&wide, row + column.offset + lane * sizeof wide, sizeof wide);
    if (column.type == ScalarType::f32) std::memcpy(&narrow, row + column.offset + lane * sizeof narrow, sizeof narrow);
    return wide + static_cast<double>(narrow);
  };
  const auto column_of = [&](const char* name) {
    return std::find_if(schema.columns.begin(), schema.columns.end(), [&](const Column& c) { return c.name == name; });
  };
  const auto normal = column_of("normal_force");
  const auto tangent = column_of("tangent_force");
  REQUIRE(normal != schema.columns.end());
  REQUIRE(tangent != schema.columns.end());
  double most = 0;
  for (std::uint64_t i = 0; i < view.tables[*table].row_count; ++i)
    for (std::size_t point = 0; point < 2; ++point) {
      const std::uint8_t* row = view.tables[*table].data + i * schema.row_size;
      const double bound = friction * value_of(row, *normal, point);
      const double force = std::fabs(value_of(row, *tangent, point));
      if (force > bound) most = std::max(most, (force - bound) / force);
    }
  return most;
}

}  // namespace

TEST_CASE("friction stays in its cone in random worlds, with joints and without",
          "[engine][contacts][joints][worlds][regression]") {
  constexpr double friction = 0.5;
  const auto make_rough = [](Body& body) {
    for (engine::Shape& shape : body.shapes) shape.material.friction = friction;
  };
  int jointed_count = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    engine::RandomWorld world = engine::random_world(seed, {60, 60});
    Scene& scene = world.scene;
    scene.settings.friction_mix = engine::MixRule::geometric_mean;
    for (Body& body : scene.bodies) make_rough(body);
    for (Body& body : scene.prototypes) make_rough(body);
    if (!scene.joints.empty() && scene.settings.solver == engine::SolverKind::tgs_soft) {
      scene.settings.joints = JointSolverKind::direct;
      ++jointed_count;
    }
    for (const Precision precision : {Precision::f32, Precision::f64}) {
      scene.settings.precision = precision;
      const double rounding = precision == Precision::f32 ? 1e-6 : 1e-14;
      const auto made = engine::make_engine(scene);
      if (!made) continue;  // some worlds are legal in one precision alone
      std::size_t next = 0;
      for (std::uint64_t tick = 0; tick < world.tick_count; ++tick) {
        std::vector<engine::Input> inputs;
        while (next < world.inputs.size() && world.inputs[next].tick == tick) inputs.push_back(world.inputs[next++]);
        Bytes bytes;
        if (!inputs.empty()) engine::encode_inputs(inputs, bytes);
        if (!(*made)->step({scene.settings.dt, bytes}, nullptr)) break;
        CAPTURE(seed, tick, precision);
        REQUIRE(friction_excess((*made)->state(), friction) <= rounding);
      }
    }
  }
  CHECK(jointed_count > 30);
}
