// Jointed bodies solved directly: the positions at the end of a substep, then the velocities there.
// SPDX-License-Identifier: MIT
// Source: Andersen, "Rattle", Journal of Computational Physics 52, 1983; Hairer, Lubich, Wanner, "Geometric Numerical
// Integration", 2006, VII.1.4. The guards are derived here.
//
//   v' = v + M^-1 G(x)^T p  with  C(x moved by h v') = target        meet_positions
//   x' = x moved by h v'
//   v" = v' + M^-1 G(x')^T q  with  G(x') v" = 0                     project_velocities
//
// The first equation is solved by a few passes with the matrix of the poses x. Trees of joints begin with the predicted
// velocities. Islands with loops, limits, springs or motors, and bodies that turn far in a substep, begin with
// velocities that keep G(x) v' = 0: in a straight bridge, rows contradict each other to second order. The error falls
// by about h w in each pass, with w the spin. The energy then oscillates and does not drift. Four guards keep the
// energy from growing. If the passes miss the target, their changes are discarded, and velocities with G(x) v' = 0 are
// kept instead. The first pass is bounded (begin_with_prediction, bound_changes). If later passes add more than a tenth
// of the kinetic energy, their changes are scaled. Bodies that whip through a large angle in a substep may still gain
// energy at positions that are met: they are slowed down afterwards (bound_gain in direct_energy.h).
//
// A gap is corrected by a velocity of bounded energy that bodies have during the move alone (the push).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/joints/direct/block_ldl.h"
#include "engine/joints/direct/direct_drive.h"
#include "engine/joints/direct/joint_equations.h"

namespace ticktrue::engine {

inline constexpr std::uint32_t no_direct_body = 0xffffffff;

struct DirectBody {
  Pose pose;
  Triple velocity{};    // m/s, m/s, rad/s
  Triple lag{};         // the velocity less the velocity of the move
  double mass = 1;      // kg; of bodies that joints do not move: any value
  double inertia = 1;   // kg m^2; 0: the body does not rotate
  double inv_mass = 1;  // filled by factor_island
  double inv_inertia = 1;
};

/// What each pass needs of a joint. Shapes and drives are kept apart, since few passes need them.
struct DirectJoint {
  std::uint32_t body_a = no_direct_body;
  std::uint32_t body_b = no_direct_body;
  std::uint32_t first_drive = 0;   // in DirectIsland::drives, of the rows after the rigid ones
  Triple impulses{};               // of this substep, before the move
  JointEquations equations;        // at the poses of the last factor_island
  std::array<bool, 3> can_move{};  // of the row: a body follows its impulse; filled by factor_island
  Triple compliances{};            // 1/kg or 1/(kg m^2)
  Triple targets{};                // of the errors of rigid rows after the move; filled by begin_substep
};

enum class PositionOutcome : std::uint8_t { met, scaled, missed };

/// The velocities of bodies, the impulses of joints and the drives: what passes change.
struct SavedIsland {
  std::vector<Triple> velocities;  // [moving body]
  std::vector<Triple> impulses;    // [joint]
  std::vector<DirectDrive> drives;
};

struct DirectIsland {
  std::vector<DirectBody> bodies;  // bodies that joints move come first
  std::size_t moving_count = 0;    // the other bodies have their own pose and velocity
  std::vector<DirectJoint> joints;
  std::vector<JointShape> shapes;   // [joint]
  std::vector<DirectDrive> drives;  // of the rows after the rigid ones, joint by joint
  std::shared_ptr<const JointGraph> graph;
  BlockSystem system;
  std::vector<Triple> push;              // [moving body] velocities; empty: none
  std::vector<Triple> push_impulses;     // [joint]
  double push_share = 1;                 // of the wanted correction
  double worst_miss = 0;                 // m or rad, the largest after the early passes of meet_positions
  bool has_drives = false;               // some drive exists
  bool is_free = false;                  // each joint acts on two moving bodies, with opposite impulses: momentum stays
  std::vector<Pose> moved_poses;         // [body] after a move with the present velocities
  SavedIsland saved;                     // before the last changes
  SavedIsland start;                     // before the first pass of meet_positions
  std::vector<double> angular_impulses;  // [moving body] N m s, of its joints
};

/// The body after a substep with its velocity.
Pose moved(const DirectBody& body, double h);

/// The joint as a node of the graph. Joints move the bodies below `moving_count`. `a_turns`, `b_turns`: the body can
/// rotate.
GraphJoint graph_joint(const JointShape& shape, const DirectJoint& joint, std::size_t moving_count, bool a_turns,
                       bool b_turns);
/// Whether the joint acts on two moving bodies, with opposite impulses.
bool is_internal(const JointShape& shape, const DirectJoint& joint, std::size_t moving_count);
/// Makes the graph of bodies that joints all move. Call again when bodies or joints were added or removed.
void order_island(DirectIsland& island);
/// Computes equations and matrix at the present poses, for project_velocities.
void factor_island(DirectIsland& island);
/// The mobility of a driven row while the rigid rows of its joint hold. Requires: factor_island.
double drive_mobility(const DirectIsland& island, std::size_t joint, std::size_t row);

/// Whether some joint has an impulse.
bool has_impulses(const DirectIsland& island);
/// The largest error of a rigid row that bodies can follow, m or rad. Requires: factor_island.
double largest_gap(const DirectIsland& island);
/// Raises inertias where impulses of joints rotate bodies faster than substeps can follow
/// (engine/joints/joint_inertia.h). True: an inertia was raised. Requires: factor_island.
bool raise_inertias(DirectIsland& island, double h);
/// Adds to `changes` the velocity changes of the moving bodies by rows that act like forces.
void add_force_like_changes(const DirectIsland& island, std::vector<Triple>& changes);

/// Lets the drives act, and chooses the push of this substep. Requires: a factored system.
void begin_substep(DirectIsland& island, double h);
/// Clears the impulses of the last substep and applies the impulses of bounded motors at their bounds. Later passes
/// recompute all other impulses. Impulses of redundant rows have no bound and would be kicks in the next substep.
void start_impulses(DirectIsland& island);
/// Computes velocities that keep the rows at the push's speed, for passes that alternate with contacts. Requires:
/// begin_substep.
void solve_velocities(DirectIsland& island, double h);
/// Computes velocities whose move meets the positions, to the tolerance (m, rad) or as well as `pass_max` passes can.
/// Requires: begin_substep; pass_max >= 1.
PositionOutcome meet_positions(DirectIsland& island, double h, double tolerance, int pass_max);
/// Removes the push by its impulses at the new poses, which keeps angular momentum. Requires: the system is factored at
/// the poses after the move.
void end_push(DirectIsland& island);
/// Requires: the system is factored at the poses after the move.
void project_velocities(DirectIsland& island);

/// Factors the rigid rows alone, for the three functions below. Saves the drives.
void factor_rigid_rows(DirectIsland& island);
/// Restores the drives and factors all rows.
void end_rigid_rows(DirectIsland& island);
void clear_body_impulses(DirectIsland& island);
/// Adds an impulse on a moving body.
void add_body_impulse(DirectIsland& island, std::uint32_t body, const Triple& impulse);
/// Computes how the impulses change velocities while the rigid rows hold.
void solve_body_impulses(DirectIsland& island);
/// The change that solve_body_impulses has computed.
const Triple& velocity_change(const DirectIsland& island, std::uint32_t body);

}  // namespace ticktrue::engine
