// Flipping one bit of a hot body record.
// SPDX-License-Identifier: MIT
#include "engine/solvers/fault.h"

#include <cstring>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// The lane of the record that becomes this lane of the column; null if the record has none.
Real* lane_of(MovingBody& body, BodyField field, std::size_t lane) {
  switch (field) {
    case BodyField::position:
      return lane == 0 ? &body.delta_position.x : &body.delta_position.y;
    case BodyField::rotation:
      return lane == 0 ? &body.delta_rotation.c : &body.delta_rotation.s;
    case BodyField::velocity:
      return lane == 0 ? &body.velocity.x : &body.velocity.y;
    case BodyField::angular_velocity:
      return &body.angular_velocity;
  }
  return nullptr;
}

}  // namespace

void flip_injected(const SolvedSet& solved, int substep) {
  const InjectedFault& fault = *solved.tick.injected;
  if (fault.substep != substep || !solved.has_body(fault.row)) return;
  Real* lane = lane_of(solved.bodies.records[fault.row], fault.field, fault.lane);
  unsigned char bytes[sizeof(Real)];
  std::memcpy(bytes, lane, sizeof bytes);
  const std::size_t byte = machine_is_little_endian ? fault.bit / 8 : sizeof bytes - 1 - fault.bit / 8;
  bytes[byte] = static_cast<unsigned char>(bytes[byte] ^ (1u << (fault.bit % 8)));
  std::memcpy(lane, bytes, sizeof bytes);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
