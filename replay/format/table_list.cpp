// Encodes, checks and composes lists of tables. Format: docs/trace_format.md, section 20.
// SPDX-License-Identifier: MIT
#include "replay/format/table_list.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

#include "base/assert.h"
#include "base/limits.h"
#include "replay/format/payload.h"

namespace ticktrue::replay {
namespace {

constexpr std::size_t varint_size_max = 10;

void put_varint(std::uint64_t value, Bytes& out) {
  for (; value > 0x7f; value >>= 7) out.push_back(static_cast<std::uint8_t>(value | 0x80));
  out.push_back(static_cast<std::uint8_t>(value));
}

Error bad_list(const std::string& what) {
  return {ErrorCode::corrupt, "state image: " + what, ""};
}

bool same_rows(ByteView a, ByteView b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size()) == 0);
}

}  // namespace

void encode_table_list(ListBase base, std::span<const ImageTable> tables, std::span<const std::uint32_t> listed,
                       Bytes& out) {
  out.clear();
  out.push_back(static_cast<std::uint8_t>(base));
  put_varint(listed.size(), out);
  std::uint32_t next = 0;
  for (const std::uint32_t table : listed) {
    put_varint(table - next, out);
    next = table + 1;
    for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(tables[table].row_count >> (8 * i)));
    out.insert(out.end(), tables[table].rows.begin(), tables[table].rows.end());
  }
}

/// Reads base and number of tables. False: these fields are incomplete or wrong.
bool TableListShape::read_head(const StateSchema& schema, ByteView image, bool is_whole, Status& status) {
  ByteReader in(image);
  const std::uint8_t base = in.u8();
  left_ = in.varint();
  if (!in.ok()) {
    if (is_whole || image.size() > varint_size_max) status = bad_list("list of tables: ends early");
    return false;
  }
  if (base != static_cast<std::uint8_t>(base_)) {
    status = bad_list("list of tables: base: found " + std::to_string(base) + ", expected " +
                      std::to_string(static_cast<unsigned>(base_)) +
                      (base_ == ListBase::nothing ? ": no state of one tick less stands before it"
                                                  : ": the state of one tick less stands before it"));
    return false;
  }
  if (left_ > schema.tables.size()) {
    status = bad_list("list of tables: found " + std::to_string(left_) + " tables, expected at most " +
                      std::to_string(schema.tables.size()));
    return false;
  }
  offset_ = in.offset();
  return true;
}

Status TableListShape::pass(const StateSchema& schema, ByteView image, std::uint64_t image_size, ListBase base) {
  const bool is_whole = image.size() == image_size;
  base_ = base;
  Status status;
  if (!has_head_) has_head_ = read_head(schema, image, is_whole, status);
  if (!has_head_) return status;
  while (left_ > 0 && offset_ < image.size()) {
    ByteReader in(image.subspan(static_cast<std::size_t>(offset_)));
    const std::uint64_t skip = in.varint();
    const std::uint32_t row_count = in.u32();
    if (!in.ok()) {
      if (is_whole || image.size() - offset_ >= varint_size_max + row_count_size)
        return bad_list("list of tables: ends early, or a skip is no number");
      return {};
    }
    if (skip >= schema.tables.size() - next_table_)
      return bad_list("list of tables: skip: found " + std::to_string(skip) + " behind table " +
                      std::to_string(next_table_) + " of " + std::to_string(schema.tables.size()));
    const std::uint64_t table = next_table_ + skip;
    const TableSchema& described = schema.tables[static_cast<std::size_t>(table)];
    if (row_count == 0 && base == ListBase::nothing)
      return bad_list("table " + described.name + ": is listed and has no rows");
    const std::uint64_t rows = offset_ + in.offset();
    offset_ = rows + std::uint64_t{row_count} * described.row_size;
    if (offset_ > image_size)
      return bad_list("table " + described.name + ": rows: found " + std::to_string(row_count) +
                      ", expected at most what an image of " + std::to_string(image_size) + " bytes holds");
    entries_.push_back({static_cast<std::uint32_t>(table), row_count, static_cast<std::size_t>(rows)});
    next_table_ = table + 1;
    --left_;
  }
  if (left_ == 0 && offset_ != image_size)
    return bad_list("size: found " + std::to_string(image_size) + " bytes, expected " + std::to_string(offset_) +
                    " by its list of tables");
  if (left_ > 0 && is_whole) return bad_list("list of tables: ends early");
  return {};
}

void ComposedState::reset(std::size_t table_count) {
  has_state_ = false;
  tables_.assign(table_count, {});
  own_.assign(table_count, {});
}

void ComposedState::take_whole(const StateSchema& schema, const TableListShape& list, std::uint64_t ticks_done,
                               Bytes& image) {
  std::swap(whole_, image);
  tables_.assign(tables_.size(), {});
  for (Bytes& rows : own_) rows = Bytes();
  listed_.clear();
  size_ = row_count_size * tables_.size();
  for (const TableListShape::Entry& entry : list.entries()) {
    const std::size_t size = std::size_t{entry.row_count} * schema.tables[entry.table].row_size;
    tables_[entry.table] = {ByteView(whole_).subspan(entry.offset, size), entry.row_count};
    listed_.push_back(entry.table);
    size_ += size;
  }
  has_state_ = true;
  ticks_done_ = ticks_done;
}

Status ComposedState::replace(const StateSchema& schema, const TableListShape& list, std::uint64_t ticks_done,
                              ByteView image, std::uint64_t size_max) {
  TICKTRUE_ASSERT(has_state_);
  const auto rows_of = [&](const TableListShape::Entry& entry) {
    return image.subspan(entry.offset, std::size_t{entry.row_count} * schema.tables[entry.table].row_size);
  };
  std::uint64_t size = size_;
  for (const TableListShape::Entry& entry : list.entries()) {
    const ByteView rows = rows_of(entry);
    const ImageTable& before = tables_[entry.table];
    if (before.row_count == entry.row_count && same_rows(before.rows, rows))
      return bad_list("table " + schema.tables[entry.table].name + ": is listed and has the rows of the tick before");
    size += rows.size();
    size -= before.rows.size();
  }
  if (size > size_max)
    return Error{ErrorCode::limit,
                 "state image: bytes of all its tables: found " + std::to_string(size) + ", expected at most " +
                     std::to_string(size_max) + " at this place of the file",
                 ""};
  listed_.clear();
  for (const TableListShape::Entry& entry : list.entries()) {
    const ByteView rows = rows_of(entry);
    own_[entry.table].assign(rows.begin(), rows.end());
    tables_[entry.table] = {own_[entry.table], entry.row_count};
    listed_.push_back(entry.table);
  }
  size_ = size;
  ticks_done_ = ticks_done;
  return {};
}

void LastState::find_changed(std::span<const ImageTable> tables, bool is_whole,
                             std::vector<std::uint32_t>& changed) const {
  changed.clear();
  for (std::size_t t = 0; t < tables.size(); ++t) {
    const bool is_listed = is_whole ? tables[t].row_count > 0 : !same_rows(rows_[t], tables[t].rows);
    if (is_listed) changed.push_back(static_cast<std::uint32_t>(t));
  }
}

void LastState::keep(std::span<const ImageTable> tables, std::span<const std::uint32_t> changed, bool is_whole,
                     std::uint64_t ticks_done) {
  if (is_whole)
    for (Bytes& rows : rows_) rows.clear();
  rows_.resize(tables.size());
  for (const std::uint32_t t : changed) rows_[t].assign(tables[t].rows.begin(), tables[t].rows.end());
  has_state_ = true;
  ticks_done_ = ticks_done;
}

CellLayout::CellLayout(const StateSchema& schema) {
  std::size_t column = 0;
  for (const TableSchema& table : schema.tables) {
    first_column_.push_back(column);
    column += table.columns.size();
  }
  first_column_.push_back(column);
}

void encode_cell_list(const CellLayout& layout, const StateCells& cells, const StateCells* before, ByteWriter& out) {
  const auto is_listed = [&](std::size_t t) {
    if (before == nullptr) return cells.row_counts[t] > 0;
    if (cells.row_counts[t] != before->row_counts[t]) return true;
    const std::size_t size = layout.column_count(t) * sizeof(std::uint32_t);
    const std::size_t first = layout.first_column(t);
    return std::memcmp(&cells.columns[first], &before->columns[first], size) != 0;
  };
  std::uint64_t listed = 0;
  for (std::size_t t = 0; t < layout.table_count(); ++t) listed += is_listed(t) ? 1 : 0;
  out.u8(static_cast<std::uint8_t>(before == nullptr ? ListBase::nothing : ListBase::before));
  out.varint(listed);
  std::size_t next = 0;
  for (std::size_t t = 0; t < layout.table_count(); ++t) {
    if (!is_listed(t)) continue;
    out.varint(t - next);
    next = t + 1;
    out.varint(cells.row_counts[t]);
    if (cells.row_counts[t] == 0) continue;
    for (std::size_t c = 0; c < layout.column_count(t); ++c) out.u32(cells.columns[layout.first_column(t) + c]);
  }
  out.varint(cells.partition_cells);
  encode_row_cells(cells, out);
}

/// Reads one listed table. False: the body ends early, or the table does not differ from the record before.
bool ComposedCells::read_table(const CellLayout& layout, std::size_t table, ByteReader& in) {
  const std::uint64_t row_count = in.varint();
  if (!in.ok() || row_count > std::numeric_limits<std::uint32_t>::max()) return false;
  if (!has_cells_ && row_count == 0) return false;
  bool differs = cells_.row_counts[table] != row_count;
  cells_.row_counts[table] = static_cast<std::uint32_t>(row_count);
  for (std::size_t c = layout.first_column(table); c < layout.first_column(table + 1); ++c) {
    const std::uint32_t value = row_count == 0 ? 0 : in.u32();
    differs = differs || cells_.columns[c] != value;
    cells_.columns[c] = value;
  }
  return in.ok() && differs;
}

bool ComposedCells::apply(const CellLayout& layout, ByteView body) {
  ByteReader in(body);
  const std::uint8_t base = in.u8();
  const std::uint64_t listed = in.varint();
  if (!in.ok() || base != static_cast<std::uint8_t>(has_cells_ ? ListBase::before : ListBase::nothing)) return false;
  if (!has_cells_) {
    cells_.row_counts.assign(layout.table_count(), 0);
    cells_.columns.assign(layout.first_column(layout.table_count()), 0);
  }
  std::size_t next = 0;
  for (std::uint64_t i = 0; i < listed; ++i) {
    const std::uint64_t skip = in.varint();
    if (!in.ok() || skip >= layout.table_count() - next) return false;
    next += static_cast<std::size_t>(skip);
    if (!read_table(layout, next++, in)) return false;
  }
  const std::uint64_t partition_cells = in.varint();
  if (!in.ok() || partition_cells == 0 || partition_cells > partition_cells_max ||
      in.remaining() != 2 * partition_count * static_cast<std::size_t>(partition_cells))
    return false;
  cells_.partition_cells = static_cast<std::uint32_t>(partition_cells);
  cells_.cells.resize(partition_count * cells_.partition_cells);
  const ByteView values = in.bytes(in.remaining());
  for (std::size_t i = 0; i < cells_.cells.size(); ++i)
    cells_.cells[i] = static_cast<std::uint16_t>(values[2 * i] | values[2 * i + 1] << 8);
  has_cells_ = true;
  return true;
}

}  // namespace ticktrue::replay
