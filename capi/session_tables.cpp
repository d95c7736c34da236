// What a program registers: columns, tables of structs, keys, references, row names, stages.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "base/limits.h"
#include "base/state/declared_members.h"
#include "capi/call_values.h"
#include "capi/session.h"

namespace ticktrue::capi {
static_assert(TICKTRUE_SHOWN == shown_type_flag);

int Session::column(const char* table, const char* name, const void* data, int type, std::uint32_t lanes,
                    std::uint32_t rows, std::size_t stride) {
  if (!can_call("column")) return status_;
  ColumnSource source;
  source.data = data;
  source.type = declared_type(type);
  source.lane_count = lanes;
  source.row_count = rows;
  source.stride = stride;
  source.is_shown = is_declared_shown(type);
  const Status status = state_.column(text_of(table), text_of(name), source);
  if (probe_ && status) tell_probe(table, name, source);
  return status ? TICKTRUE_OK : fail(status.error());
}

int Session::table(const char* name, std::size_t stride, const ticktrue_member* members, std::uint32_t member_count,
                   std::uint32_t& table_number) {
  if (!can_call("table") || refuse_in_callback("table")) return status_;
  if (const Status status = check_name("table", text_of(name)); !status) return fail(status.error());
  const std::string place = "table " + std::string(text_of(name)) + ": ";
  if (members == nullptr || member_count == 0)
    return fail(usage(place + "members: found " + (members == nullptr ? "null" : "0") + ", expected 1.." +
                          number(limits::column_count_max),
                      "each member of the struct that is compared is one of them"));
  const Result<std::vector<RowMember>> row = read_members(place, members, member_count);
  if (!row) return fail(row.error());
  const Result<std::size_t> made = state_.table(text_of(name), stride, *row);
  if (!made) return fail(made.error());
  table_number = static_cast<std::uint32_t>(*made);
  return TICKTRUE_OK;
}

int Session::rows(std::uint32_t table, const void* base, std::uint32_t rows) {
  if (!can_call("rows")) return status_;
  const Status status = state_.rows(table, base, rows);
  if (probe_ && status && table < state_.schema().tables.size()) {
    ColumnSource source;
    source.data = base;
    source.row_count = rows;
    tell_probe(state_.schema().tables[table].name.c_str(), "", source);
  }
  return status ? TICKTRUE_OK : fail(status.error());
}

int Session::child(const char* name, const char* parent, const ChildSource& source, const ticktrue_member* members,
                   std::uint32_t member_count) {
  if (!can_call("child") || refuse_in_callback("child")) return status_;
  if (const Status status = check_name("table", text_of(name)); !status) return fail(status.error());
  const Result<std::vector<RowMember>> row =
      read_members("table " + std::string(text_of(name)) + ": ", members, member_count);
  if (!row) return fail(row.error());
  const Status status = state_.child(text_of(name), text_of(parent), source, *row);
  return status ? TICKTRUE_OK : fail(status.error());
}

int Session::key(const char* table, std::uint32_t columns) {
  if (!can_call("key") || refuse_in_callback("key")) return status_;
  const Status status = state_.key(text_of(table), columns);
  return status ? TICKTRUE_OK : fail(status.error());
}

int Session::reference(const char* table, const char* column, const char* target) {
  if (!can_call("reference") || refuse_in_callback("reference")) return status_;
  const Status status = state_.reference(text_of(table), text_of(column), text_of(target));
  return status ? TICKTRUE_OK : fail(status.error());
}

int Session::row_names(const char* table, ticktrue_namer call, void* user) {
  if (!can_call("row_names") || refuse_in_callback("row_names")) return status_;
  if (!state_.find_table(text_of(table)))
    return fail(usage("row_names: table " + std::string(text_of(table)) + ": found none of this name",
                      "register its columns first"));
  namers_[std::string(text_of(table))] = {call, user};
  return TICKTRUE_OK;
}

int Session::add_stage(const char* name) {
  if (!can_call("add_stage") || refuse_in_callback("add_stage")) return status_;
  if (phase_ != Phase::registering)
    return wrong_order("add_stage: found a new stage after the first tick", "add every stage before the first tick");
  const std::string text(text_of(name));
  if (const Status status = check_name("stage", text); !status) return fail(status.error());
  if (std::find(stages_.begin(), stages_.end(), text) != stages_.end())
    return fail(usage("stage " + text + ": stands twice"));
  if (stages_.size() >= limits::stage_count_max)
    return fail(usage("stages: found more than " + number(limits::stage_count_max)));
  stages_.push_back(text);
  return TICKTRUE_OK;
}

}  // namespace ticktrue::capi
