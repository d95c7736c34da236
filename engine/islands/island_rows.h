// Islands, their supports and the impacts on them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/contacts/contact_stiffness.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// The error estimate of an island.
struct IslandError {
  Real error;  // with the most substeps, relative to the allowed error
  Real depth;  // steps from the nearest non-dynamic body to the farthest body
};

/// A contact or joint that may support a body.
struct Support {
  std::uint32_t other;      // row
  Real compliance;          // m/N at four substeps
  Real force;               // N, of the last tick; 0 where loads are not measured
  Real arm, other_arm;      // of a joint, from the two centres of mass, m; of a contact 0
  Vec2 normal;              // of a contact: unit, towards the other body; of a joint: from centre to centre, m
  Vec2 middle;              // of a contact or a joint's anchor, from the body's centre of mass, m
  Real half_width2;         // of a contact with two points, m^2; otherwise 0
  Real angular_compliance;  // of a contact with two points or a rigid weld, rad/(N m) at four substeps; otherwise 0
};

/// The error of a body that tilts with its support.
struct TiltError {
  Vec2 displacement;  // m
  Real angle;         // rad
};

inline constexpr std::uint32_t no_solver_set = 0xffffffff;

/// Islands solved together, with the same number of substeps. Ranges of TickLists::set_rows, set_contacts and
/// ContactBatches::batches and ::runs.
struct SolverSet {
  int substeps = 1;
  bool has_resting_impacts = false;
  std::uint32_t joint_iterations = 1;  // over its joints in each substep
  Real h = 0;                          // s, of a substep
  ContactStiffness stiffness;
  std::uint32_t first_row = 0, row_end = 0;
  std::uint32_t first_contact = 0, contact_end = 0;
  std::uint32_t first_batch = 0, batch_end = 0;
  std::uint32_t first_run = 0, run_end = 0;
};

/// An approach by less than this share of the allowed motion per substep is no impact.
inline constexpr Real resting_impact_share = Real(0.05);

/// A contact that hits a body at rest in this tick.
struct RestingImpact {
  std::uint32_t contact;  // in TickLists::contact_pairs
  std::uint32_t body;     // a dynamic one of the pair
  Real closing;           // m/s, before the pass
  Real allowed;           // m, the allowed motion of the bodies meanwhile
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
