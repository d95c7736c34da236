// The direct joint solver's factorisation: LDL^T of 3 x 3 blocks in doubles, in the order of a joint graph.
// SPDX-License-Identifier: MIT
// Source: Vanderbei, "Symmetric Quasidefinite Matrices", SIAM Journal on Optimization 5, 1995: [M, G^T; G, -c] with
// positive M and c has this factorisation in every order, without pivoting.
//
// The graph alone determines the operations. A row that is not in the system has a gradient of 0 and compliance 1.
#pragma once

#include <array>
#include <vector>

#include "engine/joints/direct/articulated.h"
#include "engine/joints/direct/joint_graph.h"

namespace ticktrue::engine {

/// [M, G^T; G, -c] (v, -p) = (f, r): v are the changes of velocity, p the impulses of the joints, f impulses on bodies,
/// and r the required changes of the rows' speeds.
struct BlockSystem {
  std::vector<Block> diagonal;                // [node]; factored: the inverse of the pivot
  std::vector<Block> blocks;                  // [block]; factored: L
  std::vector<Triple> values;                 // [node] the right-hand side; solved: the solution
  std::vector<Block> column;                  // of the node in elimination
  std::vector<ArticulatedJoint> articulated;  // [JointGraph::articulations]; their blocks and compliances are not used
};

/// Gives the system the size of the graph, and sets the blocks to 0 that no joint sets.
void clear_system(const JointGraph& graph, BlockSystem& system);
void set_body(const JointGraph& graph, BlockSystem& system, std::uint32_t body, double mass, double inertia);
/// Of a joint that is no articulation. Requires: compliances > 0.
void set_joint(const JointGraph& graph, BlockSystem& system, std::uint32_t joint, const Triple& compliances);
/// `gradient`: rows of the joint; columns of one of its bodies. `place`: of this body among the joint's bodies.
void set_gradient(const JointGraph& graph, BlockSystem& system, std::uint32_t joint, std::uint32_t body_place,
                  const Block& gradient);

/// Factors one node. Call for all nodes in their order. Requires: this node and the nodes of its blocks are set. Later
/// nodes may be set afterwards, which hides that time: the nodes of a chain wait for each other.
void factor_node(const JointGraph& graph, BlockSystem& system, std::size_t at);
/// Solves for system.values. Requires: all nodes are factored.
void solve(const JointGraph& graph, BlockSystem& system);

}  // namespace ticktrue::engine
