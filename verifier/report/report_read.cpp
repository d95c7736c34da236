// Reads values with their types. A field that a report of another version lacks keeps its default.
// SPDX-License-Identifier: MIT
#include "verifier/report/report_read.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "verifier/report/content_text.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::verifier {
namespace {

using nlohmann::json;

constexpr std::size_t list_size_max = 4096;
constexpr std::size_t content_text_max = 4096;  // bytes

const json* member(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

void take(const json& object, const char* key, std::string& value) {
  if (const json* found = member(object, key); found != nullptr && found->is_string())
    value = found->get<std::string>();
}
void take(const json& object, const char* key, std::uint64_t& value) {
  if (const json* found = member(object, key); found != nullptr && found->is_number_unsigned())
    value = found->get<std::uint64_t>();
}
void take(const json& object, const char* key, std::optional<std::uint64_t>& value) {
  if (const json* found = member(object, key); found != nullptr && found->is_number_unsigned())
    value = found->get<std::uint64_t>();
}
void take(const json& object, const char* key, double& value) {
  if (const json* found = member(object, key); found != nullptr && found->is_number()) value = found->get<double>();
}

/// Calls `use` with each element of the list, up to a limit.
template <typename Use>
void each(const json& object, const char* key, const Use& use) {
  const json* found = member(object, key);
  if (found == nullptr || !found->is_array()) return;
  for (std::size_t i = 0; i < std::min(found->size(), list_size_max); ++i) use((*found)[i]);
}

std::vector<std::string> texts(const json& object, const char* key) {
  std::vector<std::string> list;
  each(object, key, [&](const json& text) {
    if (text.is_string()) list.push_back(text.get<std::string>());
  });
  return list;
}

std::optional<std::uint64_t> hexadecimal(const json& object, const char* key) {
  std::string text;
  take(object, key, text);
  std::uint64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.empty() || failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

const Column* find_column(const StateSchema& schema, const LaneReport& row) {
  const auto table = schema.find_table(row.table);
  if (!table) return nullptr;
  for (const Column& column : schema.tables[*table].columns)
    if (column.name == row.column) return &column;
  return nullptr;
}

void read_lane(const json& object, const StateSchema& schema, Divergence& divergence) {
  LaneReport row;
  take(object, "table", row.table);
  take(object, "column", row.column);
  take(object, "row", row.row);
  take(object, "id", row.id);
  take(object, "name", row.name);
  std::uint64_t lane = 0;
  take(object, "lane", lane);
  const Column* column = find_column(schema, row);
  if (column == nullptr || lane >= column->lane_count) return;
  row.lane = static_cast<std::uint32_t>(lane);
  row.lane_count = column->lane_count;
  row.type = column->type;
  row.expected = hexadecimal(object, "expected");
  row.got = hexadecimal(object, "got");
  take(object, "place", row.place);
  divergence.rows.push_back(std::move(row));
}

void read_content(const json& object, Divergence& divergence) {
  ContentReport content;
  std::string kind;
  take(object, "place", content.place);
  take(object, "table", content.table);
  take(object, "row", content.row);
  take(object, "id", content.id);
  take(object, "name", content.name);
  take(object, "kind", kind);
  content.is_text = kind == "text";
  const auto take_bytes = [&](const char* key, std::optional<std::string>& bytes) {
    const json* found = member(object, key);
    if (found == nullptr || !found->is_string()) return;
    const auto& text = found->get_ref<const std::string&>();
    if (text.size() > content_text_max) return;
    bytes = content.is_text ? std::optional(text) : bytes_of_hex(text);
  };
  take_bytes("expected", content.expected);
  take_bytes("got", content.got);
  take(object, "first", content.first);
  take(object, "expected_size", content.expected_size);
  take(object, "got_size", content.got_size);
  take(object, "byte", content.offset);
  take(object, "character", content.character);
  divergence.contents.push_back(std::move(content));
}

void read_cells(const json& cells, Divergence& divergence) {
  divergence.from_cells = true;
  take(cells, "candidate_count", divergence.candidate_count);
  take(cells, "rows", divergence.owner_count);
  if (const json* healed = member(cells, "healed"); healed != nullptr && healed->is_boolean())
    divergence.healed = healed->get<bool>();
  std::uint64_t unexplained = 0;
  take(cells, "unexplained_cells", unexplained);
  divergence.unexplained_cells = static_cast<std::uint32_t>(std::min<std::uint64_t>(unexplained, UINT32_MAX));
  each(cells, "row_counts", [&](const json& table) {
    RowCountDifference& difference = divergence.row_counts.emplace_back();
    take(table, "table", difference.table);
    take(table, "expected", difference.expected);
    take(table, "got", difference.got);
  });
  each(cells, "candidates", [&](const json& row) {
    Candidate& candidate = divergence.candidates.emplace_back();
    take(row, "table", candidate.table);
    take(row, "row", candidate.row);
    take(row, "id", candidate.id);
    take(row, "name", candidate.name);
    take(row, "place", candidate.place);
  });
}

Divergence read_divergence(const json& object, const StateSchema& schema) {
  Divergence divergence;
  take(object, "tick", divergence.tick);
  take(object, "time_s", divergence.time_s);
  std::string stage;
  take(object, "stage", stage);
  if (!stage.empty()) divergence.stage = stage;
  take(object, "stage_note", divergence.stage_note);
  each(object, "tables", [&](const json& table) {
    TableDifference& difference = divergence.tables.emplace_back();
    take(table, "table", difference.table);
    difference.columns = texts(table, "columns");
    if (const json* content = member(table, "content"); content != nullptr && content->is_boolean())
      difference.is_content = content->get<bool>();
  });
  each(object, "rows", [&](const json& row) { read_lane(row, schema, divergence); });
  take(object, "lane_count", divergence.lane_count);
  each(object, "contents", [&](const json& content) { read_content(content, divergence); });
  take(object, "content_count", divergence.content_count);
  if (const json* cells = member(object, "cells"); cells != nullptr && cells->is_object())
    read_cells(*cells, divergence);
  divergence.expected_root = hexadecimal(object, "expected_hash").value_or(0);
  divergence.got_root = hexadecimal(object, "got_hash").value_or(0);
  for (const std::string& line : texts(object, "inputs")) divergence.inputs += line + "\n";
  return divergence;
}

void read_marks(const json& object, Report& report) {
  MarksDifference& marks = report.marks.emplace();
  take(object, "tick", marks.tick);
  each(object, "names", [&](const json& name) {
    NameDifference& difference = marks.names.emplace_back();
    take(name, "name", difference.name);
    take(name, "expected", difference.expected);
    take(name, "got", difference.got);
  });
  take(object, "name_count", marks.name_count);
}

replay::BuildFacts read_facts(const json& builds, const char* key) {
  replay::BuildFacts facts;
  const json* object = member(builds, key);
  if (object == nullptr || !object->is_object()) return facts;
  for (const auto& [name, value] : object->items())
    if (value.is_string() && facts.size() < list_size_max) facts.emplace_back(name, value.get<std::string>());
  return facts;
}

void read_compared(const json& object, Report& report) {
  report.compared.ticks = report.ticks_compared;
  const json* compared = member(object, "compared");
  if (compared == nullptr) return;
  take(*compared, "stage_hashes", report.compared.stage_hashes);
  take(*compared, "images", report.compared.images);
  take(*compared, "cells", report.compared.cells);
  take(*compared, "marks", report.compared.marks);
}

void read_fields(const json& object, const StateSchema& schema, Report& report) {
  take(object, "file", report.file);
  take(object, "reason", report.reason);
  take(object, "hint", report.hint);
  take(object, "mode", report.mode);
  take(object, "title", report.title);
  take(object, "simulation", report.simulation);
  take(object, "ticks_recorded", report.ticks_recorded);
  take(object, "ticks_compared", report.ticks_compared);
  take(object, "first_tick", report.first_tick);
  take(object, "time_s", report.time_s);
  report.root_hash = hexadecimal(object, "root_hash").value_or(0);
  take(object, "checkpoints_compared", report.checkpoints_compared);
  take(object, "checkpoint", report.checkpoint);
  read_compared(object, report);
  if (const json* marks = member(object, "marks"); marks != nullptr && marks->is_object()) read_marks(*marks, report);
  if (const json* divergence = member(object, "divergence"); divergence != nullptr && divergence->is_object())
    report.divergence = read_divergence(*divergence, schema);
  report.warnings = texts(object, "warnings");
  report.notes = texts(object, "notes");
  report.again = texts(object, "again");
  if (const json* builds = member(object, "builds"); builds != nullptr) {
    report.recorded_build = read_facts(*builds, "recorded");
    report.here_build = read_facts(*builds, "here");
  }
}

}  // namespace

std::optional<ReadReport> read_report(const std::string& text, const StateSchema& schema) {
  // Without exceptions. The limit of nesting follows from the schema of a report.
  constexpr int depth_max = 16;
  const json object = json::parse(
      text, [](int depth, json::parse_event_t, json&) { return depth <= depth_max; }, false);
  std::string name, verdict;
  take(object, "schema", name);
  take(object, "verdict", verdict);
  const auto info =
      std::find_if(verdicts.begin(), verdicts.end(), [&](const VerdictInfo& one) { return one.name == verdict; });
  if (!is_verify_schema(name) || info == verdicts.end()) return std::nullopt;
  ReadReport read;
  read.report.verdict = info->verdict;
  read_fields(object, schema, read.report);
  json finding = {{"verdict", verdict}};
  for (const char* key : {"divergence", "checkpoint", "reason", "ticks_compared"})
    if (const json* found = member(object, key); found != nullptr) finding[key] = *found;
  read.finding = finding.dump(-1, ' ', true, json::error_handler_t::replace);
  return read;
}

}  // namespace ticktrue::verifier
