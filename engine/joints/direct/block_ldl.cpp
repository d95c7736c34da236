// LDL^T of the direct joint solver: products of 3 x 3 blocks in a fixed order.
// SPDX-License-Identifier: MIT
// Source: Golub and Van Loan, "Matrix Computations", 4.1 (LDL^T); Davis, "Direct Methods for Sparse Linear Systems",
// 2006 (fill and elimination).
#include "engine/joints/direct/block_ldl.h"

#include <type_traits>

namespace ticktrue::engine {
namespace {

constexpr std::size_t n = 3;

/// Replaces the leading symmetric block of this dimension by its inverse, by LDL^T. Reads the lower half. Requires:
/// definite.
template <std::size_t dimension>
[[gnu::always_inline]] inline void invert(Block& a) {
  const double inv_0 = 1 / a[0];
  if constexpr (dimension == 1) {
    a[0] = inv_0;
    return;
  }
  const double l_10 = a[3] * inv_0;
  const double inv_1 = 1 / (a[4] - l_10 * a[3]);
  if constexpr (dimension == 2) {
    a[0] = inv_0 + l_10 * l_10 * inv_1;
    a[1] = a[3] = -(l_10 * inv_1);
    a[4] = inv_1;
    return;
  }
  const double l_20 = a[6] * inv_0;
  const double below = a[7] - l_20 * a[3];
  const double l_21 = below * inv_1;
  const double inv_2 = 1 / ((a[8] - l_20 * a[6]) - l_21 * below);
  const double m_20 = l_10 * l_21 - l_20;  // of L^-1
  a[0] = (inv_0 + l_10 * l_10 * inv_1) + m_20 * m_20 * inv_2;
  a[1] = a[3] = -(l_10 * inv_1) - m_20 * l_21 * inv_2;
  a[2] = a[6] = m_20 * inv_2;
  a[4] = inv_1 + l_21 * l_21 * inv_2;
  a[5] = a[7] = -(l_21 * inv_2);
  a[8] = inv_2;
}

template <std::size_t dimension>
using Dimension = std::integral_constant<std::size_t, dimension>;

/// Calls body with the dimension as a compile-time constant, so that its loops have constant ends.
template <typename Body>
[[gnu::always_inline]] inline void with_dimension(std::uint32_t dimension, const Body& body) {
  if (dimension == 3)
    body(Dimension<3>{});
  else if (dimension == 2)
    body(Dimension<2>{});
  else
    body(Dimension<1>{});
}

template <std::size_t count>
[[gnu::always_inline]] inline double row_product(const double* a, const double* b) {
  double sum = a[0] * b[0];
  for (std::size_t j = 1; j < count; ++j) sum += a[j] * b[j];
  return sum;
}

/// a b
template <std::size_t rows, std::size_t columns>
[[gnu::always_inline]] inline void set_product(Block& r, const Block& a, const Block& b) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k < columns; ++k) {
      double sum = a[n * i] * b[k];
      for (std::size_t j = 1; j < columns; ++j) sum += a[n * i + j] * b[n * j + k];
      r[n * i + k] = sum;
    }
}

/// r -= a b^T; `columns`: of a and b.
template <std::size_t columns, std::size_t rows_a, std::size_t rows_b>
[[gnu::always_inline]] inline void subtract_product(Block& r, const Block& a, const Block& b) {
  for (std::size_t i = 0; i < rows_a; ++i)
    for (std::size_t k = 0; k < rows_b; ++k) r[n * i + k] -= row_product<columns>(&a[n * i], &b[n * k]);
}

/// r -= a b^T for a symmetric block: only the lower half, which is all that inverses read.
template <std::size_t columns, std::size_t rows>
[[gnu::always_inline]] inline void subtract_lower(Block& r, const Block& a, const Block& b) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k <= i; ++k) r[n * i + k] -= row_product<columns>(&a[n * i], &b[n * k]);
}

/// Copies element by element: copies of whole blocks would go through memory.
template <std::size_t rows, std::size_t columns>
[[gnu::always_inline]] inline void copy(Block& r, const Block& a) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k < columns; ++k) r[n * i + k] = a[n * i + k];
}

template <std::size_t columns>
[[gnu::always_inline]] inline void factor_columns(const JointGraph& graph, BlockSystem& system, std::size_t at) {
  const GraphNode& node = graph.nodes[at];
  Block& inverse = system.diagonal[at];
  invert<columns>(inverse);
  Block* const blocks = system.blocks.data() + node.first_block;
  const std::uint32_t* const rows = graph.block_rows.data() + node.first_block;
  Block* const column = system.column.data();
  const auto dimension = [&](std::uint32_t i) { return graph.nodes[rows[i]].dimension; };
  std::uint32_t target = node.first_target;
  for (std::uint32_t i = 0; i < node.block_count; ++i)
    with_dimension(dimension(i), [&](auto r) {
      copy<r.value, columns>(column[i], blocks[i]);
      set_product<r.value, columns>(blocks[i], column[i], inverse);
    });
  for (std::uint32_t i = 0; i < node.block_count; ++i)
    with_dimension(dimension(i), [&](auto c) {
      subtract_lower<columns, c.value>(system.diagonal[rows[i]], blocks[i], column[i]);
      for (std::uint32_t k = i + 1; k < node.block_count; ++k) {
        Block& block = system.blocks[graph.targets[target++]];
        with_dimension(dimension(k),
                       [&](auto r) { subtract_product<columns, r.value, c.value>(block, blocks[k], column[i]); });
      }
    });
}

template <std::size_t columns>
[[gnu::always_inline]] inline void solve_forward(const JointGraph& graph, BlockSystem& system, std::size_t at) {
  const GraphNode& node = graph.nodes[at];
  double value[columns];  // element by element: copies of whole blocks would go through memory
  for (std::size_t k = 0; k < columns; ++k) value[k] = system.values[at][k];
  for (std::uint32_t i = node.first_block; i < node.first_block + node.block_count; ++i) {
    const std::uint32_t row = graph.block_rows[i];
    const Block& block = system.blocks[i];
    Triple& of_row = system.values[row];
    with_dimension(graph.nodes[row].dimension, [&](auto rows) {
      for (std::size_t k = 0; k < rows.value; ++k) of_row[k] -= row_product<columns>(&block[n * k], value);
    });
  }
}

template <std::size_t columns>
[[gnu::always_inline]] inline void solve_backward(const JointGraph& graph, BlockSystem& system, std::size_t at) {
  const GraphNode& node = graph.nodes[at];
  const Block& inverse = system.diagonal[at];
  Triple value{};
  for (std::size_t k = 0; k < columns; ++k) value[k] = row_product<columns>(&inverse[n * k], system.values[at].data());
  for (std::uint32_t i = node.first_block; i < node.first_block + node.block_count; ++i) {
    const std::uint32_t row = graph.block_rows[i];
    const Block& block = system.blocks[i];
    const Triple& of_row = system.values[row];
    with_dimension(graph.nodes[row].dimension, [&](auto rows) {
      for (std::size_t k = 0; k < columns; ++k) {
        double sum = block[k] * of_row[0];
        for (std::size_t j = 1; j < rows.value; ++j) sum += block[n * j + k] * of_row[j];
        value[k] -= sum;
      }
    });
  }
  for (std::size_t k = 0; k < columns; ++k) system.values[at][k] = value[k];
}

Block* parent_block(const Articulation& at, BlockSystem& system) {
  return at.parent == no_node ? nullptr : &system.diagonal[at.parent];
}
Triple* parent_values(const Articulation& at, BlockSystem& system) {
  return at.parent == no_node ? nullptr : &system.values[at.parent];
}

}  // namespace

void clear_system(const JointGraph& graph, BlockSystem& system) {
  system.diagonal.resize(graph.nodes.size());
  system.blocks.resize(graph.block_rows.size());
  system.values.resize(graph.nodes.size());
  system.column.resize(graph.column_max);
  system.articulated.resize(graph.articulations.size());
  for (const std::uint32_t block : graph.fill_blocks) system.blocks[block] = {};
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

void factor_node(const JointGraph& graph, BlockSystem& system, std::size_t at) {
  const GraphNode& node = graph.nodes[at];
  if (node.is_carried) return;
  if (node.articulation != no_articulation) {
    const Articulation& ends = graph.articulations[node.articulation];
    factor(system.articulated[node.articulation], system.diagonal[ends.child], parent_block(ends, system));
    return;
  }
  with_dimension(node.dimension, [&](auto columns) { factor_columns<columns.value>(graph, system, at); });
}

void solve(const JointGraph& graph, BlockSystem& system) {
  for (std::size_t at = 0; at < graph.nodes.size(); ++at) {
    const GraphNode& node = graph.nodes[at];
    if (node.is_carried) continue;
    if (node.articulation != no_articulation) {
      const Articulation& ends = graph.articulations[node.articulation];
      eliminate(system.articulated[node.articulation], system.values[at], system.values[ends.child],
                parent_values(ends, system));
      continue;
    }
    with_dimension(node.dimension, [&](auto columns) { solve_forward<columns.value>(graph, system, at); });
  }
  for (std::size_t at = graph.nodes.size(); at-- > 0;) {
    const GraphNode& node = graph.nodes[at];
    if (node.is_carried) continue;
    if (node.articulation != no_articulation) {
      const Articulation& ends = graph.articulations[node.articulation];
      substitute(system.articulated[node.articulation], system.values[at], system.values[ends.child],
                 parent_values(ends, system));
      continue;
    }
    with_dimension(node.dimension, [&](auto columns) { solve_backward<columns.value>(graph, system, at); });
  }
}

}  // namespace ticktrue::engine
