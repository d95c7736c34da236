// The order in which the direct joint solver eliminates bodies and joints, and the places of its blocks.
// SPDX-License-Identifier: MIT
// Source: Baraff, "Linear-Time Dynamics using Lagrange Multipliers", SIGGRAPH 1996 (bodies and joints as nodes); Tinney
// and Walker, Proceedings of the IEEE 55, 1967 (least degree first); Jacobs and Hendrickson, "An Algorithm for
// Two-Dimensional Rigidity Percolation: The Pebble Game", Journal of Computational Physics 137, 1997, and Lee and
// Streinu, "Pebble game algorithms and sparse graphs", Discrete Mathematics 308, 2008 (degrees of freedom, for k = l =
// 3).
//
// The system is [M, G^T; G, -c]: M the masses, G the gradients of the joints' rows, c the compliances. Each body is a
// node of 3 rows, each joint a node of 1 to 3 rows. In a tree the order below adds no block.
//
// A joint may follow when the bodies eliminated around it leave its rows as many degrees of freedom as it has rows; all
// that is not eliminated counts as the ground. Otherwise the pivot of a joint in a loop would be a rounding error: a
// body that hangs on the loop has freedom of its own, which is of no use to the loop. Each row of a joint must act on
// each of the eliminated bodies, or the joint follows all its bodies.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ticktrue::engine {

inline constexpr std::size_t joint_body_max = 4;
/// Each loop adds up to three columns to the blocks of a node. Components with more loops are solved by iteration.
inline constexpr std::uint32_t direct_loop_max = 8;

/// A joint as input of the order.
struct GraphJoint {
  std::array<std::uint32_t, joint_body_max> bodies{};  // moving bodies, by index
  std::uint32_t body_count = 0;
  std::uint32_t row_count = 0;  // 1..3
  bool is_to_world = false;     // one of its bodies does not move
  bool is_last = false;         // some row may act on a part of its bodies alone: the joint follows all of them
  std::uint32_t dimension = 3;  // of its blocks: further rows are not used
  bool holds_point = false;     // rows: x and y of a point of two bodies, then perhaps their angle, which both have
};

inline constexpr std::uint32_t no_articulation = 0xffffffff;

struct GraphNode {
  bool is_joint = false;
  bool is_redundant = false;       // a joint whose rows follow from others, according to the count of freedom
  std::uint32_t index = 0;         // of the body or joint
  std::uint32_t dimension = 3;     // of its blocks; 3 of a body
  std::uint32_t first_block = 0;   // the blocks below the diagonal, one for each later node that is coupled
  std::uint32_t block_count = 0;   // the rows of these blocks ascend
  std::uint32_t first_target = 0;  // for i < j in these blocks, in order: the block of rows j and columns i
  bool is_carried = false;         // a body that is eliminated with its joint, as an articulated one
  std::uint32_t articulation = no_articulation;  // of a joint: in JointGraph::articulations
};

inline constexpr std::uint32_t no_node = 0xffffffff;

/// A joint that alone connects an eliminated body to the rest (articulated.h).
struct Articulation {
  std::uint32_t child = 0;         // the node of that body
  std::uint32_t parent = no_node;  // the node of the other body; no_node: it does not move
};

/// The place of the gradient of a joint with respect to one of its bodies.
struct GradientPlace {
  std::uint32_t block = 0;
  bool is_transposed = false;
};

struct JointGraph {
  std::vector<GraphNode> nodes;           // in the order of elimination
  std::vector<std::uint32_t> block_rows;  // [block] a node
  std::vector<std::uint32_t> targets;     // blocks
  std::vector<std::uint32_t> body_nodes;  // [body]
  std::vector<std::uint32_t> joint_nodes;
  std::vector<std::array<GradientPlace, joint_body_max>> gradients;  // [joint][body of the joint]
  std::vector<Articulation> articulations;
  std::vector<std::uint32_t> fill_blocks;  // zero before the elimination
  std::uint32_t column_max = 0;            // the largest number of blocks of a node
};

/// The number of joints beyond those of a forest. Joints to bodies that do not move close no loop.
std::uint32_t count_loops(std::uint32_t body_count, const std::vector<GraphJoint>& joints);

/// The order depends on the indices of bodies and joints alone. `turns`: [body] 0 for a body with two degrees of
/// freedom; empty: each has three. Requires: a joint has bodies, and its bodies differ.
JointGraph make_joint_graph(std::uint32_t body_count, const std::vector<GraphJoint>& joints,
                            const std::vector<std::uint8_t>& turns = {});

}  // namespace ticktrue::engine
