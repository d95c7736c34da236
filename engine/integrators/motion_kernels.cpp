// How bodies advance by themselves under semi-implicit Euler, several at a time.
// SPDX-License-Identifier: MIT
#include "engine/contacts/solver_kernels.h"
#include "engine/simd/quads.h"

namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA {
namespace {

using Quad = Real __attribute__((vector_size(4 * sizeof(Real))));

void step_velocities(Real* bodies, const Real* steps, const std::uint32_t* rows, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t begin = static_cast<std::size_t>(rows[i]) * body_record_length;
    Quad velocity, gain, decay;
    std::memcpy(&velocity, bodies + begin, sizeof velocity);
    std::memcpy(&gain, steps + begin, sizeof gain);
    std::memcpy(&decay, steps + begin + 4, sizeof decay);
    velocity = decay * velocity + gain;
    std::memcpy(bodies + begin, &velocity, sizeof velocity);
  }
}

struct Turn {
  Wide c, s;
};

/// Element by element what rotation_by does (math/vec2.h), the quadrant chosen without integers.
TICKTRUE_INLINE Turn rotation_by(Wide angle) {
  constexpr bool is_single = sizeof(Real) == 4;
  const Wide round = spread(is_single ? Real(0x1.8p23) : Real(0x1.8p52));
  const Wide limit = spread(is_single ? Real(0x1.8p21) : Real(0x1.8p50));
  angle = angle > limit ? limit : (angle < -limit ? -limit : angle);
  const Wide quarters = angle * spread(Real(0.63661977236758134308));  // 2 / pi
  const Wide turn = (quarters + round) - round;
  const Wide part_1 = spread(is_single ? Real(1.5703125) : Real(0x1.921fb54p0));
  const Wide part_2 = spread(is_single ? Real(4.83826794896619e-4) : Real(0x1.10b4611a62633p-30));
  const Wide x = (angle - turn * part_1) - turn * part_2;
  const Wide z = x * x;
  const auto series = [&z](const Real* terms, int count) {
    Wide sum = spread(terms[count - 1]);
    for (int i = count - 1; i-- > 0;) sum = spread(terms[i]) + z * sum;
    return sum;
  };
  constexpr int term_count = is_single ? 4 : 7;
  constexpr Real sine_terms[] = {
      Real(-1.0 / 6),        Real(1.0 / 120),          Real(-1.0 / 5040),           Real(1.0 / 362880),
      Real(-1.0 / 39916800), Real(1.0 / 6227020800.0), Real(-1.0 / 1307674368000.0)};
  constexpr Real cosine_terms[] = {
      Real(-0.5),           Real(1.0 / 24),          Real(-1.0 / 720),           Real(1.0 / 40320),
      Real(-1.0 / 3628800), Real(1.0 / 479001600.0), Real(-1.0 / 87178291200.0), Real(1.0 / 20922789888000.0)};
  const Wide sine = x + x * z * series(sine_terms, term_count);
  const Wide cosine = spread(1) + z * series(cosine_terms, is_single ? 4 : 8);
  // turn modulo 4, in -2..2.
  const Wide rest = turn - spread(4) * ((turn * spread(Real(0.25)) + round) - round);
  const Wide zero{};
  const auto is_even = (rest == zero) | (rest * rest > spread(Real(2.5)));
  const auto is_first = rest == zero;
  const auto is_ahead = rest == spread(1);
  const Wide back_c = is_ahead ? -sine : sine;
  const Wide back_s = is_ahead ? cosine : -cosine;
  return {is_even ? (is_first ? cosine : -cosine) : back_c, is_even ? (is_first ? sine : -sine) : back_s};
}

void move_bodies(Real* bodies, const std::uint32_t* rows, std::size_t count, std::uint32_t resting,
                 std::uint32_t unread, Real h) {
  const Wide step = spread(h);
  for (std::size_t i = 0; i < count; i += wide_count) {
    std::uint32_t tail_read[wide_count], tail_write[wide_count];
    const std::uint32_t* read = rows + i;
    const std::uint32_t* write = rows + i;
    if (count - i < wide_count) {
      for (std::size_t lane = 0; lane < wide_count; ++lane) {
        tail_read[lane] = i + lane < count ? rows[i + lane] : resting;
        tail_write[lane] = i + lane < count ? rows[i + lane] : unread;
      }
      read = tail_read;
      write = tail_write;
    }
    const Quads velocity = gather_quads<body_record_length>(bodies, read);
    Quads pose = gather_quads<body_record_length>(bodies + 4, read);
    pose.at[0] = pose.at[0] + step * velocity.at[0];
    pose.at[1] = pose.at[1] + step * velocity.at[1];
    const Turn turn = rotation_by(step * velocity.at[2]);
    const Wide c = turn.c * pose.at[2] - turn.s * pose.at[3];
    pose.at[3] = turn.c * pose.at[3] + turn.s * pose.at[2];
    pose.at[2] = c;
    scatter_quads<body_record_length>(bodies + 4, write, pose);
  }
}

}  // namespace

MotionKernels motion_kernels() {
  return {step_velocities, move_bodies};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION::TICKTRUE_ISA
