// The messages with which players locate a desync: parts of two documents, and what the sender has of the other's.
// SPDX-License-Identifier: MIT
//
// Documents are cut into parts so that any transport can carry them. A document is sent again from the first byte that
// the other side lacks, until it has all: parts may be lost, doubled and come in any order.
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
inline constexpr std::size_t message_size_min = 256;  // room that a message is given at least
inline constexpr std::size_t message_fields_size = 68;

/// How much of the other's documents the sender has.
struct Received {
  std::uint32_t size = 0;  // from the begin, without gap
  bool is_whole = false;
};

struct Message {
  std::uint64_t identity = 0;  // of the session
  std::uint32_t from = 0;      // player
  std::uint32_t to = 0;
  std::uint64_t tick = 0;  // that differs
  std::array<Received, document_count> received{};
  Document document = Document::none;
  std::uint32_t document_size = 0;
  std::uint32_t offset = 0;
  ByteView part;
};
Bytes encode_message(const Message& message);
/// Views into `bytes`. Errors: corrupt.
Result<Message> decode_message(ByteView bytes);

inline constexpr std::size_t document_root_count_max = 256;

/// What a player says of the tick first.
struct CellsDocument {
  std::uint64_t first_tick = 0;  // of the roots
  std::vector<std::uint64_t> roots;
  TickInputs inputs;  // of the tick
  bool has_state = false;
  StateCells cells;  // of the state, if there is one
};
void encode_cells_document(const CellsDocument& document, const StateSchema& schema, ByteWriter& out);
/// Errors: corrupt.
Result<CellsDocument> decode_cells_document(const StateSchema& schema, ByteView bytes);

/// Rows of one table that can differ.
struct SentTable {
  std::uint32_t table = 0;
  std::uint32_t row_count = 0;      // that the sender has
  bool is_whole = false;            // all of them are here
  std::vector<std::uint32_t> rows;  // else: which, ascending
  Bytes bytes;                      // canonical
};
struct RowsDocument {
  bool is_cut = false;  // more rows can differ than are here
  std::vector<SentTable> tables;
};
void encode_rows_document(const RowsDocument& document, ByteWriter& out);
/// Errors: corrupt.
Result<RowsDocument> decode_rows_document(const StateSchema& schema, ByteView bytes);

}  // namespace ticktrue::capi
