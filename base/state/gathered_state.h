// A state stored anywhere in memory, shown as packed rows: columns by pointer, stride and count, gathered after a tick.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/child_tables.h"
#include "base/state/state_view.h"

namespace ticktrue {

/// Where the values of one column lie: those of row r begin at `data + r * stride`.
struct ColumnSource {
  const void* data = nullptr;  // may be null where there are no rows
  ScalarType type = ScalarType::u8;
  std::uint32_t lane_count = 1;
  std::uint32_t row_count = 0;
  std::size_t stride = 0;    // bytes; 0: the values of a row alone, packed
  void* writable = nullptr;  // the same place, where scatter() may write
  bool is_shown = false;     // stored and printed, never judged
};

/// One column of a table whose rows are structs: its value lies `offset` bytes behind the begin of a row.
struct RowMember {
  std::string_view name;
  ScalarType type = ScalarType::u8;
  std::uint32_t lane_count = 1;
  std::size_t offset = 0;
  bool is_shown = false;
};

/// A child table as a program registers it.
struct ChildSource {
  TableForm form = TableForm::rows;  // not plain
  ElementReader read = nullptr;
  void* user = nullptr;    // given to it
  std::size_t stride = 0;  // bytes from an element to the next; of rows
};

/// The shown part of the rows of a table that has some.
struct ShownRows {
  std::uint32_t table = 0;
  ImageTable rows;  // canonical
};

/// Finds a place by its name. Hashed: a program may register thousands of columns in every tick.
class NameIndex {
 public:
  std::optional<std::size_t> find(std::string_view name) const {
    const auto found = places_.find(name);
    return found == places_.end() ? std::nullopt : std::optional(found->second);
  }
  /// Requires: a name that is not there yet.
  void add(std::string_view name, std::size_t place) { places_.emplace(name, place); }

 private:
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view name) const { return std::hash<std::string_view>()(name); }
  };
  std::unordered_map<std::string, std::size_t, Hash, std::equal_to<>> places_;
};

class GatheredState {
 public:
  /// Before freeze: adds a column, and its table at its first column. After it: says where a known column lies now.
  /// Errors: usage (an empty or wrong name, no lanes, a stride below the size of a row's values, null with rows, after
  /// freeze: an unknown column or another type or lane count), limit.
  Status column(std::string_view table, std::string_view name, const ColumnSource& source);

  /// Before freeze: adds a table of structs of `stride` bytes, without rows, and returns its number. A table that is
  /// known with the same members keeps its number.
  /// Errors: usage (wrong names, a name twice, a member outside of the struct, after freeze: an unknown table), limit.
  Result<std::size_t> table(std::string_view name, std::size_t stride, std::span<const RowMember> members);
  /// Says where the rows of such a table lie now. `writable`: the same place, where scatter() may write.
  /// Errors: usage (no such table, null with rows), limit.
  Status rows(std::size_t table, const void* first, std::uint32_t row_count, void* writable = nullptr);
  std::optional<std::size_t> find_table(std::string_view name) const { return table_names_.find(name); }

  /// Before freeze: adds a child of `parent`, a table that is known. `members`: of an element, for the form `rows`; may
  /// be empty. A child that is known with the same members takes `read` and `user` of this call.
  /// Errors: usage (as table(); no such parent; no reader; shown members), limit.
  Status child(std::string_view name, std::string_view parent, const ChildSource& source,
               std::span<const RowMember> members);
  bool has_children() const { return has_children_; }

  /// The leading `column_count` columns of the table are its key: rows ascend by them, and are compared by key.
  /// Errors: usage (unknown table, after freeze). Whether the columns may be keys, freeze says.
  Status key(std::string_view table, std::uint32_t column_count);

  /// The column holds keys of the rows of `target`, or no_reference. Errors: usage.
  Status reference(std::string_view table, std::string_view column, std::string_view target);

  /// Fixes tables and columns. Errors: usage (nothing registered), and what check_schema refuses.
  Status freeze();
  bool is_frozen() const { return frozen_; }

  /// Copies every value into packed rows, which view() then shows.
  /// Calls the readers of children. They may say where columns and rows lie, and change nothing else here.
  /// Errors: usage (columns of a table with different row counts, keys that do not ascend, null with elements), limit.
  /// Requires: is_frozen().
  Status gather();
  const StateView& view() const { return view_; }
  const StateSchema& schema() const { return schema_; }

  /// Writes a table of an image back to where its columns lie; `rows` are little-endian rows of the schema.
  /// Requires: the sources have `writable` and rows.row_count rows.
  void scatter(std::size_t table, const ImageTable& rows);

  /// Of a child: those of the last gather().
  std::uint32_t row_count(std::size_t table) const {
    return sources_[table].child ? view_.tables[table].row_count : sources_[table].columns.front().row_count;
  }

  /// With the shown columns, behind the judged ones. Requires: is_frozen().
  const StateSchema& whole_schema() const { return whole_; }
  bool has_shown() const { return !shown_tables_.empty(); }
  /// Copies the shown values of all tables that have rows; valid until the next call. Errors: usage (other row counts
  /// than the judged columns), limit. Requires: is_frozen().
  Result<std::vector<ShownRows>> gather_shown();

 private:
  /// A member of the struct of a table, as it was registered.
  struct Member {
    std::string name;
    RowMember member;  // its name is empty
  };
  /// The source of a child table, the layout of its elements, and its packed rows.
  struct Child {
    ChildSource source;
    std::vector<ElementPart> parts;
    ChildRows rows;
    std::vector<const std::uint8_t*> elements;  // [row], where each lies; kept if a child of its own needs it
  };
  /// Where the columns of one table lie.
  struct TableSource {
    NameIndex names;  // of a shown column: shown_place and its place in `shown`
    std::vector<ColumnSource> columns;
    std::vector<Column> shown_columns;
    std::vector<ColumnSource> shown;
    std::uint32_t shown_row_size = 0;
    std::vector<Member> members;         // empty: each column lies where it says
    std::size_t stride = 0;              // of these
    const std::uint8_t* base = nullptr;  // of its rows, where it has members
    std::optional<Child> child;
    bool is_parent = false;
  };
  static constexpr std::size_t shown_place = std::size_t{1} << 20;

  Status add_table(std::string_view name);
  Status add_child_columns(std::size_t table, std::span<const RowMember> members);
  Status gather_table(std::size_t table);
  Status gather_child(std::size_t table, std::uint64_t image_size_max);
  Status add_column(std::size_t table, std::string_view name, const ColumnSource& source);
  void make_whole_schema();
  Status check_keys(std::size_t table) const;
  bool has_members(std::size_t table, std::size_t stride, std::span<const RowMember> members) const;

  StateSchema schema_;
  NameIndex table_names_;
  std::vector<TableSource> sources_;  // [table]
  std::size_t column_count_ = 0;      // of all tables
  std::vector<Bytes> rows_;           // [table], in the machine's byte order
  StateView view_;
  StateSchema whole_;
  StateSchema shown_schema_;                 // the shown part alone, of the tables that have one
  std::vector<std::uint32_t> shown_tables_;  // their numbers
  std::vector<Bytes> shown_rows_;            // [place in shown_tables_]
  Bytes shown_canonical_;
  bool frozen_ = false;
  bool has_children_ = false;
};

/// Whether a name may stand in a schema and in a report: 1..name_size_max bytes, no control characters.
/// Errors: usage. `what` begins the message.
Status check_name(const std::string& what, std::string_view name);

}  // namespace ticktrue
