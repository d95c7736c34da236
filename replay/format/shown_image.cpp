// Writes and reads shown images.
// SPDX-License-Identifier: MIT
#include "replay/format/shown_image.h"

#include <string>

#include "base/limits.h"

namespace ticktrue::replay {

void encode_shown(std::span<const ShownRows> tables, Bytes& out) {
  ByteWriter writer;
  writer.varint(tables.size());
  std::uint32_t next = 0;
  for (const ShownRows& table : tables) {
    writer.varint(table.table - next);
    writer.u32(table.rows.row_count);
    writer.bytes(table.rows.rows);
    next = table.table + 1;
  }
  const ByteView bytes = writer.view();
  out.assign(bytes.begin(), bytes.end());
}

Result<std::vector<ShownRows>> decode_shown(const StateSchema& whole, ByteView bytes) {
  const auto wrong = [](const std::string& what) { return Error{ErrorCode::corrupt, "shown image: " + what, ""}; };
  ByteReader in(bytes);
  const std::uint64_t listed = in.varint();
  if (!in.ok() || listed > whole.tables.size())
    return wrong("tables: found " + std::to_string(listed) + ", expected at most " +
                 std::to_string(whole.tables.size()));
  std::vector<ShownRows> tables;
  std::uint64_t next = 0;
  for (std::uint64_t i = 0; i < listed; ++i) {
    const std::uint64_t skip = in.varint();
    if (!in.ok() || skip >= whole.tables.size() || next + skip >= whole.tables.size())
      return wrong("table: found one behind the last");
    const auto number = static_cast<std::uint32_t>(next + skip);
    next = number + 1;
    const TableSchema& table = whole.tables[number];
    const std::uint32_t row_count = in.u32();
    if (table.shown_row_size == 0) return wrong("table " + table.name + ": found one without shown columns");
    const std::uint64_t size = static_cast<std::uint64_t>(row_count) * table.shown_row_size;
    if (!in.ok() || row_count == 0 || size > in.remaining())
      return wrong("table " + table.name + ": rows: found " + std::to_string(row_count) + ", expected 1 or more in " +
                   std::to_string(in.remaining()) + " bytes");
    tables.push_back({number, {in.bytes(static_cast<std::size_t>(size)), row_count}});
  }
  if (!in.at_end()) return wrong("size: found " + std::to_string(in.remaining()) + " bytes behind the last table");
  return tables;
}

std::string shown_row_text(const TableSchema& whole, const ShownRows& rows, std::size_t row) {
  std::string text;
  for (const Column& column : whole.columns) {
    if (!column.is_shown) continue;
    const std::size_t size = scalar_info(column.type)->size;
    std::string values;
    for (std::size_t lane = 0; lane < column.lane_count; ++lane) {
      const ByteView bytes = rows.rows.rows.subspan(row * whole.shown_row_size + column.offset + lane * size, size);
      std::uint64_t bits = 0;
      for (std::size_t i = 0; i < size; ++i) bits |= static_cast<std::uint64_t>(bytes[i]) << (8 * i);
      values += (lane > 0 ? ", " : "") + lane_text(column.type, bits);
    }
    text += (text.empty() ? "" : ", ") + column.name + " " + (column.lane_count > 1 ? "(" + values + ")" : values);
  }
  return text;
}

}  // namespace ticktrue::replay
