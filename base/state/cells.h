// Cells: short hashes of a state that name the tick's differing columns, and the few rows that can have differed.
// SPDX-License-Identifier: MIT
//
// Two states are compared by the cells stored in two files, a few hundred bytes each. A hash per column says which
// columns differ. For the rows, each *owner* (base/state/state_view.h: a body, with its contacts and joints) has a
// value that is xored into one 16-bit cell of each of four partitions; cells that differ then name the owners that can
// have differed. docs/trace_format.md, "Cells", has every formula, and the arithmetic of how long the list is and what
// is missed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/state/state_view.h"

namespace ticktrue {

inline constexpr std::size_t partition_count = 4;
inline constexpr std::uint32_t partition_cells_max = 4'096;

struct StateCells {
  std::vector<std::uint32_t> row_counts;  // [table]
  std::vector<std::uint32_t> columns;     // [column], those of all tables in the schema's order; 0 without rows
  std::uint32_t partition_cells = 0;      // cells of one partition
  std::vector<std::uint16_t> cells;       // [partition][cell]

  bool operator==(const StateCells&) const = default;
};

/// How many cells a partition gets for so many owners: about one for each up to 96 in all, then as their square root.
std::uint32_t partition_cells_for(std::uint64_t owner_count);

/// A row that may stand in a list of candidates.
struct CellOwner {
  std::size_t table = 0;
  std::size_t row = 0;
  std::uint64_t key = 0;  // identifies it within its table: its key, or its row if the table has no key
};

/// The cell of each partition that the owner's value goes into.
std::array<std::uint32_t, partition_count> cells_of(const CellOwner& owner, std::uint32_t partition_cells);

/// The cells of an owner's value, cached: the same owners occur tick after tick.
struct CellPlace {
  std::uint64_t key = 0;
  std::array<std::uint16_t, partition_count> cells{};
  bool is_known = false;
};

/// Computes the cells of states of one schema; reuses its buffers between calls. Where the schema has many tables, it
/// keeps the values of their rows. A table is hashed again if the hash of all its rows is another than in the last
/// call.
class CellHasher {
 public:
  explicit CellHasher(const StateSchema& schema);

  /// `partition_cells` 0: as many as partition_cells_for says. Requires: a state of the schema.
  void hash(const StateView& state, std::uint32_t partition_cells, StateCells& out);

  /// How many tables the last call hashed: all that have rows, but for those that did not change and were left out.
  std::size_t hashed_table_count() const { return hashed_table_count_; }

  /// Every owner of the state, in table and row order. Valid until the next call.
  const std::vector<CellOwner>& owners(const StateView& state);

  /// Those the row belongs to: itself, or the rows it refers to.
  std::vector<CellOwner> owners_of(const StateView& state, std::size_t table, std::size_t row);
  /// The same for each row of the table.
  std::vector<std::vector<CellOwner>> owners_of_rows(const StateView& state, std::size_t table);

 private:
  /// A word of a row that holds the id of a row of an owning table.
  struct Reference {
    std::size_t word = 0;
    std::size_t target = 0;
  };
  struct Table {
    bool owns = false;                     // its rows are owners
    bool is_words = false;                 // every lane is 4 or 8 bytes: the row is its own words
    std::size_t words = 0;                 // 32-bit words of a row: one for each lane, two for lanes of 8 bytes
    std::uint64_t seed = 0;                // of its rows' hashes
    std::vector<std::size_t> column_word;  // first word of each column, then `words`
    std::vector<Reference> references;     // to owning tables
    std::size_t key_words = 0;
    std::vector<CellPlace> places;           // [row], of an owning table
    bool places_are_dense = false;           // their keys are those of a dense lookup
    bool is_kept = false;                    // its rows are in no value but their own, and `values` is kept
    std::optional<std::uint64_t> rows_hash;  // of the rows that `values` and the kept columns are of
    std::vector<std::uint64_t> values;       // [row], as they are in the kept cells
  };
  enum class Tables { all, not_kept };
  /// Finds the row with an id.
  struct Lookup {
    bool is_dense = false;  // ids are first, first + 1, ...
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::vector<std::uint64_t> slots;  // open addressing: id and row + 1
    std::uint32_t find(std::uint32_t id) const;
  };

  const std::uint32_t* words_of(std::size_t table, const TableRows& rows);
  void add_products(const Table& table, const std::uint32_t* words, std::size_t first, std::size_t row_count);
  void hash_columns(const Table& table, std::size_t row_count, std::uint32_t* out) const;
  void make_lookup(const Table& table, const std::uint32_t* words, std::size_t row_count, Lookup& lookup);
  static std::uint64_t key_of(const Table& table, const std::uint32_t* row_words, std::size_t row);
  void prepare(const StateView& state, Tables which);
  std::vector<CellOwner> prepared_owners(const StateView& state, std::size_t table, std::size_t row);
  void forget_values();
  void update_kept(std::size_t table, const TableRows& rows, std::uint32_t* columns);
  void hash_table(std::size_t table, std::size_t row_count, std::uint32_t* columns);
  void keep_places(std::size_t table, std::size_t row_count);
  void fold_rows(std::size_t table, std::size_t first, std::size_t row_count);
  bool find_owners(const Table& table, const std::uint32_t* row_words);

  const StateSchema schema_;
  std::vector<Table> tables_;
  std::size_t column_count_ = 0;                      // of all tables
  std::vector<const std::uint32_t*> words_;           // [table], rows as words
  std::vector<std::vector<std::uint32_t>> expanded_;  // [table], rows whose lanes are no words
  std::vector<Lookup> lookups_;                       // [table], of owning tables that are referred to
  std::vector<bool> is_target_;                       // [table]
  std::vector<std::size_t> first_owner_;              // [table], index of its first row in values_
  std::vector<std::uint64_t> values_;                 // [owner], twice: the two are added
  std::uint32_t places_cells_ = 0;                    // the cells of a partition that places are of
  std::vector<std::uint32_t> kept_columns_;           // [column], of tables whose values are kept
  std::size_t hashed_table_count_ = 0;
  std::vector<std::uint64_t> kept_cells_;  // of all these tables, as wide_cells_
  std::vector<std::uint64_t> wide_cells_;  // [partition][cell], with all bits of the values that were put into it
  std::vector<std::size_t> found_;         // owners of one row
  std::vector<std::uint64_t> sums_;        // [word]
  std::vector<std::uint64_t> block_sums_;  // [word]
  std::vector<std::uint64_t> hashes_;      // [row]
  std::vector<CellOwner> owners_;
};

}  // namespace ticktrue
