// Square roots, rotations and vector lanes over fixed arguments, compiled with the flags of the solvers.
// SPDX-License-Identifier: MIT
#include "engine/simd/probe.h"

#include "base/random.h"
#include "engine/math/vec2.h"
#include "engine/simd/realxn.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

using namespace TICKTRUE_ISA;

constexpr int sample_count = 256;

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
  // Eight lanes for every width of RealxN, so that builds of different widths give the same bytes.
  constexpr int value_count = 8;
  Real lanes[value_count] = {};
  for (int i = 0; i < sample_count; ++i) {
    const Real angle = Real(random.real(-20, 20));
    const Real magnitude = Real(random.real(1e-30, 1e-3));
    const Rotation rotation = rotation_by(angle);
    pose = normalized(pose * rotation);
    put(out, rotation);
    put(out, pose);
    put(out, square_root(magnitude));
    const Vec2 rotated = rotate(rotation, {angle, magnitude});
    put(out, length(rotated));
    put(out, cross(rotated, rotate_back(pose, rotated)));
    for (int lane = 0; lane < value_count; ++lane) lanes[lane] += angle * Real(lane) / Real(7);
    for (int first = 0; first < value_count; first += simd_width) {
      const RealxN value = load_xn(lanes + first);
      store_xn(lanes + first,
               smaller(larger(value * rotation.c - value * rotation.s, broadcast(Real(-9))), broadcast(Real(9))));
    }
    for (const Real lane : lanes) put(out, lane);
  }
  // Divides down through the subnormal numbers. The first value is unknown to compilers.
  Real small = absolute(pose.c) * (sizeof(Real) == 4 ? Real(0x1p-120) : Real(0x1p-1016));
  for (int i = 0; i < 64; ++i) {
    small = small * Real(0.4);
    put(out, small);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
