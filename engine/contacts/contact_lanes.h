// Contacts in the layout of the kernels: sixteen per batch, in the frame of their normals.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/simd/lanes.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// Two vectors of eight lanes, which kernels solve side by side.
inline constexpr int contact_lane_count = 2 * lane_count;
using ContactLanes = LanesOf<contact_lane_count>;

/// A point from the narrow phase, with the forces of the tick before. `fill` writes these lanes, and `prepare` turns
/// them into ContactPointLanes.
struct FoundPointLanes {
  ContactLanes anchor_a_x, anchor_a_y;  // from A's centre of mass, m
  ContactLanes anchor_b_x, anchor_b_y;
  ContactLanes exists;                       // 1 or 0
  ContactLanes normal_force, tangent_force;  // N
};

/// The points of a batch.
struct FoundPoints {
  FoundPointLanes points[2];
};

/// A point in the solver's form. Arms are levers about the bodies' centres of mass: cross(anchor, normal),
/// cross(anchor, right_turn(normal)), in m.
struct ContactPointLanes {
  ContactLanes normal_arm_a, normal_arm_b;
  ContactLanes tangent_arm_a, tangent_arm_b;
  ContactLanes separation;          // at the start of the tick, plus slop, m
  ContactLanes present_separation;  // at the poses of `fill` or of the last `relax`, m
  ContactLanes normal_mass;         // effective mass, kg; 0 if the point does not exist
  ContactLanes normal_impulse;      // N s, accumulated in this substep
  ContactLanes tangent_mass;
  ContactLanes tangent_impulse;
};

/// A batch refers to the record of a body by its offset from the first record, in words of eight bytes. Addresses then
/// need no multiplication.
inline constexpr std::uint32_t words_per_record = body_record_length * sizeof(Real) / 8;

struct ContactBatch {
  std::uint32_t
      read_a[contact_lane_count];  // in SolverBodies::records; static bodies and empty lanes read the dummy body
  std::uint32_t read_b[contact_lane_count];
  std::int32_t count;       // all later lanes are empty
  std::uint32_t immovable;  // 1: one body of each contact is not dynamic
  std::uint32_t is_serial;  // 1: lanes are solved one after the other; 0: no two lanes share a dynamic body
  std::uint32_t bounces;    // 1: some lane has restitution
  ContactLanes inv_mass_a, inv_mass_b, inv_inertia_a, inv_inertia_b;
  ContactLanes normal_x, normal_y, friction;
  ContactPointLanes points[2];
  ContactLanes radius_a, radius_b;            // of round shapes, m
  std::uint32_t write_a[contact_lane_count];  // non-dynamic bodies are written to a sink
  std::uint32_t write_b[contact_lane_count];
  std::uint32_t contact[contact_lane_count];  // in State::contacts
};

/// The lanes of conveyors and rolling resistance of a batch.
struct SurfaceLanes {
  ContactLanes tangent_speed;       // m/s, of B's surface seen from A's, along right_turn(normal)
  ContactLanes rolling_resistance;  // m, torque per normal force
  ContactLanes rolling_mass;        // effective mass of the relative rotation, kg m^2
  ContactLanes rolling_impulse;     // N m s, accumulated in this substep
};

/// The lanes of restitution of a batch.
struct BounceLanes {
  ContactLanes restitution;
  ContactLanes approach[2];     // relative normal velocity at the start of the tick, m/s
  ContactLanes impulse_max[2];  // N s, largest of the tick: 0 means no restitution
};

inline constexpr std::uint32_t no_contact = 0xffffffff;

/// The sources of batches: pointers into the first row of a table, with the distance of two rows in bytes. Each pointer
/// may be read four numbers far.
struct ContactSource {
  const std::uint32_t* slots;         // [batch, lane] the contact
  const std::uint8_t* is_serial;      // [batch] ContactBatch::is_serial
  std::size_t pair_size;              // of ContactPair, bytes
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
  const std::uint32_t* records;  // of each body: the record to read, the record to write
  std::uint32_t sink;            // in `records`: written for non-dynamic bodies
  std::uint32_t own_sink;        // written instead of `sink`
  std::uint32_t dummy;           // read by empty lanes
  Real slop;                     // relative to the size
};

/// Consecutive batches, for one call of a kernel.
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

/// Features of a scene's contacts. A kernel without a feature leaves out its work; the bits are the same.
namespace contact_feature {
inline constexpr unsigned friction = 1;
inline constexpr unsigned second_point = 2;
inline constexpr unsigned radius = 4;  // some shape is round
inline constexpr unsigned bounce = 8;
inline constexpr unsigned surface = 16;
inline constexpr unsigned general = 15;  // without surfaces
inline constexpr unsigned all = 31;
}  // namespace contact_feature

/// Whether a batch writes to sinks: full batches of dynamic bodies do not.
[[gnu::always_inline]] inline bool has_sinks(const ContactBatch& batch) {
  return batch.immovable != 0 || batch.count < contact_lane_count;
}

struct FillingKernels {
  /// Fills `count` batches, except the fields of `prepare`, and `bounces`. `found`: [batch]. `slot_count`: batches in
  /// the slots of the source, at least `count`.
  void (*fill)(const ContactSource& source, ContactBatch* batches, FoundPoints* found, std::size_t count,
               std::size_t slot_count);
  /// Stores forces at ContactSource::forces. `inv_h`: 1/s.
  void (*store)(const ContactBatch* batches, std::size_t count, Real* forces, std::size_t row_size, Real inv_h);
};

struct ContactKernels {
  /// `found`: [batch], as filled.
  void (*prepare)(const ContactWork& work, const FoundPoints* found);
  void (*warm_start)(const ContactWork& work);
  /// Requires: `fill` or `relax` has run since the poses changed.
  void (*solve)(const ContactWork& work);
  void (*relax)(const ContactWork& work);
  /// Applies restitution at points that hit faster than `threshold`. True if there was such a point.
  bool (*bounce)(const ContactWork& work, Real threshold);
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
