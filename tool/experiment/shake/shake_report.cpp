// Text, JSON, JUnit XML and workflow commands of a shake.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/shake_report.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "base/count_text.h"
#include "base/plain_text.h"
#include "tool/output/json_output.h"
#include "verifier/report/exit_codes.h"
#include "verifier/report/report_ci.h"

namespace ticktrue::shake {
namespace {

using cli::Json;

constexpr std::size_t name_width = 16;
constexpr std::size_t line_width = 110;

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size() + 1), ' ');
  return text;
}

std::string seconds(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", value);
  return text;
}

std::string class_of(const RowResult& row) {
  return std::string(1, static_cast<char>(row.choice.perturbation->kind));
}

std::string moved_text(const RowResult& row) {
  std::string text = row.outcome.kind == OutcomeKind::diverged ? "DIVERGED "
                     : row.outcome.kind == OutcomeKind::match  ? "MOVED    "  // the control does not run as recorded
                                                               : "FAILED   ";
  text += outcome_text(row.outcome);
  if (row.repeat_count > row.moved_count)
    text += "  (" + std::to_string(row.moved_count) + " of " + std::to_string(row.repeat_count) + " runs)";
  return text;
}

/// " label a, b, c", wrapped into lines of limited length.
std::string list_text(const std::string& label, const std::vector<std::string>& names) {
  std::string text;
  std::string line = "  " + padded(label, name_width);
  const std::string indent(line.size(), ' ');
  bool is_first = true;
  for (const std::string& name : names) {
    const std::string word = (is_first ? "" : ", ") + name;
    if (line.size() + word.size() > line_width && !is_first) {
      text += line + ",\n";
      line = indent + name;
    } else {
      line += word;
    }
    is_first = false;
  }
  return names.empty() ? "" : text + line + "\n";
}

std::string control_text(const ShakeReport& report) {
  const std::size_t count = report.control.size();
  if (!report.repeats) {
    std::string text = "  " + padded("control", name_width) + "DOES NOT REPEAT\n";
    struct Seen {
      std::string text;
      std::size_t times = 0;
    };
    std::map<std::string, Seen> seen;  // by signature
    for (const Outcome& outcome : report.control) {
      constexpr std::size_t hash_digits = 8;
      Seen& one = seen[signature(outcome)];
      one.text = outcome_text(outcome);
      if (!outcome.got_hash.empty()) one.text += "  (state " + outcome.got_hash.substr(0, hash_digits) + ")";
      ++one.times;
    }
    constexpr std::size_t shown_max = 4;
    std::size_t shown = 0;
    for (const auto& [key, one] : seen)
      if (++shown <= shown_max)
        text += "  " + padded("", name_width) + std::to_string(one.times) + " of " + std::to_string(count) +
                " runs: " + one.text + "\n";
    if (shown > shown_max)
      text += "  " + padded("", name_width) + "and " + count_text(shown - shown_max, "other outcome") + "\n";
    return text;
  }
  std::string text =
      "  " + padded("control", name_width) + "same " + std::to_string(count) + " of " + std::to_string(count) + " runs";
  if (report.control.front().kind != OutcomeKind::match)
    text += ", and not as recorded: " + outcome_text(report.control.front());
  return text + "\n";
}

/// The sources that could not be fixed, and why.
std::string not_tried_text(const ShakeReport& report) {
  if (report.fix.not_tried.empty()) return "";
  return list_text("not tried", report.fix.not_tried) + "  " + padded("", name_width) + plain_line(report.no_shim) +
         "\n";
}

std::string fix_text(const ShakeReport& report) {
  const std::string indent = "  " + padded("", name_width);
  if (!report.fix.is_found) {
    std::string text = "  " + padded("cause", name_width) + "not found: nothing that can be held still is enough\n";
    for (const std::string& place : report.instructions)
      text += indent + "the program has " + place + ", which no library stands in front of\n";
    return text + not_tried_text(report);
  }
  std::string names;
  for (const std::string& name : report.fix.names) names += (names.empty() ? "" : " and ") + name;
  const char* certainty = report.fix.not_tried.empty() ? "" : "not certain: ";
  std::string text =
      "  " + padded("cause", name_width) + certainty + names + ": held still, the program repeats itself\n";
  if (report.fix.cause) text += indent + report.fix.cause->text() + "\n";
  return text + not_tried_text(report);
}

/// The perturbations that do not apply, by reason.
std::string reasons_text(const ShakeReport& report) {
  std::string text;
  std::vector<std::string> reasons;
  for (const RowResult& row : report.rows)
    if (row.state == RowState::not_applicable && std::find(reasons.begin(), reasons.end(), row.reason) == reasons.end())
      reasons.push_back(row.reason);
  for (const std::string& reason : reasons) {
    std::string names;
    for (const RowResult& row : report.rows)
      if (row.state == RowState::not_applicable && row.reason == reason)
        names += (names.empty() ? "" : ", ") + std::string(row.choice.perturbation->name);
    text += "    " + names + ": " + plain_line(reason) + "\n";
  }
  return text;
}

/// Whether something else may be the cause that only the preload library can change.
bool leaves_causes_open(const ShakeReport& report) {
  if (!report.repeats) return !report.fix.not_tried.empty();
  const auto is_untried = [&](const RowResult& row) {
    return row.state == RowState::not_applicable && row.reason == report.no_shim;
  };
  return report.moved_count(Kind::a) > 0 && std::any_of(report.rows.begin(), report.rows.end(), is_untried);
}

/// One next step for each cause.
std::vector<std::string> next_steps(const ShakeReport& report) {
  std::vector<std::string> steps;
  if (leaves_causes_open(report))
    steps.emplace_back("shake again where the preload library loads: what was not tried may be the cause");
  for (std::size_t i = 0; i < report.fix.mends.size(); ++i)
    steps.push_back((report.fix.not_tried.empty() ? "" : "if the cause is " + report.fix.names[i] + ": ") +
                    report.fix.mends[i]);
  for (const RowResult& row : report.rows)
    if (row.state == RowState::moved && row.choice.perturbation->kind != Kind::c)
      steps.emplace_back(row.choice.perturbation->mend);
  std::vector<std::string> once;
  for (const std::string& step : steps)
    if (std::find(once.begin(), once.end(), step) == once.end()) once.push_back(step);
  return once;
}

const char* verdict_name(const ShakeReport& report, const ShakeSubject& subject) {
  if (!report.failure.empty()) return "failed";
  if (!report.repeats) return "not_reproducible";
  return exit_code(report, subject) == verifier::exit_ok ? "same" : "moved";
}

const char* state_name(const RowResult& row) {
  switch (row.state) {
    case RowState::same:
    case RowState::same_together:
      return "same";
    case RowState::moved:
      return outcome_name(row.outcome.kind);
    case RowState::not_applicable:
      return "not_applicable";
    case RowState::not_run:
      return "not_run";
  }
  return "";
}

/// A number as in the report.
Json value_json(const OutcomeValue& value) {
  if (!value.is_number) return value.text;
  if (value.text == "-0") return -0.0;
  return Json::parse(value.text);
}

Json outcome_json(const Outcome& outcome) {
  Json object = {{"outcome", outcome_name(outcome.kind)}, {"wall_s", outcome.wall_s}};
  if (outcome.kind == OutcomeKind::match) return object;
  object["tick"] = outcome.tick;
  object["reason"] = outcome.reason;
  object["stage"] = outcome.stage;
  object["table"] = outcome.table;
  object["column"] = outcome.column;
  object["row"] = outcome.row ? Json(*outcome.row) : Json(nullptr);
  object["name"] = outcome.row_name;
  object["expected_value"] = value_json(outcome.expected);
  object["got_value"] = value_json(outcome.got);
  return object;
}

Json cause_json(const std::optional<Cause>& cause) {
  if (!cause) return nullptr;
  Json object = {{"text", cause->text()}, {"found", cause->failure.empty()}};
  if (!cause->failure.empty()) return object;
  if (!cause->dispatch.features.empty()) {
    object["cpu_features"] = cause->dispatch.features;
    object["module"] = cause->dispatch.module;
    object["variable"] = cause->dispatch.variable;
    return object;
  }
  if (cause->is_ticks) {
    object["first_tick"] = cause->tick_first;
    object["last_tick"] = cause->tick_last;
    return object;
  }
  object["function"] = cause->function;
  object["call"] = cause->nth;
  object["number"] = cause->number;
  object["tick"] = cause->position == 0 ? Json(nullptr) : Json((cause->position - 1) / 2);
  object["between_ticks"] = cause->position % 2 == 0;
  object["size"] = cause->size;
  object["calls_needed"] = cause->call_count;
  object["symbol"] = cause->site.function;
  object["source"] = cause->site.file;
  object["line"] = cause->site.line;
  object["module"] = cause->site.module;
  object["offset"] = cause->site.offset;
  return object;
}

Json row_json(const RowResult& row) {
  const Perturbation& perturbation = *row.choice.perturbation;
  Json object = {{"name", perturbation.name}, {"class", class_of(row)},
                 {"what", perturbation.what}, {"outcome", state_name(row)},
                 {"reason", row.reason},      {"together", row.state == RowState::same_together},
                 {"runs", row.run_count},     {"wall_s", row.wall_s}};
  if (row.state != RowState::moved) return object;
  object["run"] = outcome_json(row.outcome);
  object["moved"] = row.moved_count;
  object["repeated"] = row.repeat_count;
  object["cause"] = cause_json(row.cause);
  object["mend"] = perturbation.mend;
  return object;
}

}  // namespace

int exit_code(const ShakeReport& report, const ShakeSubject& subject) {
  if (!report.failure.empty()) return verifier::exit_usage;
  if (!report.repeats) return verifier::exit_not_reproducible;
  const bool has_moved = report.moved_count(Kind::a) > 0 || !report.together_outcome.reason.empty() ||
                         report.together_outcome.kind == OutcomeKind::diverged ||
                         (subject.fails_for_b && report.moved_count(Kind::b) > 0);
  if (has_moved) return verifier::exit_finding;
  return report.control.front().kind == OutcomeKind::match ? verifier::exit_ok : verifier::exit_usage;
}

std::string shake_text(const ShakeReport& report, const ShakeSubject& subject) {
  std::string text = "shaken  " + subject.trace + "  " + count_text(subject.tick_count, "tick") + ", " +
                     count_text(report.rows.size(), "perturbation") + ", " + count_text(report.run_count, "run") +
                     ", " + seconds(report.wall_s) + "\n";
  if (!report.failure.empty()) return text + "  " + padded("control", name_width) + report.failure + "\n";
  text += control_text(report);
  if (!report.repeats) text += fix_text(report);
  std::vector<std::string> same;
  for (const RowResult& row : report.rows) {
    if (row.state == RowState::same || row.state == RowState::same_together)
      same.emplace_back(row.choice.perturbation->name);
    if (row.state != RowState::moved) continue;
    text += "  " + padded(class_of(row) + " " + std::string(row.choice.perturbation->name), name_width) +
            moved_text(row) + "\n";
    const bool has_cause = row.cause && row.choice.perturbation->narrowing != Narrowing::none;
    if (has_cause) text += "  " + padded("", name_width) + "cause: " + row.cause->text() + "\n";
  }
  const bool has_moved_together = signature(report.together_outcome) != signature(Outcome{});
  if (has_moved_together && report.moved_count(Kind::a) == 0) {
    std::string names;
    for (const std::string& name : report.together) names += (names.empty() ? "" : " with ") + name;
    text += "  " + padded("A together", name_width) + "DIVERGED " + outcome_text(report.together_outcome) + "\n";
    text += "  " + padded("", name_width) + "none of them alone; " + (names.empty() ? "not narrowed" : names) + "\n";
  }
  if (!same.empty()) text += list_text("same", same);
  const std::size_t without = report.count(RowState::not_applicable);
  if (without > 0) text += "  " + padded("not applicable", name_width) + std::to_string(without) + "\n";
  text += reasons_text(report);
  if (report.repeats && report.count(RowState::not_run) > 0)
    text += "  " + padded("not run", name_width) + std::to_string(report.count(RowState::not_run)) +
            " for want of time (--time)\n";
  for (const std::string& note : report.notes) text += "  " + padded("note", name_width) + plain_line(note) + "\n";
  if (report.repeats && report.control.front().kind != OutcomeKind::match && report.moved_count(Kind::a) == 0)
    text += "next  record " + subject.trace + " anew with this build: only ticks before the difference were examined\n";
  for (const std::string& step : next_steps(report)) text += "next  " + step + "\n";
  return text;
}

std::string shake_json(const ShakeReport& report, const ShakeSubject& subject) {
  Json object;
  object["schema"] = "ticktrue.shake/2";
  object["file"] = subject.trace;
  object["command"] = subject.words;
  object["ticks"] = subject.tick_count;
  object["verdict"] = verdict_name(report, subject);
  object["exit_code"] = exit_code(report, subject);
  object["reason"] = report.failure;
  object["runs"] = report.run_count;
  object["wall_s"] = report.wall_s;
  object["ended_early"] = report.ended_early;
  object["control"] = Json::array();
  for (const Outcome& outcome : report.control) object["control"].push_back(outcome_json(outcome));
  object["repeats"] = report.repeats;
  object["fixed_by"] = report.fix.names;
  object["not_tried"] = report.fix.not_tried;
  object["not_tried_reason"] = report.fix.not_tried.empty() ? "" : report.no_shim;
  object["fixed_call"] = cause_json(report.fix.cause);
  object["instructions"] = report.instructions;
  object["together"] = report.together;
  object["moved"] = {
      {"A", report.moved_count(Kind::a)}, {"B", report.moved_count(Kind::b)}, {"C", report.moved_count(Kind::c)}};
  object["not_applicable"] = report.count(RowState::not_applicable);
  object["perturbations"] = Json::array();
  for (const RowResult& row : report.rows) object["perturbations"].push_back(row_json(row));
  object["notes"] = report.notes;
  object["next"] = next_steps(report);
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// --- JUnit XML and workflow commands ---

namespace {

std::string row_text(const RowResult& row) {
  std::string text = std::string(row.choice.perturbation->name) + ": " + outcome_text(row.outcome);
  if (row.cause && row.cause->failure.empty()) text += "; cause: " + row.cause->text();
  return text;
}

bool is_failure(const RowResult& row, const ShakeSubject& subject) {
  if (row.state != RowState::moved) return false;
  const Kind kind = row.choice.perturbation->kind;
  return kind == Kind::a || (kind == Kind::b && subject.fails_for_b);
}

std::string unstable_text(const ShakeReport& report) {
  std::string text = "the program does not repeat itself";
  const char* label = report.fix.not_tried.empty() ? "; cause: " : "; cause, not certain: ";
  for (const std::string& name : report.fix.names) text += label + name;
  if (report.fix.cause && report.fix.cause->failure.empty()) text += ", " + report.fix.cause->text();
  return text;
}

}  // namespace

std::string shake_junit(const ShakeReport& report, const ShakeSubject& subject) {
  std::string cases;
  std::size_t failures = 0;
  std::size_t errors = 0;
  std::size_t skipped = 0;
  const auto add = [&](std::string_view name, const std::string& inside) {
    cases += "    <testcase classname=\"" + verifier::xml_text(subject.trace) + "\" name=\"" +
             verifier::xml_text(name) + "\"";
    cases += inside.empty() ? "/>\n" : ">" + inside + "</testcase>\n";
  };
  std::string control;
  if (!report.failure.empty()) {
    control = "<error message=\"" + verifier::xml_text(report.failure) + "\"/>";
    ++errors;
  } else if (!report.repeats) {
    control = "<failure message=\"" + verifier::xml_text(unstable_text(report)) + "\"/>";
    ++failures;
  }
  add("control", control);
  for (const RowResult& row : report.rows) {
    std::string inside;
    if (is_failure(row, subject)) {
      inside = "<failure message=\"" + verifier::xml_text(row_text(row)) + "\"/>";
      ++failures;
    } else if (row.state == RowState::not_applicable || row.state == RowState::not_run) {
      inside = "<skipped message=\"" + verifier::xml_text(row.reason) + "\"/>";
      ++skipped;
    }
    add(row.choice.perturbation->name, inside);
  }
  const std::string counts = "tests=\"" + std::to_string(report.rows.size() + 1) + "\" failures=\"" +
                             std::to_string(failures) + "\" errors=\"" + std::to_string(errors) + "\" skipped=\"" +
                             std::to_string(skipped) + "\"";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n  <testsuite name=\"shake\" " + counts + ">\n" +
         cases + "  </testsuite>\n</testsuites>\n";
}

std::string shake_github(const ShakeReport& report, const ShakeSubject& subject) {
  std::string lines;
  if (!report.failure.empty()) lines += "::error title=shake::" + verifier::github_text(report.failure, false) + "\n";
  if (report.failure.empty() && !report.repeats)
    lines += "::error title=shake::" + verifier::github_text(unstable_text(report), false) + "\n";
  for (const RowResult& row : report.rows)
    if (row.state == RowState::moved)
      lines += std::string(is_failure(row, subject) ? "::error" : "::warning") +
               " title=shake::" + verifier::github_text(row_text(row), false) + "\n";
  return lines;
}

}  // namespace ticktrue::shake
