// Copies the rows of a state, and compares them with those of another.
// SPDX-License-Identifier: MIT
#include "base/state/kept_state.h"

#include <cstring>

namespace ticktrue {

KeptState::KeptState(const StateView& state) {
  view_.schema = state.schema;
  rows_.reserve(state.tables.size());
  for (std::size_t t = 0; t < state.tables.size(); ++t) {
    const TableRows& rows = state.tables[t];
    const std::size_t size = static_cast<std::size_t>(rows.row_count) * state.schema->tables[t].row_size;
    rows_.emplace_back(rows.data, rows.data + size);
    view_.tables.push_back({rows_.back().data(), rows.row_count});
    size_ += size;
  }
}

bool KeptState::is_same(const StateView& state) const {
  for (std::size_t t = 0; t < rows_.size(); ++t) {
    if (state.tables[t].row_count != view_.tables[t].row_count) return false;
    if (!rows_[t].empty() && std::memcmp(rows_[t].data(), state.tables[t].data, rows_[t].size()) != 0) return false;
  }
  return true;
}

}  // namespace ticktrue
