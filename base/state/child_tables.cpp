// Packing of child tables, and the rules of their rows.
// SPDX-License-Identifier: MIT
#include "base/state/child_tables.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "base/limits.h"

namespace ticktrue {
namespace {

constexpr std::size_t owner_offset = 0;
constexpr std::size_t index_offset = 4;
constexpr std::size_t size_offset = 8;
constexpr std::size_t bytes_offset = 12;

std::uint32_t read_u32(const std::uint8_t* at) {
  return static_cast<std::uint32_t>(at[0]) | static_cast<std::uint32_t>(at[1]) << 8 |
         static_cast<std::uint32_t>(at[2]) << 16 | static_cast<std::uint32_t>(at[3]) << 24;
}

void put(std::uint8_t* at, std::uint32_t value) {
  std::memcpy(at, &value, sizeof value);
}

Error wrong(const TableSchema& table, std::size_t row, const std::string& what) {
  return {ErrorCode::corrupt, "state image: " + table.name + "[" + std::to_string(row) + "]: " + what, ""};
}

std::string found_text(std::uint64_t found, const std::string& expected) {
  return "found " + std::to_string(found) + ", expected " + expected;
}

/// Size and unused bytes of a piece. `is_last`: of its owner.
Status check_piece(const TableSchema& table, const std::uint8_t* bytes, std::size_t row, bool is_last) {
  const std::size_t room = piece_size(table);
  const std::uint32_t size = read_u32(bytes + size_offset);
  if (size == 0 || size > room) return wrong(table, row, "size: " + found_text(size, "1.." + std::to_string(room)));
  if (!is_last && size < room)
    return wrong(table, row, "size: " + found_text(size, std::to_string(room) + ": another piece follows"));
  for (std::size_t i = size; i < room; ++i)
    if (bytes[bytes_offset + i] != 0)
      return wrong(table, row,
                   "byte " + std::to_string(i) + ", which is unused: " + found_text(bytes[bytes_offset + i], "0"));
  return {};
}

Status check_child(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t t) {
  const TableSchema& table = schema.tables[t];
  const ImageTable& rows = tables[t];
  const auto parent = static_cast<std::size_t>(table.parent);
  const TableSchema& parent_schema = schema.tables[parent];
  const bool by_id = table.columns[0].target >= 0;
  std::size_t owner_row = 0;  // by id: the first row of the parent whose id is not below the owner
  ChildKey before;
  for (std::size_t row = 0; row < rows.row_count; ++row) {
    const std::uint8_t* bytes = rows.rows.data() + row * table.row_size;
    const ChildKey key = child_key(table, rows, row);
    const bool is_first = row == 0 || key.owner != before.owner;
    if (row > 0 && key.owner < before.owner)
      return wrong(table, row, "owner: " + found_text(key.owner, "at least " + std::to_string(before.owner)));
    const std::uint64_t index = is_first ? 0 : std::uint64_t{before.index} + 1;
    if (key.index != index)
      return wrong(table, row, "index: " + found_text(key.index, std::to_string(index) + ": it counts without gap"));
    if (is_first && by_id) {
      const auto id_at = [&](std::size_t r) {
        return read_u32(tables[parent].rows.data() + r * parent_schema.row_size);
      };
      while (owner_row < tables[parent].row_count && id_at(owner_row) < key.owner) ++owner_row;
      if (owner_row == tables[parent].row_count || id_at(owner_row) != key.owner)
        return wrong(table, row, "owner: " + found_text(key.owner, "the id of a row of " + parent_schema.name));
    } else if (is_first && key.owner >= tables[parent].row_count) {
      return wrong(table, row,
                   "owner: " + found_text(key.owner, "a row of " + parent_schema.name + ", which has " +
                                                         std::to_string(tables[parent].row_count)));
    }
    if (has_pieces(table)) {
      const bool is_last = row + 1 == rows.row_count || child_key(table, rows, row + 1).owner != key.owner;
      if (const Status status = check_piece(table, bytes, row, is_last); !status) return status;
    }
    before = key;
  }
  return {};
}

}  // namespace

bool has_children(const StateSchema& schema) {
  return std::any_of(schema.tables.begin(), schema.tables.end(),
                     [](const TableSchema& table) { return table.form != TableForm::plain; });
}

Status check_children(const StateSchema& schema, std::span<const ImageTable> tables,
                      std::span<const std::uint32_t> changed) {
  const auto is_changed = [&](std::size_t t) { return std::binary_search(changed.begin(), changed.end(), t); };
  for (std::size_t t = 0; t < schema.tables.size(); ++t) {
    const TableSchema& table = schema.tables[t];
    if (table.form == TableForm::plain) continue;
    if (!is_changed(t) && !is_changed(static_cast<std::size_t>(table.parent))) continue;
    if (const Status status = check_child(schema, tables, t); !status) return status;
  }
  return {};
}

Status check_children(const StateSchema& schema, std::span<const ImageTable> tables) {
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    if (schema.tables[t].form != TableForm::plain)
      if (const Status status = check_child(schema, tables, t); !status) return status;
  return {};
}

ChildKey child_key(const TableSchema& table, const ImageTable& rows, std::size_t row) {
  const std::uint8_t* bytes = rows.rows.data() + row * table.row_size;
  return {read_u32(bytes + owner_offset), read_u32(bytes + index_offset)};
}

std::optional<std::size_t> find_owner(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t child,
                                      std::uint32_t owner) {
  const TableSchema& table = schema.tables[child];
  const auto parent = static_cast<std::size_t>(table.parent);
  const std::size_t row_count = tables[parent].row_count;
  if (table.columns[0].target < 0) return owner < row_count ? std::optional<std::size_t>(owner) : std::nullopt;
  const auto id_at = [&](std::size_t row) {
    return read_u32(tables[parent].rows.data() + row * schema.tables[parent].row_size);
  };
  std::size_t low = 0, high = row_count;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    if (id_at(middle) < owner)
      low = middle + 1;
    else
      high = middle;
  }
  return low < row_count && id_at(low) == owner ? std::optional(low) : std::nullopt;
}

std::uint8_t* ChildRows::add(const TableSchema& table, std::uint64_t count, std::uint64_t image_size_max) {
  const std::uint64_t row_count = row_count_ + count;
  if (count > limits::row_count_max || row_count > limits::row_count_max || row_count * table.row_size > image_size_max)
    return nullptr;
  const auto size = static_cast<std::size_t>(row_count * table.row_size);
  // Grows in large steps: a text that grows by a piece in each tick takes no memory in most of them.
  if (size > rows_.size()) rows_.resize(std::max(size, 2 * rows_.size()));
  std::uint8_t* at = rows_.data() + row_count_ * table.row_size;
  row_count_ = static_cast<std::size_t>(row_count);
  return at;
}

namespace {

Error too_large(const TableSchema& table, std::uint32_t owner, std::size_t count, std::uint64_t image_size_max) {
  return {ErrorCode::limit,
          "table " + table.name + ": owner " + std::to_string(owner) + ": found " + std::to_string(count) +
              (has_pieces(table) ? " bytes" : " elements") + ", with which the table grows beyond " +
              std::to_string(limits::row_count_max) + " rows or " + std::to_string(image_size_max) + " bytes",
          "the count that the callback gives is that of one owner"};
}

}  // namespace

Status ChildRows::add_elements(const TableSchema& table, std::uint32_t owner, const ElementList& elements,
                               std::span<const ElementPart> parts, std::uint64_t image_size_max) {
  std::uint8_t* at = add(table, elements.count, image_size_max);
  if (at == nullptr) return too_large(table, owner, elements.count, image_size_max);
  const std::uint8_t* from = elements.first;
  for (std::size_t i = 0; i < elements.count; ++i, at += table.row_size, from += elements.stride) {
    put(at + owner_offset, owner);
    put(at + index_offset, static_cast<std::uint32_t>(i));
    for (const ElementPart& part : parts) std::memcpy(at + part.to, from + part.from, part.size);
  }
  return {};
}

Status ChildRows::add_pieces(const TableSchema& table, std::uint32_t owner, const ElementList& bytes,
                             std::uint64_t image_size_max) {
  if (bytes.count == 0) return {};
  const std::size_t room = piece_size(table);
  const std::uint64_t count = (static_cast<std::uint64_t>(bytes.count) - 1) / room + 1;
  std::uint8_t* at = add(table, count, image_size_max);
  if (at == nullptr) return too_large(table, owner, bytes.count, image_size_max);
  const std::uint8_t* from = bytes.first;
  std::size_t left = bytes.count;
  for (std::uint32_t i = 0; left > 0; ++i, at += table.row_size) {
    const std::size_t size = std::min(left, room);
    put(at + owner_offset, owner);
    put(at + index_offset, i);
    put(at + size_offset, static_cast<std::uint32_t>(size));
    std::memcpy(at + bytes_offset, from, size);
    std::memset(at + bytes_offset + size, 0, room - size);
    if constexpr (!machine_is_little_endian)
      for (std::size_t lane = 0; lane < room; lane += 4)
        std::reverse(at + bytes_offset + lane, at + bytes_offset + lane + 4);
    from += size;
    left -= size;
  }
  return {};
}

}  // namespace ticktrue
