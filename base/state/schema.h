// The schema of a state (tables of named columns), and its encoding in a trace.
// SPDX-License-Identifier: MIT
//
// A state is a list of tables (world, bodies, contacts, ...). A table is an array of packed rows; a row is a list
// of columns; a column is 1..n lanes of one scalar type. Packed: columns cover every byte of a row, no padding.
//
// Classes: a *judged* column is hashed and compared. A *shown* column is stored and printed, and decides nothing. Only
// the schema of a trace has shown columns: all else is about its judged schema.
//
// Owners: a table no column of which refers to another table *owns* its rows (a world, bodies). A row of any other
// table (contacts, joints, sleep) belongs to each row of an owning table that its reference columns name by id; one
// that names none owns itself. So a simulation says which rows make up a body by giving columns a target, and in no
// other way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"

namespace ticktrue {

enum class ScalarType : std::uint8_t { u8 = 1, u16, u32, u64, i32, i64, f32, f64, i8, i16 };

struct ScalarInfo {
  ScalarType type;
  std::string_view name;
  std::uint8_t size;  // bytes
  bool is_float;
  bool is_signed;  // an integer that may be negative
};
/// Null for a value that is no ScalarType.
const ScalarInfo* scalar_info(ScalarType type);
constexpr bool is_float(ScalarType type) {
  return type == ScalarType::f32 || type == ScalarType::f64;
}

/// A reference column may hold this instead of an id: "refers to nothing".
inline constexpr std::uint32_t no_reference = 0xffffffffu;

/// One named quantity of a row.
struct Column {
  std::string name;
  ScalarType type = ScalarType::u32;
  std::uint8_t lane_count = 1;
  std::uint16_t offset = 0;                               // bytes from the start of the row's part of its class
  double min = -std::numeric_limits<double>::infinity();  // smallest value load() accepts; floats must be finite
  double max = std::numeric_limits<double>::infinity();   // largest value load() accepts
  std::int16_t target = -1;  // >= 0: holds ids of the rows of this table (its first column)
  bool optional = false;     // a reference that may be no_reference
  bool is_shown = false;     // stored and printed, never judged

  bool operator==(const Column&) const = default;
};

/// The relation between the rows of a table and those of its parent. A child table has the key (owner, index).
enum class TableForm : std::uint8_t {
  plain,  // no child
  rows,   // the elements of a nested list
  bytes,  // pieces of a string of bytes
  text,   // pieces of a text
};
inline constexpr std::uint8_t table_form_max = 3;

struct TableSchema {
  std::string name;
  std::vector<Column> columns;        // judged ones by offset, then shown ones; each class covers its part of the row
  std::uint32_t row_size = 0;         // bytes of the judged part
  std::uint8_t key_column_count = 0;  // rows ascend strictly by these leading integer columns; 0: any order
  TableForm form = TableForm::plain;
  std::int16_t parent = -1;          // >= 0: a child of this table, which stands before it
  std::uint32_t shown_row_size = 0;  // bytes of the shown part

  bool operator==(const TableSchema&) const = default;
};

struct StateSchema {
  std::vector<TableSchema> tables;

  bool operator==(const StateSchema&) const = default;
  /// Index of the table, or nothing.
  std::optional<std::size_t> find_table(std::string_view name) const;
};

/// How a schema stands in a trace, and what it may hold.
enum class SchemaLayout : std::uint8_t {
  first,  // of format versions 1 and 2: at most 64 tables, judged columns, no children, types up to f64
  third,  // of format version 3
};
/// The older one, where it holds all that the schema has.
SchemaLayout layout_of(const StateSchema& schema);

/// Whether rows of the table are owners: none of its columns refers to another table.
bool owns_rows(const StateSchema& schema, std::size_t table);

/// The schema without shown columns and without tables that have no others. Requires: check_schema.
StateSchema judged_schema(const StateSchema& schema);
bool has_shown_columns(const StateSchema& schema);

/// Refuses gaps, overlaps, empty names, duplicates, bad targets, wrong children and anything beyond base/limits.h.
Status check_schema(const StateSchema& schema, SchemaLayout layout = SchemaLayout::first);
void encode_schema(const StateSchema& schema, ByteWriter& out, SchemaLayout layout = SchemaLayout::first);
Result<StateSchema> decode_schema(ByteReader& in, SchemaLayout layout = SchemaLayout::first);

}  // namespace ticktrue
