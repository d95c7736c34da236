// Finds a value that is not finite and describes its place.
// SPDX-License-Identifier: MIT
#include "base/state/non_finite.h"

#include "base/state/state_view.h"

namespace ticktrue {

std::optional<NonFinite> find_non_finite_of(const Simulation& simulation, std::uint64_t tick) {
  const StateView& state = simulation.state();
  const std::optional<StatePlace> place = find_non_finite(state);
  if (!place) return std::nullopt;
  const TableSchema& table = state.schema->tables[place->table];
  const Column& column = table.columns[place->column];
  Bytes image;
  encode_image(state, image);
  NonFinite found;
  found.tick = tick;
  found.table = table.name;
  found.row = place->row;
  found.row_name = simulation.row_name(place->table, place->row);
  found.column = column.name;
  found.lane = static_cast<std::uint32_t>(place->lane);
  if (const auto tables = split_image(*state.schema, image))
    found.value = lane_text(column.type, lane_bits(table, (*tables)[place->table].rows, *place));
  return found;
}

std::string non_finite_text(const NonFinite& found) {
  return "tick " + std::to_string(found.tick) + ": table " + found.table + ", row " + std::to_string(found.row) +
         (found.row_name.empty() ? "" : " (" + found.row_name + ")") + ", column " + found.column + ", lane " +
         std::to_string(found.lane) + ": found " + found.value + ", expected a finite number";
}

}  // namespace ticktrue
