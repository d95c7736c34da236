// Writes a report as JSON: schema ticktrue.verify/2.
// SPDX-License-Identifier: MIT
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "base/build_info.h"
#include "base/hash.h"
#include "base/plain_text.h"
#include "verifier/report/content_text.h"
#include "verifier/report/json_parts.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {

using Json = nlohmann::ordered_json;

Json facts_json(const replay::BuildFacts& facts) {
  Json object = Json::object();
  for (const auto& [name, value] : facts) object[name] = value;
  return object;
}

Json differences_json(const std::vector<FactDifference>& differences, const char* a_name, const char* b_name) {
  Json list = Json::array();
  for (const FactDifference& difference : differences)
    list.push_back({{"name", difference.name},
                    {a_name, difference.a},
                    {b_name, difference.b},
                    {"changes_bits", difference.changes_bits}});
  return list;
}

Json causes_json(const std::vector<Cause>& found) {
  Json list = Json::array();
  for (const Cause cause : found) list.push_back({{"cause", cause_info(cause).name}, {"text", cause_info(cause).text}});
  return list;
}

Json build_json() {
  const BuildInfo& info = build_info();
  return {{"version", info.version},
          {"commit", info.commit},
          {"compiler", info.compiler},
          {"flags", info.flags},
          {"target", info.target}};
}

bool is_verify_schema(std::string_view name) {
  return name == verify_schema || name == "ticktrue.verify/1";
}

Json value_json(ScalarType type, std::uint64_t bits) {
  constexpr std::int64_t exact_max = std::int64_t{1} << 53;  // of a double, which most JSON readers use
  const std::string text = lane_text(type, bits);
  if (scalar_info(type)->is_float) {
    const double value = std::strtod(text.c_str(), nullptr);
    return std::isfinite(value) ? Json(value) : Json(text);
  }
  std::int64_t value = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_exact = failure == std::errc() && value >= -exact_max && value <= exact_max;
  return is_exact ? Json(value) : Json(text);
}

std::string value_text(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return lane_text(ScalarType::f64, bits_of(value.get<double>()));
  return value.is_number() ? value.dump() : "";
}

Json lane_json(const LaneReport& row) {
  const auto bits = [&](const std::optional<std::uint64_t>& value) {
    return value ? Json(lane_hex(row.type, *value)) : Json(nullptr);
  };
  const auto number = [&](const std::optional<std::uint64_t>& value) {
    return value ? value_json(row.type, *value) : Json(nullptr);
  };
  std::optional<std::uint64_t> ulp;
  if (row.expected && row.got) ulp = ulp_distance(row.type, *row.expected, *row.got);
  Json object = {{"row", row.row},
                 {"id", row.id ? Json(*row.id) : Json(nullptr)},
                 {"name", row.name},
                 {"table", row.table},
                 {"column", row.column},
                 {"lane", row.lane},
                 {"expected", bits(row.expected)},
                 {"got", bits(row.got)},
                 {"expected_value", number(row.expected)},
                 {"got_value", number(row.got)},
                 {"ulp", ulp ? Json(*ulp) : Json(nullptr)}};
  if (!row.place.empty()) object["place"] = row.place;
  return object;
}

Json content_json(const ContentReport& content) {
  const auto bytes = [&](const std::optional<std::string>& value) {
    if (!value) return Json(nullptr);
    return content.is_text ? Json(*value) : Json(hex_text(*value));
  };
  return {{"place", content.place},
          {"table", content.table},
          {"row", content.row},
          {"id", content.id ? Json(*content.id) : Json(nullptr)},
          {"name", content.name},
          {"kind", content.is_text ? "text" : "bytes"},
          {"expected", bytes(content.expected)},
          {"got", bytes(content.got)},
          {"first", content.first},
          {"expected_size", content.expected_size},
          {"got_size", content.got_size},
          {"byte", content.offset},
          {"character", content.character ? Json(*content.character) : Json(nullptr)}};
}

namespace {

/// The rows that can have differed, according to the cells.
Json cells_json(const Divergence& divergence) {
  Json object = {{"candidate_count", divergence.candidate_count},
                 {"rows", divergence.owner_count},
                 {"healed", divergence.healed},
                 {"unexplained_cells", divergence.unexplained_cells}};
  Json counts = Json::array();
  for (const RowCountDifference& table : divergence.row_counts)
    counts.push_back({{"table", table.table}, {"expected", table.expected}, {"got", table.got}});
  object["row_counts"] = std::move(counts);
  Json candidates = Json::array();
  for (const Candidate& candidate : divergence.candidates)
    candidates.push_back({{"table", candidate.table},
                          {"row", candidate.row},
                          {"id", candidate.id ? Json(*candidate.id) : Json(nullptr)},
                          {"name", candidate.name}});
  for (std::size_t i = 0; i < divergence.candidates.size(); ++i)
    if (!divergence.candidates[i].place.empty()) candidates[i]["place"] = divergence.candidates[i].place;
  object["candidates"] = std::move(candidates);
  return object;
}

}  // namespace

Json divergence_json(const Divergence& divergence) {
  const TableDifference* first = divergence.tables.empty() ? nullptr : &divergence.tables.front();
  Json object = {{"tick", divergence.tick},
                 {"time_s", divergence.time_s},
                 {"stage", divergence.stage ? Json(*divergence.stage) : Json(nullptr)},
                 {"stage_note", divergence.stage_note},
                 {"table", first != nullptr ? Json(first->table) : Json(nullptr)},
                 {"columns", first != nullptr ? Json(first->columns) : Json::array()}};
  Json tables = Json::array();
  for (const TableDifference& table : divergence.tables) {
    tables.push_back({{"table", table.table}, {"columns", table.columns}});
    if (table.is_content) tables.back()["content"] = true;
  }
  object["tables"] = std::move(tables);
  Json rows = Json::array();
  for (const LaneReport& row : divergence.rows) rows.push_back(lane_json(row));
  object["rows"] = std::move(rows);
  object["lane_count"] = divergence.lane_count;
  if (divergence.content_count > 0) {
    Json contents = Json::array();
    for (const ContentReport& content : divergence.contents) contents.push_back(content_json(content));
    object["contents"] = std::move(contents);
    object["content_count"] = divergence.content_count;
  }
  object["cells"] = divergence.from_cells ? cells_json(divergence) : Json(nullptr);
  Json spread = Json::array();
  for (const Spread& at : divergence.spread)
    spread.push_back({{"tick", at.tick}, {"rows", at.row_count}, {"of", at.of}, {"estimated", at.estimated}});
  object["spread"] = std::move(spread);
  object["expected_hash"] = hex64(divergence.expected_root);
  object["got_hash"] = hex64(divergence.got_root);
  object["inputs"] = input_lines_json(divergence.inputs);
  return object;
}

Json non_finite_json(const NonFinite& found) {
  return {{"tick", found.tick},     {"table", found.table}, {"row", found.row},    {"name", found.row_name},
          {"column", found.column}, {"lane", found.lane},   {"value", found.value}};
}

Json compared_json(const ComparedParts& compared) {
  Json object = {{"stage_hashes", compared.stage_hashes}, {"images", compared.images}, {"cells", compared.cells}};
  if (compared.marks > 0) object["marks"] = compared.marks;
  return object;
}

namespace {

Json marks_json(const MarksDifference& marks) {
  Json names = Json::array();
  for (const NameDifference& name : marks.names)
    names.push_back({{"name", name.name}, {"expected", name.expected}, {"got", name.got}});
  return {{"tick", marks.tick}, {"names", std::move(names)}, {"name_count", marks.name_count}};
}

}  // namespace

Json input_lines_json(const std::string& lines) {
  return Json(split_lines(lines));
}

Json end_json(const TraceEnd& end) {
  const replay::TraceTail& tail = end.tail;
  const char* condition = "complete";
  if (tail.condition == replay::TraceCondition::truncated) condition = "truncated";
  if (tail.condition == replay::TraceCondition::damaged) condition = "damaged";
  Json object = {{"condition", condition}, {"ticks_intact", tail.ticks_intact}};
  object["last_good_tick"] = tail.ticks_intact > 0 ? Json(tail.ticks_intact - 1) : Json(nullptr);
  if (end.salvaged_from) object["salvaged_from"] = *end.salvaged_from;
  object["reason"] = nullptr;
  object["note"] = "";
  if (tail.end) {
    for (const replay::EndReasonInfo& info : replay::end_reasons)
      if (info.reason == tail.end->reason) object["reason"] = info.name;
    object["note"] = tail.end->note;
  }
  object["offset"] = tail.offset;
  object["message"] = tail.message;
  object["pending"] = nullptr;
  if (tail.has_pending_inputs)
    object["pending"] = {{"tick", tail.ticks_intact},
                         {"dt", hex64(bits_of(tail.pending_dt))},
                         {"inputs", input_lines_json(end.pending_inputs)}};
  return object;
}

namespace {

Json intact_json(const Report& report) {
  Json list = Json::array();
  if (report.end)
    for (const replay::IntactRange& range : report.end->tail.intact_after)
      list.push_back(
          {{"first_tick", range.first_tick}, {"last_tick", range.last_tick}, {"has_checkpoint", range.has_checkpoint}});
  return list;
}

Json against_json(const OtherBuild& other) {
  return {{"binary", other.binary},
          {"verdict", other.verdict.empty() ? Json(nullptr) : Json(other.verdict)},
          {"reason", other.reason},
          {"ticks_compared", other.ticks_compared},
          {"diverged_at", other.diverged_at ? Json(*other.diverged_at) : Json(nullptr)},
          {"build", facts_json(other.facts)}};
}

}  // namespace

Json report_row_json(const Report& report) {
  Json object;
  object["file"] = report.file;
  object["verdict"] = verdict_info(report.verdict).name;
  object["ticks_recorded"] = report.ticks_recorded ? Json(*report.ticks_recorded) : Json(nullptr);
  object["ticks_compared"] = report.ticks_compared;
  object["divergence"] = report.divergence ? divergence_json(*report.divergence) : Json(nullptr);
  object["reason"] = report.reason;
  object["hint"] = report.hint;
  object["mode"] = report.mode;
  object["title"] = report.title;
  object["simulation"] = report.simulation;
  object["first_tick"] = report.first_tick;
  object["time_s"] = report.time_s;
  object["root_hash"] = hex64(report.root_hash);
  object["checkpoints_compared"] = report.checkpoints_compared;
  object["compared"] = compared_json(report.compared);
  object["stretches"] = report.segments;
  if (report.marks) object["marks"] = marks_json(*report.marks);
  object["checkpoint"] = report.checkpoint ? Json(*report.checkpoint) : Json(nullptr);
  object["non_finite"] = report.non_finite ? non_finite_json(*report.non_finite) : Json(nullptr);
  object["end"] = report.end ? end_json(*report.end) : Json(nullptr);
  object["intact_after"] = intact_json(report);
  object["inputs"] = report.divergence ? input_lines_json(report.divergence->inputs) : Json::array();
  object["warnings"] = report.warnings;
  object["notes"] = report.notes;
  object["builds"] = {{"recorded", facts_json(report.recorded_build)},
                      {"here", report.here_build.empty() ? build_json() : facts_json(report.here_build)}};
  const std::vector<FactDifference> differences = fact_differences(report.recorded_build, report.here_build);
  if (!differences.empty()) object["builds"]["differ"] = differences_json(differences, "recorded", "here");
  if (Json why = causes_json(likely_causes(report)); !why.empty()) object["why"] = std::move(why);
  object["again"] = report.again;
  if (report.against) object["against"] = against_json(*report.against);
  return object;
}

void add_counts(Json& object, std::span<const Report> reports, bool allow_truncated) {
  std::uint64_t passed = 0, failed = 0, expected = 0, not_applicable = 0;
  for (const Report& report : reports) {
    if (report.verdict == Verdict::match)
      ++passed;
    else if (report.exit_code(allow_truncated) == exit_ok)
      ++expected;
    else if (report.verdict == Verdict::not_comparable)
      ++not_applicable;
    else
      ++failed;
  }
  object["passed"] = passed;
  object["failed"] = failed;
  object["expected"] = expected;
  object["not_applicable"] = not_applicable;
}

std::string report_json(std::span<const Report> reports, bool allow_truncated) {
  Json object = {{"schema", verify_schema}};
  if (reports.size() == 1) {
    const Json row = report_row_json(reports[0]);
    for (const auto& [name, value] : row.items()) object[name] = value;
  }
  add_counts(object, reports, allow_truncated);
  if (reports.size() != 1) {
    Json rows = Json::array();
    for (const Report& report : reports) rows.push_back(report_row_json(report));
    object["rows"] = std::move(rows);
  }
  return plain_text(object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ticktrue::verifier
