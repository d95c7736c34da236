// The messages with which players locate a desync: parts of two documents, and how much the sender has received.
// SPDX-License-Identifier: MIT
//
// Documents are cut into parts, so that any transport can carry them. A document is sent again from the first byte that
// the other side lacks, until it is complete. Parts may be lost, duplicated and reordered.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/cells.h"
#include "base/state/schema.h"
#include "capi/peers/kept_ticks.h"

namespace ticktrue::capi {

enum class Document : std::uint8_t { none = 0, cells = 1, rows = 2 };
inline constexpr std::size_t document_count = 2;
inline constexpr std::size_t document_size_max = std::size_t{2} << 20;
inline constexpr std::size_t message_size_min = 256;  // least capacity for a message
inline constexpr std::size_t message_fields_size = 68;

/// How much of the other player's document the sender has received.
struct Received {
  std::uint32_t size = 0;  // bytes from the begin, without a gap
  bool is_whole = false;
};

struct Message {
  std::uint64_t identity = 0;  // of the session
  std::uint32_t from = 0;      // the player who sends
  std::uint32_t to = 0;
  std::uint64_t tick = 0;  // the differing tick
  std::array<Received, document_count> received{};
  Document document = Document::none;
  std::uint32_t document_size = 0;
  std::uint32_t offset = 0;
  ByteView part;
};
Bytes encode_message(const Message& message);
/// The message refers to `bytes`. Errors: corrupt.
Result<Message> decode_message(ByteView bytes);

inline constexpr std::size_t document_root_count_max = 256;

/// The first document of a player about the tick.
struct CellsDocument {
  std::uint64_t first_tick = 0;  // the tick of the first root
  std::vector<std::uint64_t> roots;
  TickInputs inputs;  // of the tick
  bool has_state = false;
  StateCells cells;  // of the state, if has_state
};
void encode_cells_document(const CellsDocument& document, const StateSchema& schema, ByteWriter& out);
/// Errors: corrupt.
Result<CellsDocument> decode_cells_document(const StateSchema& schema, ByteView bytes);

/// Rows of one table that may differ.
struct SentTable {
  std::uint32_t table = 0;
  std::uint32_t row_count = 0;      // rows of the sender's table
  bool is_whole = false;            // all rows are included
  std::vector<std::uint32_t> rows;  // unless is_whole: the numbers of the included rows, ascending
  Bytes bytes;                      // the included rows, canonical
};
struct RowsDocument {
  bool is_cut = false;  // more rows may differ than are included
  std::vector<SentTable> tables;
};
void encode_rows_document(const RowsDocument& document, ByteWriter& out);
/// Errors: corrupt.
Result<RowsDocument> decode_rows_document(const StateSchema& schema, ByteView bytes);

}  // namespace ticktrue::capi
