// Fills the system of a direct island joint by joint, and factors it.
// SPDX-License-Identifier: MIT
#include "engine/joints/direct/direct_system.h"

#include <utility>

namespace ticktrue::engine {
namespace {

/// Relative to the mobility of a row alone. Redundant rows get more, since nothing else bounds their impulses.
constexpr double compliance_share = 1e-10;
constexpr double redundant_compliance_share = 1e-8;

bool turns(const DirectBody& body) {
  return body.inv_inertia > 0;
}

/// Whether the system takes the gradients of the body unchanged.
bool keeps_gradient(const DirectIsland& island, std::uint32_t body) {
  return !is_moving(island, body) || turns(island.bodies[body]);
}

/// Sets an articulation of the system from the joint's equations and its law of the angle.
void set_articulation(DirectIsland& island, std::uint32_t index, std::uint32_t articulation) {
  DirectJoint& joint = island.joints[index];
  const JointEquations& equations = joint.equations;
  const std::uint32_t child = island.graph->nodes[island.graph->articulations[articulation].child].index;
  const bool has_angle = equations.row_count == 3;
  const RowLaw law = has_angle ? law_of(island, joint, 2) : RowLaw{false, 0, 0, 0};
  ArticulatedArms arms;
  double a_x = -equations.gradient_a[5];
  double a_y = equations.gradient_a[2];
  double b_x = equations.gradient_b[5];
  double b_y = -equations.gradient_b[2];
  if (is_moving(island, joint.body_a) && !turns(island.bodies[joint.body_a])) a_x = a_y = 0;
  if (is_moving(island, joint.body_b) && !turns(island.bodies[joint.body_b])) b_x = b_y = 0;
  if (joint.body_b == child)
    arms = {1, b_x, b_y, a_x, a_y, law.is_in_system, law.compliance};
  else
    arms = {-1, a_x, a_y, b_x, b_y, law.is_in_system, law.compliance};
  island.system.articulated[articulation].arms = arms;
  joint.compliances = {0, 0, law.compliance};
}

/// Sets a joint of the system from its equations and laws.
void set_joint(DirectIsland& island, std::uint32_t index) {
  const std::uint32_t articulation = island.graph->nodes[island.graph->joint_nodes[index]].articulation;
  if (articulation != no_articulation) return set_articulation(island, index, articulation);
  DirectJoint& joint = island.joints[index];
  const JointEquations& equations = joint.equations;
  const bool is_redundant = island.graph->nodes[island.graph->joint_nodes[index]].is_redundant;
  const double share = is_redundant ? redundant_compliance_share : compliance_share;
  joint.compliances = {1, 1, 1};
  std::array<bool, 3> is_set{};
  bool is_whole = keeps_gradient(island, joint.body_a) && keeps_gradient(island, joint.body_b);
  for (std::size_t row = 0; row < equations.row_count; ++row) {
    const RowLaw law = law_of(island, joint, row);
    const double k = law.is_in_system ? mobility(island, joint, row) : 0;
    is_set[row] = k > 0;
    is_whole = is_whole && is_set[row];
    if (is_set[row]) joint.compliances[row] = law.compliance > share * k ? law.compliance : share * k;
  }
  set_joint(*island.graph, island.system, index, joint.compliances);
  std::uint32_t place = 0;
  for (const auto& [body, gradient] :
       {std::pair{joint.body_a, &equations.gradient_a}, std::pair{joint.body_b, &equations.gradient_b}}) {
    if (!is_moving(island, body)) continue;
    if (is_whole) {
      set_gradient(*island.graph, island.system, index, place++, *gradient);
      continue;
    }
    Block entries = *gradient;
    for (std::size_t row = 0; row < equations.row_count; ++row)
      for (std::size_t column = 0; column < 3; ++column)
        if (!is_set[row] || (column == 2 && !turns(island.bodies[body]))) entries[3 * row + column] = 0;
    set_gradient(*island.graph, island.system, index, place++, entries);
  }
}

/// Sets a node of the system from equations and laws.
void set_node(DirectIsland& island, const GraphNode& node) {
  if (node.is_joint) return set_joint(island, node.index);
  const DirectBody& body = island.bodies[node.index];
  set_body(*island.graph, island.system, node.index, body.mass, turns(body) ? body.inertia : 1);
}

}  // namespace

void factor_laws(DirectIsland& island) {
  const JointGraph& graph = *island.graph;
  clear_system(graph, island.system);
  std::size_t set_count = 0;
  for (std::size_t at = 0; at < graph.nodes.size(); ++at) {
    const GraphNode& node = graph.nodes[at];
    const std::size_t last = node.block_count > 0 ? graph.block_rows[node.first_block + node.block_count - 1] : at;
    for (; set_count <= last; ++set_count) set_node(island, graph.nodes[set_count]);
    factor_node(graph, island.system, at);
  }
}

}  // namespace ticktrue::engine
