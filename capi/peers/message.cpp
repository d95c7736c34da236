// Encodes and checks messages and their documents. Format: docs/trace_format.md, "Messages of a desync".
// SPDX-License-Identifier: MIT
#include "capi/peers/message.h"

#include <algorithm>
#include <string>
#include <utility>

#include "base/hash.h"
#include "base/limits.h"
#include "replay/format/table_list.h"

namespace ticktrue::capi {
namespace {

constexpr std::array<std::uint8_t, 4> message_magic{'T', 'T', 'D', 1};
constexpr std::size_t message_check_size = 8;
constexpr std::size_t message_size_max = document_size_max + 1'024;

Error wrong_message(const std::string& what) {
  return {ErrorCode::corrupt, "desync message: " + what, ""};
}

/// Reads a flag. False: the byte is neither 0 nor 1.
bool read_message_flag(ByteReader& in, bool& flag) {
  const std::uint8_t value = in.u8();
  flag = value == 1;
  return value <= 1;
}

}  // namespace

Bytes encode_message(const Message& message) {
  ByteWriter out;
  out.bytes(message_magic);
  out.u64(message.identity);
  out.u32(message.from);
  out.u32(message.to);
  out.u64(message.tick);
  for (const Received& received : message.received) {
    out.u32(received.size);
    out.u8(received.is_whole ? 1 : 0);
  }
  out.u8(static_cast<std::uint8_t>(message.document));
  out.u32(message.document_size);
  out.u32(message.offset);
  out.u32(static_cast<std::uint32_t>(message.part.size()));
  out.bytes(message.part);
  out.u64(hash64(out.view()));
  return out.take();
}

Result<Message> decode_message(ByteView bytes) {
  if (bytes.size() > message_size_max) return wrong_message("found " + std::to_string(bytes.size()) + " bytes");
  if (bytes.size() < message_magic.size() + message_check_size ||
      !std::equal(message_magic.begin(), message_magic.end(), bytes.begin()))
    return wrong_message("found other bytes, expected those of ticktrue_desync_message");
  const ByteView content = bytes.first(bytes.size() - message_check_size);
  const std::uint64_t check = ByteReader(bytes.last(message_check_size)).u64();
  if (const std::uint64_t found = hash64(content); found != check)
    return wrong_message("check: found " + hex64(found) + ", expected " + hex64(check));
  ByteReader in(content.subspan(message_magic.size()));
  Message message;
  message.identity = in.u64();
  message.from = in.u32();
  message.to = in.u32();
  message.tick = in.u64();
  for (Received& received : message.received) {
    received.size = in.u32();
    if (!read_message_flag(in, received.is_whole)) return wrong_message("a flag is neither 0 nor 1");
  }
  const std::uint8_t document = in.u8();
  message.document_size = in.u32();
  message.offset = in.u32();
  message.part = in.bytes(in.u32());
  if (!in.ok() || !in.at_end()) return wrong_message("ends early, or bytes follow");
  if (document > document_count) return wrong_message("document: found " + std::to_string(document));
  message.document = static_cast<Document>(document);
  const bool has_part = !message.part.empty();
  if (message.document_size > document_size_max || message.offset > message.document_size ||
      message.part.size() > message.document_size - message.offset || has_part != (message.document != Document::none))
    return wrong_message("a part lies outside of its document");
  return message;
}

void encode_cells_document(const CellsDocument& document, const StateSchema& schema, ByteWriter& out) {
  out.u64(document.first_tick);
  out.u16(static_cast<std::uint16_t>(document.roots.size()));
  for (const std::uint64_t root : document.roots) out.u64(root);
  out.f64(document.inputs.dt);
  out.u64(document.inputs.size);
  out.u64(document.inputs.hash);
  out.u8(static_cast<std::uint8_t>(document.inputs.begin.size()));
  out.bytes(document.inputs.begin);
  out.u8(document.has_state ? 1 : 0);
  if (document.has_state) replay::encode_cell_list(replay::CellLayout(schema), document.cells, nullptr, out);
}

Result<CellsDocument> decode_cells_document(const StateSchema& schema, ByteView bytes) {
  ByteReader in(bytes);
  CellsDocument document;
  document.first_tick = in.u64();
  const std::uint16_t root_count = in.u16();
  if (root_count > document_root_count_max) return wrong_message("too many roots");
  for (std::size_t i = 0; i < root_count && in.ok(); ++i) document.roots.push_back(in.u64());
  if (document.first_tick > limits::tick_count_max) return wrong_message("first tick: found one behind the last");
  document.inputs.dt = in.f64();
  document.inputs.size = in.u64();
  document.inputs.hash = in.u64();
  const std::uint8_t begin_size = in.u8();
  if (begin_size > input_begin_max) return wrong_message("too many bytes of inputs");
  const ByteView begin = in.bytes(begin_size);
  document.inputs.begin.assign(begin.begin(), begin.end());
  if (!read_message_flag(in, document.has_state) || !in.ok())
    return wrong_message("ends early, or a flag is neither 0 nor 1");
  const ByteView list = in.bytes(in.remaining());
  if (!document.has_state) {
    if (!list.empty()) return wrong_message("bytes follow");
    return document;
  }
  replay::ComposedCells cells;
  if (!cells.apply(replay::CellLayout(schema), list)) return wrong_message("cells: no list of this session's tables");
  document.cells = cells.cells();
  return document;
}

void encode_rows_document(const RowsDocument& document, ByteWriter& out) {
  out.u8(document.is_cut ? 1 : 0);
  out.varint(document.tables.size());
  std::uint32_t next = 0;
  for (const SentTable& table : document.tables) {
    out.varint(table.table - next);
    next = table.table + 1;
    out.u32(table.row_count);
    out.u8(table.is_whole ? 1 : 0);
    if (!table.is_whole) {
      out.u32(static_cast<std::uint32_t>(table.rows.size()));
      for (const std::uint32_t row : table.rows) out.u32(row);
    }
    out.bytes(table.bytes);
  }
}

Result<RowsDocument> decode_rows_document(const StateSchema& schema, ByteView bytes) {
  ByteReader in(bytes);
  RowsDocument document;
  if (!read_message_flag(in, document.is_cut)) return wrong_message("a flag is neither 0 nor 1");
  const std::uint64_t table_count = in.varint();
  std::uint64_t next = 0;
  for (std::uint64_t i = 0; i < table_count; ++i) {
    const std::uint64_t skip = in.varint();
    SentTable table;
    table.row_count = in.u32();
    if (!read_message_flag(in, table.is_whole)) return wrong_message("a flag is neither 0 nor 1");
    if (!in.ok() || skip >= schema.tables.size() - next) return wrong_message("rows: end early, or are of no table");
    table.table = static_cast<std::uint32_t>(next + skip);
    next = table.table + 1;
    if (table.row_count > limits::row_count_max) return wrong_message("rows: too many");
    std::uint64_t count = table.row_count;
    if (!table.is_whole) {
      count = in.u32();
      if (count > in.remaining() / sizeof(std::uint32_t)) return wrong_message("rows: end early");
      for (std::uint64_t row = 0; row < count; ++row) {
        const std::uint32_t number = in.u32();
        if (number >= table.row_count || (!table.rows.empty() && number <= table.rows.back()))
          return wrong_message("rows: their numbers do not ascend within the table");
        table.rows.push_back(number);
      }
    }
    const std::uint64_t size = count * schema.tables[table.table].row_size;
    if (size > in.remaining()) return wrong_message("rows: end early");
    const ByteView rows = in.bytes(static_cast<std::size_t>(size));
    table.bytes.assign(rows.begin(), rows.end());
    document.tables.push_back(std::move(table));
  }
  if (!in.ok() || !in.at_end()) return wrong_message("rows: bytes follow");
  return document;
}

}  // namespace ticktrue::capi
