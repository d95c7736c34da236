// Selects rows by the cells of both states. Merges received rows into a copy of this player's rows.
// SPDX-License-Identifier: MIT
#include "capi/peers/sent_rows.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "replay/format/table_list.h"
#include "verifier/locate/locate_cells.h"

namespace ticktrue::capi {
namespace {

/// Tables with other row counts or column hashes. If only the root hash differs, all tables.
std::vector<std::uint32_t> differing_tables(const StateSchema& schema, const StateCells& a, const StateCells& b) {
  const replay::CellLayout layout(schema);
  std::vector<std::uint32_t> found;
  for (std::size_t t = 0; t < layout.table_count(); ++t) {
    const std::size_t first = layout.first_column(t);
    bool differs = a.row_counts[t] != b.row_counts[t];
    for (std::size_t c = 0; c < layout.column_count(t); ++c) differs |= a.columns[first + c] != b.columns[first + c];
    if (differs) found.push_back(static_cast<std::uint32_t>(t));
  }
  if (found.empty())
    for (std::size_t t = 0; t < layout.table_count(); ++t) found.push_back(static_cast<std::uint32_t>(t));
  return found;
}

using OwnerKeys = std::set<std::pair<std::size_t, std::size_t>>;  // table, row

class Selection {
 public:
  Selection(const StateView& state, CellHasher& hasher, OwnerKeys candidates)
      : state_(state), hasher_(hasher), candidates_(std::move(candidates)) {}

  void add(std::uint32_t number, const ImageTable& rows) {
    const std::size_t row_size = state_.schema->tables[number].row_size;
    SentTable table;
    table.table = number;
    table.row_count = rows.row_count;
    table.is_whole = rows.rows.size() <= whole_left_;
    if (table.is_whole) {
      whole_left_ -= rows.rows.size();
      table.bytes.assign(rows.rows.begin(), rows.rows.end());
    } else {
      const auto owners = hasher_.owners_of_rows(state_, number);
      for (std::uint32_t row = 0; row < rows.row_count && !document_.is_cut; ++row) {
        if (!can_differ(owners[row])) continue;
        if (row_size > bytes_left_ || rows_left_ == 0) {
          document_.is_cut = true;
          break;
        }
        bytes_left_ -= row_size;
        --rows_left_;
        table.rows.push_back(row);
        const ByteView bytes = rows.rows.subspan(row * row_size, row_size);
        table.bytes.insert(table.bytes.end(), bytes.begin(), bytes.end());
      }
    }
    document_.tables.push_back(std::move(table));
  }
  RowsDocument take() { return std::move(document_); }

 private:
  bool can_differ(const std::vector<CellOwner>& owners) const {
    return std::any_of(owners.begin(), owners.end(), [this](const CellOwner& owner) {
      return candidates_.count({owner.table, owner.row}) > 0;
    });
  }

  const StateView& state_;
  CellHasher& hasher_;
  OwnerKeys candidates_;
  RowsDocument document_;
  std::size_t whole_left_ = whole_tables_size_max;
  std::size_t bytes_left_ = sent_rows_size_max - whole_tables_size_max;
  std::size_t rows_left_ = sent_row_count_max;
};

}  // namespace

RowsDocument rows_to_send(const StateView& state, const StateCells& there, CellHasher& hasher) {
  StateCells here;
  hasher.hash(state, there.partition_cells, here);
  OwnerKeys candidates;
  for (const CellOwner& owner : verifier::find_candidates(there, here, hasher.owners(state)).candidates)
    candidates.emplace(owner.table, owner.row);
  Bytes buffer;
  const std::vector<ImageTable> tables = canonical_tables(state, buffer);
  Selection selection(state, hasher, std::move(candidates));
  for (const std::uint32_t table : differing_tables(*state.schema, here, there)) selection.add(table, tables[table]);
  return selection.take();
}

/// Rows are matched by key, or by number if the table has no key. A row with a key that was sent and did not come back
/// does not exist on the other side.
void OtherState::merge(const TableSchema& table, const SentTable* sent, const SentTable& came, bool is_cut,
                       Bytes& rows) const {
  const std::size_t size = table.row_size;
  if (table.key_column_count == 0) {
    // The document was truncated: a row that neither side has is left out.
    const std::size_t last = came.rows.empty() ? 0 : std::size_t{came.rows.back()} + 1;
    rows.resize(std::min<std::size_t>(came.row_count, std::max(rows.size() / size, last)) * size);
    for (std::size_t i = 0; i < came.rows.size(); ++i)
      std::memcpy(rows.data() + came.rows[i] * size, came.bytes.data() + i * size, size);
    return;
  }
  const auto key_of = [&table](const std::uint8_t* row) {
    std::vector<std::uint64_t> key;
    for (std::size_t c = 0; c < table.key_column_count; ++c)
      key.push_back(lane_bits(table, {row, table.row_size}, {0, 0, c, 0}));
    return key;
  };
  std::map<std::vector<std::uint64_t>, const std::uint8_t*> merged;
  for (std::size_t i = 0; i < rows.size(); i += size) merged[key_of(rows.data() + i)] = rows.data() + i;
  if (sent != nullptr && !sent->is_whole && !is_cut)
    for (std::size_t i = 0; i < sent->bytes.size(); i += size) merged.erase(key_of(sent->bytes.data() + i));
  for (std::size_t i = 0; i < came.bytes.size(); i += size)
    merged[key_of(came.bytes.data() + i)] = came.bytes.data() + i;
  Bytes all;
  for (const auto& [key, row] : merged) all.insert(all.end(), row, row + size);
  rows = std::move(all);
}

OtherState::OtherState(const StateView& here, const RowsDocument& sent, const RowsDocument& came) {
  const StateSchema& schema = *here.schema;
  Bytes buffer;
  for (const ImageTable& table : canonical_tables(here, buffer))
    rows_.emplace_back(table.rows.begin(), table.rows.end());
  for (const SentTable& table : came.tables) {
    if (table.is_whole) {
      rows_[table.table] = table.bytes;
      continue;
    }
    const auto own = std::find_if(sent.tables.begin(), sent.tables.end(),
                                  [&](const SentTable& other) { return other.table == table.table; });
    merge(schema.tables[table.table], own == sent.tables.end() ? nullptr : &*own, table, came.is_cut || sent.is_cut,
          rows_[table.table]);
  }
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    tables_.push_back({rows_[t], static_cast<std::uint32_t>(rows_[t].size() / schema.tables[t].row_size)});
}

}  // namespace ticktrue::capi
