// Gathering and scattering of columns, and the checks of what was registered.
// SPDX-License-Identifier: MIT
#include "base/state/gathered_state.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "base/limits.h"
#include "base/state/declared_members.h"

namespace ticktrue {
namespace {

Error refused(const std::string& message, const std::string& hint = "") {
  return {ErrorCode::usage, message, hint};
}

std::string column_place(const TableSchema& table, const Column& column) {
  return "table " + table.name + ": column " + column.name;
}

std::size_t values_size(ScalarType type, std::uint32_t lane_count) {
  return static_cast<std::size_t>(scalar_info(type)->size) * lane_count;
}

std::size_t source_stride(const ColumnSource& source) {
  return source.stride != 0 ? source.stride : values_size(source.type, source.lane_count);
}

template <std::size_t size>
void copy_fixed(const std::uint8_t* from, std::size_t from_stride, std::uint8_t* to, std::size_t to_stride,
                std::size_t count) {
  for (std::size_t row = 0; row < count; ++row, from += from_stride, to += to_stride) std::memcpy(to, from, size);
}

/// `count` pieces of `size` bytes. Small sizes as single moves: a call of memcpy per value costs more than the value.
void copy_strided(const std::uint8_t* from, std::size_t from_stride, std::uint8_t* to, std::size_t to_stride,
                  std::size_t size, std::size_t count) {
  if (size == from_stride && size == to_stride) {
    if (count > 0) std::memcpy(to, from, size * count);
    return;
  }
  if (size == 4) return copy_fixed<4>(from, from_stride, to, to_stride, count);
  if (size == 8) return copy_fixed<8>(from, from_stride, to, to_stride, count);
  if (size == 16) return copy_fixed<16>(from, from_stride, to, to_stride, count);
  for (std::size_t row = 0; row < count; ++row, from += from_stride, to += to_stride) std::memcpy(to, from, size);
}

/// Requires: `size` is 1, 2, 4 or 8.
std::uint64_t key_value(const std::uint8_t* bytes, std::size_t size) {
  std::uint8_t u8 = 0;
  std::uint16_t u16 = 0;
  std::uint32_t u32 = 0;
  std::uint64_t u64 = 0;
  switch (size) {
    case 1:
      std::memcpy(&u8, bytes, 1);
      return u8;
    case 2:
      std::memcpy(&u16, bytes, 2);
      return u16;
    case 4:
      std::memcpy(&u32, bytes, 4);
      return u32;
    default:
      std::memcpy(&u64, bytes, 8);
      return u64;
  }
}

}  // namespace

Status check_name(const std::string& what, std::string_view name) {
  if (name.empty() || name.size() > limits::name_size_max)
    return refused(what + ": name: found " + std::to_string(name.size()) + " bytes, expected 1.." +
                   std::to_string(limits::name_size_max));
  for (const char c : name)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      return refused(what + ": name: found a control character, expected printable text");
  return {};
}

Result<RowMember> read_member(const std::string& place, const DeclaredMember& declared) {
  RowMember member{declared.name, declared_type(declared.type), declared.lane_count, declared.offset,
                   is_declared_shown(declared.type)};
  if (const Status status = check_name(place + "column", member.name); !status) return status.error();
  const ScalarInfo* scalar = scalar_info(member.type);
  if (scalar == nullptr || declared.size == 0) return member;
  if (declared.lane_count == 0 && declared.size % scalar->size == 0)
    member.lane_count = static_cast<std::uint32_t>(
        std::min<std::size_t>(declared.size / scalar->size, std::numeric_limits<std::uint32_t>::max()));
  else if (declared.lane_count == 0 || declared.size != std::size_t{scalar->size} * declared.lane_count)
    return refused(place + "column " + std::string(member.name) + ": bytes in the struct: found " +
                       std::to_string(declared.size) + ", expected " +
                       (declared.lane_count == 0 ? "a multiple of " + std::to_string(scalar->size)
                                                 : std::to_string(std::size_t{scalar->size} * declared.lane_count)) +
                       " (" + std::string(scalar->name) + ")",
                   "the type is that of the member: TICKTRUE_U8 for one byte, TICKTRUE_F64 for double");
  return member;
}

namespace {

std::string place_of(std::string_view table, std::string_view column) {
  return "table " + std::string(table) + ": column " + std::string(column);
}

Status check_row_count(const std::string& place, const void* data, std::uint32_t row_count) {
  if (row_count > limits::row_count_max)
    return Error{ErrorCode::limit,
                 place + ": rows: found " + std::to_string(row_count) + ", expected at most " +
                     std::to_string(limits::row_count_max),
                 ""};
  if (data == nullptr && row_count > 0)
    return refused(place + ": pointer: found null, expected the first of " + std::to_string(row_count) + " rows",
                   "a table that is empty now has 0 rows");
  return {};
}

Status check_type(std::string_view table, std::string_view name, ScalarType type, std::uint32_t lane_count) {
  // The C interface has neither i8 nor i16.
  if (scalar_info(type) == nullptr || type > ScalarType::f64)
    return refused(place_of(table, name) + ": type: found " + std::to_string(static_cast<unsigned>(type)) +
                   ", expected one of 1..8 (u8 to f64)");
  if (lane_count == 0 || lane_count > std::numeric_limits<std::uint8_t>::max())
    return refused(place_of(table, name) + ": lanes: found " + std::to_string(lane_count) + ", expected 1..255",
                   "one value a row is one lane; longer arrays are rows of a table of their own");
  return {};
}

/// Requires: check_type.
Status check_source(std::string_view table, std::string_view name, const ColumnSource& source) {
  if (source.row_count > limits::row_count_max || (source.data == nullptr && source.row_count > 0))
    return check_row_count(place_of(table, name), source.data, source.row_count);
  const std::size_t size = values_size(source.type, source.lane_count);
  // One row may say anything: there is no second one.
  if (source.stride != 0 && source.stride < size && source.row_count > 1)
    return refused(place_of(table, name) + ": stride: found " + std::to_string(source.stride) +
                       " bytes, expected at least " + std::to_string(size) + " (" + std::to_string(source.lane_count) +
                       " lanes of " + std::string(scalar_info(source.type)->name) + ")",
                   "the stride is the distance from one row's value to the next row's: often the size of the struct");
  return {};
}

/// Names, types and places of members.
Status check_members(std::string_view name, std::size_t stride, std::span<const RowMember> members) {
  const std::string place = "table " + std::string(name);
  for (const RowMember& member : members) {
    if (const Status status = check_name(place + ": column", member.name); !status) return status;
    if (const Status status = check_type(name, member.name, member.type, member.lane_count); !status) return status;
    const std::size_t size = values_size(member.type, member.lane_count);
    if (stride < size || member.offset > stride - size)
      return refused(place_of(name, member.name) + ": offset: found " + std::to_string(member.offset) + " with " +
                         std::to_string(size) + " bytes, expected both inside the " + std::to_string(stride) +
                         " bytes of a row",
                     "the stride is the size of the struct, the offset is offsetof(struct, member)");
  }
  NameIndex names;
  for (std::size_t c = 0; c < members.size(); ++c) {
    if (const std::optional<std::size_t> before = names.find(members[c].name))
      return refused(place_of(name, members[c].name) + ": stands twice: as member " + std::to_string(*before) +
                     " and as member " + std::to_string(c) + ", counted from 0");
    names.add(members[c].name, c);
  }
  return {};
}

}  // namespace

namespace {

/// `first`: the column that has row_count rows.
Status check_row_counts(const TableSchema& table, const std::vector<ColumnSource>& sources, const Column& first,
                        std::uint32_t row_count) {
  for (std::size_t c = 0; c < sources.size(); ++c)
    if (sources[c].row_count != row_count)
      return refused("table " + table.name + ": rows: column " + table.columns[c].name + " has " +
                         std::to_string(sources[c].row_count) + ", column " + first.name + " has " +
                         std::to_string(row_count),
                     "all columns of a table have the same number of rows: register all of them again when it changes");
  return {};
}

void pack_rows(const TableSchema& table, const std::vector<ColumnSource>& sources, std::uint32_t row_count,
               std::uint8_t* rows) {
  if (row_count == 0) return;
  for (std::size_t c = 0; c < sources.size();) {
    // Neighbours in memory that are neighbours in the row are copied together.
    const auto* from = static_cast<const std::uint8_t*>(sources[c].data);
    const std::size_t stride = source_stride(sources[c]);
    const std::size_t offset = table.columns[c].offset;
    std::size_t size = 0;
    do {
      size += values_size(sources[c].type, sources[c].lane_count);
      ++c;
    } while (c < sources.size() && static_cast<const std::uint8_t*>(sources[c].data) == from + size &&
             source_stride(sources[c]) == stride &&
             size + values_size(sources[c].type, sources[c].lane_count) <= stride);
    copy_strided(from, stride, rows + offset, table.row_size, size, row_count);
  }
}

}  // namespace

Status GatheredState::column(std::string_view table_name, std::string_view name, const ColumnSource& source) {
  std::optional<std::size_t> t = table_names_.find(table_name);
  std::optional<std::size_t> c;
  if (t) c = sources_[*t].names.find(name);
  if (!c) {
    if (const Status status = check_name("table", table_name); !status) return status;
    if (const Status status = check_name("table " + std::string(table_name) + ": column", name); !status) return status;
  }
  if (const Status status = check_type(table_name, name, source.type, source.lane_count); !status) return status;
  if (const Status status = check_source(table_name, name, source); !status) return status;
  if (t && sources_[*t].child)
    return refused(place_of(table_name, name) + ": found a child table, whose columns are registered with it");
  if (t && !sources_[*t].members.empty())
    return refused(place_of(table_name, name) + ": found a table whose columns are members of a struct",
                   "ticktrue_rows says where its rows lie; columns of their own make a table of another name");
  if (c) {
    const bool was_shown = *c >= shown_place;
    TableSource& known = sources_[*t];
    const Column& column = was_shown ? known.shown_columns[*c - shown_place] : schema_.tables[*t].columns[*c];
    if (column.type != source.type || column.lane_count != source.lane_count || was_shown != source.is_shown)
      return refused(place_of(table_name, name) + ": found another type or lane count than before, expected the same",
                     "a column that is registered again says where its values lie now, nothing else");
    (was_shown ? known.shown[*c - shown_place] : known.columns[*c]) = source;
    return {};
  }
  if (frozen_)
    return refused(place_of(table_name, name) + ": found a new column after the first tick, expected one that is known",
                   "register every table and column before the first tick; a table may have 0 rows then");
  if (!t) {
    if (const Status status = add_table(table_name); !status) return status;
    t = schema_.tables.size() - 1;
  }
  return add_column(*t, name, source);
}

/// Requires: a name that is checked and not known.
Status GatheredState::add_table(std::string_view name) {
  if (schema_.tables.size() >= limits::registered_table_count_max)
    return Error{ErrorCode::limit,
                 "table " + std::string(name) + ": tables: expected at most " +
                     std::to_string(limits::registered_table_count_max),
                 ""};
  table_names_.add(name, schema_.tables.size());
  schema_.tables.emplace_back();
  schema_.tables.back().name = std::string(name);
  sources_.emplace_back();
  return {};
}

/// Requires: a name that is checked and not known in this table; check_type.
Status GatheredState::add_column(std::size_t t, std::string_view name, const ColumnSource& source) {
  TableSchema& table = schema_.tables[t];
  TableSource& known = sources_[t];
  const std::uint32_t before = source.is_shown ? known.shown_row_size : table.row_size;
  const std::size_t row_size = before + values_size(source.type, source.lane_count);
  if (table.columns.size() + known.shown.size() >= limits::column_count_max || row_size > limits::row_size_max)
    return Error{ErrorCode::limit,
                 place_of(table.name, name) + ": the row grows beyond " + std::to_string(limits::column_count_max) +
                     " columns or " + std::to_string(limits::row_size_max) + " bytes",
                 "make several tables of it"};
  if (column_count_ >= limits::registered_column_count_max)
    return Error{ErrorCode::limit,
                 place_of(table.name, name) + ": columns of all tables: expected at most " +
                     std::to_string(limits::registered_column_count_max),
                 ""};
  ++column_count_;
  Column column;
  column.name = std::string(name);
  column.type = source.type;
  column.lane_count = static_cast<std::uint8_t>(source.lane_count);
  column.offset = static_cast<std::uint16_t>(before);
  column.is_shown = source.is_shown;
  if (source.is_shown) {
    known.shown_row_size = static_cast<std::uint32_t>(row_size);
    known.names.add(name, shown_place + known.shown.size());
    known.shown.push_back(source);
    known.shown_columns.push_back(std::move(column));
    return {};
  }
  table.row_size = static_cast<std::uint32_t>(row_size);
  known.names.add(name, table.columns.size());
  known.columns.push_back(source);
  table.columns.push_back(std::move(column));
  return {};
}

bool GatheredState::has_members(std::size_t t, std::size_t stride, std::span<const RowMember> members) const {
  const TableSource& source = sources_[t];
  if (source.members.size() != members.size() || source.stride != stride) return false;
  for (std::size_t m = 0; m < members.size(); ++m) {
    const RowMember& known = source.members[m].member;
    if (source.members[m].name != members[m].name || known.type != members[m].type ||
        known.lane_count != members[m].lane_count || known.offset != members[m].offset ||
        known.is_shown != members[m].is_shown)
      return false;
  }
  return true;
}

Result<std::size_t> GatheredState::table(std::string_view name, std::size_t stride,
                                         std::span<const RowMember> members) {
  const std::string place = "table " + std::string(name);
  if (const Status status = check_name("table", name); !status) return status.error();
  if (members.empty() || members.size() > limits::column_count_max)
    return refused(place + ": members: found " + std::to_string(members.size()) + ", expected 1.." +
                   std::to_string(limits::column_count_max));
  if (const Status status = check_members(name, stride, members); !status) return status.error();
  if (const std::optional<std::size_t> t = table_names_.find(name)) {
    if (has_members(*t, stride, members)) return *t;
    return refused(place + ": found other members than before, expected the same",
                   "a table is registered once; ticktrue_rows says where its rows lie now");
  }
  if (frozen_)
    return refused(place + ": found a new table after the first tick, expected one that is known",
                   "register every table before the first tick; a table may have 0 rows then");
  if (const Status status = add_table(name); !status) return status.error();
  const std::size_t t = schema_.tables.size() - 1;
  for (const RowMember& member : members) {
    ColumnSource source;
    source.type = member.type;
    source.lane_count = member.lane_count;
    source.stride = stride;
    source.is_shown = member.is_shown;
    if (const Status status = add_column(t, member.name, source); !status) return status.error();
    sources_[t].members.push_back({std::string(member.name), member});
    sources_[t].members.back().member.name = {};
  }
  sources_[t].stride = stride;
  return t;
}

Status GatheredState::child(std::string_view name, std::string_view parent, const ChildSource& source,
                            std::span<const RowMember> members) {
  TICKTRUE_ASSERT(source.form != TableForm::plain);
  const std::string place = "table " + std::string(name);
  if (const Status status = check_name("table", name); !status) return status;
  const auto p = find_table(parent);
  if (!p)
    return refused(place + ": parent: found no table " + std::string(parent),
                   "register the parent before its children");
  if (has_pieces(schema_.tables[*p]))
    return refused(place + ": parent: found the pieces of " + std::string(parent) + ", expected a table of rows");
  if (source.read == nullptr)
    return refused(place + ": elements: found null, expected a callback that gives the elements of a row");
  if (const Status status = check_members(name, source.stride, members); !status) return status;
  for (const RowMember& member : members)
    if (member.is_shown)
      return refused(place_of(name, member.name) + ": found a shown column in a child table, expected a judged one");
  if (const std::optional<std::size_t> t = table_names_.find(name)) {
    TableSource& known = sources_[*t];
    if (!known.child || known.child->source.form != source.form ||
        schema_.tables[*t].parent != static_cast<std::int16_t>(*p) || !has_members(*t, source.stride, members))
      return refused(place + ": found another parent, form or members than before, expected the same",
                     "a child is registered once; a call again says which callback gives its elements");
    known.child->source = source;
    return {};
  }
  if (frozen_)
    return refused(place + ": found a new table after the first tick, expected one that is known",
                   "register every table before the first tick; a list may be empty then");
  if (const Status status = add_table(name); !status) return status;
  const std::size_t t = schema_.tables.size() - 1;
  schema_.tables[t].form = source.form;
  schema_.tables[t].parent = static_cast<std::int16_t>(*p);
  sources_[t].child.emplace().source = source;
  sources_[t].stride = source.stride;
  sources_[*p].is_parent = has_children_ = true;
  return add_child_columns(t, members);
}

/// The columns of the form, and those of an element.
Status GatheredState::add_child_columns(std::size_t t, std::span<const RowMember> members) {
  ColumnSource source;
  source.type = ScalarType::u32;
  const auto add = [&](std::string_view name, std::uint32_t lane_count) {
    source.lane_count = lane_count;
    return add_column(t, name, source);
  };
  if (const Status status = add("owner", 1); !status) return status;
  if (const Status status = add("index", 1); !status) return status;
  schema_.tables[t].key_column_count = 2;
  if (has_pieces(schema_.tables[t])) {
    if (const Status status = add("size", 1); !status) return status;
    return add("bytes", schema_.tables[t].form == TableForm::text ? text_lane_count : bytes_lane_count);
  }
  std::vector<ElementPart>& parts = sources_[t].child->parts;
  for (const RowMember& member : members) {
    if (sources_[t].names.find(member.name))
      return refused(place_of(schema_.tables[t].name, member.name) + ": found a name that every child table has",
                     "owner and index are its key: give the member another name");
    source.type = member.type;
    if (const Status status = add(member.name, member.lane_count); !status) return status;
    const std::size_t size = values_size(member.type, member.lane_count);
    const std::size_t to = schema_.tables[t].row_size - size;
    // Neighbours in the element that are neighbours in the row are copied together.
    if (!parts.empty() && parts.back().from + parts.back().size == member.offset)
      parts.back().size += size;
    else
      parts.push_back({member.offset, to, size});
    sources_[t].members.push_back({std::string(member.name), member});
    sources_[t].members.back().member.name = {};
  }
  return {};
}

Status GatheredState::rows(std::size_t t, const void* first, std::uint32_t row_count, void* writable) {
  if (t >= sources_.size() || sources_[t].members.empty() || sources_[t].child)
    return refused("rows: table " + std::to_string(t) + ": found " +
                       (t >= sources_.size() ? "no such number"
                        : sources_[t].child  ? "a child, whose elements a callback gives"
                                             : "columns that were registered one by one") +
                       ", expected a number that ticktrue_table gave",
                   "columns of ticktrue_column are registered again when they have moved");
  if (const Status status = check_row_count("table " + schema_.tables[t].name, first, row_count); !status)
    return status;
  const auto* bytes = static_cast<const std::uint8_t*>(first);
  TableSource& source = sources_[t];
  source.base = bytes;
  std::size_t judged = 0, shown = 0;
  for (const Member& member : source.members) {
    ColumnSource& column = member.member.is_shown ? source.shown[shown++] : source.columns[judged++];
    column.data = row_count == 0 ? nullptr : bytes + member.member.offset;
    const bool can_write = writable != nullptr && row_count > 0;
    column.writable = can_write ? static_cast<std::uint8_t*>(writable) + member.member.offset : nullptr;
    column.row_count = row_count;
  }
  return {};
}

Status GatheredState::key(std::string_view table_name, std::uint32_t column_count) {
  const auto t = find_table(table_name);
  if (!t) return refused("key: table " + std::string(table_name) + ": found none of this name", "register its columns");
  TableSchema& table = schema_.tables[*t];
  if (sources_[*t].child)
    return refused("key: table " + table.name + ": found a child table, whose key is owner and index");
  if (frozen_ && table.key_column_count == column_count) return {};
  if (frozen_) return refused("table " + table.name + ": key: found a change after the first tick");
  if (column_count == 0 || column_count > table.columns.size())
    return refused("table " + table.name + ": key columns: found " + std::to_string(column_count) + ", expected 1.." +
                   std::to_string(table.columns.size()) + " (those registered so far)");
  table.key_column_count = static_cast<std::uint8_t>(column_count);
  return {};
}

Status GatheredState::reference(std::string_view table_name, std::string_view column_name, std::string_view target) {
  const auto t = find_table(table_name);
  const auto other = find_table(target);
  if (!t || !other)
    return refused("reference: table " + std::string(t ? target : table_name) + ": found none of this name",
                   "register the columns of both tables first");
  const auto c = sources_[*t].names.find(column_name);
  if (!c)
    return refused("reference: table " + schema_.tables[*t].name + ": column " + std::string(column_name) +
                   ": found none of this name");
  if (*c >= shown_place)
    return refused("reference: " + place_of(table_name, column_name) + ": found a shown column, expected a judged one");
  const bool is_of_form = has_pieces(schema_.tables[*t]) || *c < schema_.tables[*t].key_column_count;
  if (sources_[*t].child && is_of_form)
    return refused("reference: " + place_of(table_name, column_name) +
                   ": found a column that every child table has, expected one of its elements");
  Column& column = schema_.tables[*t].columns[*c];
  if (frozen_ && column.target == static_cast<std::int16_t>(*other)) return {};
  if (frozen_)
    return refused(column_place(schema_.tables[*t], column) + ": target: found a change after the first tick");
  column.target = static_cast<std::int16_t>(*other);
  column.optional = true;
  return {};
}

Status GatheredState::freeze() {
  if (schema_.tables.empty())
    return refused("state: found no column, expected at least one",
                   "register everything that can influence a later tick, before the first tick");
  for (std::size_t t = 0; t < schema_.tables.size(); ++t)
    if (schema_.tables[t].columns.empty())
      return refused("table " + schema_.tables[t].name + ": found shown columns alone, expected a judged one",
                     "an id or an index, whose number of rows is judged");
  for (TableSchema& table : schema_.tables) {
    if (table.form == TableForm::plain) continue;
    const TableSchema& parent = schema_.tables[static_cast<std::size_t>(table.parent)];
    const bool has_ids = parent.key_column_count == 1 && parent.columns[0].type == ScalarType::u32;
    table.columns[0].target = has_ids ? table.parent : std::int16_t{-1};
  }
  make_whole_schema();
  if (const Status status = check_schema(whole_, SchemaLayout::third); !status)
    return Error{ErrorCode::usage, status.error().message, status.error().hint};
  rows_.resize(schema_.tables.size());
  view_.schema = &schema_;
  view_.tables.resize(schema_.tables.size());
  frozen_ = true;
  return {};
}

void GatheredState::make_whole_schema() {
  whole_ = schema_;
  shown_schema_.tables.clear();
  shown_tables_.clear();
  for (std::size_t t = 0; t < sources_.size(); ++t) {
    const TableSource& source = sources_[t];
    if (source.shown.empty()) continue;
    TableSchema& table = whole_.tables[t];
    table.columns.insert(table.columns.end(), source.shown_columns.begin(), source.shown_columns.end());
    table.shown_row_size = source.shown_row_size;
    TableSchema& part = shown_schema_.tables.emplace_back();
    part.name = table.name;
    part.columns = source.shown_columns;
    part.row_size = source.shown_row_size;
    shown_tables_.push_back(static_cast<std::uint32_t>(t));
  }
  shown_rows_.resize(shown_tables_.size());
}

Result<std::vector<ShownRows>> GatheredState::gather_shown() {
  TICKTRUE_ASSERT(frozen_);
  StateView view;
  view.schema = &shown_schema_;
  std::uint64_t size = 0;
  for (std::size_t i = 0; i < shown_tables_.size(); ++i) {
    const TableSource& source = sources_[shown_tables_[i]];
    const std::uint32_t row_count = source.columns.front().row_count;
    const TableSchema& table = shown_schema_.tables[i];
    const Column& first = schema_.tables[shown_tables_[i]].columns[0];
    if (const Status status = check_row_counts(table, source.shown, first, row_count); !status) return status.error();
    size += static_cast<std::uint64_t>(row_count) * table.row_size;
    if (size > limits::shown_size_max)
      return Error{
          ErrorCode::limit,
          "table " + table.name + ": shown columns: grow beyond " + std::to_string(limits::shown_size_max) + " bytes",
          ""};
    shown_rows_[i].resize(static_cast<std::size_t>(row_count) * table.row_size);
    pack_rows(table, source.shown, row_count, shown_rows_[i].data());
    view.tables.push_back({shown_rows_[i].data(), row_count});
  }
  const std::vector<ImageTable> canonical = canonical_tables(view, shown_canonical_);
  std::vector<ShownRows> rows;
  for (std::size_t i = 0; i < canonical.size(); ++i)
    if (canonical[i].row_count > 0) rows.push_back({shown_tables_[i], canonical[i]});
  return rows;
}

Status GatheredState::check_keys(std::size_t t) const {
  const TableSchema& table = schema_.tables[t];
  struct Key {
    std::size_t offset;
    std::size_t size;
  };
  std::array<Key, std::numeric_limits<std::uint8_t>::max()> keys;  // key_column_count is a std::uint8_t
  for (std::size_t c = 0; c < table.key_column_count; ++c)
    keys[c] = {table.columns[c].offset, scalar_info(table.columns[c].type)->size};
  const std::uint8_t* row = rows_[t].data();
  for (std::uint32_t r = 1; r < view_.tables[t].row_count; ++r, row += table.row_size) {
    for (std::size_t c = 0; c < table.key_column_count; ++c) {
      const std::uint64_t before = key_value(row + keys[c].offset, keys[c].size);
      const std::uint64_t here = key_value(row + table.row_size + keys[c].offset, keys[c].size);
      if (before < here) break;
      if (before == here && c + 1 < table.key_column_count) continue;
      return refused(column_place(table, table.columns[c]) + ", row " + std::to_string(r) +
                         ": keys must ascend: found " + std::to_string(here) + " after " + std::to_string(before),
                     "sort the rows by key, or register the table without a key: rows then compare by position");
    }
  }
  return {};
}

Status GatheredState::gather_table(std::size_t t) {
  const TableSchema& table = schema_.tables[t];
  const std::vector<ColumnSource>& sources = sources_[t].columns;
  const std::uint32_t row_count = sources.front().row_count;
  rows_[t].resize(static_cast<std::size_t>(row_count) * table.row_size);
  view_.tables[t] = {rows_[t].data(), row_count};
  if (row_count == 0) return {};
  pack_rows(table, sources, row_count, rows_[t].data());
  return check_keys(t);
}

Status GatheredState::gather_child(std::size_t t, std::uint64_t image_size_max) {
  const TableSchema& table = schema_.tables[t];
  const auto p = static_cast<std::size_t>(table.parent);
  Child& child = *sources_[t].child;
  child.rows.clear();
  child.elements.clear();
  view_.tables[t] = {};
  const TableRows owners = view_.tables[p];
  // A reader may say that rows lie elsewhere: that holds from the next call on.
  const std::uint8_t* const base = sources_[p].base;
  const bool is_grandchild = sources_[p].child.has_value();
  const bool by_id = table.columns[0].target >= 0;
  for (std::uint32_t row = 0; row < owners.row_count; ++row) {
    const std::uint8_t* owner_at = nullptr;
    if (is_grandchild)
      owner_at = sources_[p].child->elements[row];
    else if (base != nullptr)
      owner_at = base + row * sources_[p].stride;
    ElementList list;
    list.first = static_cast<const std::uint8_t*>(child.source.read(child.source.user, owner_at, row, &list.count));
    if (list.count == 0) continue;
    list.stride = child.source.stride;
    std::uint32_t owner = row;
    if (by_id) std::memcpy(&owner, owners.data + std::size_t{row} * schema_.tables[p].row_size, sizeof owner);
    if (list.first == nullptr)
      return refused("table " + table.name + ": owner " + std::to_string(owner) +
                         ": found null, expected the first of " + std::to_string(list.count) +
                         (has_pieces(table) ? " bytes" : " elements"),
                     "an empty list has the count 0");
    const Status status = has_pieces(table) ? child.rows.add_pieces(table, owner, list, image_size_max)
                                            : child.rows.add_elements(table, owner, list, child.parts, image_size_max);
    if (!status) return status;
    if (sources_[t].is_parent)
      for (std::size_t i = 0; i < list.count; ++i) child.elements.push_back(list.first + i * list.stride);
  }
  view_.tables[t] = child.rows.rows();
  return {};
}

Status GatheredState::gather() {
  TICKTRUE_ASSERT(frozen_);
  std::uint64_t image_size = 0;
  for (std::size_t t = 0; t < schema_.tables.size(); ++t) {
    const TableSchema& table = schema_.tables[t];
    if (sources_[t].child) {
      if (const Status status = gather_child(t, limits::state_image_size_max - image_size); !status) return status;
      image_size += static_cast<std::uint64_t>(view_.tables[t].row_count) * table.row_size;
      continue;
    }
    const std::vector<ColumnSource>& sources = sources_[t].columns;
    const std::uint32_t row_count = sources.front().row_count;
    if (const Status status = check_row_counts(table, sources, table.columns[0], row_count); !status) return status;
    image_size += static_cast<std::uint64_t>(row_count) * table.row_size;
    if (image_size > limits::state_image_size_max)
      return Error{
          ErrorCode::limit,
          "table " + table.name + ": state: grows beyond " + std::to_string(limits::state_image_size_max) + " bytes",
          ""};
    if (const Status status = gather_table(t); !status) return status;
  }
  return {};
}

void GatheredState::scatter(std::size_t t, const ImageTable& rows) {
  const TableSchema& table = schema_.tables[t];
  TICKTRUE_ASSERT(frozen_ && rows.row_count == row_count(t));
  Bytes packed(rows.rows.size());
  decode_rows(table, rows, packed.data());
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const ColumnSource& source = sources_[t].columns[c];
    auto* to = static_cast<std::uint8_t*>(source.writable);
    if (rows.row_count == 0) continue;
    TICKTRUE_ASSERT(to != nullptr);
    copy_strided(packed.data() + table.columns[c].offset, table.row_size, to, source_stride(source),
                 values_size(source.type, source.lane_count), rows.row_count);
  }
}

}  // namespace ticktrue
