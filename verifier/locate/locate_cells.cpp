// Finds differing columns and rows from column hashes and cells.
// SPDX-License-Identifier: MIT
#include "verifier/locate/locate_cells.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "replay/format/payload.h"
#include "verifier/locate/locate_contents.h"

namespace ticktrue::verifier {
namespace {

/// The differing cells, by partition.
class CellMap {
 public:
  explicit CellMap(const StateCells& a) : width_(a.partition_cells), marks_(a.cells.size()) {}
  std::size_t index(std::size_t partition, std::uint32_t cell) const { return partition * width_ + cell; }
  bool operator()(std::size_t partition, std::uint32_t cell) const { return marks_[index(partition, cell)]; }
  void set(std::size_t i, bool mark) { marks_[i] = mark; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(std::count(marks_.begin(), marks_.end(), true)); }

 private:
  std::size_t width_;
  std::vector<bool> marks_;
};

/// The value of the row's first key column; nothing: the table has no key.
std::optional<std::uint64_t> id_of(const TableSchema& table, const TableRows& rows, std::size_t row) {
  if (table.key_column_count == 0) return std::nullopt;
  const std::uint8_t* at = rows.data + row * table.row_size;
  const std::size_t size = scalar_info(table.columns[0].type)->size;
  std::uint64_t id = 0;
  for (std::size_t i = 0; i < size; ++i)
    id |= std::uint64_t{at[machine_is_little_endian ? i : size - 1 - i]} << (8 * i);
  return id;
}

CellMap differing_cells(const StateCells& a, const StateCells& b) {
  CellMap map(a);
  for (std::size_t i = 0; i < a.cells.size(); ++i) map.set(i, a.cells[i] != b.cells[i]);
  return map;
}

}  // namespace

CellFinding find_candidates(const StateCells& expected, const StateCells& got, const std::vector<CellOwner>& owners,
                            const std::vector<CellOwner>& gone) {
  TICKTRUE_ASSERT(expected.cells.size() == got.cells.size());
  CellFinding finding;
  const CellMap differs = differing_cells(expected, got);
  CellMap unexplained = differs;
  finding.differing_cells = differs.count();
  const auto owner_at = [&](std::size_t i) -> const CellOwner& {
    return i < owners.size() ? owners[i] : gone[i - owners.size()];
  };
  const auto add = [&](std::size_t i) {
    (i < owners.size() ? finding.candidates : finding.gone).push_back(owner_at(i));
    const auto at = cells_of(owner_at(i), expected.partition_cells);
    for (std::size_t p = 0; p < partition_count; ++p) unexplained.set(unexplained.index(p, at[p]), false);
  };
  std::vector<std::size_t> by_three;
  for (std::size_t i = 0; i < owners.size() + gone.size(); ++i) {
    const auto at = cells_of(owner_at(i), expected.partition_cells);
    std::size_t matches = 0;
    for (std::size_t p = 0; p < partition_count; ++p) matches += differs(p, at[p]) ? 1 : 0;
    if (matches == partition_count) add(i);
    if (matches + 1 == partition_count) by_three.push_back(i);
  }
  const CellMap left = unexplained;
  const bool is_long = finding.candidates.size() + finding.gone.size() > short_list_max;
  for (const std::size_t i : by_three) {
    const auto at = cells_of(owner_at(i), expected.partition_cells);
    bool explains = is_long;
    for (std::size_t p = 0; p < partition_count; ++p) explains = explains || left(p, at[p]);
    if (!explains) continue;
    add(i);
    finding.healed = true;
  }
  finding.unexplained_cells = unexplained.count();
  return finding;
}

std::uint64_t estimate_differing(const StateCells& expected, const StateCells& got, std::uint64_t owner_count) {
  if (expected.cells.size() != got.cells.size()) return owner_count;
  const double share =
      static_cast<double>(differing_cells(expected, got).count()) / static_cast<double>(expected.cells.size());
  if (share >= 1) return owner_count;
  // d owners leave (1 - 1/c)^d of the c cells of a partition unchanged.
  const double count = std::log1p(-share) / std::log1p(-1.0 / expected.partition_cells);
  return std::min(owner_count, static_cast<std::uint64_t>(std::llround(count)));
}

RowsBefore rows_before(const StateView& state, const RowNamer& row_name) {
  RowsBefore before;
  before.owners = CellHasher(*state.schema).owners(state);
  for (const CellOwner& owner : before.owners) before.names.push_back(row_name ? row_name(owner.table, owner.row) : "");
  for (const TableRows& rows : state.tables) before.row_counts.push_back(rows.row_count);
  return before;
}

namespace {

using OwnerKey = std::pair<std::size_t, std::uint64_t>;  // table, key
std::set<OwnerKey> keys_of(const std::vector<CellOwner>& owners) {
  std::set<OwnerKey> keys;
  for (const CellOwner& owner : owners) keys.emplace(owner.table, owner.key);
  return keys;
}

/// Adds candidates to the divergence: owners in the state here, and owners in the previous state that no longer exist.
/// If the number of rows is unchanged, a missing owner is the row here with the same index and another key.
void list_candidates(const StateSchema& schema, const CellFinding& finding, const StateView& rows,
                     const RowNamer& row_name, const RowsBefore* before, std::vector<Candidate>& listed) {
  const auto is_listed = [&](const std::string& table, std::uint64_t row) {
    return std::any_of(listed.begin(), listed.end(),
                       [&](const Candidate& other) { return other.table == table && other.row == row; });
  };
  const auto list_here = [&](std::size_t table, std::size_t row) {
    Candidate candidate{schema.tables[table].name, row, id_of(schema.tables[table], rows.tables[table], row), ""};
    if (row_name) candidate.name = row_name(table, row);
    listed.push_back(std::move(candidate));
  };
  for (const CellOwner& owner : finding.candidates) list_here(owner.table, owner.row);
  for (const CellOwner& owner : finding.gone) {
    const TableSchema& table = schema.tables[owner.table];
    if (before->row_counts[owner.table] == rows.tables[owner.table].row_count) {
      if (!is_listed(table.name, owner.row)) list_here(owner.table, owner.row);
      continue;
    }
    Candidate candidate{table.name, owner.row, std::nullopt, ""};
    if (table.key_column_count == 1) candidate.id = owner.key;
    for (std::size_t i = 0; i < before->owners.size(); ++i)
      if (before->owners[i].table == owner.table && before->owners[i].row == owner.row)
        candidate.name = before->names[i];
    listed.push_back(std::move(candidate));
  }
}

}  // namespace

void locate_cells(const StateSchema& schema, const StateCells& expected, const StateCells& got, const StateView* rows,
                  const RowNamer& row_name, std::size_t row_count_max, Divergence& divergence,
                  const RowsBefore* before) {
  divergence.tables.clear();
  divergence.row_counts.clear();
  divergence.candidates.clear();
  std::size_t first_column = 0;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const TableSchema& table = schema.tables[t];
    TableDifference difference;
    difference.table = table.name;
    difference.is_content = has_pieces(table);
    for (std::size_t c = 0; c < table.columns.size(); ++c)
      if (expected.columns[first_column + c] != got.columns[first_column + c])
        difference.columns.push_back(table.columns[c].name);
    first_column += table.columns.size();
    if (expected.row_counts[t] != got.row_counts[t])
      divergence.row_counts.push_back({table.name, expected.row_counts[t], got.row_counts[t]});
    if (!difference.columns.empty()) divergence.tables.push_back(std::move(difference));
  }
  divergence.from_cells = true;
  if (rows == nullptr || expected.partition_cells != got.partition_cells) return;
  CellHasher hasher(schema);
  const std::vector<CellOwner>& owners = hasher.owners(*rows);
  std::vector<CellOwner> gone;
  if (before != nullptr) {
    const std::set<OwnerKey> here = keys_of(owners);
    for (const CellOwner& owner : before->owners)
      if (here.count({owner.table, owner.key}) == 0) gone.push_back(owner);
  }
  const CellFinding finding = find_candidates(expected, got, owners, gone);
  divergence.owner_count = owners.size();
  divergence.healed = finding.healed;
  divergence.unexplained_cells = finding.unexplained_cells;
  list_candidates(schema, finding, *rows, row_name, before, divergence.candidates);
  divergence.candidate_count = divergence.candidates.size();
  divergence.candidates.resize(std::min(divergence.candidates.size(), row_count_max));
  if (!has_children(schema)) return;
  Bytes buffer;
  const std::vector<ImageTable> tables = canonical_tables(*rows, buffer);
  for (Candidate& candidate : divergence.candidates)
    if (const auto t = schema.find_table(candidate.table); t && candidate.row < tables[*t].row_count)
      candidate.place = child_place(schema, tables, *t, static_cast<std::size_t>(candidate.row));
}

namespace {

std::uint64_t count_owners(const StateSchema& schema, const std::vector<std::uint32_t>& row_counts) {
  std::uint64_t count = 0;
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    if (owns_rows(schema, t)) count += row_counts[t];
  return count;
}

}  // namespace

Spread spread_of_cells(const StateSchema& schema, const StateCells& a, const StateCells& b, std::uint64_t tick) {
  const std::uint64_t owner_count = std::max(count_owners(schema, a.row_counts), count_owners(schema, b.row_counts));
  return {tick, estimate_differing(a, b, owner_count), owner_count, true};
}

Spread spread_of_tables(const StateSchema& schema, std::span<const ImageTable> a, std::span<const ImageTable> b,
                        std::uint64_t tick) {
  Spread spread;
  spread.tick = tick;
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    if (owns_rows(schema, t)) spread.of += std::max(a[t].row_count, b[t].row_count);
  constexpr std::size_t lane_count_max = 1'000'000;
  StatePlace last{schema.tables.size(), 0, 0, 0};
  for (const LaneDifference& lane : diff_images(schema, a, b, lane_count_max)) {
    const bool is_new = lane.place.table != last.table || lane.place.row != last.row;
    last = lane.place;
    if (is_new && owns_rows(schema, lane.place.table)) ++spread.row_count;
  }
  return spread;
}

std::optional<Spread> measure_spread(const StateSchema& schema, const replay::TickRecord& recorded,
                                     const StateView& here, CellHasher& hasher) {
  if (recorded.cells != nullptr) {
    StateCells got;
    hasher.hash(here, recorded.cells->partition_cells, got);
    return spread_of_cells(schema, *recorded.cells, got, recorded.tick);
  }
  if (recorded.image) {
    Bytes buffer;
    return spread_of_tables(schema, recorded.image->tables, canonical_tables(here, buffer), recorded.tick);
  }
  return std::nullopt;
}

std::string more_detail_command(const std::string& file, std::uint64_t tick, const std::string& tool) {
  const std::string number = std::to_string(tick);
  return tool + " record " + shell_word(file) + " --ticks " + std::to_string(tick + 1) + " --detail full:" + number +
         ".." + number + " -o full.ttr, with the build that recorded it; then " + tool + " verify full.ttr here";
}

Result<ImageState> ImageState::of(const StateSchema& schema, ByteView image) {
  const Result<std::vector<ImageTable>> tables = split_image(schema, image);
  if (!tables) return tables.error();
  ImageState state;
  state.view_.schema = &schema;
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const ImageTable& table = (*tables)[t];
    state.rows_.emplace_back(table.rows.size());
    decode_rows(schema.tables[t], table, state.rows_.back().data());
    state.view_.tables.push_back({state.rows_.back().data(), table.row_count});
  }
  return state;
}

}  // namespace ticktrue::verifier
