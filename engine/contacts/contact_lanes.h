// Contacts as kernels see them: sixteen to a batch, in the frame of their normals.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/simd/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Two vectors of eight: kernels solve both side by side.
inline constexpr int contact_lane_count = 2 * lane_count;
using ContactLanes = LanesOf<contact_lane_count>;

/// Arms are levers about the bodies' centres of mass: cross(anchor, normal), cross(anchor, right_turn(normal)), in m.
struct ContactPointLanes {
  ContactLanes normal_arm_a, normal_arm_b;    // before `prepare`: the anchors' x and y of A
  ContactLanes tangent_arm_a, tangent_arm_b;  // before `prepare`: those of B
  ContactLanes separation;                    // at the start of the tick, plus slop, m
  ContactLanes present_separation;            // at the poses of the last `solve` or `relax`, m
  ContactLanes normal_mass;                   // effective mass, kg; 0 where there is no point. Before `prepare`: 1 or 0
  ContactLanes normal_impulse;                // N s, accumulated in this substep. Before `prepare`: N
  ContactLanes tangent_mass;
  ContactLanes tangent_impulse;
};

/// Batches name records of bodies by their distance from the first in words of eight bytes, which addresses need no
/// multiplication for.
inline constexpr std::uint32_t words_per_record = body_record_length * sizeof(Real) / 8;

struct ContactBatch {
  std::uint32_t
      read_a[contact_lane_count];  // in Scratch::bodies; static bodies and empty lanes read the resting record
  std::uint32_t read_b[contact_lane_count];
  std::int32_t count;       // lanes from here on are empty
  std::uint32_t immovable;  // 1: one body of each contact is not moved by impulses
  std::uint32_t is_serial;  // 1: lanes are solved one after the other; else no body is moved by two of them
  std::uint32_t bounces;    // 1: some lane has restitution
  ContactLanes inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
  ContactLanes normal_x, normal_y, friction;
  ContactPointLanes points[2];
  ContactLanes radius_a, radius_b;            // of round shapes, m
  std::uint32_t write_a[contact_lane_count];  // bodies that impulses do not move are written to a record nobody reads
  std::uint32_t write_b[contact_lane_count];
  std::uint32_t contact[contact_lane_count];  // in State::contacts
};

/// What conveyors and rolling resistance add to a batch.
struct SurfaceLanes {
  ContactLanes tangent_speed;       // m/s, of B's surface seen from A's, along right_turn(normal)
  ContactLanes rolling_resistance;  // m, torque per normal force
  ContactLanes rolling_mass;        // effective mass of the relative turn, kg m^2
  ContactLanes rolling_impulse;     // N m s, accumulated in this substep
};

/// What restitution needs of a batch.
struct BounceLanes {
  ContactLanes restitution;
  ContactLanes approach[2];     // relative normal velocity at the start of the tick, m/s
  ContactLanes impulse_max[2];  // N s, largest of the tick: a point that never pushed does not bounce
};

inline constexpr std::uint32_t no_contact = 0xffffffff;

/// What batches are filled from: numbers of the first of rows that follow each other at a distance in bytes. Four
/// numbers are there for each pointer, whatever the fourth may be.
struct ContactSource {
  const std::uint32_t* slots;         // [batch, lane] the contact
  const std::uint8_t* is_serial;      // [batch] ContactBatch::is_serial
  std::size_t pair_size;              // of TouchingPair, bytes
  const std::uint32_t* body_indices;  // rows of the two bodies
  const Real* surface;                // friction, radius of A, radius of B, size
  const Real* normal;                 // x, y
  const Real* anchors[2];             // of the points: A's x, y, B's x, y
  const Real* separation[2];          // of the points
  const std::int32_t* point_count;
  std::size_t row_size;          // of ContactRow, bytes
  const Real* forces;            // normal ones of the points, tangential ones
  std::size_t mass_size;         // of BodyMass, bytes
  const Real* masses;            // inverse mass, inverse inertia
  const std::uint32_t* records;  // of each body: where to read it, where to write it
  std::uint32_t sink;            // written for what impulses do not move; in `records`, and
  std::uint32_t own_sink;        // instead of it
  std::uint32_t dummy;           // read for empty lanes
  Real slop;                     // of the size
};

/// Batches that follow each other, for one call of a kernel.
struct ContactWork {
  ContactBatch* batches;
  std::size_t batch_count;
  SurfaceLanes* surfaces;  // [batch], for kernels with surfaces
  BounceLanes* bounces;    // [batch], for kernels with bounces
  Real* bodies;
  Real h;  // s, of a substep
  Softness moving;
  Softness immovable;
};

/// What contacts of a scene may have. Kernels without one of these leave its work out and give the same bits.
namespace contact_feature {
inline constexpr unsigned friction = 1;
inline constexpr unsigned second_point = 2;
inline constexpr unsigned radius = 4;  // some shape is round
inline constexpr unsigned bounce = 8;
inline constexpr unsigned surface = 16;
inline constexpr unsigned general = 15;  // without surfaces
inline constexpr unsigned all = 31;
}  // namespace contact_feature

/// Whether bodies are written elsewhere than they are read: full batches of moving ones are not.
[[gnu::always_inline]] inline bool has_sinks(const ContactBatch& batch) {
  return batch.immovable != 0 || batch.count < contact_lane_count;
}

struct FillingKernels {
  /// Fills `count` batches but for what `prepare` finds, and `bounces`.
  void (*fill)(const ContactSource& source, ContactBatch* batches, std::size_t count);
  /// Forces back to `rows`, those of ContactSource::forces. `inv_h`: 1/s.
  void (*store)(const ContactBatch* batches, std::size_t count, Real* forces, std::size_t row_size, Real inv_h);
};

struct ContactKernels {
  void (*prepare)(const ContactWork& work);
  void (*warm_start)(const ContactWork& work);
  void (*solve)(const ContactWork& work);
  /// As `solve`. Requires: `fill`, `solve` or `relax` since the poses changed.
  void (*solve_again)(const ContactWork& work);
  void (*relax)(const ContactWork& work);
  /// Gives points that hit faster than `threshold` their bounce. True if any did.
  bool (*bounce)(const ContactWork& work, Real threshold);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
