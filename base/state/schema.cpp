// Schemas: what they may be, their judged part, and their bytes in a trace.
// SPDX-License-Identifier: MIT
#include "base/state/schema.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "base/limits.h"

namespace ticktrue {
namespace {

constexpr std::array<ScalarInfo, 10> scalars{{
    {ScalarType::u8, "u8", 1, false, false},
    {ScalarType::u16, "u16", 2, false, false},
    {ScalarType::u32, "u32", 4, false, false},
    {ScalarType::u64, "u64", 8, false, false},
    {ScalarType::i32, "i32", 4, false, true},
    {ScalarType::i64, "i64", 8, false, true},
    {ScalarType::f32, "f32", 4, true, false},
    {ScalarType::f64, "f64", 8, true, false},
    {ScalarType::i8, "i8", 1, false, true},
    {ScalarType::i16, "i16", 2, false, true},
}};

constexpr std::size_t child_key_count = 2;
constexpr std::size_t piece_column_count = 4;  // of a child of bytes or text: owner, index, size, bytes

bool is_of_first_layout(ScalarType type) {
  return type <= ScalarType::f64;
}

std::size_t table_count_max(SchemaLayout layout) {
  return layout == SchemaLayout::first ? limits::table_count_max : limits::registered_table_count_max;
}

Error schema_error(const std::string& what) {
  return {ErrorCode::corrupt, "schema: " + what, ""};
}

/// Two places with one name: the first that has a place before it. Sorted, since all pairs of thousands are millions.
struct Duplicate {
  std::size_t first = 0;
  std::size_t second = std::numeric_limits<std::size_t>::max();  // none
};
template <typename Item>
Duplicate find_duplicate(const std::vector<Item>& items) {
  std::vector<std::size_t> order(items.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&items](std::size_t a, std::size_t b) {
    const int compared = items[a].name.compare(items[b].name);
    return compared != 0 ? compared < 0 : a < b;
  });
  Duplicate found;
  for (std::size_t i = 1; i < order.size(); ++i)
    if (order[i] < found.second && items[order[i]].name == items[order[i - 1]].name) found = {order[i - 1], order[i]};
  return found;
}

std::string duplicate_text(const char* what, const Duplicate& duplicate) {
  return std::string(": stands twice: as ") + what + " " + std::to_string(duplicate.first) + " and as " + what + " " +
         std::to_string(duplicate.second) + ", counted from 0";
}

bool has_u32_key(const TableSchema& table) {
  return table.key_column_count == 1 && !table.columns.empty() && table.columns[0].type == ScalarType::u32;
}

Status check_target(const StateSchema& schema, const Column& column, const std::string& place) {
  if (column.target < -1 || column.target >= static_cast<int>(schema.tables.size()))
    return schema_error(place + ": refers to no table");
  if (column.target < 0) return {};
  const TableSchema& target = schema.tables[static_cast<std::size_t>(column.target)];
  if (column.type != ScalarType::u32 || !has_u32_key(target))
    return schema_error(place + ": a reference must be u32, to a table with one u32 key");
  if (!column.is_shown && target.row_size == 0)
    return schema_error(place + ": a judged column refers to table " + target.name + ", which has no judged column");
  return {};
}

Status check_key_column(const TableSchema& table, const Column& column, const std::string& place) {
  const ScalarInfo& info = *scalar_info(column.type);
  if (info.is_float || info.is_signed || column.lane_count != 1)
    return schema_error(place + ": a key column must be one unsigned integer");
  if (column.is_shown != table.columns[0].is_shown)
    return schema_error(place + ": key columns must all be judged, or all be shown");
  return {};
}

/// Bytes of the columns of a class so far.
struct RowSizes {
  std::size_t judged = 0;
  std::size_t shown = 0;
};

Status check_column(const StateSchema& schema, const TableSchema& table, std::size_t c, SchemaLayout layout,
                    RowSizes& sizes) {
  const Column& column = table.columns[c];
  const std::string place = "table " + table.name + ": column " + column.name;
  const ScalarInfo* info = scalar_info(column.type);
  if (info == nullptr || (layout == SchemaLayout::first && !is_of_first_layout(column.type)))
    return schema_error(place + ": unknown scalar type");
  if (column.lane_count == 0) return schema_error(place + ": no lanes");
  if (column.is_shown && layout == SchemaLayout::first)
    return schema_error(place + ": shown columns need format version 3");
  if (!column.is_shown && sizes.shown > 0) return schema_error(place + ": a judged column stands behind a shown one");
  std::size_t& end = column.is_shown ? sizes.shown : sizes.judged;
  if (column.offset != end)
    return schema_error(place + ": offset: found " + std::to_string(column.offset) + ", expected " +
                        std::to_string(end) + " (columns must cover the row without gaps)");
  end += static_cast<std::size_t>(info->size) * column.lane_count;
  if (c < table.key_column_count)
    if (const Status status = check_key_column(table, column, place); !status) return status;
  if (const Status status = check_target(schema, column, place); !status) return status;
  if (!(column.min <= column.max)) return schema_error(place + ": empty range");
  return {};
}

Status check_row_size(const TableSchema& table, const char* what, std::size_t found, std::size_t covered) {
  if (found == covered) return {};
  return schema_error("table " + table.name + ": " + what + ": found " + std::to_string(found) + ", columns cover " +
                      std::to_string(covered));
}

Status check_columns(const StateSchema& schema, const TableSchema& table, SchemaLayout layout) {
  const Duplicate same_column = find_duplicate(table.columns);
  RowSizes sizes;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const Column& column = table.columns[c];
    if (column.name.empty() || column.name.size() > limits::name_size_max)
      return schema_error("table " + table.name + ": column " + std::to_string(c) + ": name is empty or too long");
    if (c == same_column.second)
      return schema_error("table " + table.name + ": column " + column.name + duplicate_text("column", same_column));
    if (const Status status = check_column(schema, table, c, layout, sizes); !status) return status;
  }
  if (const Status status = check_row_size(table, "row size", table.row_size, sizes.judged); !status) return status;
  return check_row_size(table, "shown row size", table.shown_row_size, sizes.shown);
}

/// Whether a column of a child is as its form wants it.
bool is_child_column(const TableSchema& table, std::size_t c, std::string_view name) {
  const Column& column = table.columns[c];
  return column.name == name && column.type == ScalarType::u32 && !column.optional &&
         column.is_shown == table.columns[0].is_shown && (name == "bytes" || column.lane_count == 1);
}

Status check_child(const StateSchema& schema, std::size_t t) {
  const TableSchema& table = schema.tables[t];
  const std::string place = "table " + table.name + ": ";
  if (table.form == TableForm::plain && table.parent == -1) return {};
  if (static_cast<std::uint8_t>(table.form) > table_form_max)
    return schema_error(place + "form: found " + std::to_string(static_cast<unsigned>(table.form)) + ", expected 0.." +
                        std::to_string(table_form_max));
  if (table.form == TableForm::plain || table.parent < 0)
    return schema_error(place + "has a parent and no form of a child, or a form and no parent");
  if (table.parent >= static_cast<int>(t)) return schema_error(place + "its parent does not stand before it");
  const TableSchema& parent = schema.tables[static_cast<std::size_t>(table.parent)];
  if (table.row_size > 0 && parent.row_size == 0)
    return schema_error(place + "is judged, and its parent " + parent.name + " has no judged column");
  if (table.key_column_count != child_key_count || table.columns.size() < child_key_count ||
      !is_child_column(table, 0, "owner") || !is_child_column(table, 1, "index"))
    return schema_error(place + "a child begins with the key columns owner and index, each one u32");
  const int target = has_u32_key(parent) ? table.parent : -1;
  if (table.columns[0].target != target)
    return schema_error(place + "column owner: " +
                        (target < 0 ? "refers to a table, and its parent " + parent.name + " has no u32 key"
                                    : "does not refer to its parent " + parent.name));
  if (table.columns[1].target != -1) return schema_error(place + "column index: refers to a table");
  if (table.form == TableForm::rows) return {};
  if (table.columns.size() != piece_column_count || !is_child_column(table, 2, "size") ||
      !is_child_column(table, 3, "bytes") || table.columns[2].target != -1 || table.columns[3].target != -1)
    return schema_error(place + "a child of bytes or text has the u32 columns owner, index, size and bytes");
  return {};
}

Status check_table(const StateSchema& schema, std::size_t t, SchemaLayout layout) {
  const TableSchema& table = schema.tables[t];
  const bool is_first = layout == SchemaLayout::first;
  if (table.columns.empty() || table.columns.size() > limits::column_count_max)
    return schema_error("table " + table.name + ": column count: found " + std::to_string(table.columns.size()) +
                        ", expected 1.." + std::to_string(limits::column_count_max));
  if ((table.row_size == 0 && (is_first || table.shown_row_size == 0)) || table.row_size > limits::row_size_max)
    return schema_error("table " + table.name + ": row size: found " + std::to_string(table.row_size) +
                        ", expected 1.." + std::to_string(limits::row_size_max));
  if (table.shown_row_size > limits::row_size_max)
    return schema_error("table " + table.name + ": shown row size: found " + std::to_string(table.shown_row_size) +
                        ", expected at most " + std::to_string(limits::row_size_max));
  if (table.key_column_count > table.columns.size())
    return schema_error("table " + table.name + ": more key columns than columns");
  if (const Status status = check_columns(schema, table, layout); !status) return status;
  if (is_first && (table.form != TableForm::plain || table.parent != -1))
    return schema_error("table " + table.name + ": child tables need format version 3");
  return check_child(schema, t);
}

void encode_column(const Column& column, ByteWriter& out) {
  out.text(column.name);
  out.u8(static_cast<std::uint8_t>(column.type));
  out.u8(column.lane_count);
  out.u16(column.offset);
  out.f64(column.min);
  out.f64(column.max);
  out.u16(static_cast<std::uint16_t>(column.target + 1));
  out.u8(column.optional ? 1 : 0);
}

/// A flag in `flag`. False: neither 0 nor 1.
bool read_flag(ByteReader& in, bool& flag) {
  const std::uint8_t value = in.u8();
  flag = value == 1;
  return value <= 1;
}

/// A table in `table`, 0 for none. False: beyond the limit.
bool read_table_number(ByteReader& in, SchemaLayout layout, std::int16_t& table) {
  const std::uint16_t number = in.u16();
  table = static_cast<std::int16_t>(number - 1);
  return number <= table_count_max(layout);
}

Result<Column> decode_column(ByteReader& in, SchemaLayout layout) {
  Column column;
  column.name = in.text(limits::name_size_max);
  column.type = static_cast<ScalarType>(in.u8());
  column.lane_count = in.u8();
  column.offset = in.u16();
  column.min = in.f64();
  column.max = in.f64();
  if (!read_table_number(in, layout, column.target)) return schema_error("a column refers to no table");
  if (!read_flag(in, column.optional)) return schema_error("a flag is neither 0 nor 1");
  if (layout == SchemaLayout::third && !read_flag(in, column.is_shown))
    return schema_error("the class of a column is neither 0 nor 1");
  return column;
}

/// The columns stand behind it. `column_count`: how many.
Result<TableSchema> decode_table(ByteReader& in, SchemaLayout layout, std::size_t& column_count) {
  TableSchema table;
  table.name = in.text(limits::name_size_max);
  if (layout == SchemaLayout::third) {
    table.form = static_cast<TableForm>(in.u8());
    if (!read_table_number(in, layout, table.parent)) return schema_error("a table has no such parent");
  }
  table.row_size = in.u32();
  if (layout == SchemaLayout::third) table.shown_row_size = in.u32();
  table.key_column_count = in.u8();
  column_count = in.u16();
  return table;
}

}  // namespace

const ScalarInfo* scalar_info(ScalarType type) {
  const std::size_t index = static_cast<std::size_t>(type) - 1;
  return index < scalars.size() ? &scalars[index] : nullptr;
}

std::optional<std::size_t> StateSchema::find_table(std::string_view name) const {
  for (std::size_t i = 0; i < tables.size(); ++i)
    if (tables[i].name == name) return i;
  return std::nullopt;
}

bool owns_rows(const StateSchema& schema, std::size_t table) {
  return std::none_of(
      schema.tables[table].columns.begin(), schema.tables[table].columns.end(),
      [&](const Column& column) { return column.target >= 0 && column.target != static_cast<int>(table); });
}

SchemaLayout layout_of(const StateSchema& schema) {
  const auto is_new = [](const Column& column) { return column.is_shown || !is_of_first_layout(column.type); };
  const auto has_new = [&](const TableSchema& table) {
    return table.form != TableForm::plain || table.parent != -1 ||
           std::any_of(table.columns.begin(), table.columns.end(), is_new);
  };
  const bool is_first = schema.tables.size() <= limits::table_count_max &&
                        std::none_of(schema.tables.begin(), schema.tables.end(), has_new);
  return is_first ? SchemaLayout::first : SchemaLayout::third;
}

bool has_shown_columns(const StateSchema& schema) {
  return std::any_of(schema.tables.begin(), schema.tables.end(),
                     [](const TableSchema& table) { return table.shown_row_size > 0; });
}

StateSchema judged_schema(const StateSchema& schema) {
  std::vector<std::int16_t> number(schema.tables.size(), -1);  // [table], in the result
  StateSchema judged;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const TableSchema& table = schema.tables[t];
    if (table.row_size == 0) continue;
    number[t] = static_cast<std::int16_t>(judged.tables.size());
    judged.tables.push_back(table);
    TableSchema& copy = judged.tables.back();
    copy.shown_row_size = 0;
    std::erase_if(copy.columns, [](const Column& column) { return column.is_shown; });
    if (table.columns[0].is_shown) copy.key_column_count = 0;
  }
  // A target may stand behind its column.
  for (TableSchema& table : judged.tables) {
    if (table.parent >= 0) table.parent = number[static_cast<std::size_t>(table.parent)];
    for (Column& column : table.columns)
      if (column.target >= 0) column.target = number[static_cast<std::size_t>(column.target)];
  }
  return judged;
}

Status check_schema(const StateSchema& schema, SchemaLayout layout) {
  if (schema.tables.empty() || schema.tables.size() > table_count_max(layout))
    return schema_error("table count: found " + std::to_string(schema.tables.size()) + ", expected 1.." +
                        std::to_string(table_count_max(layout)));
  const Duplicate same_table = find_duplicate(schema.tables);
  std::size_t column_count = 0;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const TableSchema& table = schema.tables[t];
    if (table.name.empty() || table.name.size() > limits::name_size_max)
      return schema_error("table " + std::to_string(t) + ": name is empty or too long");
    if (t == same_table.second) return schema_error("table " + table.name + duplicate_text("table", same_table));
    if (const Status status = check_table(schema, t, layout); !status) return status;
    column_count += table.columns.size();
  }
  if (column_count > limits::registered_column_count_max)
    return schema_error("columns of all tables: found " + std::to_string(column_count) + ", expected at most " +
                        std::to_string(limits::registered_column_count_max));
  return {};
}

void encode_schema(const StateSchema& schema, ByteWriter& out, SchemaLayout layout) {
  const bool is_third = layout == SchemaLayout::third;
  out.u16(static_cast<std::uint16_t>(schema.tables.size()));
  for (const TableSchema& table : schema.tables) {
    out.text(table.name);
    if (is_third) {
      out.u8(static_cast<std::uint8_t>(table.form));
      out.u16(static_cast<std::uint16_t>(table.parent + 1));
    }
    out.u32(table.row_size);
    if (is_third) out.u32(table.shown_row_size);
    out.u8(table.key_column_count);
    out.u16(static_cast<std::uint16_t>(table.columns.size()));
    for (const Column& column : table.columns) {
      encode_column(column, out);
      if (is_third) out.u8(column.is_shown ? 1 : 0);
    }
  }
}

Result<StateSchema> decode_schema(ByteReader& in, SchemaLayout layout) {
  StateSchema schema;
  const std::size_t table_count = in.u16();
  if (table_count > table_count_max(layout)) return schema_error("too many tables");
  std::size_t columns_left = limits::registered_column_count_max;
  for (std::size_t t = 0; t < table_count && in.ok(); ++t) {
    std::size_t column_count = 0;
    Result<TableSchema> table = decode_table(in, layout, column_count);
    if (!table) return table.error();
    if (column_count > limits::column_count_max || column_count > columns_left) return schema_error("too many columns");
    columns_left -= column_count;
    for (std::size_t c = 0; c < column_count && in.ok(); ++c) {
      Result<Column> column = decode_column(in, layout);
      if (!column) return column.error();
      table->columns.push_back(std::move(*column));
    }
    schema.tables.push_back(std::move(*table));
  }
  if (!in.ok()) return schema_error("ends early");
  if (const Status status = check_schema(schema, layout); !status) return status.error();
  return schema;
}

}  // namespace ticktrue
