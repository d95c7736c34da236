// Kernels change no bit: neither the instruction set, nor skipped work, nor the batches of joints.
// SPDX-License-Identifier: MIT
#include <cstring>

#include "base/hash.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

using engine::InstructionSet;

Scene builtin(const std::string& text) {
  Result<Scene> scene = engine::make_builtin_scene(text);
  REQUIRE(scene.has_value());
  return *std::move(scene);
}

/// Sessions with every feature that kernels handle, alone and combined.
std::vector<Session> kernel_sessions() {
  std::vector<Session> sessions;
  for (const char* precision : {"f32", "f64"})
    for (const char* name : {"pyramid?base=9&", "circles?", "billiards?", "mixed_pile?bodies=60&", "shapes?",
                             "sensors?", "bridge?", "joint_grid?columns=9&", "pyramid?base=5&solver=pgs&"}) {
      const std::string text = std::string(name) + "precision=" + precision;
      sessions.push_back({text, builtin(text), {}});
    }
  return sessions;
}

Scene net(Precision precision, int columns, int chain_length) {
  Scene scene = empty_scene(precision);
  const auto pin_to = [&](std::size_t a, Point at_a, std::size_t b, Point at_b) {
    Joint joint = joint_of(JointKind::revolute, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
    joint.anchor_a = at_a;
    joint.anchor_b = at_b;
    scene.joints.push_back(joint);
  };
  for (int column = 0; column < columns; ++column)
    for (int row = 0; row < columns; ++row) {
      const Point position{static_cast<double>(column), static_cast<double>(-row)};
      const std::size_t number = scene.bodies.size();
      const bool is_peg = row == 0 && column == 0;
      scene.bodies.push_back(is_peg ? peg(position) : bob(position, 1 + 0.1 * row, 0.02));
      if (row > 0) pin_to(number - 1, {0, -0.5}, number, {0, 0.5});
      if (column > 0) pin_to(number - static_cast<std::size_t>(columns), {0.5, 0}, number, {-0.5, 0});
    }
  for (int link = 0; link < chain_length; ++link) {
    const std::size_t number = scene.bodies.size();
    scene.bodies.push_back(link == 0 ? peg({100, 0}) : bob({100 + 0.5 * link, 0}));
    if (link > 0) pin_to(number - 1, {0.25, 0}, number, {-0.25, 0});
  }
  for (Body& body : scene.bodies) body.shapes[0].filter = {2, 0xfffffffd, 0};
  return scene;
}

}  // namespace

TEST_CASE("every instruction set gives the same bits", "[engine][kernels][determinism]") {
  std::vector<Session> sessions = kernel_sessions();
  for (GoldenSession& golden : golden_sessions()) sessions.push_back(std::move(golden.session));
  for (const Session& session : sessions) {
    engine::EngineOptions options;
    options.instruction_set = InstructionSet::baseline;
    const std::vector<std::uint64_t> expected = tick_hashes(session, 90, options);
    for (const engine::InstructionSetInfo& info : engine::instruction_sets) {
      if (!engine::can_use(info.kind)) continue;
      options.instruction_set = info.kind;
      CAPTURE(session.name, info.name);
      CHECK(tick_hashes(session, 90, options) == expected);
    }
  }
}

TEST_CASE("an instruction set that does not exist is refused, with those that do", "[engine][kernels]") {
  const Status status = engine::use_instruction_set("mmx");
  REQUIRE(!status.has_value());
  CHECK(status.error().code == ErrorCode::usage);
  CHECK(status.error().message.find("TICKTRUE_ISA: found \"mmx\", expected baseline") == 0);
}

TEST_CASE("kernels that leave out what a scene lacks give the bits of the general ones",
          "[engine][kernels][pipeline]") {
  for (const Session& session : kernel_sessions()) {
    const auto composed = make_engine_or_fail(session.scene);
    engine::EngineOptions options;
    options.full_pipeline = true;
    const auto full = make_engine_or_fail(session.scene, options);
    for (std::uint64_t tick = 0; tick < 90; ++tick) {
      REQUIRE(composed->step(input_of(session, tick), nullptr));
      REQUIRE(full->step(input_of(session, tick), nullptr));
    }
    for (const char* name : {"bodies", "contacts"}) {
      const StateView& a = composed->state();
      const StateView& b = full->state();
      const auto table_a = a.schema->find_table(name);
      const auto table_b = b.schema->find_table(name);
      if (!table_a) continue;
      const TableRows& rows_a = a.tables[*table_a];
      const TableRows& rows_b = b.tables[*table_b];
      REQUIRE(rows_a.row_count == rows_b.row_count);
      CAPTURE(session.name, name);
      CHECK(std::memcmp(rows_a.data, rows_b.data, rows_a.row_count * a.schema->tables[*table_a].row_size) == 0);
    }
  }
}

TEST_CASE("joints in batches give the bits of the order of the scene", "[engine][kernels][joints]") {
  // A long chain beside the net gives more levels than batches are worth. All joints are then solved one by one.
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    constexpr int columns = 9;
    const auto in_batches = make_engine_or_fail(net(precision, columns, 0));
    const auto one_by_one = make_engine_or_fail(net(precision, columns, 400));
    const TickInput input{in_batches->scene().settings.dt, {}};
    for (int tick = 0; tick < 120; ++tick) {
      REQUIRE(in_batches->step(input, nullptr));
      REQUIRE(one_by_one->step(input, nullptr));
    }
    const auto a = in_batches->bodies();
    const auto b = one_by_one->bodies();
    for (std::size_t i = 0; i < a.size(); ++i) {
      CAPTURE(i);
      REQUIRE(a[i].center.x == b[i].center.x);
      REQUIRE(a[i].center.y == b[i].center.y);
      REQUIRE(a[i].angle == b[i].angle);
      REQUIRE(a[i].angular_velocity == b[i].angular_velocity);
    }
  }
}

}  // namespace ticktrue::test
