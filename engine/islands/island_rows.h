// Islands, what carries them and what lands on them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "engine/contacts/contact_batch.h"
#include "engine/math/vec2.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// How far an island is from what its scene allows.
struct IslandError {
  Real error;  // at the most substeps, of what is allowed
  Real depth;  // steps from what cannot move to what is farthest from it
};

/// A contact or joint by which a body may be carried.
struct Support {
  std::uint32_t other;      // row
  Real compliance;          // m/N at four substeps
  Real arm, other_arm;      // of a joint, from the two centres of mass, m; of a contact 0
  Vec2 middle;              // of a contact, or a joint's anchor, from the body's centre of mass, m
  Real half_width2;         // of a contact with two points, m^2; else 0
  Real angular_compliance;  // of what holds the angle, rad/(N m) at four substeps; else 0
};

/// How far a body leans with what carries it.
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
  std::uint32_t joint_iterations = 1;  // over its joints before bodies move
  Real h = 0;                          // s, of a substep
  ContactStiffness stiffness;
  std::uint32_t first_row = 0, row_end = 0;
  std::uint32_t first_contact = 0, contact_end = 0;
  std::uint32_t first_batch = 0, batch_end = 0;
  std::uint32_t first_run = 0, run_end = 0;
};

/// What moves a body less in a substep, of the allowed way, is no impact.
inline constexpr Real resting_impact_share = Real(0.05);

/// A contact that hits a body at rest in this tick.
struct RestingImpact {
  std::uint32_t contact;  // in TickLists::contact_pairs
  Real closing;           // m/s, before the pass
  Real allowed;           // m, how far the bodies may move meanwhile
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
