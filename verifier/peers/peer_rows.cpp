// Compares the rows of two states: by key if the table has one, else by position.
// SPDX-License-Identifier: MIT
#include "verifier/peers/peer_rows.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "replay/format/chunk.h"

namespace ticktrue::verifier {
namespace {

ByteView row_of(const TableSchema& table, const ImageTable& rows, std::size_t row) {
  return rows.rows.subspan(row * table.row_size, table.row_size);
}

/// Compares the unsigned values of the key columns: below 0, 0 or above 0.
int compare_key_bytes(const TableSchema& table, ByteView a, ByteView b) {
  for (std::size_t c = 0; c < table.key_column_count; ++c) {
    const Column& column = table.columns[c];
    const std::size_t size = scalar_info(column.type)->size;
    for (std::size_t lane = 0; lane < column.lane_count; ++lane)
      for (std::size_t i = size; i-- > 0;) {
        const std::size_t at = column.offset + lane * size + i;
        if (a[at] != b[at]) return a[at] < b[at] ? -1 : 1;
      }
  }
  return 0;
}

bool ascends_by_key(const TableSchema& table, const ImageTable& rows) {
  if (table.key_column_count == 0) return false;
  for (std::size_t row = 1; row < rows.row_count; ++row)
    if (compare_key_bytes(table, row_of(table, rows, row - 1), row_of(table, rows, row)) >= 0) return false;
  return true;
}

/// Collects rows up to the limit.
class PeerRows {
 public:
  PeerRows(const StateSchema& schema, replay::PeerRecord& peer) : schema_(schema), peer_(peer) {}

  void add_table(std::uint32_t number, const ImageTable& recorder, const ImageTable& player) {
    const TableSchema& table = schema_.tables[number];
    replay::PeerTable found;
    found.table = number;
    const bool by_key = ascends_by_key(table, recorder) && ascends_by_key(table, player);
    std::uint32_t a = 0, b = 0;
    while (!peer_.is_cut && (a < recorder.row_count || b < player.row_count)) {
      const bool has_a = a < recorder.row_count, has_b = b < player.row_count;
      const int order = !has_a    ? 1
                        : !has_b  ? -1
                        : !by_key ? 0
                                  : compare_key_bytes(table, row_of(table, recorder, a), row_of(table, player, b));
      const bool takes_a = order <= 0, takes_b = order >= 0;
      const bool is_same = takes_a && takes_b && is_same_row(table, recorder, a, player, b);
      if (!is_same && has_room((takes_a ? 1 : 0) + (takes_b ? 1 : 0), takes_b ? table.row_size : 0)) {
        if (takes_a) found.removed.push_back(a);
        if (takes_b) add_row(table, player, b, found);
      }
      a += takes_a ? 1 : 0;
      b += takes_b ? 1 : 0;
    }
    if (!found.removed.empty() || !found.rows.empty()) peer_.tables.push_back(std::move(found));
  }

 private:
  static bool is_same_row(const TableSchema& table, const ImageTable& one, std::size_t a, const ImageTable& other,
                          std::size_t b) {
    return std::memcmp(row_of(table, one, a).data(), row_of(table, other, b).data(), table.row_size) == 0;
  }

  bool has_room(std::size_t rows, std::size_t size) {
    if (rows > rows_left_ || size > size_left_) {
      peer_.is_cut = true;
      return false;
    }
    rows_left_ -= rows;
    size_left_ -= size;
    return true;
  }

  static void add_row(const TableSchema& table, const ImageTable& rows, std::uint32_t row, replay::PeerTable& found) {
    found.rows.push_back(row);
    const ByteView bytes = row_of(table, rows, row);
    found.bytes.insert(found.bytes.end(), bytes.begin(), bytes.end());
  }

  const StateSchema& schema_;
  replay::PeerRecord& peer_;
  std::size_t rows_left_ = replay::peer_row_count_max;
  std::size_t size_left_ = replay::peer_rows_size_max;
};

Error no_such_row(const TableSchema& table) {
  return {ErrorCode::corrupt, "peer: table " + table.name + ": found a row behind the last one", ""};
}

Result<Bytes> apply_rows(const TableSchema& table, const ImageTable& recorder, const replay::PeerTable& peer) {
  if (!peer.removed.empty() && peer.removed.back() >= recorder.row_count) return no_such_row(table);
  const std::size_t count = recorder.row_count - peer.removed.size() + peer.rows.size();
  if (!peer.rows.empty() && peer.rows.back() >= count) return no_such_row(table);
  Bytes rows;
  rows.reserve(count * table.row_size);
  std::size_t own = 0, removed = 0, placed = 0;
  for (std::size_t row = 0; row < count; ++row) {
    ByteView bytes;
    if (placed < peer.rows.size() && peer.rows[placed] == row) {
      bytes = ByteView(peer.bytes).subspan(placed++ * table.row_size, table.row_size);
    } else {
      while (removed < peer.removed.size() && peer.removed[removed] == own) ++removed, ++own;
      bytes = row_of(table, recorder, own++);
    }
    rows.insert(rows.end(), bytes.begin(), bytes.end());
  }
  return rows;
}

}  // namespace

void set_peer_rows(const StateSchema& schema, std::span<const ImageTable> recorder, std::span<const ImageTable> player,
                   replay::PeerRecord& peer) {
  peer.has_state = true;
  PeerRows rows(schema, peer);
  for (std::uint32_t t = 0; t < schema.tables.size(); ++t) rows.add_table(t, recorder[t], player[t]);
}

Result<std::vector<Bytes>> rows_of_peer(const StateSchema& schema, std::span<const ImageTable> recorder,
                                        const replay::PeerRecord& peer) {
  std::vector<Bytes> rows;
  auto next = peer.tables.begin();
  for (std::uint32_t t = 0; t < schema.tables.size(); ++t) {
    if (next == peer.tables.end() || next->table != t) {
      rows.emplace_back(recorder[t].rows.begin(), recorder[t].rows.end());
      continue;
    }
    Result<Bytes> applied = apply_rows(schema.tables[t], recorder[t], *next++);
    if (!applied) return applied.error();
    rows.push_back(std::move(*applied));
  }
  return rows;
}

std::vector<ImageTable> tables_of(const StateSchema& schema, const std::vector<Bytes>& rows) {
  std::vector<ImageTable> tables;
  for (std::size_t t = 0; t < rows.size(); ++t)
    tables.push_back({rows[t], static_cast<std::uint32_t>(rows[t].size() / schema.tables[t].row_size)});
  return tables;
}

std::uint64_t root_of_tables(const StateSchema& schema, std::span<const ImageTable> tables) {
  StateView view;
  view.schema = &schema;
  std::vector<Bytes> rows(tables.size());
  for (std::size_t t = 0; t < tables.size(); ++t) {
    rows[t].resize(tables[t].rows.size());
    decode_rows(schema.tables[t], tables[t], rows[t].data());
    view.tables.push_back({rows[t].data(), tables[t].row_count});
  }
  return root_hash(view);
}

}  // namespace ticktrue::verifier
