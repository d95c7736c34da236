// Lists of tables, version 3: a state image or cells with only the changed tables.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/cells.h"
#include "base/state/state_view.h"

namespace ticktrue::replay {

inline constexpr std::size_t row_count_size = 4;  // of a table in an image

/// The state to which a list is relative.
enum class ListBase : std::uint8_t {
  nothing = 0,  // lists all tables that have rows
  before = 1,   // lists the tables that differ from the state before
};

// ---- State images ----

/// Appends a list of the tables with the numbers `listed`, which ascend.
void encode_table_list(ListBase base, std::span<const ImageTable> tables, std::span<const std::uint32_t> listed,
                       Bytes& out);

/// Checks a list that arrives in parts. A wrong count is found before later parts are read.
class TableListShape {
 public:
  /// Checks `image`, the bytes of the list so far. `base`: the base that the list must have.
  /// Errors: corrupt.
  Status pass(const StateSchema& schema, ByteView image, std::uint64_t image_size, ListBase base);

  /// One listed table and the offset of its rows in the list.
  struct Entry {
    std::uint32_t table = 0;
    std::uint32_t row_count = 0;
    std::size_t offset = 0;  // of its rows
  };
  /// Requires: all parts of the list passed.
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  bool read_head(const StateSchema& schema, ByteView image, bool is_whole, Status& status);

  std::vector<Entry> entries_;
  std::uint64_t offset_ = 0;      // of the next field
  std::uint64_t left_ = 0;        // remaining tables
  std::uint64_t next_table_ = 0;  // the lowest number that the next table may have
  bool has_head_ = false;
  ListBase base_ = ListBase::nothing;
};

/// The tables of the last state, as a reader composes them. It owns their rows or refers to them.
class ComposedState {
 public:
  /// Forgets the state.
  void reset(std::size_t table_count);
  /// Whether the state after `ticks_done` ticks is stored.
  bool holds(std::uint64_t ticks_done) const { return has_state_ && ticks_done_ == ticks_done; }

  /// Sets the state from a whole list. The rows stay in the bytes of `image`: the object takes these bytes, and `image`
  /// gets another buffer.
  void take_whole(const StateSchema& schema, const TableListShape& list, std::uint64_t ticks_done, Bytes& image);
  /// Replaces the listed tables. Errors: corrupt (a listed table is unchanged), limit.
  Status replace(const StateSchema& schema, const TableListShape& list, std::uint64_t ticks_done, ByteView image,
                 std::uint64_t size_max);

  std::span<const ImageTable> tables() const { return tables_; }
  /// The tables in the last list.
  std::span<const std::uint32_t> listed() const { return listed_; }
  std::uint64_t size() const { return size_; }

 private:
  bool has_state_ = false;
  std::uint64_t ticks_done_ = 0;
  std::uint64_t size_ = 0;  // of all rows and row counts
  Bytes whole_;             // rows of the last whole list
  std::vector<Bytes> own_;  // [table], rows of a later list
  std::vector<ImageTable> tables_;
  std::vector<std::uint32_t> listed_;
};

/// The tables of the last state, which a writer stores to find changes.
class LastState {
 public:
  void forget() { has_state_ = false; }
  bool holds(std::uint64_t ticks_done) const { return has_state_ && ticks_done_ == ticks_done; }
  /// Finds the tables that differ from the stored state; without a stored state, the tables with rows.
  void find_changed(std::span<const ImageTable> tables, bool is_whole, std::vector<std::uint32_t>& changed) const;
  void keep(std::span<const ImageTable> tables, std::span<const std::uint32_t> changed, bool is_whole,
            std::uint64_t ticks_done);

 private:
  bool has_state_ = false;
  std::uint64_t ticks_done_ = 0;
  std::vector<Bytes> rows_;  // [table]
};

// ---- Cells ----

/// The columns of StateCells that belong to each table.
class CellLayout {
 public:
  explicit CellLayout(const StateSchema& schema);
  std::size_t table_count() const { return first_column_.size() - 1; }
  std::size_t first_column(std::size_t table) const { return first_column_[table]; }
  std::size_t column_count(std::size_t table) const { return first_column_[table + 1] - first_column_[table]; }

 private:
  std::vector<std::size_t> first_column_;  // [table], then the number of columns
};

/// `before`: the cells of the previous record in the ticks chunk; null for the first record.
void encode_cell_list(const CellLayout& layout, const StateCells& cells, const StateCells* before, ByteWriter& out);

/// Composes the cells of a ticks chunk, record by record.
class ComposedCells {
 public:
  /// To be called before the first record of a chunk.
  void reset() { has_cells_ = false; }
  /// False: the body is not a valid list here. Then the cells are undefined.
  bool apply(const CellLayout& layout, ByteView body);
  const StateCells& cells() const { return cells_; }

 private:
  bool read_table(const CellLayout& layout, std::size_t table, ByteReader& in);

  bool has_cells_ = false;
  StateCells cells_;
};

}  // namespace ticktrue::replay
