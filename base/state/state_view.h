// A state as a list of tables: hash, image, validation, diff and finite check are written once, here.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/schema.h"

namespace ticktrue {

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
/// The same. `table_hashes`: set to a hash for each table, of what the root hash covers of it.
std::uint64_t root_hash(const StateView& state, std::vector<std::uint64_t>& table_hashes);

/// State image: for each table u32 row_count, then its rows, little-endian. What checkpoints hold.
void encode_image(const StateView& state, Bytes& out);

/// The tables of an image, as little-endian rows inside the image.
struct ImageTable {
  ByteView rows;
  std::uint32_t row_count = 0;
};
/// Errors: corrupt if sizes do not add up or a limit is exceeded. Does not look at values.
Result<std::vector<ImageTable>> split_image(const StateSchema& schema, ByteView image);
/// The image of these tables as one piece.
void join_image(std::span<const ImageTable> tables, Bytes& out);
/// The tables of a state as canonical rows: its own rows where the machine is little-endian, else copies in `buffer`.
std::vector<ImageTable> canonical_tables(const StateView& state, Bytes& buffer);
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
std::vector<LaneDifference> diff_images(const StateSchema& schema, std::span<const ImageTable> expected,
                                        std::span<const ImageTable> got, std::size_t count_max);

}  // namespace ticktrue
