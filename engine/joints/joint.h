// Joints: the steps of the solver in each substep, for all kinds alike.
// SPDX-License-Identifier: MIT
//
// Joints are solved one at a time in the order of the scene, which is part of the physics. A faster order may replace
// it if the bits stay the same (joint_order.h). A joint consists of rows: rigid rows (soft constraints tied to the
// substep rate), limits, motors and springs. Accumulated impulses are stored as forces in the state. Springs act before
// positions change; the relax pass leaves them out (joint_spring.h).
#pragma once

#include <cstdint>
#include <vector>

#include "engine/contacts/soft.h"
#include "engine/joints/joint_model.h"
#include "engine/joints/joint_order.h"
#include "engine/joints/joint_spring.h"
#include "engine/model/body_rows.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct SolvedSet;

/// Accumulated impulses of a substep. The file of each kind lists the impulses that the kind uses.
struct JointImpulses {
  Vec2 linear;       // N s
  Real angular = 0;  // N m s
  Real spring = 0;
  Real lower = 0;  // >= 0
  Real upper = 0;  // >= 0
  Real motor = 0;
};

/// A joint prepared for one tick.
struct JointWork {
  std::uint32_t row;  // in State::joints
  const JointModel* model;
  std::uint32_t read_a, read_b;    // in SolverBodies::records
  std::uint32_t write_a, write_b;  // non-dynamic bodies are written to a sink
  Real inv_mass_a, inv_mass_b;
  Real inv_inertia_a, inv_inertia_b;
  Vec2 anchor_a, anchor_b;     // from the centres of mass at the start of the tick, world axes, m
  Vec2 axis;                   // at the start of the tick, world axes
  Vec2 center_offset;          // from A's centre of mass to B's at the start of the tick, m
  Vec2 center_a, center_b;     // of mass, at the start of the tick, world, m
  Rotation relative_rotation;  // of B relative to A and the reference, at the start of the tick
  Softness soft;               // of the rigid rows
  SpringStep spring;
  SpringStep linear_spring[2];  // along the principal axes of the point's mobility, the more mobile one first
  Real motor_speed;             // m/s or rad/s
  Real motor_impulse_max;       // N s or N m s
  Real impulse_max;             // N s
  Real angular_impulse_max;     // N m s
  Real turning = 0;             // turning_of, 1/(N s); 0: impulses are not bounded
  JointImpulses impulses;
  Vec2 start_velocity;  // of the point row before the substep, m/s; set for springs
  Real start_speed;     // of the spring row before the substep
};

/// Consecutive joints of one kind.
struct JointRun {
  JointWork* first;
  JointWork* last;  // one beyond
  MovingBody* bodies;
};

/// The functions of a joint kind. `describe` fills in the part of the model that only this kind has. `save_velocities`
/// saves the velocities before a substep, for springs.
struct JointFunctions {
  void (*describe)(JointModel& model, const Joint& joint, const JointCenters& centers);
  void (*prepare)(JointWork& joint, Real h);
  void (*save_velocities)(JointRun run);
  void (*warm_start)(JointRun run);
  void (*solve)(JointRun run, Real h, Bias bias);
};

/// Consecutive joints of one kind in JointWorkspace::joints, or consecutive batches.
struct JointRange {
  JointKind kind;
  JointPath path;  // `first`, `last`: in JointWorkspace::revolutes, ::driven_revolutes or ::joints
  bool springs;    // some joint has a spring, or is driven like one
  std::uint32_t first;
  std::uint32_t last;          // one beyond
  std::uint32_t level;         // of all joints of the range, if several threads solve them
  std::size_t chunk_size = 0;  // in batches
};

/// Prepares a joint. Requires: prepare_bodies.
JointWork make_joint(const SolvedSet& solved, const JointPlace& place, const Softness& soft);
/// N/m of a rigid row per kg of effective mass, for substeps of length h.
Real joint_stiffness(Real h);

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
