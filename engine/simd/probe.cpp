// Square roots, rotations and lanes of Wide over fixed arguments. Compiled with the flags of the solvers, as they are.
// SPDX-License-Identifier: MIT
#include "engine/simd/probe.h"

#include "base/random.h"
#include "engine/math/vec2.h"
#include "engine/simd/wide.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

using namespace TICKTRUE_ISA;

constexpr int round_count = 256;

void put(ByteWriter& out, Real value) {
  if constexpr (sizeof(Real) == 4)
    out.u32(bits_of(value));
  else
    out.u64(bits_of(value));
}

void put(ByteWriter& out, Rotation q) {
  put(out, q.c);
  put(out, q.s);
}

}  // namespace

void probe_arithmetic(ByteWriter& out) {
  Random random(1);
  Rotation pose;
  // Eight lanes whatever the width of Wide is, so that builds of different widths give the same bytes.
  constexpr int lane_count = 8;
  Real lanes[lane_count] = {};
  for (int i = 0; i < round_count; ++i) {
    const Real angle = Real(random.real(-20, 20));
    const Real magnitude = Real(random.real(1e-30, 1e-3));
    const Rotation turn = rotation_by(angle);
    pose = normalized(pose * turn);
    put(out, turn);
    put(out, pose);
    put(out, square_root(magnitude));
    const Vec2 turned = rotate(turn, {angle, magnitude});
    put(out, length(turned));
    put(out, cross(turned, rotate_back(pose, turned)));
    for (int lane = 0; lane < lane_count; ++lane) lanes[lane] += angle * Real(lane) / Real(7);
    for (int first = 0; first < lane_count; first += wide_count) {
      const Wide value = load_wide(lanes + first);
      store_wide(lanes + first, smaller(larger(value * turn.c - value * turn.s, spread(Real(-9))), spread(Real(9))));
    }
    for (const Real lane : lanes) put(out, lane);
  }
  // Down through the subnormal numbers, from one that no compiler knows.
  Real small = absolute(pose.c) * (sizeof(Real) == 4 ? Real(0x1p-120) : Real(0x1p-1016));
  for (int i = 0; i < 64; ++i) {
    small = small * Real(0.4);
    put(out, small);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
