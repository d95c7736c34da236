// Compares two schemas table by table and column by column.
// SPDX-License-Identifier: MIT
#include "verifier/locate/schema_difference.h"

#include <algorithm>

namespace ticktrue::verifier {
namespace {

std::string range_text(const Column& column) {
  return lane_text(ScalarType::f64, bits_of(column.min)) + ".." + lane_text(ScalarType::f64, bits_of(column.max));
}

std::string reference_text(const StateSchema& schema, const Column& column) {
  if (column.target < 0) return "no reference";
  return (column.optional ? "optional reference to " : "reference to ") +
         schema.tables[static_cast<std::size_t>(column.target)].name;
}

/// Requires: equal types and lane counts.
bool range_may_differ(const Column& a, const Column& b, Ranges ranges) {
  if (a.target >= 0 || b.target >= 0 || ranges == Ranges::same) return false;
  return ranges == Ranges::any || (a.min >= b.min && a.max <= b.max);
}

std::optional<SchemaDifference> column_difference(const StateSchema& a, const StateSchema& b, const std::string& place,
                                                  const Column& column_a, const Column& column_b, Ranges ranges) {
  if (column_a.type != column_b.type)
    return SchemaDifference{place, std::string(scalar_info(column_a.type)->name),
                            std::string(scalar_info(column_b.type)->name)};
  if (column_a.lane_count != column_b.lane_count)
    return SchemaDifference{place, std::to_string(column_a.lane_count) + " lanes",
                            std::to_string(column_b.lane_count) + " lanes"};
  const bool same_range =
      bits_of(column_a.min) == bits_of(column_b.min) && bits_of(column_a.max) == bits_of(column_b.max);
  if (!same_range && !range_may_differ(column_a, column_b, ranges))
    return SchemaDifference{
        place, range_text(column_a), range_text(column_b),
        ranges == Ranges::inside && column_a.target < 0 ? "values may be recorded that this build does not know" : ""};
  if (column_a.target != column_b.target || column_a.optional != column_b.optional)
    return SchemaDifference{place, reference_text(a, column_a), reference_text(b, column_b)};
  if (column_a.offset != column_b.offset)
    return SchemaDifference{place, "at byte " + std::to_string(column_a.offset),
                            "at byte " + std::to_string(column_b.offset)};
  return std::nullopt;
}

std::string child_text(const StateSchema& schema, const TableSchema& table) {
  static constexpr std::string_view children[] = {"rows", "bytes", "text"};
  if (table.parent < 0) return "no child table";
  return "child table (" + std::string(children[static_cast<std::size_t>(table.form) - 1]) + ") of " +
         schema.tables[static_cast<std::size_t>(table.parent)].name;
}

std::string table_names(const StateSchema& schema) {
  std::string text;
  for (const TableSchema& table : schema.tables) text += (text.empty() ? "" : ", ") + table.name;
  return text;
}

}  // namespace

std::string schema_text(const SchemaDifference& difference) {
  return "schema: " + difference.place + ": recorded " + difference.a + ", here " + difference.b +
         (difference.meaning.empty() ? "" : ": " + difference.meaning);
}

std::optional<SchemaDifference> precision_difference(const StateSchema& a, const StateSchema& b) {
  if (a.tables.size() != b.tables.size()) return std::nullopt;
  std::optional<SchemaDifference> found;
  for (std::size_t t = 0; t < a.tables.size(); ++t) {
    const TableSchema& table_a = a.tables[t];
    const TableSchema& table_b = b.tables[t];
    if (table_a.name != table_b.name || table_a.columns.size() != table_b.columns.size()) return std::nullopt;
    for (std::size_t c = 0; c < table_a.columns.size(); ++c) {
      const Column& column_a = table_a.columns[c];
      Column same = table_b.columns[c];
      const std::string_view name_a = scalar_info(column_a.type)->name;
      const std::string_view name_b = scalar_info(same.type)->name;
      if (column_a.type != same.type) {
        if (!scalar_info(column_a.type)->is_float || !scalar_info(same.type)->is_float) return std::nullopt;
        const SchemaDifference here{"precision", std::string(name_a), std::string(name_b)};
        if (found && found->a != here.a) return std::nullopt;
        found = here;
        same.type = column_a.type;
      }
      same.offset = column_a.offset;
      if (!(same == column_a)) return std::nullopt;
    }
  }
  return found;
}

std::optional<SchemaDifference> first_schema_difference(const StateSchema& a, const StateSchema& b, Ranges ranges) {
  for (const TableSchema& table : a.tables) {
    const auto index = b.find_table(table.name);
    if (!index) return SchemaDifference{table.name, "a table", "no such table"};
    const TableSchema& other = b.tables[*index];
    for (std::size_t c = 0; c < std::max(table.columns.size(), other.columns.size()); ++c) {
      if (c >= other.columns.size())
        return SchemaDifference{table.name + "." + table.columns[c].name, "a column", "no such column"};
      if (c >= table.columns.size())
        return SchemaDifference{table.name + "." + other.columns[c].name, "no such column", "a column"};
      const Column& column_a = table.columns[c];
      const Column& column_b = other.columns[c];
      if (column_a.name != column_b.name)
        return SchemaDifference{"column " + std::to_string(c) + " of " + table.name, column_a.name, column_b.name};
      if (auto found = column_difference(a, b, table.name + "." + column_a.name, column_a, column_b, ranges))
        return found;
    }
    if (child_text(a, table) != child_text(b, other))
      return SchemaDifference{table.name, child_text(a, table), child_text(b, other)};
    if (table.row_size != other.row_size || table.key_column_count != other.key_column_count)
      return SchemaDifference{
          table.name,
          std::to_string(table.row_size) + " bytes a row, " + std::to_string(table.key_column_count) + " key columns",
          std::to_string(other.row_size) + " bytes a row, " + std::to_string(other.key_column_count) + " key columns"};
  }
  for (const TableSchema& table : b.tables)
    if (!a.find_table(table.name)) return SchemaDifference{table.name, "no such table", "a table"};
  const auto same_name = [](const TableSchema& one, const TableSchema& two) { return one.name == two.name; };
  if (std::equal(a.tables.begin(), a.tables.end(), b.tables.begin(), b.tables.end(), same_name)) return std::nullopt;
  return SchemaDifference{"tables", table_names(a), table_names(b)};
}

}  // namespace ticktrue::verifier
