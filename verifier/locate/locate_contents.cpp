// Puts pieces together, owner by owner, in the order of all states.
// SPDX-License-Identifier: MIT
#include "verifier/locate/locate_contents.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

namespace ticktrue::verifier {
namespace {

constexpr std::size_t size_offset = 8;
constexpr std::size_t bytes_offset = 12;
constexpr std::size_t nesting_max = 64;  // of child tables; for a deeper child only the table is reported

/// The tables of one side.
struct Side {
  const StateSchema& schema;
  std::span<const ImageTable> tables;
};

/// Identifies a row in all states: id or number of the row at the top level, followed by indices.
using Path = std::vector<std::uint64_t>;

std::optional<Path> path_of(const Side& side, std::size_t t, std::size_t row, std::size_t depth);

/// The path of the parent row that owns the child rows with this owner.
std::optional<Path> owner_path(const Side& side, std::size_t child, std::uint32_t owner, std::size_t depth) {
  const auto parent = static_cast<std::size_t>(side.schema.tables[child].parent);
  if (side.schema.tables[parent].form == TableForm::plain) return Path{owner};
  const std::optional<std::size_t> row = find_owner(side.schema, side.tables, child, owner);
  return row ? path_of(side, parent, *row, depth + 1) : std::nullopt;
}

/// The path of a row. Requires: a child table.
std::optional<Path> path_of(const Side& side, std::size_t t, std::size_t row, std::size_t depth) {
  if (depth > nesting_max) return std::nullopt;
  const ChildKey key = child_key(side.schema.tables[t], side.tables[t], row);
  std::optional<Path> path = owner_path(side, t, key.owner, depth);
  if (path) path->push_back(key.index);
  return path;
}

/// The row of the child table with this owner and index.
std::optional<std::size_t> find_element(const Side& side, std::size_t t, std::uint32_t owner, std::uint64_t index) {
  const TableSchema& table = side.schema.tables[t];
  std::size_t low = 0, high = side.tables[t].row_count;
  while (low < high) {
    const std::size_t middle = low + (high - low) / 2;
    const ChildKey key = child_key(table, side.tables[t], middle);
    if (std::pair<std::uint64_t, std::uint64_t>(key.owner, key.index) <
        std::pair<std::uint64_t, std::uint64_t>(owner, index))
      low = middle + 1;
    else
      high = middle;
  }
  if (low == side.tables[t].row_count) return std::nullopt;
  const ChildKey key = child_key(table, side.tables[t], low);
  return key.owner == owner && key.index == index ? std::optional(low) : std::nullopt;
}

/// Whether this side has the parent row with this path.
bool has_row(const Side& side, std::size_t child, std::span<const std::uint64_t> path) {
  // The parents of the child, from the nearest to the top level.
  std::vector<std::size_t> parents;
  for (std::size_t t = child; side.schema.tables[t].form != TableForm::plain && parents.size() <= nesting_max;) {
    t = static_cast<std::size_t>(side.schema.tables[t].parent);
    parents.push_back(t);
  }
  if (parents.size() != path.size()) return true;
  auto owner = static_cast<std::uint32_t>(path[0]);
  for (std::size_t level = 0; level + 1 < path.size(); ++level) {
    const std::size_t t = parents[parents.size() - 2 - level];
    if (!find_owner(side.schema, side.tables, t, owner)) return false;
    const std::optional<std::size_t> row = find_element(side, t, owner, path[level + 1]);
    if (!row) return false;
    owner = static_cast<std::uint32_t>(*row);
  }
  return find_owner(side.schema, side.tables, child, owner).has_value();
}

/// The pieces of one owner.
struct Pieces {
  const TableSchema* table = nullptr;
  const std::uint8_t* rows = nullptr;
  std::size_t count = 0;
  std::uint32_t owner = 0;

  std::size_t room() const { return piece_size(*table); }
  std::uint64_t size() const {
    if (count == 0) return 0;
    const std::uint8_t* last = rows + (count - 1) * table->row_size;
    std::uint32_t used = 0;
    for (int i = 0; i < 4; ++i)
      used |= static_cast<std::uint32_t>(last[size_offset + static_cast<std::size_t>(i)]) << (8 * i);
    return static_cast<std::uint64_t>(count - 1) * room() + std::min<std::uint64_t>(used, room());
  }
  const std::uint8_t* piece(std::size_t i) const { return rows + i * table->row_size + bytes_offset; }
  std::uint8_t at(std::uint64_t offset) const {
    return piece(static_cast<std::size_t>(offset / room()))[offset % room()];
  }
  std::string part(std::uint64_t first, std::uint64_t behind) const {
    std::string text;
    for (std::uint64_t i = first; i < behind; ++i) text += static_cast<char>(at(i));
    return text;
  }
};

/// The pieces of the owner whose first piece is `row`. Requires: such a row.
Pieces pieces_at(const Side& side, std::size_t t, std::size_t row) {
  const TableSchema& table = side.schema.tables[t];
  Pieces pieces{&table, side.tables[t].rows.data() + row * table.row_size, 0,
                child_key(table, side.tables[t], row).owner};
  while (row + pieces.count < side.tables[t].row_count &&
         child_key(table, side.tables[t], row + pieces.count).owner == pieces.owner)
    ++pieces.count;
  return pieces;
}

/// The first differing byte; nothing: all bytes are equal.
std::optional<std::uint64_t> first_difference(const Pieces& a, const Pieces& b) {
  const std::uint64_t a_size = a.size(), b_size = b.size();
  const std::uint64_t both = std::min(a_size, b_size);
  std::uint64_t offset = 0;
  for (std::size_t i = 0; i < std::min(a.count, b.count); ++i, offset += a.room())
    if (std::memcmp(a.piece(i), b.piece(i), a.room()) != 0) break;
  offset = std::min(offset, both);
  while (offset < both && a.at(offset) == b.at(offset)) ++offset;
  if (offset == both && a_size == b_size) return std::nullopt;
  return offset;
}

/// The number of characters before the one at the offset; nothing: an earlier byte is not valid UTF-8. Requires: the
/// earlier bytes are the same on both sides.
std::optional<std::uint64_t> character_at(const Pieces& pieces, std::uint64_t offset) {
  std::uint64_t count = 0, at = 0;
  const std::uint64_t size = pieces.size();
  while (at < offset) {
    const std::size_t bytes = utf8_size(pieces.part(at, std::min<std::uint64_t>(at + 4, size)));
    if (bytes == 0) return std::nullopt;
    if (at + bytes > offset) break;
    at += bytes;
    ++count;
  }
  return count;
}

/// Whether the byte is inside a character, after its first byte.
bool is_inner(std::uint8_t byte) {
  return (byte & 0xc0) == 0x80;
}

/// The bytes around the difference, without incomplete characters at both ends.
std::string window(const Pieces& pieces, std::uint64_t first, std::uint64_t offset, bool is_text) {
  const std::uint64_t size = pieces.size();
  std::uint64_t behind = std::min(size, offset + content_behind_max);
  if (is_text && behind < size)
    for (int i = 0; i < 3 && behind > offset && is_inner(pieces.at(behind)); ++i) --behind;
  return first < behind ? pieces.part(first, behind) : std::string();
}

/// All of it but the place. A state without pieces has an empty side. Requires: pieces of one state at least that has a
/// byte.
ContentDifference content_of(std::span<const Pieces> states, std::uint64_t offset, bool is_text) {
  ContentDifference content;
  content.is_text = is_text;
  content.offset = offset;
  const Pieces* longest = &states[0];
  for (const Pieces& pieces : states)
    if (pieces.size() >= longest->size()) longest = &pieces;
  if (is_text) content.character = character_at(*longest, offset);
  content.first = offset > content_before_max ? offset - content_before_max : 0;
  if (is_text && content.first > 0)
    for (int i = 0; i < 3 && content.first < offset && is_inner(longest->at(content.first)); ++i) ++content.first;
  for (const Pieces& pieces : states)
    content.sides.emplace_back(ContentSide{window(pieces, content.first, offset, is_text), pieces.size()});
  return content;
}

std::string name_in_parent(const StateSchema& schema, std::size_t t) {
  const std::string& name = schema.tables[t].name;
  const std::string begin = schema.tables[static_cast<std::size_t>(schema.tables[t].parent)].name + ".";
  return name.size() > begin.size() && name.compare(0, begin.size(), begin) == 0 ? name.substr(begin.size()) : name;
}

/// "units[3]" or "units[3].inventory[2]". `top`: set to the row at the top level.
std::string row_place(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t t, std::size_t row,
                      StatePlace& top, std::size_t depth) {
  const TableSchema& table = schema.tables[t];
  if (table.form == TableForm::plain || depth > nesting_max) {
    top.table = t;
    top.row = row;
    return table.name + "[" + std::to_string(row) + "]";
  }
  const ChildKey key = child_key(table, tables[t], row);
  const auto parent = static_cast<std::size_t>(table.parent);
  const std::optional<std::size_t> owner = find_owner(schema, tables, t, key.owner);
  const std::string begin =
      owner ? row_place(schema, tables, parent, *owner, top, depth + 1) : schema.tables[parent].name + "[?]";
  const std::string text = begin + "." + name_in_parent(schema, t);
  return has_pieces(table) ? text : text + "[" + std::to_string(key.index) + "]";
}

/// Place and owner of the pieces that begin at this row.
void set_place(const Side& side, std::size_t t, std::size_t row, ContentDifference& content) {
  content.table = side.schema.tables[t].name;
  content.place = row_place(side.schema, side.tables, t, row, content.top, 0);
  const TableSchema& table = side.schema.tables[content.top.table];
  if (table.form == TableForm::plain && table.key_column_count > 0 &&
      content.top.row < side.tables[content.top.table].row_count)
    content.id = lane_bits(table, side.tables[content.top.table].rows, {content.top.table, content.top.row, 0, 0});
}

/// The current position of one state in its pieces.
struct Walk {
  const Side& side;
  std::size_t t;
  std::size_t row = 0;
  Pieces pieces = {};
  std::optional<Path> path = std::nullopt;

  bool is_done() const { return row >= side.tables[t].row_count; }
  void read() {
    if (is_done()) return;
    pieces = pieces_at(side, t, row);
    path = owner_path(side, t, pieces.owner, 0);
  }
  void next() {
    row += pieces.count;
    read();
  }
};

/// The states whose next pieces belong to the same owner, the first one in order.
std::vector<bool> next_owner(std::span<const Walk> walks) {
  std::vector<bool> takes;
  const Path* first = nullptr;
  bool has_paths = true;
  for (const Walk& at : walks) {
    takes.push_back(!at.is_done());
    if (at.is_done()) continue;
    has_paths = has_paths && at.path;
    if (at.path && (first == nullptr || *at.path < *first)) first = &*at.path;
  }
  for (std::size_t i = 0; i < walks.size() && has_paths; ++i) takes[i] = takes[i] && *walks[i].path == *first;
  return takes;
}

/// The first byte that is not the same in all; nothing: all are the same.
std::optional<std::uint64_t> first_difference(std::span<const Pieces> states) {
  std::optional<std::uint64_t> first;
  for (std::size_t i = 1; i < states.size(); ++i)
    if (const auto offset = first_difference(states[0], states[i]); offset && (!first || *offset < *first))
      first = offset;
  return first;
}

void compare_table(const StateSchema& schema, std::span<const std::span<const ImageTable>> states, std::size_t t,
                   std::size_t count_max, ContentDifferences& found) {
  const TableSchema& table = schema.tables[t];
  std::vector<Side> sides;
  for (const std::span<const ImageTable> tables : states) sides.push_back({schema, tables});
  std::vector<Walk> walks;
  for (const Side& side : sides) walks.push_back({side, t});
  for (Walk& at : walks) at.read();
  std::vector<Pieces> pieces;
  for (;;) {
    const std::vector<bool> takes = next_owner(walks);
    const auto placing = static_cast<std::size_t>(std::find(takes.begin(), takes.end(), true) - takes.begin());
    if (placing == takes.size()) return;
    pieces.clear();
    for (std::size_t i = 0; i < walks.size(); ++i)
      pieces.push_back(takes[i] ? walks[i].pieces : Pieces{&table, nullptr, 0, 0});
    if (const auto offset = first_difference(pieces)) {
      if (found.list.size() < count_max) {
        ContentDifference content = content_of(pieces, *offset, table.form == TableForm::text);
        const Walk& from = walks[placing];
        set_place(from.side, t, from.row, content);
        content.placed_by = placing;
        for (std::size_t i = 0; i < walks.size(); ++i)
          if (!takes[i] && from.path && !has_row(sides[i], t, *from.path)) content.sides[i].reset();
        found.list.push_back(std::move(content));
      }
      ++found.count;
    }
    for (std::size_t i = 0; i < walks.size(); ++i)
      if (takes[i]) walks[i].next();
  }
}

}  // namespace

std::string child_place(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t table,
                        std::size_t row) {
  if (schema.tables[table].form == TableForm::plain) return "";
  StatePlace top;
  return row_place(schema, tables, table, row, top, 0);
}

std::vector<Content> contents_of(const StateSchema& schema, std::span<const ImageTable> tables, std::size_t table) {
  const Side side{schema, tables};
  std::vector<Content> contents;
  for (std::size_t row = 0; row < tables[table].row_count;) {
    const Pieces pieces = pieces_at(side, table, row);
    contents.push_back({child_place(schema, tables, table, row), pieces.part(0, pieces.size())});
    row += pieces.count;
  }
  return contents;
}

ContentDifferences find_content_differences(const StateSchema& schema,
                                            std::span<const std::span<const ImageTable>> states,
                                            std::size_t count_max) {
  ContentDifferences found;
  for (std::size_t t = 0; t < schema.tables.size(); ++t)
    if (has_pieces(schema.tables[t])) compare_table(schema, states, t, count_max, found);
  return found;
}

void locate_contents(const StateSchema& schema, std::span<const ImageTable> expected, std::span<const ImageTable> got,
                     const RowNamer& row_name, std::size_t count_max, Divergence& divergence) {
  const std::span<const ImageTable> states[] = {got, expected};  // places and names are those of the state here
  ContentDifferences found = find_content_differences(schema, states, count_max);
  divergence.contents.clear();
  divergence.content_count = found.count;
  for (ContentDifference& content : found.list) {
    ContentReport& report = divergence.contents.emplace_back();
    report.place = std::move(content.place);
    report.table = std::move(content.table);
    report.row = content.top.row;
    report.id = content.id;
    if (row_name && content.placed_by == 0) report.name = row_name(content.top.table, content.top.row);
    report.is_text = content.is_text;
    report.first = content.first;
    report.offset = content.offset;
    report.character = content.character;
    if (auto& side = content.sides[0]) report.got = std::move(side->bytes), report.got_size = side->size;
    if (auto& side = content.sides[1]) report.expected = std::move(side->bytes), report.expected_size = side->size;
  }
}

}  // namespace ticktrue::verifier
