// State as a list of named columns: hash, image, validation, diff and finite check are written once, here.
// SPDX-License-Identifier: MIT
//
// A state is a list of tables (world, bodies, contacts, ...). A table is an array of packed rows; a row is a list
// of columns; a column is 1..n lanes of one scalar type. Packed: columns cover every byte of a row, no padding.
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

enum class ScalarType : std::uint8_t { u8 = 1, u16, u32, u64, i32, i64, f32, f64 };

struct ScalarInfo {
  ScalarType type;
  std::string_view name;
  std::uint8_t size;  // bytes
  bool is_float;
};
/// Null for a value that is no ScalarType.
const ScalarInfo* scalar_info(ScalarType type);

/// A reference column may hold this instead of an id: "refers to nothing".
inline constexpr std::uint32_t no_reference = 0xffffffffu;

/// One named quantity of a row.
struct Column {
  std::string name;
  ScalarType type = ScalarType::u32;
  std::uint8_t lane_count = 1;
  std::uint16_t offset = 0;                               // bytes from the start of the row
  double min = -std::numeric_limits<double>::infinity();  // smallest value load() accepts; floats must be finite
  double max = std::numeric_limits<double>::infinity();   // largest value load() accepts
  std::int16_t target = -1;  // >= 0: holds ids of the rows of this table (its first column)
  bool optional = false;     // a reference that may be no_reference

  bool operator==(const Column&) const = default;
};

struct TableSchema {
  std::string name;
  std::vector<Column> columns;        // by offset; together they cover the row
  std::uint32_t row_size = 0;         // bytes
  std::uint8_t key_column_count = 0;  // rows ascend strictly by these leading integer columns; 0: any order

  bool operator==(const TableSchema&) const = default;
};

struct StateSchema {
  std::vector<TableSchema> tables;

  bool operator==(const StateSchema&) const = default;
  /// Index of the table, or nothing.
  std::optional<std::size_t> find_table(std::string_view name) const;
};

/// Whether rows of the table are owners: none of its columns refers to another table.
bool owns_rows(const StateSchema& schema, std::size_t table);

/// Refuses gaps, overlaps, empty names, duplicates, bad targets and anything beyond base/limits.h.
Status check_schema(const StateSchema& schema);
void encode_schema(const StateSchema& schema, ByteWriter& out);
Result<StateSchema> decode_schema(ByteReader& in);

/// The rows of one table in the machine's own byte order.
struct TableRows {
  const std::uint8_t* data = nullptr;
  std::uint32_t row_count = 0;
};

/// What a simulation shows of itself: every column that can influence a later tick. Valid until its next step.
struct StateView {
  const StateSchema* schema = nullptr;
  std::vector<TableRows> tables;  // one for each table of the schema
};

/// XXH3-64 over, for each table: hash of its name, row count, and the hash of each 16 KiB block of its canonical
/// (little-endian) rows. docs/trace_format.md, "Root hash".
std::uint64_t root_hash(const StateView& state);

/// State image: for each table u32 row_count, then its rows, little-endian. What checkpoints hold.
void encode_image(const StateView& state, Bytes& out);

/// The tables of an image, as little-endian rows inside the image.
struct ImageTable {
  ByteView rows;
  std::uint32_t row_count = 0;
};
/// Errors: corrupt if sizes do not add up or a limit is exceeded. Does not look at values.
Result<std::vector<ImageTable>> split_image(const StateSchema& schema, ByteView image);
/// split_image, and every value within its column's range, floats finite, references resolved, keys ascending.
Result<std::vector<ImageTable>> check_image(const StateSchema& schema, ByteView image);
/// Copies little-endian rows into rows of the machine's byte order. `out` has row_count * row_size bytes.
void decode_rows(const TableSchema& table, const ImageTable& rows, std::uint8_t* out);

/// A place in a state.
struct StatePlace {
  std::size_t table = 0;
  std::size_t row = 0;
  std::size_t column = 0;
  std::size_t lane = 0;
  bool operator==(const StatePlace&) const = default;
};
/// The first NaN or infinity in table, row, column order.
std::optional<StatePlace> find_non_finite(const StateView& state);
/// The first -0 in the same order. Our own engine stores none (docs/determinism.md).
std::optional<StatePlace> find_negative_zero(const StateView& state);

/// One lane as canonical bits, widened to 64.
std::uint64_t lane_bits(const TableSchema& table, ByteView canonical_rows, const StatePlace& place);
/// A lane for people: decimal with as many digits as needed to read it back exactly.
std::string lane_text(ScalarType type, std::uint64_t bits);
/// Bits in hexadecimal, as many digits as the type has.
std::string lane_hex(ScalarType type, std::uint64_t bits);
/// Distance in units in the last place, saturating. Nothing for integers and where one side is NaN.
std::optional<std::uint64_t> ulp_distance(ScalarType type, std::uint64_t a, std::uint64_t b);

/// A lane that differs between two images of one schema. A row only one image has differs in every lane of its
/// key columns, with the other side absent.
struct LaneDifference {
  StatePlace place;                 // row: index in `expected`, or in `got` where expected has no such row
  std::optional<std::uint64_t> id;  // value of the row's first key column, where the table has one
  std::optional<std::uint64_t> expected;
  std::optional<std::uint64_t> got;
};
/// All differences in table, row, column, lane order, at most `count_max`. Rows of keyed tables are matched by key.
std::vector<LaneDifference> diff_images(const StateSchema& schema, const std::vector<ImageTable>& expected,
                                        const std::vector<ImageTable>& got, std::size_t count_max);

}  // namespace ticktrue
