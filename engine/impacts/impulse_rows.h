// Contacts that push together, as a system of equations.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A contact point that pushes, or holds by friction, as a row J of the velocities of its two bodies.
struct ActiveRow {
  std::uint32_t batch, lane, point;  // where its impulse is
  std::uint32_t body_a, body_b;      // rows
  std::uint32_t read_a, read_b;      // records
  std::uint32_t place_a, place_b;    // in ImpulseStep::bodies, or no_body
  double along_a[3], along_b[3];     // x, y, angular
  double residual;                   // J v less what is wanted, m/s
  double stiffness;                  // kg
  double impulse, change;            // N s
  double friction;                   // coefficient
  bool is_friction;                  // with the row before as its normal
};

/// All contacts of a group that push, solved at once.
struct ImpulseStep {
  std::vector<ActiveRow> rows;
  std::vector<double> full_change;        // [row] changes before they are cut
  std::vector<std::uint32_t> start;       // [body] in `neighbours`
  std::vector<std::uint32_t> neighbours;  // bodies
  std::vector<std::uint8_t> is_start;     // [body] touches something immovable
  std::vector<std::uint32_t> place;       // [body] in `bodies`, or no_body
  std::vector<std::uint32_t> bodies;
  std::vector<std::uint32_t> first;    // [unknown] column of the first entry of its row
  std::vector<std::size_t> row_start;  // [unknown] in `matrix`
  std::vector<double> matrix;
  std::vector<double> velocity, total;  // [unknown]
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
