// JUnit XML and workflow commands of a shake.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/shake_report.h"
#include "verifier/report/report_ci.h"

namespace ticktrue::shake {
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
  for (const std::string& name : report.fix.names) text += "; cause: " + name;
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
