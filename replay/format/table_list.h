// Lists of tables, version 3: a state image and cells hold the tables that changed.
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

/// What a list is relative to.
enum class ListBase : std::uint8_t {
  nothing = 0,  // lists all tables that have rows
  before = 1,   // lists the tables that differ from the state before
};

// ---- State images ----

/// Appends a list of the tables with these numbers, which ascend.
void encode_table_list(ListBase base, std::span<const ImageTable> tables, std::span<const std::uint32_t> listed,
                       Bytes& out);

/// Checks a list that arrives in parts: a wrong count is found before the rest is read.
class TableListShape {
 public:
  /// Reads what stands in `image`, the bytes of the list so far. `base`: what it must be relative to.
  /// Errors: corrupt.
  Status pass(const StateSchema& schema, ByteView image, std::uint64_t image_size, ListBase base);

  /// One listed table and the place of its rows in the list.
  struct Entry {
    std::uint32_t table = 0;
    std::uint32_t row_count = 0;
    std::size_t offset = 0;  // of its rows
  };
  /// Requires: the list was passed whole.
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  bool read_head(const StateSchema& schema, ByteView image, bool is_whole, Status& status);

  std::vector<Entry> entries_;
  std::uint64_t offset_ = 0;      // of the next field
  std::uint64_t left_ = 0;        // tables to come
  std::uint64_t next_table_ = 0;  // the first that may be listed next
  bool has_head_ = false;
  ListBase base_ = ListBase::nothing;
};

/// The tables of the last state, as a reader composes them. Owns or points to their rows.
class ComposedState {
 public:
  /// Begins with no state.
  void reset(std::size_t table_count);
  /// Whether it holds the state with so many ticks done.
  bool holds(std::uint64_t ticks_done) const { return has_state_ && ticks_done_ == ticks_done; }

  /// Takes a whole list over: `image` becomes the storage of its rows, and is another buffer afterwards.
  void take_whole(const StateSchema& schema, const TableListShape& list, std::uint64_t ticks_done, Bytes& image);
  /// Replaces the listed tables. Errors: corrupt (a listed table without a difference), limit.
  Status replace(const StateSchema& schema, const TableListShape& list, std::uint64_t ticks_done, ByteView image,
                 std::uint64_t size_max);

  std::span<const ImageTable> tables() const { return tables_; }
  /// The tables that the last list held.
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

/// The tables of the last state, as a writer keeps them to find what changed.
class LastState {
 public:
  void forget() { has_state_ = false; }
  bool holds(std::uint64_t ticks_done) const { return has_state_ && ticks_done_ == ticks_done; }
  /// The tables that differ from the state kept; without one, those with rows.
  void find_changed(std::span<const ImageTable> tables, bool is_whole, std::vector<std::uint32_t>& changed) const;
  void keep(std::span<const ImageTable> tables, std::span<const std::uint32_t> changed, bool is_whole,
            std::uint64_t ticks_done);
  std::uint64_t size_with(std::span<const ImageTable> tables) const;

 private:
  bool has_state_ = false;
  std::uint64_t ticks_done_ = 0;
  std::vector<Bytes> rows_;  // [table]
};

// ---- Cells ----

/// Which columns of StateCells belong to a table.
class CellLayout {
 public:
  explicit CellLayout(const StateSchema& schema);
  std::size_t table_count() const { return first_column_.size() - 1; }
  std::size_t first_column(std::size_t table) const { return first_column_[table]; }
  std::size_t column_count(std::size_t table) const { return first_column_[table + 1] - first_column_[table]; }

 private:
  std::vector<std::size_t> first_column_;  // [table], then their number
};

/// `before`: those of the record before in the ticks chunk; null for the first.
void encode_cell_list(const CellLayout& layout, const StateCells& cells, const StateCells* before, ByteWriter& out);

/// Composes the cells of a ticks chunk, record by record.
class ComposedCells {
 public:
  /// Before the first record of a chunk.
  void reset() { has_cells_ = false; }
  /// False: the body is no list that can stand here. Then the cells are those of no record.
  bool apply(const CellLayout& layout, ByteView body);
  const StateCells& cells() const { return cells_; }

 private:
  bool read_table(const CellLayout& layout, std::size_t table, ByteReader& in);

  bool has_cells_ = false;
  StateCells cells_;
};

}  // namespace ticktrue::replay
