// The joint equations of the direct solver: errors at known poses, and gradients against finite differences.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "base/random.h"
#include "engine/joints/direct/joint_equations.h"
#include "engine/math/trig.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;

namespace {

struct Coordinates {
  double at[6];  // x, y, angle of A, then of B
};

Pose pose_of(const double* at) {
  const SinCos turn = sin_cos(at[2]);
  return {{at[0], at[1]}, turn.cos, turn.sin};
}

JointShape shape_of(Random& random, JointKind kind) {
  JointShape shape;
  shape.kind = kind;
  const auto place = [&random](double size) { return Place{random.real(-size, size), random.real(-size, size)}; };
  shape.anchor_a = place(1);
  shape.anchor_b = place(1);
  const SinCos axis = sin_cos(random.real(-3, 3));
  shape.axis = {axis.cos, axis.sin};
  const SinCos reference = sin_cos(random.real(-1, 1));
  shape.reference_c = reference.cos;
  shape.reference_s = reference.sin;
  shape.length = random.real(1, 3);
  shape.ground_a = place(5);
  shape.ground_b = place(5);
  shape.ratio = random.real(0.5, 2);
  shape.is_driven = random.below(2) == 0;
  shape.turns_driven = kind == JointKind::wheel && random.below(2) == 0;
  return shape;
}

constexpr JointKind kinds[] = {JointKind::revolute, JointKind::weld,     JointKind::prismatic,
                               JointKind::wheel,    JointKind::distance, JointKind::pulley};

}  // namespace

TEST_CASE("gradients of joints are those of their errors", "[engine][joints][direct]") {
  Random random(1);
  constexpr double step = 1e-6;
  for (const JointKind kind : kinds)
    for (int i = 0; i < 100; ++i) {
      const JointShape shape = shape_of(random, kind);
      Coordinates x{};
      for (double& value : x.at) value = random.real(-1, 1);
      const JointEquations equations = equations_of(shape, pose_of(x.at), pose_of(x.at + 3));
      const std::uint32_t checked = equations.row_count - (shape.turns_driven ? 1u : 0u);
      INFO(info_of(joint_kinds, kind).name << ", draw " << i);
      for (std::size_t k = 0; k < 6; ++k) {
        Coordinates more = x;
        Coordinates less = x;
        more.at[k] += step;
        less.at[k] -= step;
        const Triple above = equations_of(shape, pose_of(more.at), pose_of(more.at + 3)).errors;
        const Triple below = equations_of(shape, pose_of(less.at), pose_of(less.at + 3)).errors;
        for (std::size_t row = 0; row < checked; ++row) {
          const Block& gradient = k < 3 ? equations.gradient_a : equations.gradient_b;
          REQUIRE(gradient[3 * row + k % 3] == Approx((above[row] - below[row]) / (2 * step)).margin(1e-7));
        }
      }
    }
}

TEST_CASE("joints tell how many rows hold, and how many are driven", "[engine][joints][direct]") {
  const Pose world;
  const auto counts = [&world](JointKind kind, bool is_driven, bool turns_driven = false) {
    JointShape shape;
    shape.kind = kind;
    shape.is_driven = is_driven;
    shape.turns_driven = turns_driven;
    const JointEquations equations = equations_of(shape, world, world);
    return std::pair(equations.rigid_count, equations.row_count);
  };
  using Counts = std::pair<std::uint32_t, std::uint32_t>;
  REQUIRE(counts(JointKind::revolute, false) == Counts{2, 2});
  REQUIRE(counts(JointKind::revolute, true) == Counts{2, 3});
  REQUIRE(counts(JointKind::weld, false) == Counts{3, 3});
  REQUIRE(counts(JointKind::prismatic, true) == Counts{2, 3});
  REQUIRE(counts(JointKind::wheel, false) == Counts{1, 1});
  REQUIRE(counts(JointKind::wheel, true, true) == Counts{1, 3});
  REQUIRE(counts(JointKind::distance, false) == Counts{1, 1});
  REQUIRE(counts(JointKind::distance, true) == Counts{0, 1});
  REQUIRE(counts(JointKind::pulley, false) == Counts{1, 1});
  REQUIRE_FALSE(has_equations(JointKind::motor));
  REQUIRE_FALSE(has_equations(JointKind::friction));
  REQUIRE_FALSE(has_equations(JointKind::target));
}

TEST_CASE("gaps far from the origin keep their digits", "[engine][joints][direct]") {
  JointShape shape;
  shape.anchor_a = {0.5, 0};
  shape.anchor_b = {-0.5, 0};
  const double far = 0x1p20;
  const JointEquations equations = equations_of(shape, {{far, 0}, 1, 0}, {{far + 1 + 0x1p-30, 0}, 1, 0});
  REQUIRE(equations.errors[0] == 0x1p-30);
  REQUIRE(equations.errors[1] == 0);
}
