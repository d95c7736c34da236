// LDL^T of the direct joint solver: products of 3 x 3 blocks in a fixed order.
// SPDX-License-Identifier: MIT
// Source: Golub and Van Loan, "Matrix Computations", 4.1 (LDL^T); Davis, "Direct Methods for Sparse Linear Systems",
// 2006 (fill and elimination).
#include "engine/joints/direct/block_ldl.h"

namespace ticktrue::engine {
namespace {

constexpr std::size_t n = 3;

/// The inverse of a symmetric block by its own LDL^T. Requires: definite.
Block inverse_of(const Block& a) {
  const double inv_0 = 1 / a[0];
  const double l_10 = a[3] * inv_0;
  const double l_20 = a[6] * inv_0;
  const double inv_1 = 1 / (a[4] - l_10 * a[3]);
  const double below = a[7] - l_20 * a[3];
  const double l_21 = below * inv_1;
  const double inv_2 = 1 / ((a[8] - l_20 * a[6]) - l_21 * below);
  const double m_20 = l_10 * l_21 - l_20;  // of L^-1
  const double r_01 = -(l_10 * inv_1) - m_20 * l_21 * inv_2;
  const double r_02 = m_20 * inv_2;
  const double r_12 = -(l_21 * inv_2);
  return {(inv_0 + l_10 * l_10 * inv_1) + m_20 * m_20 * inv_2,
          r_01,
          r_02,
          r_01,
          inv_1 + l_21 * l_21 * inv_2,
          r_12,
          r_02,
          r_12,
          inv_2};
}

Block product(const Block& a, const Block& b) {
  Block r;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k)
      r[n * i + k] = (a[n * i] * b[k] + a[n * i + 1] * b[n + k]) + a[n * i + 2] * b[2 * n + k];
  return r;
}

/// r -= a b^T
void subtract_product(Block& r, const Block& a, const Block& b) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < n; ++k)
      r[n * i + k] -= (a[n * i] * b[n * k] + a[n * i + 1] * b[n * k + 1]) + a[n * i + 2] * b[n * k + 2];
}

Triple product(const Block& a, const Triple& v) {
  Triple r;
  for (std::size_t i = 0; i < n; ++i) r[i] = (a[n * i] * v[0] + a[n * i + 1] * v[1]) + a[n * i + 2] * v[2];
  return r;
}

Triple transposed_product(const Block& a, const Triple& v) {
  Triple r;
  for (std::size_t i = 0; i < n; ++i) r[i] = (a[i] * v[0] + a[n + i] * v[1]) + a[2 * n + i] * v[2];
  return r;
}

void subtract(Triple& r, const Triple& v) {
  for (std::size_t i = 0; i < n; ++i) r[i] -= v[i];
}

}  // namespace

void clear_system(const JointGraph& graph, BlockSystem& system) {
  system.diagonal.assign(graph.nodes.size(), Block{});
  system.blocks.assign(graph.block_rows.size(), Block{});
  system.values.assign(graph.nodes.size(), Triple{});
}

void set_body(const JointGraph& graph, BlockSystem& system, std::uint32_t body, double mass, double inertia) {
  system.diagonal[graph.body_nodes[body]] = {mass, 0, 0, 0, mass, 0, 0, 0, inertia};
}

void set_joint(const JointGraph& graph, BlockSystem& system, std::uint32_t joint, const Triple& compliances) {
  system.diagonal[graph.joint_nodes[joint]] = {-compliances[0], 0, 0, 0, -compliances[1], 0, 0, 0, -compliances[2]};
}

void set_gradient(const JointGraph& graph, BlockSystem& system, std::uint32_t joint, std::uint32_t body_place,
                  const Block& gradient) {
  const GradientPlace& place = graph.gradients[joint][body_place];
  Block& block = system.blocks[place.block];
  for (std::size_t row = 0; row < n; ++row)
    for (std::size_t column = 0; column < n; ++column)
      block[place.is_transposed ? n * column + row : n * row + column] = gradient[n * row + column];
}

void factor(const JointGraph& graph, BlockSystem& system) {
  for (std::size_t at = 0; at < graph.nodes.size(); ++at) {
    const GraphNode& node = graph.nodes[at];
    const Block inverse = inverse_of(system.diagonal[at]);
    system.diagonal[at] = inverse;
    const auto begin = system.blocks.begin() + node.first_block;
    system.column.assign(begin, begin + node.block_count);
    for (std::uint32_t i = 0; i < node.block_count; ++i)
      system.blocks[node.first_block + i] = product(system.column[i], inverse);
    std::uint32_t target = node.first_target;
    for (std::uint32_t i = 0; i < node.block_count; ++i) {
      const std::uint32_t block = node.first_block + i;
      subtract_product(system.diagonal[graph.block_rows[block]], system.blocks[block], system.column[i]);
      for (std::uint32_t k = i + 1; k < node.block_count; ++k)
        subtract_product(system.blocks[graph.targets[target++]], system.blocks[node.first_block + k], system.column[i]);
    }
  }
}

void solve(const JointGraph& graph, BlockSystem& system) {
  for (std::size_t at = 0; at < graph.nodes.size(); ++at) {
    const GraphNode& node = graph.nodes[at];
    const Triple value = system.values[at];
    for (std::uint32_t i = node.first_block; i < node.first_block + node.block_count; ++i)
      subtract(system.values[graph.block_rows[i]], product(system.blocks[i], value));
  }
  for (std::size_t at = graph.nodes.size(); at-- > 0;) {
    const GraphNode& node = graph.nodes[at];
    Triple value = product(system.diagonal[at], system.values[at]);
    for (std::uint32_t i = node.first_block; i < node.first_block + node.block_count; ++i)
      subtract(value, transposed_product(system.blocks[i], system.values[graph.block_rows[i]]));
    system.values[at] = value;
  }
}

}  // namespace ticktrue::engine
