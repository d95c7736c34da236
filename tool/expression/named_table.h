// A table of the state by its name.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "base/state/state_view.h"

namespace ticktrue::tool {

/// The rows of a table of the state, with values by column.
class NamedTable {
 public:
  NamedTable(const StateView& state, std::string_view name) {
    const std::optional<std::size_t> table = state.schema->find_table(name);
    if (!table) return;
    schema_ = &state.schema->tables[*table];
    rows_ = state.tables[*table];
  }
  std::uint32_t row_count() const { return rows_.row_count; }

  /// Requires: the column has u32, f32 or f64, and there is such a lane.
  double value(std::uint32_t row, std::string_view column, unsigned lane = 0) const {
    const auto found = std::find_if(schema_->columns.begin(), schema_->columns.end(),
                                    [&](const Column& info) { return info.name == column; });
    const std::size_t size = scalar_info(found->type)->size;
    const std::uint8_t* at = rows_.data + std::size_t{row} * schema_->row_size + found->offset + lane * size;
    if (found->type == ScalarType::f32) return static_cast<double>(read<float>(at));
    if (found->type == ScalarType::f64) return read<double>(at);
    return read<std::uint32_t>(at);
  }
  /// Requires: the column has u32.
  std::uint32_t whole(std::uint32_t row, std::string_view column) const {
    return static_cast<std::uint32_t>(value(row, column));
  }

 private:
  template <typename T>
  static T read(const std::uint8_t* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
  }

  const TableSchema* schema_ = nullptr;
  TableRows rows_;
};

}  // namespace ticktrue::tool
