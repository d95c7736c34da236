// Compares tables that changed with those of the first state, for the columns without a change so far.
// SPDX-License-Identifier: MIT
#include "capi/change_summary.h"

#include <cstring>

#include "base/state/child_tables.h"

namespace ticktrue::capi {
namespace {

constexpr std::size_t summary_name_count_max = 8;

std::string names_text(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < summary_name_count_max; ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > summary_name_count_max)
    text += " and " + std::to_string(names.size() - summary_name_count_max) + " more";
  return text;
}

/// The first column whose constancy is worth reporting. Keys and the fill counts of text pieces come before it.
std::size_t first_column(const TableSchema& schema) {
  return has_pieces(schema) ? schema.columns.size() - 1 : schema.key_column_count;
}

}  // namespace

/// Looks for columns of a table that differ from the first state. Requires: the table differs.
void ChangeSummary::compare(std::size_t number, const TableRows& rows) {
  Table& table = tables_[number];
  const TableSchema& schema = first_->view().schema->tables[number];
  const TableRows& first = first_->view().tables[number];
  if (table.constant.empty()) return;
  if (rows.row_count != first.row_count) {
    table.constant.clear();  // rows were added or removed
    return;
  }
  const std::size_t size = schema.row_size;
  std::erase_if(table.constant, [&](std::size_t c) {
    const Column& column = schema.columns[c];
    const std::size_t column_size = static_cast<std::size_t>(scalar_info(column.type)->size) * column.lane_count;
    for (std::size_t at = column.offset; at < size * rows.row_count; at += size)
      if (std::memcmp(rows.data + at, first.data + at, column_size) != 0) return true;
    return false;
  });
}

void ChangeSummary::add(const StateView& state, std::span<const std::uint64_t> table_hashes) {
  if (!first_) {
    first_.emplace(state);
    first_hashes_.assign(table_hashes.begin(), table_hashes.end());
    tables_.resize(state.tables.size());
    for (std::size_t t = 0; t < tables_.size(); ++t) {
      const TableSchema& schema = state.schema->tables[t];
      for (std::size_t c = first_column(schema); c < schema.columns.size(); ++c) tables_[t].constant.push_back(c);
    }
  }
  for (std::size_t t = 0; t < tables_.size(); ++t) {
    tables_[t].had_rows = tables_[t].had_rows || state.tables[t].row_count > 0;
    if (table_hashes[t] != first_hashes_[t]) compare(t, state.tables[t]);
  }
}

std::vector<std::string> ChangeSummary::lines() const {
  std::vector<std::string> lines, empty, constant;
  if (!first_) return lines;
  bool is_any_changed = false;
  for (std::size_t t = 0; t < tables_.size(); ++t) {
    const TableSchema& schema = first_->view().schema->tables[t];
    if (!tables_[t].had_rows) {
      empty.push_back(schema.name);
      continue;
    }
    is_any_changed = is_any_changed || tables_[t].constant.size() + first_column(schema) < schema.columns.size();
    for (const std::size_t c : tables_[t].constant)
      constant.push_back(has_pieces(schema) ? schema.name : schema.name + "." + schema.columns[c].name);
  }
  if (!empty.empty()) lines.push_back("tables that stayed empty: " + names_text(empty));
  if (!constant.empty() && is_any_changed) lines.push_back("columns that never changed: " + names_text(constant));
  return lines;
}

}  // namespace ticktrue::capi
