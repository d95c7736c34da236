// Active contacts as a system of equations.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A Jacobian row J of an active contact point: normal, or static friction.
struct ActiveRow {
  std::uint32_t batch, lane, point;  // the place of its impulse
  std::uint32_t body_a, body_b;      // rows
  std::uint32_t read_a, read_b;      // records
  std::uint32_t place_a, place_b;    // in ImpulseStep::bodies, or no_body
  double along_a[3], along_b[3];     // x, y, angular
  double residual;                   // J v - wanted, m/s
  double stiffness;                  // kg
  double impulse, change;            // N s
  double friction;                   // coefficient
  bool is_friction;                  // the row before it is the normal of the same point
};

/// All active contacts of a set, solved at once.
struct ImpulseStep {
  std::vector<ActiveRow> rows;
  std::vector<double> full_change;        // [row] changes before the projection
  std::vector<std::uint32_t> start;       // [body] in `neighbours`
  std::vector<std::uint32_t> neighbours;  // bodies
  std::vector<std::uint8_t> is_start;     // [body] has a contact with a non-dynamic body
  std::vector<std::uint32_t> place;       // [body] in `bodies`, or no_body
  std::vector<std::uint32_t> bodies;
  std::vector<std::uint32_t> first;    // [unknown] column of the first entry of its row
  std::vector<std::size_t> row_start;  // [unknown] in `matrix`
  std::vector<double> matrix;
  std::vector<double> velocity, total;  // [unknown]
};

template <typename Visit>
void list_fields(ImpulseStep& of, const Visit& visit) {
  auto& [rows, full_change, start, neighbours, is_start, place, bodies, first, row_start, matrix, velocity, total] = of;
  visit(rows, full_change, start, neighbours, is_start, place, bodies, first, row_start, matrix, velocity, total);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
