// Cell and column hashes: multiplications over packed words, no call per row.
// SPDX-License-Identifier: MIT
#include "base/state/cells.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "base/assert.h"
#include "base/hash.h"
#include "base/row_kernels.h"

namespace ticktrue {
namespace {

constexpr std::uint64_t multiplier = 0xd6e8feb86659fd93u;  // odd, bits without pattern
constexpr std::uint32_t no_owner = 0xffffffffu;
// From so many tables on, values of rows are kept: in a tick of a program with many tables, most of them do not change.
// Below, nearly all change, and finding that out would cost more than it spares.
constexpr std::size_t kept_table_count_min = 65;

/// One step of a chain; a bijection of `hash` for each `word` and of `word` for each `hash`.
std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  hash = (hash ^ word) * multiplier;
  return hash ^ (hash >> 32);
}

std::uint64_t two_words(const std::uint32_t* words) {
  std::uint64_t both;
  std::memcpy(&both, words, sizeof both);
  return machine_is_little_endian ? both : both << 32 | both >> 32;
}

inline std::uint64_t hash_row(const std::uint32_t* words, std::size_t count, std::uint64_t seed) {
  std::uint64_t hash = seed;
  std::size_t i = 0;
  for (; i + 1 < count; i += 2) hash = mix(hash, two_words(words + i));
  return i < count ? mix(hash, words[i]) : hash;
}

template <std::size_t count>
void hash_rows_of(const std::uint32_t* words, std::size_t row_count, std::uint64_t seed, std::uint64_t* out) {
  for (std::size_t row = 0; row < row_count; ++row, words += count) {
    std::uint64_t hash = seed;
    for (std::size_t i = 0; i + 1 < count; i += 2) hash = mix(hash, two_words(words + i));
    out[row] = count % 2 != 0 ? mix(hash, words[count - 1]) : hash;
  }
}

/// The hash of each row. The chains of short rows are unrolled, so that those of several rows overlap.
template <std::size_t... counts>
void hash_rows(std::index_sequence<counts...>, const std::uint32_t* words, std::size_t count, std::size_t row_count,
               std::uint64_t seed, std::uint64_t* out) {
  using HashRows = void (*)(const std::uint32_t*, std::size_t, std::uint64_t, std::uint64_t*);
  constexpr HashRows by_count[] = {hash_rows_of<counts + 1>...};
  if (count - 1 < sizeof...(counts)) return by_count[count - 1](words, row_count, seed, out);
  for (std::size_t row = 0; row < row_count; ++row) out[row] = hash_row(words + row * count, count, seed);
}
constexpr std::make_index_sequence<24> short_rows;

/// The sum of products (base/row_kernels.h) of one word.
std::uint64_t sum_products_of_word(const std::uint32_t* words, std::size_t stride, std::size_t first,
                                   std::size_t row_count) {
  std::uint64_t sum = 0;
  std::uint32_t key = (static_cast<std::uint32_t>(first) + 1) * row_step;
  for (std::size_t row = 0; row < row_count; row += 2, key += 2 * row_step) {
    const std::uint32_t a = words[row * stride] + key;
    const std::uint32_t b = (row + 1 < row_count ? words[(row + 1) * stride] : 0) + key + row_step;
    sum += std::uint64_t{a} * b;
  }
  return sum;
}

/// Writes the lanes of a column as words, behind each other in each row of `out`.
template <typename Value>
void expand_lanes(const TableRows& rows, std::size_t row_size, const Column& column, std::size_t word_count,
                  std::uint32_t* out) {
  const std::uint8_t* row = rows.data + column.offset;
  for (std::size_t r = 0; r < rows.row_count; ++r, row += row_size, out += word_count) {
    std::uint32_t* word = out;
    for (std::size_t i = 0; i < column.lane_count; ++i) {
      Value value;
      std::memcpy(&value, row + i * sizeof value, sizeof value);
      *word++ = static_cast<std::uint32_t>(value);
      if constexpr (sizeof value == 8) *word++ = static_cast<std::uint32_t>(value >> 32);
    }
  }
}

/// Owners up to `owner_count_max` share so many cells a partition.
struct CellStep {
  std::uint64_t owner_count_max;
  std::uint32_t partition_cells;
};
constexpr std::array<CellStep, 10> cell_steps{{{8, 4},
                                               {32, 8},
                                               {256, 16},
                                               {1'500, 24},
                                               {3'000, 34},
                                               {6'000, 48},
                                               {12'000, 68},
                                               {24'000, 96},
                                               {48'000, 136},
                                               {96'000, 192}}};
constexpr std::uint32_t partition_cells_beyond = 272;

}  // namespace

std::uint32_t partition_cells_for(std::uint64_t owner_count) {
  for (const CellStep& step : cell_steps)
    if (owner_count <= step.owner_count_max) return step.partition_cells;
  return partition_cells_beyond;
}

std::array<std::uint32_t, partition_count> cells_of(const CellOwner& owner, std::uint32_t partition_cells) {
  // Twice after the key: one multiplication would leave neighbouring keys in neighbouring cells.
  const std::uint64_t hash = mix(mix(mix(0, owner.table + 1), owner.key), 0);
  std::array<std::uint32_t, partition_count> cells;
  for (std::size_t p = 0; p < partition_count; ++p)
    cells[p] = static_cast<std::uint32_t>((((hash >> (16 * p)) & 0xffff) * partition_cells) >> 16);
  return cells;
}

/// The row, or no_owner. No row has the id no_reference.
inline std::uint32_t CellHasher::Lookup::find(std::uint32_t id) const {
  if (is_dense) return id - first < count ? id - first : no_owner;
  if (id == no_reference) return no_owner;
  const std::size_t mask = slots.size() - 1;
  for (std::size_t at = (id * row_step) & mask;; at = (at + 1) & mask) {
    if (slots[at] == 0) return no_owner;
    if (slots[at] >> 32 == id) return static_cast<std::uint32_t>(slots[at]) - 1;
  }
}

CellHasher::CellHasher(const StateSchema& schema) : schema_(schema) {
  tables_.resize(schema.tables.size());
  is_target_.resize(schema.tables.size());
  expanded_.resize(schema.tables.size());
  lookups_.resize(schema.tables.size());
  words_.resize(schema.tables.size());
  first_owner_.resize(schema.tables.size());
  for (std::size_t t = 0; t < tables_.size(); ++t) {
    const TableSchema& described = schema.tables[t];
    Table& table = tables_[t];
    table.owns = owns_rows(schema, t);
    table.is_words = machine_is_little_endian;
    table.seed = mix(0, ~std::uint64_t{t});
    for (const Column& column : described.columns) {
      const std::size_t size = scalar_info(column.type)->size;
      table.is_words = table.is_words && size >= 4;
      table.column_word.push_back(table.words);
      table.words += column.lane_count * (size == 8 ? 2u : 1u);
    }
    table.column_word.push_back(table.words);
    column_count_ += described.columns.size();
    table.key_words = table.column_word[described.key_column_count];
  }
  for (std::size_t t = 0; t < tables_.size(); ++t)
    for (std::size_t c = 0; c < schema.tables[t].columns.size(); ++c) {
      const Column& column = schema.tables[t].columns[c];
      if (tables_[t].owns || column.target < 0 || !tables_[static_cast<std::size_t>(column.target)].owns) continue;
      const auto target = static_cast<std::size_t>(column.target);
      for (std::size_t lane = 0; lane < column.lane_count; ++lane)
        tables_[t].references.push_back({tables_[t].column_word[c] + lane, target});
      is_target_[target] = true;
    }
  if (tables_.size() < kept_table_count_min) return;
  for (std::size_t t = 0; t < tables_.size(); ++t) tables_[t].is_kept = tables_[t].owns && !is_target_[t];
  kept_columns_.resize(column_count_);
}

/// The words of all rows: the rows themselves, or an expanded copy.
const std::uint32_t* CellHasher::words_of(std::size_t index, const TableRows& rows) {
  const Table& table = tables_[index];
  if (table.is_words && reinterpret_cast<std::uintptr_t>(rows.data) % alignof(std::uint32_t) == 0)
    return reinterpret_cast<const std::uint32_t*>(rows.data);
  const TableSchema& described = schema_.tables[index];
  std::vector<std::uint32_t>& words = expanded_[index];
  words.resize(rows.row_count * table.words);
  if (words.empty()) return words.data();
  for (std::size_t c = 0; c < described.columns.size(); ++c) {
    const Column& column = described.columns[c];
    std::uint32_t* out = words.data() + table.column_word[c];
    const std::size_t row_size = described.row_size;
    switch (scalar_info(column.type)->size) {
      case 1:
        expand_lanes<std::uint8_t>(rows, row_size, column, table.words, out);
        break;
      case 2:
        expand_lanes<std::uint16_t>(rows, row_size, column, table.words, out);
        break;
      case 4:
        expand_lanes<std::uint32_t>(rows, row_size, column, table.words, out);
        break;
      default:
        expand_lanes<std::uint64_t>(rows, row_size, column, table.words, out);
        break;
    }
  }
  return words.data();
}

/// Adds the products of some rows to the sums of the table's words.
void CellHasher::add_products(const Table& table, const std::uint32_t* words, std::size_t first,
                              std::size_t row_count) {
  if (table.words < 4) {
    for (std::size_t word = 0; word < table.words; ++word)
      sums_[word] += sum_products_of_word(words + word, table.words, first, row_count);
    return;
  }
  block_sums_.resize(table.words);
  row_kernels().sum_products(words, table.words, first, row_count, block_sums_.data());
  for (std::size_t word = 0; word < table.words; ++word) sums_[word] += block_sums_[word];
}

/// The hashes of the table's columns, from the sums of its words.
void CellHasher::hash_columns(const Table& table, std::size_t row_count, std::uint32_t* out) const {
  for (std::size_t c = 0; c + 1 < table.column_word.size(); ++c) {
    std::uint64_t hash = row_count;
    for (std::size_t word = table.column_word[c]; word < table.column_word[c + 1]; ++word)
      hash = mix(hash, sums_[word]);
    out[c] = static_cast<std::uint32_t>(hash);
  }
}

void CellHasher::make_lookup(const Table& table, const std::uint32_t* words, std::size_t row_count, Lookup& lookup) {
  lookup.first = row_count == 0 ? 0 : words[0];
  lookup.count = static_cast<std::uint32_t>(row_count);
  std::uint32_t deviation = 0;
  for (std::size_t row = 0; row < row_count; ++row)
    deviation |= words[row * table.words] - lookup.first - static_cast<std::uint32_t>(row);
  lookup.is_dense = deviation == 0;
  if (lookup.is_dense) return;
  std::size_t size = 16;
  while (size < 2 * row_count) size *= 2;
  lookup.slots.assign(size, 0);
  for (std::size_t row = 0; row < row_count; ++row) {
    const std::uint32_t id = words[row * table.words];
    std::size_t at = (id * row_step) & (size - 1);
    while (lookup.slots[at] != 0) at = (at + 1) & (size - 1);
    lookup.slots[at] = std::uint64_t{id} << 32 | (row + 1);
  }
}

inline std::uint64_t CellHasher::key_of(const Table& table, const std::uint32_t* row_words, std::size_t row) {
  if (table.key_words == 1) return row_words[0];
  return table.key_words == 0 ? row : hash_row(row_words, table.key_words, 0);
}

/// Puts the owners of a row of a table that does not own into found_; false if there is none.
bool CellHasher::find_owners(const Table& table, const std::uint32_t* row_words) {
  found_.clear();
  for (const Reference& reference : table.references) {
    const std::uint32_t row = lookups_[reference.target].find(row_words[reference.word]);
    if (row != no_owner) found_.push_back(first_owner_[reference.target] + row);
  }
  return !found_.empty();
}

/// Fills words_, first_owner_ and lookups_.
void CellHasher::prepare(const StateView& state, Tables which) {
  TICKTRUE_ASSERT(state.tables.size() == tables_.size());
  std::size_t owner_count = 0;
  for (std::size_t t = 0; t < tables_.size(); ++t) {
    if (which == Tables::not_kept && tables_[t].is_kept) continue;
    words_[t] = words_of(t, state.tables[t]);
    first_owner_[t] = owner_count;
    if (tables_[t].owns) owner_count += state.tables[t].row_count;
    if (is_target_[t]) make_lookup(tables_[t], words_[t], state.tables[t].row_count, lookups_[t]);
  }
  values_.assign(2 * owner_count, 0);
}

namespace {

/// The value of an owner in its cells.
inline std::uint64_t owner_value(const CellPlace& place, std::uint64_t sum) {
  return mix(sum, place.key);
}

/// Xors a value into its wide cells.
inline void put_value(std::uint64_t* cells, std::uint32_t partition_cells, const CellPlace& place,
                      std::uint64_t value) {
  for (std::size_t p = 0; p < partition_count; ++p, cells += partition_cells) cells[place.cells[p]] ^= value;
}

/// The bits of its partition in each cell.
void narrow_cells(const std::uint64_t* wide, std::uint32_t partition_cells, std::uint16_t* cells) {
  for (std::size_t p = 0; p < partition_count; ++p)
    for (std::size_t i = 0; i < partition_cells; ++i) *cells++ = static_cast<std::uint16_t>(*wide++ >> (16 * p));
}

CellPlace place_of(const CellOwner& owner, std::uint32_t partition_cells) {
  CellPlace place;
  place.key = owner.key;
  place.is_known = true;
  const auto cells = cells_of(owner, partition_cells);
  for (std::size_t p = 0; p < partition_count; ++p) place.cells[p] = static_cast<std::uint16_t>(cells[p]);
  return place;
}

}  // namespace

void CellHasher::hash(const StateView& state, std::uint32_t partition_cells, StateCells& out) {
  TICKTRUE_ASSERT(partition_cells <= partition_cells_max && state.tables.size() == tables_.size());
  std::uint64_t owner_count = 0;
  for (std::size_t t = 0; t < tables_.size(); ++t)
    if (tables_[t].owns) owner_count += state.tables[t].row_count;
  out.partition_cells = partition_cells == 0 ? partition_cells_for(owner_count) : partition_cells;
  out.row_counts.clear();
  if (places_cells_ != out.partition_cells) {
    places_cells_ = out.partition_cells;
    forget_values();
  }
  prepare(state, Tables::not_kept);
  wide_cells_.assign(partition_count * out.partition_cells, 0);
  hashed_table_count_ = 0;
  out.columns.assign(column_count_, 0);
  for (const bool owns : {true, false}) {
    std::size_t column = 0;
    for (std::size_t t = 0; t < tables_.size(); ++t) {
      const Table& table = tables_[t];
      if (table.owns == owns && table.is_kept) {
        update_kept(t, state.tables[t], kept_columns_.data() + column);
      } else if (table.owns == owns && state.tables[t].row_count > 0) {
        hash_table(t, state.tables[t].row_count, out.columns.data() + column);
        ++hashed_table_count_;
      }
      column += table.column_word.size() - 1;
    }
  }
  // What is kept of a table that is hashed anew in each tick is 0.
  for (std::size_t c = 0; c < kept_columns_.size(); ++c) out.columns[c] |= kept_columns_[c];
  for (std::size_t i = 0; i < kept_cells_.size(); ++i) wide_cells_[i] ^= kept_cells_[i];
  for (std::size_t t = 0; t < tables_.size(); ++t) {
    out.row_counts.push_back(state.tables[t].row_count);
    if (!tables_[t].owns || tables_[t].is_kept) continue;
    const CellPlace* places = tables_[t].places.data();
    const std::uint64_t* values = values_.data() + first_owner_[t];
    const std::uint64_t* more = values + values_.size() / 2;
    for (std::size_t row = 0; row < state.tables[t].row_count; ++row)
      put_value(wide_cells_.data(), places_cells_, places[row], owner_value(places[row], values[row] + more[row]));
  }
  out.cells.resize(wide_cells_.size());
  narrow_cells(wide_cells_.data(), places_cells_, out.cells.data());
}

void CellHasher::forget_values() {
  for (Table& table : tables_) {
    table.places.clear();
    table.values.clear();
    table.rows_hash.reset();
  }
  if (kept_columns_.empty()) return;
  kept_cells_.assign(partition_count * places_cells_, 0);
  kept_columns_.assign(column_count_, 0);
}

/// Brings what is kept of a table up to its rows.
void CellHasher::update_kept(std::size_t index, const TableRows& rows, std::uint32_t* columns) {
  Table& table = tables_[index];
  const std::size_t row_count = rows.row_count;
  const std::uint64_t rows_hash = hash64({rows.data, row_count * schema_.tables[index].row_size});
  if (table.rows_hash == rows_hash && table.values.size() == row_count) return;
  table.rows_hash = rows_hash;
  ++hashed_table_count_;
  std::uint64_t* const cells = kept_cells_.data();
  for (std::size_t row = row_count; row < table.values.size(); ++row)
    put_value(cells, places_cells_, table.places[row], table.values[row]);  // a second time: takes it out
  table.places.resize(row_count);
  table.values.resize(row_count);
  std::fill(columns, columns + (table.column_word.size() - 1), 0u);
  if (row_count == 0) return;
  const std::uint32_t* words = words_of(index, rows);
  hashes_.resize(row_count);
  hash_rows(short_rows, words, table.words, row_count, table.seed, hashes_.data());
  sums_.assign(table.words, 0);
  add_products(table, words, 0, row_count);
  hash_columns(table, row_count, columns);
  for (std::size_t row = 0; row < row_count; ++row, words += table.words) {
    CellPlace& place = table.places[row];
    std::uint64_t& value = table.values[row];
    const std::uint64_t key = key_of(table, words, row);
    if (place.key != key || !place.is_known) {
      put_value(cells, places_cells_, place, std::exchange(value, 0));
      place = place_of({index, row, key}, places_cells_);
    }
    const std::uint64_t before = std::exchange(value, owner_value(place, hashes_[row]));
    if (value != before) put_value(cells, places_cells_, place, value ^ before);
  }
}

/// Columns and rows of a table, some rows at a time: what is read once stays in the nearest cache for the rest.
void CellHasher::hash_table(std::size_t index, std::size_t row_count, std::uint32_t* columns) {
  constexpr std::size_t block_size = 8 * 1024;  // bytes
  Table& table = tables_[index];
  sums_.assign(table.words, 0);
  if (table.owns) keep_places(index, row_count);
  const std::size_t block_rows = std::max<std::size_t>(2, block_size / (4 * table.words) / 2 * 2);
  for (std::size_t first = 0; first < row_count; first += block_rows) {
    const std::size_t count = std::min(block_rows, row_count - first);
    const std::uint32_t* words = words_[index] + first * table.words;
    if (table.owns)
      hash_rows(short_rows, words, table.words, count, table.seed, values_.data() + first_owner_[index] + first);
    else
      fold_rows(index, first, count);
    add_products(table, words, first, count);
  }
  hash_columns(table, row_count, columns);
}

/// Finds the cells of owners again where another one has come to stand in a row. Keys known to be first, first + 1, ...
/// are not looked at.
void CellHasher::keep_places(std::size_t index, std::size_t row_count) {
  Table& table = tables_[index];
  const bool is_dense = is_target_[index] && lookups_[index].is_dense && table.key_words == 1;
  const std::uint32_t first_key = lookups_[index].first;
  std::size_t known = std::min(row_count, table.places.size());
  table.places.resize(row_count);
  if (!is_dense || !table.places_are_dense || (known > 0 && table.places[0].key != first_key)) known = 0;
  table.places_are_dense = is_dense;
  const std::uint32_t* words = words_[index] + known * table.words;
  for (std::size_t row = known; row < row_count; ++row, words += table.words) {
    const std::uint64_t key = key_of(table, words, row);
    CellPlace& place = table.places[row];
    if (place.key != key || !place.is_known) place = place_of({index, row, key}, places_cells_);
  }
}

/// Rows of a table that does not own go to the owners they refer to. Every second row goes to the second half of the
/// values: contacts stand in the order of their first body, and each addition to the same one waits for the one before.
void CellHasher::fold_rows(std::size_t index, std::size_t first, std::size_t row_count) {
  const Table& table = tables_[index];
  hashes_.resize(row_count);
  const std::uint32_t* words = words_[index] + first * table.words;
  hash_rows(short_rows, words, table.words, row_count, table.seed, hashes_.data());
  const std::uint64_t* hashes = hashes_.data();
  const std::size_t stride = table.words;
  bool all_have_owners = false;
  for (const Reference& reference : table.references) {
    const Lookup& lookup = lookups_[reference.target];
    std::uint64_t* even = values_.data() + first_owner_[reference.target];
    std::uint64_t* odd = even + values_.size() / 2;
    const std::uint32_t* id = words + reference.word;
    std::size_t found = 0;
    const auto fold = [&](const auto& find) {
      const auto add = [&](std::uint64_t* values, std::size_t row) {
        const std::uint32_t owner = find(id[row * stride]);
        if (owner == no_owner) return;
        values[owner] += hashes[row];
        ++found;
      };
      std::size_t row = 0;
      for (; row + 1 < row_count; row += 2) add(even, row), add(odd, row + 1);
      if (row < row_count) add(even, row);
    };
    if (lookup.is_dense)
      fold([first_id = lookup.first, count = lookup.count](std::uint32_t wanted) {
        return wanted - first_id < count ? wanted - first_id : no_owner;
      });
    else
      fold([&](std::uint32_t wanted) { return lookup.find(wanted); });
    all_have_owners = all_have_owners || found == row_count;
  }
  if (all_have_owners) return;
  for (std::size_t row = 0; row < row_count; ++row, words += table.words) {
    if (find_owners(table, words)) continue;
    const std::uint64_t key = key_of(table, words, first + row);
    const CellPlace place = place_of({index, first + row, key}, places_cells_);
    put_value(wide_cells_.data(), places_cells_, place, owner_value(place, hashes_[row]));
  }
}

const std::vector<CellOwner>& CellHasher::owners(const StateView& state) {
  prepare(state, Tables::all);
  owners_.clear();
  for (std::size_t t = 0; t < tables_.size(); ++t)
    for (std::size_t row = 0; row < state.tables[t].row_count; ++row) {
      const std::uint32_t* words = words_[t] + row * tables_[t].words;
      if (tables_[t].owns || !find_owners(tables_[t], words))
        owners_.push_back({t, row, key_of(tables_[t], words, row)});
    }
  return owners_;
}

std::vector<CellOwner> CellHasher::prepared_owners(const StateView& state, std::size_t table, std::size_t row) {
  const std::uint32_t* words = words_[table] + row * tables_[table].words;
  if (tables_[table].owns || !find_owners(tables_[table], words))
    return {{table, row, key_of(tables_[table], words, row)}};
  std::vector<CellOwner> owners;
  for (const std::size_t found : found_) {
    std::size_t target = 0;
    while (!tables_[target].owns || found - first_owner_[target] >= state.tables[target].row_count) ++target;
    const std::size_t target_row = found - first_owner_[target];
    owners.push_back(
        {target, target_row, key_of(tables_[target], words_[target] + target_row * tables_[target].words, target_row)});
  }
  return owners;
}

std::vector<CellOwner> CellHasher::owners_of(const StateView& state, std::size_t table, std::size_t row) {
  prepare(state, Tables::all);
  return prepared_owners(state, table, row);
}

std::vector<std::vector<CellOwner>> CellHasher::owners_of_rows(const StateView& state, std::size_t table) {
  prepare(state, Tables::all);
  std::vector<std::vector<CellOwner>> owners;
  owners.reserve(state.tables[table].row_count);
  for (std::size_t row = 0; row < state.tables[table].row_count; ++row)
    owners.push_back(prepared_owners(state, table, row));
  return owners;
}

}  // namespace ticktrue
