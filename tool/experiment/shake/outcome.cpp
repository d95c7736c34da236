// Each line of a result file is a report of schema ticktrue.verify/2 (or 1), one for each session.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/outcome.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "base/plain_text.h"
#include "verifier/report/json_parts.h"

namespace ticktrue::shake {
namespace {

std::string text_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::uint64_t number_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : 0;
}

OutcomeValue value_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  return {verifier::value_text(*found), found->is_number()};
}

/// Reads the first differing lane of the first differing row. Without a row, reads the first table and column.
void read_place(const nlohmann::json& divergence, Outcome& outcome) {
  outcome.tick = number_at(divergence, "tick");
  outcome.stage = text_at(divergence, "stage");
  outcome.table = text_at(divergence, "table");
  outcome.got_hash = text_at(divergence, "got_hash");
  if (const auto columns = divergence.find("columns");
      columns != divergence.end() && columns->is_array() && !columns->empty() && columns->front().is_string())
    outcome.column = columns->front().get<std::string>();
  const auto rows = divergence.find("rows");
  if (rows != divergence.end() && rows->is_array() && !rows->empty()) {
    const nlohmann::json& lane = rows->front();
    outcome.table = text_at(lane, "table");
    outcome.column = text_at(lane, "column");
    outcome.row = number_at(lane, "row");
    outcome.row_name = text_at(lane, "name");
    outcome.expected = value_at(lane, "expected_value");
    outcome.got = value_at(lane, "got_value");
    return;
  }
  const auto cells = divergence.find("cells");
  if (cells == divergence.end() || !cells->is_object()) return;
  const auto candidates = cells->find("candidates");
  if (candidates == cells->end() || !candidates->is_array() || candidates->size() != 1) return;
  outcome.row = number_at(candidates->front(), "row");
  outcome.row_name = text_at(candidates->front(), "name");
}

void read_report(const nlohmann::json& report, Outcome& outcome) {
  const std::string verdict = text_at(report, "verdict");
  outcome.ticks_compared = number_at(report, "ticks_compared");
  outcome.kind = OutcomeKind::other;
  if (verdict == "match") outcome.kind = OutcomeKind::match;
  const auto divergence = report.find("divergence");
  if (verdict == "diverged" && divergence != report.end() && divergence->is_object()) {
    outcome.kind = OutcomeKind::diverged;
    read_place(*divergence, outcome);
  }
  if (outcome.kind == OutcomeKind::match || !outcome.table.empty()) return;
  const std::string reason = text_at(report, "reason");
  outcome.reason = verdict + (reason.empty() ? "" : ": " + reason);
}

/// Reads the first report that is not a match.
bool read_result(const std::string& result, Outcome& outcome) {
  bool has_report = false;
  const auto take = [&](const std::string& text) {
    const nlohmann::json report = nlohmann::json::parse(text, nullptr, false);
    if (!report.is_object() || !verifier::is_verify_schema(text_at(report, "schema"))) return false;
    if (!has_report || outcome.kind == OutcomeKind::match) read_report(report, outcome);
    has_report = true;
    return true;
  };
  if (take(result)) return true;
  std::istringstream lines(result);
  for (std::string line; std::getline(lines, line);) take(line);
  return has_report;
}

std::string first_line(const std::string& text) {
  constexpr std::size_t length_max = 160;
  const std::string line = plain_line(text.substr(0, text.find('\n')));
  return line.size() > length_max ? line.substr(0, length_max) + "..." : line;
}

std::string last_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  const std::size_t line = text.rfind('\n');
  return first_line(line == std::string::npos ? text : text.substr(line + 1));
}

void read_page(const shim::Page& page, Outcome& outcome) {
  outcome.has_shim = page.is_loaded != 0;
  outcome.has_session = page.session.session_process != 0;
  outcome.changed_count = page.changed_count;
  for (std::size_t f = 0; f < shim::function_count; ++f) {
    outcome.call_counts[f] = page.call_counts[f];
    outcome.tick_counts[f] = page.tick_counts[f];
  }
}

}  // namespace

std::uint64_t Outcome::calls_of(shim::Group group) const {
  std::uint64_t count = 0;
  for (std::size_t f = 0; f < shim::function_count; ++f)
    if (shim::functions[f].group == group) count += call_counts[f];
  return count;
}

const char* outcome_name(OutcomeKind kind) {
  constexpr const char* names[] = {"match", "diverged", "other_verdict", "no_result", "crashed", "hung", "not_started"};
  return names[static_cast<std::size_t>(kind)];
}

std::string signature(const Outcome& outcome) {
  std::string text = outcome_name(outcome.kind);
  if (outcome.kind == OutcomeKind::diverged) text += " " + std::to_string(outcome.tick) + " " + outcome.got_hash;
  if (outcome.kind == OutcomeKind::other) text += " " + outcome.reason;
  return text;
}

Outcome judge(const verifier::ChildResult& child, const verifier::ChildLimits& limits, const std::string& result,
              const shim::Page* page) {
  Outcome outcome;
  if (page != nullptr) read_page(*page, outcome);
  outcome.wall_s = child.end.wall_s;
  outcome.exit_status = child.end.exit_status;
  outcome.escaped = child.end.escaped;
  const std::string failure = verifier::child_failure(child, limits);
  if (child.end.how == verifier::ChildEnd::How::not_started) {
    outcome.reason = failure;
    return outcome;
  }
  // A report counts even if the program failed later.
  if (read_result(result, outcome)) return outcome;
  const bool is_hung =
      child.end.how == verifier::ChildEnd::How::timed_out || child.end.how == verifier::ChildEnd::How::stopped;
  outcome.kind = OutcomeKind::no_result;
  if (is_hung) outcome.kind = OutcomeKind::hung;
  if (child.end.how == verifier::ChildEnd::How::killed_by_signal) outcome.kind = OutcomeKind::crashed;
  if (page != nullptr && page->session.position > 0) outcome.tick = (page->session.position - 1) / 2;
  outcome.reason = failure;
  if (failure.empty() || outcome.kind == OutcomeKind::no_result)
    outcome.reason = "ended with status " + std::to_string(child.end.exit_status) + " and without a result" +
                     (child.message.empty() ? "" : ": " + last_line(child.message));
  else if (page != nullptr && page->session.session_process != 0)
    outcome.reason +=
        page->session.position == 0 ? ", before the first tick" : ", in tick " + std::to_string(outcome.tick);
  return outcome;
}

std::string outcome_text(const Outcome& outcome) {
  if (outcome.kind == OutcomeKind::match) return "as recorded";
  if (outcome.kind != OutcomeKind::diverged) return outcome.reason;
  std::string text = "tick " + std::to_string(outcome.tick);
  if (!outcome.stage.empty()) text += "  stage " + outcome.stage;
  if (!outcome.table.empty()) text += "  " + outcome.table + (outcome.column.empty() ? "" : "." + outcome.column);
  if (outcome.row) text += " row " + std::to_string(*outcome.row);
  if (!outcome.row_name.empty()) text += " \"" + outcome.row_name + "\"";
  if (!outcome.expected.text.empty() || !outcome.got.text.empty())
    text += "  " + outcome.expected.text + " -> " + outcome.got.text;
  return plain_line(text);
}

}  // namespace ticktrue::shake
