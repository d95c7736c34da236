// Compares failures, and parses their places.
// SPDX-License-Identifier: MIT
#include "tool/experiment/reduce/failure.h"

#include <cstring>

namespace ticktrue::reduce {
namespace {

/// The text between `before` and the first character of `ends`. Empty if `before` is not in the message.
std::string_view text_between(std::string_view message, std::string_view before, std::string_view ends) {
  const std::size_t at = message.find(before);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = message.substr(at + before.size());
  return rest.substr(0, rest.find_first_of(ends));
}

}  // namespace

bool is_same(const Failure& a, const Failure& b, bool is_loose) {
  return a.kind == b.kind && (is_loose || (a.stage == b.stage && a.table == b.table && a.column == b.column));
}

std::string place_text(const Failure& failure) {
  const std::string place = failure.table + (failure.column.empty() ? "" : "." + failure.column);
  return failure.stage + (failure.stage.empty() || place.empty() ? "" : ", ") + place;
}

std::vector<std::uint32_t> bodies_of_row(const StateView& state, std::size_t table, std::size_t row) {
  std::vector<std::uint32_t> bodies;
  const TableSchema& schema = state.schema->tables[table];
  if (row >= state.tables[table].row_count) return bodies;
  for (const Column& column : schema.columns) {
    const bool is_body = column.name == "body_a" || column.name == "body_b" || column.name == "body" ||
                         (schema.name == "bodies" && column.name == "id");
    if (!is_body || column.type != ScalarType::u32) continue;
    std::uint32_t id = 0;
    std::memcpy(&id, state.tables[table].data + row * schema.row_size + column.offset, sizeof id);
    bodies.push_back(id);
  }
  return bodies;
}

void read_place(std::string_view message, Failure& failure) {
  failure.stage = text_between(message, "stage ", ":,");
  failure.table = text_between(message, "table ", ":,");
  failure.column = text_between(message, "column ", ":,");
  if (!failure.table.empty() || failure.stage.empty()) return;
  const std::string_view place = text_between(message, "stage " + failure.stage + ": ", " ");
  const std::size_t dot = place.find('.');
  if (dot == std::string_view::npos) return;
  failure.table = place.substr(0, dot);
  failure.column = place.substr(dot + 1);
}

}  // namespace ticktrue::reduce
