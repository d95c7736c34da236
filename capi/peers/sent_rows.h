// Selects the rows of a differing state to send, and reconstructs the other player's state from the received rows.
// SPDX-License-Identifier: MIT
//
// Tables with equal row count and column hashes are not sent. Small tables are sent whole. Of larger tables, the rows
// whose owners the cells name are sent (base/state/cells.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "base/state/cells.h"
#include "base/state/state_view.h"
#include "capi/peers/message.h"

namespace ticktrue::capi {

inline constexpr std::size_t whole_tables_size_max = std::size_t{64} << 10;  // bytes of all tables that are sent whole
inline constexpr std::size_t sent_rows_size_max = std::size_t{1} << 20;      // bytes of all rows
inline constexpr std::size_t sent_row_count_max = 65'536;

/// The rows of `state` that may differ from a state with the cells `there`.
RowsDocument rows_to_send(const StateView& state, const StateCells& there, CellHasher& hasher);

/// The tables of the other player's state. `sent`: the rows that this player sent.
class OtherState {
 public:
  OtherState() = default;
  OtherState(const StateView& here, const RowsDocument& sent, const RowsDocument& came);
  std::span<const ImageTable> tables() const { return tables_; }

 private:
  void merge(const TableSchema& table, const SentTable* sent, const SentTable& came, bool is_cut, Bytes& rows) const;

  std::vector<Bytes> rows_;
  std::vector<ImageTable> tables_;
};

}  // namespace ticktrue::capi
