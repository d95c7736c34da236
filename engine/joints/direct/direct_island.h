// Jointed bodies solved directly: the positions at the end of a substep, then the velocities there.
// SPDX-License-Identifier: MIT
// Source: Andersen, "Rattle", Journal of Computational Physics 52, 1983; Hairer, Lubich, Wanner, "Geometric Numerical
// Integration", 2006, VII.1.4. The guards are derived here.
//
//   v' = v + M^-1 G(x)^T p  with  C(x moved by h v') = target        meet_positions
//   x' = x moved by h v'
//   v" = v' + M^-1 G(x')^T q  with  G(x') v" = 0                     project_velocities
//
// The first is solved by a fixed number of passes with the matrix of the poses x; the error falls by about h w in each,
// w the spin. Energy then oscillates and does not drift. Two guards keep it from growing: passes that miss the target
// are taken back, which leaves G(x) v' = 0; passes that ask for more than a tenth of the kinetic energy are scaled.
//
// A gap is taken back by a velocity of bounded energy that bodies have during the move alone (the push).
#pragma once

#include <cstdint>
#include <vector>

#include "engine/joints/direct/block_ldl.h"
#include "engine/joints/direct/direct_drive.h"
#include "engine/joints/direct/joint_equations.h"

namespace ticktrue::engine {

inline constexpr std::uint32_t no_direct_body = 0xffffffff;

struct DirectBody {
  Pose pose;
  Triple velocity{};  // m/s, m/s, rad/s
  double mass = 1;
  double inertia = 1;
  double inv_mass = 1;  // filled by factor_island
  double inv_inertia = 1;
};

struct DirectJoint {
  JointShape shape;
  std::uint32_t body_a = no_direct_body;
  std::uint32_t body_b = no_direct_body;
  std::array<DirectDrive, 2> drives;  // of the rows after the rigid ones
  Triple impulses{};                  // before the move: the first guess of the next substep
  JointEquations equations;           // at the poses of the last factor_island
  std::array<RowLaw, 3> laws;
  Triple compliances{};  // 1/kg or alike
};

enum class PositionOutcome : std::uint8_t { met, scaled, missed };

struct DirectIsland {
  std::vector<DirectBody> bodies;
  std::vector<DirectJoint> joints;
  JointGraph graph;
  BlockSystem system;
  std::vector<Triple> push;  // [body]; empty: none
  double push_share = 1;     // of what is to be taken back
  bool has_drives = false;
  std::vector<Pose> moved_poses;  // [body] by the present velocities
  std::vector<Triple> saved_velocities;
  std::vector<Triple> saved_impulses;
  std::vector<std::array<DirectDrive, 2>> saved_drives;
};

/// The body after a substep with its velocity.
Pose moved(const DirectBody& body, double h);

/// Makes the graph. Call again when bodies or joints were added or removed.
void order_island(DirectIsland& island);
/// Equations and matrix of the present poses, for project_velocities.
void factor_island(DirectIsland& island);

/// Lets the drives act, and chooses the push of this substep. Requires: factored.
void begin_substep(DirectIsland& island, double h);
/// Applies the impulses of the last substep, turned with the bodies. The passes below add to them.
void warm_start_island(DirectIsland& island, double h);
/// Velocities that keep the rows at the push's speed: for passes that alternate with contacts. Requires:
/// begin_substep.
void solve_velocities(DirectIsland& island, double h);
/// Velocities whose move meets the positions. Requires: solve_velocities.
PositionOutcome meet_positions(DirectIsland& island, double h, int pass_count);
/// Takes the push's velocities off. Call after the move.
void end_push(DirectIsland& island);
/// Requires: factored at the poses after the move.
void project_velocities(DirectIsland& island);

}  // namespace ticktrue::engine
