// Integration of velocities and positions by semi-implicit Euler, several bodies at a time.
// SPDX-License-Identifier: MIT
#include "engine/model/solver_kernels.h"
#include "engine/simd/transpose.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

using Row4 = Real __attribute__((vector_size(4 * sizeof(Real))));

void step_velocities(Real* bodies, const Real* steps, const std::uint32_t* rows, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t begin = static_cast<std::size_t>(rows[i]) * body_record_length;
    Row4 velocity, gain, decay;
    std::memcpy(&velocity, bodies + begin, sizeof velocity);
    std::memcpy(&gain, steps + begin, sizeof gain);
    std::memcpy(&decay, steps + begin + 4, sizeof decay);
    velocity = decay * velocity + gain;
    std::memcpy(bodies + begin, &velocity, sizeof velocity);
  }
}

struct RotationxN {
  RealxN c, s;
};

/// rotation_by of math/vec2.h, lane by lane, with the quadrant selected without integers.
TICKTRUE_INLINE RotationxN rotation_by(RealxN angle) {
  constexpr bool is_single = sizeof(Real) == 4;
  const RealxN round = broadcast(is_single ? Real(0x1.8p23) : Real(0x1.8p52));
  const RealxN limit = broadcast(is_single ? Real(0x1.8p21) : Real(0x1.8p50));
  angle = angle > limit ? limit : (angle < -limit ? -limit : angle);
  const RealxN quarters = angle * broadcast(Real(0.63661977236758134308));  // 2 / pi
  const RealxN quadrant = (quarters + round) - round;
  const RealxN part_1 = broadcast(is_single ? Real(1.5703125) : Real(0x1.921fb54p0));
  const RealxN part_2 = broadcast(is_single ? Real(4.83826794896619e-4) : Real(0x1.10b4611a62633p-30));
  const RealxN x = (angle - quadrant * part_1) - quadrant * part_2;
  const RealxN z = x * x;
  const auto series = [&z](const Real* terms, int count) {
    RealxN sum = broadcast(terms[count - 1]);
    for (int i = count - 1; i-- > 0;) sum = broadcast(terms[i]) + z * sum;
    return sum;
  };
  constexpr int term_count = is_single ? 4 : 7;
  constexpr Real sine_terms[] = {
      Real(-1.0 / 6),        Real(1.0 / 120),          Real(-1.0 / 5040),           Real(1.0 / 362880),
      Real(-1.0 / 39916800), Real(1.0 / 6227020800.0), Real(-1.0 / 1307674368000.0)};
  constexpr Real cosine_terms[] = {
      Real(-0.5),           Real(1.0 / 24),          Real(-1.0 / 720),           Real(1.0 / 40320),
      Real(-1.0 / 3628800), Real(1.0 / 479001600.0), Real(-1.0 / 87178291200.0), Real(1.0 / 20922789888000.0)};
  const RealxN sine = x + x * z * series(sine_terms, term_count);
  const RealxN cosine = broadcast(1) + z * series(cosine_terms, is_single ? 4 : 8);
  // quadrant modulo 4, in -2..2.
  const RealxN rest = quadrant - broadcast(4) * ((quadrant * broadcast(Real(0.25)) + round) - round);
  const RealxN zero{};
  const auto is_even = (rest == zero) | (rest * rest > broadcast(Real(2.5)));
  const auto is_first = rest == zero;
  const auto is_second = rest == broadcast(1);
  const RealxN back_c = is_second ? -sine : sine;
  const RealxN back_s = is_second ? cosine : -cosine;
  return {is_even ? (is_first ? cosine : -cosine) : back_c, is_even ? (is_first ? sine : -sine) : back_s};
}

void move_bodies(Real* bodies, const std::uint32_t* rows, std::size_t count, std::uint32_t dummy, std::uint32_t sink,
                 Real h) {
  const RealxN step = broadcast(h);
  for (std::size_t i = 0; i < count; i += simd_width) {
    std::uint32_t tail_read[simd_width], tail_write[simd_width];
    const std::uint32_t* read = rows + i;
    const std::uint32_t* write = rows + i;
    if (count - i < simd_width) {
      for (std::size_t lane = 0; lane < simd_width; ++lane) {
        tail_read[lane] = i + lane < count ? rows[i + lane] : dummy;
        tail_write[lane] = i + lane < count ? rows[i + lane] : sink;
      }
      read = tail_read;
      write = tail_write;
    }
    const Columns4xN velocity = gather4<body_record_length>(bodies, read);
    Columns4xN pose = gather4<body_record_length>(bodies + 4, read);
    pose.at[0] = pose.at[0] + step * velocity.at[0];
    pose.at[1] = pose.at[1] + step * velocity.at[1];
    const RotationxN delta = rotation_by(step * velocity.at[2]);
    const RealxN c = delta.c * pose.at[2] - delta.s * pose.at[3];
    pose.at[3] = delta.c * pose.at[3] + delta.s * pose.at[2];
    pose.at[2] = c;
    scatter4<body_record_length>(bodies + 4, write, pose);
  }
}

}  // namespace

MotionKernels motion_kernels() {
  return {step_velocities, move_bodies};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
