// The wavefront sweep over joints gives the bits of plain iterations.
// SPDX-License-Identifier: MIT
//
// Verified: nets with neighbouring joints of every kind; both precisions; every instruction set; one thread and
// several; fronts as early and as late as allowed; bodies removed during the run.
#include <atomic>
#include <cstring>

#include "base/build_info.h"
#include "base/parallel/chunk_order.h"
#include "base/parallel/workers.h"
#include "engine/scene/input.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

/// The kinds of joints between neighbours of a net, in turn.
enum class Kind : std::uint8_t { plain, limited, sprung, driven, weld, rod, rope };

Joint joint_between(Kind kind, std::uint32_t a, std::uint32_t b, Point half) {
  JointKind of = JointKind::revolute;
  if (kind == Kind::weld) of = JointKind::weld;
  if (kind == Kind::rod || kind == Kind::rope) of = JointKind::distance;
  Joint joint = joint_of(of, a, b);
  joint.anchor_a = half;
  joint.anchor_b = {-half.x, -half.y};
  if (kind == Kind::limited) joint.limits = engine::Range{-0.2, 0.3};
  if (kind == Kind::sprung) joint.spring = engine::JointSpring{false, 3, 0.4, 0, 0};
  if (kind == Kind::driven) joint.motor = engine::JointMotor{1, 0.5};
  if (kind == Kind::rod) joint.length = 0.25;
  if (kind == Kind::rope) joint.limits = engine::Range{0, 0.3};
  if (of == JointKind::distance) {
    joint.anchor_a = {0.75 * half.x, 0.75 * half.y};
    joint.anchor_b = {-0.75 * half.x, -0.75 * half.y};
  }
  return joint;
}

/// A net that hangs from three of its corners. `kinds`: the kinds of its joints, in turn.
Scene mixed_net(Precision precision, int columns, const std::vector<Kind>& kinds) {
  Scene scene = empty_scene(precision);
  scene.inputs = {engine::InputKind::remove};
  std::size_t next = 0;
  const auto join = [&](std::size_t a, std::size_t b, Point half) {
    const Kind kind = kinds[next++ % kinds.size()];
    scene.joints.push_back(joint_between(kind, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b), half));
  };
  for (int column = 0; column < columns; ++column)
    for (int row = 0; row < columns; ++row) {
      const Point position{static_cast<double>(column), static_cast<double>(-row)};
      const std::size_t number = scene.bodies.size();
      const bool is_corner = (row == 0 || row == columns - 1) && column == 0;
      const bool is_peg = is_corner || (row == 0 && column == columns - 1);
      scene.bodies.push_back(is_peg ? peg(position) : bob(position, 1 + 0.1 * row, 0.02));
      scene.bodies.back().shapes[0].filter = {2, 0xfffffffd, 0};
      if (row > 0) join(number - 1, number, {0, -0.5});
      if (column > 0) join(number - static_cast<std::size_t>(columns), number, {0.5, 0});
    }
  return scene;
}

/// Adds a kinematic body beside the net. A moving body without joints disables the wavefront sweep.
Scene without_wavefront(Scene scene) {
  scene.bodies.push_back(body_of(disc_shape(0.1), {-50, 0}, BodyType::kinematic_body));
  scene.bodies.back().shapes[0].filter = {2, 0xfffffffd, 0};
  return scene;
}

struct Net {
  const char* name;
  std::vector<Kind> kinds;
};
std::vector<Net> nets() {
  return {{"revolutes", {Kind::plain}},
          {"driven revolutes", {Kind::limited, Kind::sprung, Kind::driven}},
          {"plain and driven revolutes", {Kind::plain, Kind::plain, Kind::sprung, Kind::plain, Kind::limited}},
          {"all",
           {Kind::plain, Kind::limited, Kind::plain, Kind::weld, Kind::sprung, Kind::rod, Kind::driven, Kind::rope}}};
}

/// Compares the bytes of the bodies that both engines have, and of all joints.
void check_same(const engine::Engine& a, const engine::Engine& b) {
  for (const char* name : {"bodies", "joints"}) {
    const std::size_t table = *a.state().schema->find_table(name);
    const TableRows& rows_a = a.state().tables[table];
    const TableRows& rows_b = b.state().tables[table];
    const std::size_t row_count = rows_a.row_count < rows_b.row_count ? rows_a.row_count : rows_b.row_count;
    CAPTURE(name);
    REQUIRE(row_count > 0);
    REQUIRE(std::memcmp(rows_a.data, rows_b.data, row_count * a.state().schema->tables[table].row_size) == 0);
  }
}

/// `removal_tick`: the tick that removes a body.
void check_wavefront(const Scene& scene, const engine::EngineOptions& options, int tick_count, int removal_tick = -1) {
  const auto wavefront = make_engine_or_fail(scene, options);
  const auto plain = make_engine_or_fail(without_wavefront(scene));
  Bytes removal;
  engine::Input remove;
  remove.kind = engine::InputKind::remove;
  remove.body = 20;
  engine::encode_inputs({remove}, removal);
  for (int tick = 0; tick < tick_count; ++tick) {
    const TickInput input{scene.settings.dt, tick == removal_tick ? ByteView(removal) : ByteView{}};
    REQUIRE(wavefront->step(input, nullptr));
    REQUIRE(plain->step(input, nullptr));
  }
  check_same(*wavefront, *plain);
}

}  // namespace

TEST_CASE("a wavefront sweep over joints gives the bits of plain passes", "[engine][joints][threads][equivalence]") {
  for (const Precision precision : {Precision::f32, Precision::f64})
    for (const Net& net : nets())
      for (const engine::InstructionSetInfo& info : engine::instruction_sets) {
        if (!engine::can_use(info.kind)) continue;
        CAPTURE(net.name, info.name, precision == Precision::f32);
        const Scene scene = mixed_net(precision, 9, net.kinds);
        engine::EngineOptions options;
        options.instruction_set = info.kind;
        for (const bool reversed : {false, true}) {
          ChunkOrder order(reversed);
          options.parallel = {&order, 3};
          check_wavefront(scene, options, 90, 60);
          CHECK(order.line_run_count == 60);  // a wavefront sweep in each tick in which all joints exist
        }
        if (!build_info().has_threads) {
          WARN("skipped on threads: a build without threads");
          continue;
        }
        options.parallel = {nullptr, 3};
        for (const unsigned thread_count : {2u, 4u, 8u}) {
          CAPTURE(thread_count);
          options.thread_count = thread_count;
          check_wavefront(scene, options, 20);
        }
      }
}

TEST_CASE("large nets use a wavefront sweep unforced", "[engine][joints][threads][equivalence]") {
  for (const Net& net : nets()) {
    CAPTURE(net.name);
    const Scene scene = mixed_net(Precision::f32, 26, net.kinds);
    check_wavefront(scene, {}, 30);
    ChunkOrder order(true);
    engine::EngineOptions options;
    options.parallel = {&order, 0};
    check_wavefront(scene, options, 30);
    CHECK(order.line_run_count == 30);
  }
}

TEST_CASE("lines of steps are done in their order, at their distance", "[base][threads]") {
  SKIP_UNLESS(build_info().has_threads, "a build without threads");
  for (const unsigned thread_count : {2u, 4u, 8u}) {
    auto workers = make_workers(thread_count);
    REQUIRE(workers.has_value());
    const Lines lines{thread_count + 3, 200, 7};  // more than threads
    struct Progress {
      std::atomic<std::size_t> done[11] = {};
      std::atomic<bool> in_order{true};
    } progress;
    for (int repeat = 0; repeat < 20; ++repeat) {
      for (auto& done : progress.done) done = 0;
      const Parallel parallel{workers->get()};
      parallel.for_lines(lines, [&](std::size_t line, std::size_t step) {
        const std::size_t needed = step + lines.lag < lines.step_count ? step + lines.lag : lines.step_count;
        if (progress.done[line] != step || (line > 0 && progress.done[line - 1] < needed)) progress.in_order = false;
        ++progress.done[line];
      });
      for (std::size_t line = 0; line < lines.line_count; ++line) CHECK(progress.done[line] == lines.step_count);
    }
    CHECK(progress.in_order);
  }
}

}  // namespace ticktrue::test
