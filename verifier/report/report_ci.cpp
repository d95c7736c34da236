// Writes JUnit XML, workflow commands and Markdown.
// Source: JUnit XML as Jenkins and GitLab read it (testmoapp/junitxml, "JUnit XML format"); GitHub Docs, "Workflow
// commands for GitHub Actions" (escapes, parameters).
// SPDX-License-Identifier: MIT
#include "verifier/report/report_ci.h"

#include <algorithm>
#include <cstdio>

#include "base/build_info.h"
#include "base/plain_text.h"
#include "verifier/report/content_text.h"

namespace ticktrue::verifier {
namespace {

std::string markdown_cell(std::string_view text) {
  std::string safe;
  for (const char c : plain_line(text)) {
    if (c == '|' || c == '\\' || c == '`' || c == '<') safe += '\\';
    safe += c;
  }
  return safe;
}

/// A finding is a failure of the test. A trace that could not be judged is an error.
enum class Outcome { passed, failure, error };
Outcome outcome_of(const Report& report, bool allow_truncated) {
  switch (report.exit_code(allow_truncated)) {
    case exit_ok:
      return Outcome::passed;
    case exit_finding:
    case exit_not_reproducible:
    case exit_incomplete:
      return Outcome::failure;
    default:
      return Outcome::error;
  }
}

std::string seconds_text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f", value);
  return text;
}

std::size_t count_of(std::span<const Report> reports, bool allow_truncated, Outcome outcome) {
  return static_cast<std::size_t>(std::count_if(reports.begin(), reports.end(), [&](const Report& report) {
    return outcome_of(report, allow_truncated) == outcome;
  }));
}

}  // namespace

std::string xml_text(std::string_view text) {
  std::string safe;
  for (const char c : plain_text(text)) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '"')
      safe += "&quot;";
    else if (c == '\n')
      safe += "&#10;";
    else
      safe += byte < 0x20 || byte >= 0x7f ? '?' : c;  // XML or the encoding of the file name may refuse others
  }
  return safe;
}

std::string github_text(std::string_view text, bool is_parameter) {
  std::string safe;
  for (const char c : plain_text(text)) {
    if (c == '%')
      safe += "%25";
    else if (c == '\r')
      safe += "%0D";
    else if (c == '\n')
      safe += "%0A";
    else if (is_parameter && c == ':')
      safe += "%3A";
    else if (is_parameter && c == ',')
      safe += "%2C";
    else
      safe += c;
  }
  return safe;
}

std::string report_sentence(const Report& report) {
  if (!report.divergence)
    return report.reason.empty() ? std::string(verdict_info(report.verdict).summary) : report.reason;
  const Divergence& divergence = *report.divergence;
  std::string text = "tick " + std::to_string(divergence.tick);
  if (report.ticks_recorded) text += " of " + std::to_string(*report.ticks_recorded);
  if (divergence.stage) text += ", stage " + *divergence.stage;
  if (!report.reason.empty()) text += ": " + report.reason;
  if (!divergence.rows.empty()) {
    const LaneReport& row = divergence.rows.front();
    text += ": " + row.table + "." + row.column + " of row " + std::to_string(row.row);
    if (!row.name.empty()) text += " (" + row.name + ")";
    if (row.expected && row.got)
      text += ": expected " + lane_hex(row.type, *row.expected) + ", got " + lane_hex(row.type, *row.got);
    if (divergence.lane_count > 1) text += ", and " + std::to_string(divergence.lane_count - 1) + " more lanes";
  } else if (!divergence.contents.empty()) {
    const ContentReport& content = divergence.contents.front();
    text += ": " + content_place(content) + ": " + content_values(content, "expected", "got");
    if (divergence.content_count > 1) text += ", and " + std::to_string(divergence.content_count - 1) + " more texts";
  } else if (!divergence.tables.empty()) {
    text += ": " + divergence.tables.front().table;
    if (divergence.tables.front().is_content) return text;
    for (const std::string& column : divergence.tables.front().columns)
      text += (column == divergence.tables.front().columns.front() ? "." : ", ") + column;
  }
  return text;
}

std::string report_junit(std::span<const Report> reports, bool allow_truncated) {
  double all_s = 0;
  for (const Report& report : reports) all_s += report.wall_s;
  const std::string counts = "tests=\"" + std::to_string(reports.size()) + "\" failures=\"" +
                             std::to_string(count_of(reports, allow_truncated, Outcome::failure)) + "\" errors=\"" +
                             std::to_string(count_of(reports, allow_truncated, Outcome::error)) +
                             "\" skipped=\"0\" time=\"" + seconds_text(all_s) + "\"";
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"ticktrue\" " + counts +
                     ">\n  <testsuite name=\"ticktrue verify\" " + counts +
                     ">\n    <properties>\n      <property name=\"build\" value=\"" + xml_text(build_line()) +
                     "\"/>\n    </properties>\n";
  for (const Report& report : reports) {
    text += "    <testcase classname=\"ticktrue." + xml_text(report.mode.empty() ? "verify" : report.mode) +
            "\" name=\"" + xml_text(report.file) + "\" time=\"" + seconds_text(report.wall_s) + "\"";
    const Outcome outcome = outcome_of(report, allow_truncated);
    if (outcome == Outcome::passed && report.warnings.empty()) {
      text += "/>\n";
      continue;
    }
    text += ">\n";
    if (outcome != Outcome::passed) {
      const std::string element = outcome == Outcome::failure ? "failure" : "error";
      text += "      <" + element + " type=\"" + std::string(verdict_info(report.verdict).name) + "\" message=\"" +
              xml_text(report_sentence(report)) + "\">" + xml_text(report_text(report)) + "</" + element + ">\n";
    }
    for (const std::string& warning : report.warnings)
      text += "      <system-out>" + xml_text("warning: " + warning) + "</system-out>\n";
    text += "    </testcase>\n";
  }
  return text + "  </testsuite>\n</testsuites>\n";
}

std::string report_github(std::span<const Report> reports, bool allow_truncated) {
  std::string text;
  for (const Report& report : reports) {
    const std::string place = "file=" + github_text(report.file, true) + ",title=";
    if (outcome_of(report, allow_truncated) != Outcome::passed)
      text += "::error " + place + github_text("ticktrue: " + std::string(verdict_info(report.verdict).name), true) +
              "::" + github_text(report_sentence(report) + "\n" + report_text(report), false) + "\n";
    for (const std::string& warning : report.warnings)
      text += "::warning " + place + "ticktrue::" + github_text(warning, false) + "\n";
  }
  return text;
}

std::string report_markdown(std::span<const Report> reports, bool allow_truncated) {
  const std::size_t passed = count_of(reports, allow_truncated, Outcome::passed);
  std::string text = "### ticktrue verify: " + std::to_string(passed) + " of " + std::to_string(reports.size()) +
                     " traces pass\n\n" + markdown_cell(build_line()) + "\n\n";
  if (passed == reports.size()) return text;
  text += "| trace | verdict | where |\n|---|---|---|\n";
  for (const Report& report : reports)
    if (outcome_of(report, allow_truncated) != Outcome::passed)
      text += "| " + markdown_cell(report.file) + " | " + std::string(verdict_info(report.verdict).name) + " | " +
              markdown_cell(report_sentence(report)) + " |\n";
  return text + "\n";
}

}  // namespace ticktrue::verifier
