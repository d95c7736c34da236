// The flips and their findings, as text and as JSON: schema ticktrue.inject/1.
// SPDX-License-Identifier: MIT
#include <nlohmann/json.hpp>

#include "base/plain_text.h"
#include "verifier/inject/inject.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::verifier {
namespace {

std::string place_of_tick_text(const InjectRow& row) {
  std::string text = "tick " + std::to_string(row.tick) + ", " + row.place.table + "." + row.place.column + " row " +
                     std::to_string(row.place.row);
  if (!row.place.name.empty()) text += " \"" + row.place.name + "\"";
  text += " lane " + std::to_string(row.place.lane) + " bit " + std::to_string(row.bit);
  if (!row.more.empty()) text += " and " + std::to_string(row.more.size()) + " more rows";
  if (!row.place.expected) return text + " inside the solver";
  return text + ": " + lane_hex(row.place.type, *row.place.expected) + " (" +
         lane_text(row.place.type, *row.place.expected) + ") to " + lane_hex(row.place.type, *row.place.got) + " (" +
         lane_text(row.place.type, *row.place.got) + ")";
}

const char* outcome_name(InjectRow::Outcome outcome) {
  switch (outcome) {
    case InjectRow::Outcome::found:
      return "found";
    case InjectRow::Outcome::missed:
      return "missed";
    case InjectRow::Outcome::not_applicable:
      return "not_applicable";
  }
  return "missed";
}

}  // namespace

std::string inject_text(const InjectReport& report) {
  if (report.baseline.verdict != Verdict::match)
    return report_text(report.baseline) + "  note    nothing was injected: the trace itself does not match\n";
  constexpr std::size_t rows_shown_max = 10;
  bool places = true, cells = report.lists.count > 0;
  for (const InjectRow& row : report.rows)
    if (row.outcome == InjectRow::Outcome::found) {
      places = places && row.place_required;
      cells = cells && row.cells_required;
    }
  std::string text = std::string(report.failed == 0 && report.passed > 0 ? "found" : "missed") + "  " + report.file +
                     "  " + std::to_string(report.passed) + " of " + std::to_string(report.rows.size()) +
                     " flips found at the exact " +
                     (places  ? "tick, table, column, row and lane"
                      : cells ? std::string(report.is_inside ? "tick and table" : "tick, table and columns") +
                                    ", the rows concerned in the list"
                              : "tick") +
                     "\n";
  if (cells)
    text += "  list    " + std::to_string(report.lists.median) + " rows (median), at most " +
            std::to_string(report.lists.max) + "; concerned " + std::to_string(report.lists.median_concerned) +
            " (median)\n";
  if (report.waived > 0)
    text += "  waived  " + std::to_string(report.waived) +
            " of them left their own row as it should be: only those around it can be listed\n";
  if (!places && !cells)
    text +=
        "  note    where the trace stores only the hash of a tick, only the tick was required: record with "
        "--detail full for more\n";
  if (report.not_applicable > 0)
    text += "  note    " + std::to_string(report.not_applicable) +
            (report.is_inside ? " not applicable: rounding took the fault away, or nothing could be flipped there\n"
                              : " not applicable: no such place in the state\n");
  std::size_t shown = 0;
  for (const InjectRow& row : report.rows) {
    const bool single = report.rows.size() == 1;
    if ((row.outcome != InjectRow::Outcome::missed && !single) || shown++ >= rows_shown_max) continue;
    if (row.outcome == InjectRow::Outcome::not_applicable) continue;
    text += "  flipped " + place_of_tick_text(row) + "\n";
    if (row.outcome == InjectRow::Outcome::missed) text += "  missed  verify says: " + row.reason + "\n";
    if (row.divergence) text += divergence_text(*row.divergence);
  }
  return text;
}

std::string inject_json(const InjectReport& report) {
  using Json = nlohmann::ordered_json;
  Json object = {{"schema", "ticktrue.inject/1"},
                 {"file", report.file},
                 {"seed", report.seed},
                 {"count", report.rows.size()},
                 {"detail", report.detail},
                 {"baseline", verdict_info(report.baseline.verdict).name},
                 {"passed", report.passed},
                 {"failed", report.failed},
                 {"expected", 0},
                 {"not_applicable", report.not_applicable},
                 {"waived", report.waived}};
  object["lists"] = nullptr;
  if (report.lists.count > 0)
    object["lists"] = {{"count", report.lists.count},
                       {"median", report.lists.median},
                       {"max", report.lists.max},
                       {"median_concerned", report.lists.median_concerned}};
  Json rows = Json::array();
  for (const InjectRow& row : report.rows) {
    Json entry = {{"index", row.index}, {"outcome", outcome_name(row.outcome)}, {"tick", row.tick}};
    if (row.outcome != InjectRow::Outcome::not_applicable) {
      entry["table"] = row.place.table;
      entry["column"] = row.place.column;
      entry["row"] = row.place.row;
      entry["lane"] = row.place.lane;
      entry["bit"] = row.bit;
      entry["name"] = row.place.name;
      entry["expected"] = row.place.expected ? Json(lane_hex(row.place.type, *row.place.expected)) : Json(nullptr);
      entry["got"] = row.place.got ? Json(lane_hex(row.place.type, *row.place.got)) : Json(nullptr);
      entry["flipped_rows"] = 1 + row.more.size();
      entry["required"] = row.place_required ? "place" : row.cells_required ? "cells" : "tick";
      if (row.cells_required) {
        entry["concerned"] = row.concerned;
        entry["waived"] = row.waived;
        entry["list_length"] = row.list_length;
      }
    }
    entry["reason"] = row.reason;
    Json found = {{"verdict", verdict_info(row.verdict).name}};
    if (row.divergence) {
      found["tick"] = row.divergence->tick;
      const LaneReport* lane = row.divergence->rows.empty() ? nullptr : &row.divergence->rows[0];
      found["table"] = lane != nullptr ? Json(lane->table) : Json(nullptr);
      found["column"] = lane != nullptr ? Json(lane->column) : Json(nullptr);
      found["row"] = lane != nullptr ? Json(lane->row) : Json(nullptr);
      found["lane"] = lane != nullptr ? Json(lane->lane) : Json(nullptr);
      found["lane_count"] = row.divergence->lane_count;
    }
    entry["found"] = std::move(found);
    rows.push_back(std::move(entry));
  }
  object["rows"] = std::move(rows);
  return plain_text(object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace ticktrue::verifier
