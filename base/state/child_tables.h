// Child tables: texts, strings of bytes and lists that belong to the rows of another table. Their rows and their rules.
// SPDX-License-Identifier: MIT
//
// A child has the key (owner, index). `owner` is the id of the parent's row where the parent has one u32 key column,
// else the number of the row; `index` counts 0, 1, 2, ... for each owner. A text lies in pieces of one size: every
// piece of an owner but the last is full, and unused bytes are 0. An empty text or list has no row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/state_view.h"

namespace ticktrue {

inline constexpr std::uint32_t text_lane_count = 5;    // u32 of a piece of a text: rows of 32 bytes
inline constexpr std::uint32_t bytes_lane_count = 61;  // of a string of bytes: rows of 256 bytes

bool has_children(const StateSchema& schema);

/// Whether the rows of the table are pieces of texts or of strings of bytes.
inline bool has_pieces(const TableSchema& table) {
  return table.form == TableForm::bytes || table.form == TableForm::text;
}
/// Bytes that a piece has room for. Requires: has_pieces, check_schema.
inline std::size_t piece_size(const TableSchema& table) {
  return std::size_t{4} * table.columns[3].lane_count;
}

/// Refuses rows of children that break these rules. `changed`: the numbers of the tables that are new in these tables;
/// children of which neither rows nor parent are new are not looked at.
/// Errors: corrupt.
Status check_children(const StateSchema& schema, std::span<const ImageTable> tables,
                      std::span<const std::uint32_t> changed);
/// The same for all children.
Status check_children(const StateSchema& schema, std::span<const ImageTable> tables);

/// The owner of a row of a child, and its index.
struct ChildKey {
  std::uint32_t owner = 0;
  std::uint32_t index = 0;
};
ChildKey child_key(const TableSchema& table, const ImageTable& rows, std::size_t row);

/// The row of the parent that `owner` names; nothing where there is none.
std::optional<std::size_t> find_owner(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t child,
                                      std::uint32_t owner);

/// How a program gives the elements of one row of the parent: the first, and in `count` how many. `owner`: where that
/// row lies; null where its columns do not lie in a struct.
using ElementReader = const void* (*)(void* user, const void* owner, std::uint32_t row, std::size_t* count);

/// A member of an element that becomes a column, or several neighbours that are copied at once.
struct ElementPart {
  std::size_t from = 0;  // bytes from the begin of the element
  std::size_t to = 0;    // bytes from the begin of the row
  std::size_t size = 0;  // bytes
};

/// The elements of a list as a program gives them.
struct ElementList {
  const std::uint8_t* first = nullptr;
  std::size_t count = 0;
  std::size_t stride = 0;  // bytes
};

/// The packed rows of a child, in the machine's byte order. Its memory stays from tick to tick.
class ChildRows {
 public:
  void clear() { row_count_ = 0; }
  /// Rows of the elements, or pieces of the bytes, of one owner. `image_size_max`: bytes that the rows may have.
  /// Errors: limit.
  Status add_elements(const TableSchema& table, std::uint32_t owner, const ElementList& elements,
                      std::span<const ElementPart> parts, std::uint64_t image_size_max);
  Status add_pieces(const TableSchema& table, std::uint32_t owner, const ElementList& bytes,
                    std::uint64_t image_size_max);
  TableRows rows() const { return {rows_.data(), static_cast<std::uint32_t>(row_count_)}; }

 private:
  /// Room for `count` rows more; null: beyond the limits.
  std::uint8_t* add(const TableSchema& table, std::uint64_t count, std::uint64_t image_size_max);

  Bytes rows_;
  std::size_t row_count_ = 0;
};

}  // namespace ticktrue
