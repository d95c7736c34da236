// Names of rows, and the text for a place in a state.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "base/state/state_view.h"

namespace ticktrue {

/// The name of a row, empty where it has none: table, row.
using RowNamer = std::function<std::string(std::size_t table, std::size_t row)>;

/// "bodies row 3 (crate_7), column velocity, lane 1". A trace that ends in a value that is not finite has it in its
/// note.
inline std::string place_text(const StateSchema& schema, const StatePlace& place, const RowNamer& row_name) {
  const TableSchema& table = schema.tables[place.table];
  const std::string name = row_name ? row_name(place.table, place.row) : "";
  return table.name + " row " + std::to_string(place.row) + (name.empty() ? "" : " (" + name + ")") + ", column " +
         table.columns[place.column].name + ", lane " + std::to_string(place.lane);
}

}  // namespace ticktrue
