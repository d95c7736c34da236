// The page of `ticktrue corpus report`: counts, a table of the traces, and the page of the worst one.
// SPDX-License-Identifier: MIT
//
// Verified: text from traces and file names is escaped. The page loads nothing. The page of the worst trace is a frame
// of its own, without access to what is around it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "base/build_info.h"
#include "tool/cli/upkeep/corpus_commands.h"
#include "tool/report_page/report_page.h"
#include "verifier/report/report_ci.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

using tool::CorpusUnit;
using tool::html_text;

constexpr std::size_t match_row_count_max = 1000;  // the page stays below a megabyte

constexpr std::string_view page_head = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>ticktrue corpus</title><style>
:root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:2em auto;max-width:72em;padding:0 1em}
h1{font-size:1.4em}table{border-collapse:collapse;width:100%}td,th{text-align:left;padding:.2em .8em .2em 0;
border-bottom:1px solid #8884;vertical-align:top}td.n,th.n{text-align:right}.bad{color:#c22;font-weight:600}
.ok{color:#080}iframe{width:100%;height:60em;border:1px solid #8888}code{font-size:.85em}.wide{overflow-x:auto}
@media(prefers-color-scheme:dark){.bad{color:#f77}.ok{color:#6d6}}
</style></head><body>
)";

bool is_ok(const CorpusUnit& unit, bool allow_truncated) {
  return unit.problems.empty() && unit.report.exit_code(allow_truncated) == exit_ok;
}

std::string count_row(std::string_view name, std::size_t count, bool is_good) {
  return fmt::format("<tr><th scope=row>{}<td class=\"n {}\">{}\n", html_text(name), is_good ? "ok" : "bad", count);
}

std::string summary(const std::vector<CorpusUnit>& units, bool allow_truncated) {
  std::string text = "<table id=counts>\n";
  for (const verifier::VerdictInfo& info : verifier::verdicts) {
    const auto count = std::count_if(units.begin(), units.end(), [&](const CorpusUnit& unit) {
      return unit.report.verdict == info.verdict && unit.source != tool::UnitSource::missing;
    });
    const bool is_good = info.exit_code == exit_ok || (allow_truncated && info.exit_code == exit_incomplete);
    if (count > 0) text += count_row(info.name, static_cast<std::size_t>(count), is_good);
  }
  const auto missing = std::count_if(units.begin(), units.end(),
                                     [](const CorpusUnit& unit) { return unit.source == tool::UnitSource::missing; });
  if (missing > 0) text += count_row("no verdict", static_cast<std::size_t>(missing), false);
  return text + "</table>\n";
}

std::string unit_row(const CorpusUnit& unit, bool allow_truncated) {
  const verifier::Report& report = unit.report;
  const bool is_missing = unit.source == tool::UnitSource::missing;
  const std::string what = report.divergence ? verifier::report_sentence(report) : report.reason;
  const std::string recorded = report.ticks_recorded ? std::to_string(*report.ticks_recorded) : "?";
  return fmt::format("<tr><td class={}>{}<td>{}<td class=n>{} of {}<td class=n>{:.3f}<td>{}<td><code>{}</code>\n",
                     is_ok(unit, allow_truncated) ? "ok" : "bad",
                     html_text(is_missing ? "no verdict" : verifier::verdict_info(report.verdict).name),
                     html_text(report.file), report.ticks_compared, recorded, report.wall_s, html_text(what),
                     html_text(unit.key));
}

/// What is not as it should be first, then the slowest.
std::vector<const CorpusUnit*> in_order(const std::vector<CorpusUnit>& units, bool allow_truncated) {
  std::vector<const CorpusUnit*> order;
  for (const CorpusUnit& unit : units) order.push_back(&unit);
  std::stable_sort(order.begin(), order.end(), [&](const CorpusUnit* a, const CorpusUnit* b) {
    const bool is_a_ok = is_ok(*a, allow_truncated), is_b_ok = is_ok(*b, allow_truncated);
    if (is_a_ok != is_b_ok) return is_b_ok;
    return is_a_ok && a->report.wall_s > b->report.wall_s;
  });
  return order;
}

std::string table(const std::vector<CorpusUnit>& units, bool allow_truncated) {
  std::string text =
      "<h2>Traces</h2>\n<div class=wide><table id=traces>\n"
      "<tr><th>verdict<th>trace<th class=n>ticks<th class=n>seconds<th>reason<th>key\n";
  std::size_t match_count = 0;
  for (const CorpusUnit* unit : in_order(units, allow_truncated))
    if (!is_ok(*unit, allow_truncated) || ++match_count <= match_row_count_max)
      text += unit_row(*unit, allow_truncated);
  text += "</table></div>\n";
  if (match_count > match_row_count_max)
    text += fmt::format("<p>{} more match and took less time.</p>\n", match_count - match_row_count_max);
  return text;
}

/// A page as the value of an attribute.
std::string attribute_value(std::string_view page) {
  std::string value;
  for (const char c : page) {
    if (c == '&')
      value += "&amp;";
    else if (c == '"')
      value += "&quot;";
    else
      value += c;
  }
  return value;
}

/// The trace with the worst exit code of those that have a verdict; null: all are as they should be.
const CorpusUnit* worst_unit(const std::vector<CorpusUnit>& units, bool allow_truncated) {
  std::vector<int> codes;
  for (const CorpusUnit& unit : units)
    if (unit.source != tool::UnitSource::missing) codes.push_back(unit.report.exit_code(allow_truncated));
  const int worst = worst_exit_code(codes);
  if (worst == exit_ok) return nullptr;
  for (const CorpusUnit& unit : units)
    if (unit.source != tool::UnitSource::missing && unit.report.exit_code(allow_truncated) == worst) return &unit;
  return nullptr;
}

std::string worst_page(const CorpusUnit& unit, bool allow_truncated) {
  tool::PageOptions options;
  options.allow_truncated = allow_truncated;
  options.command = "ticktrue report " + verifier::shell_word(unit.report.file);
  const Result<tool::Page> page = tool::make_report_page(unit.report, options);
  const std::string title = "<h2>The worst: " + html_text(unit.report.file) + "</h2>\n";
  if (!page) return title + "<p>" + html_text(page.error().message) + "</p>\n";
  return title + "<iframe id=worst title=\"the worst trace\" sandbox=allow-scripts srcdoc=\"" +
         attribute_value(page->html) + "\"></iframe>\n";
}

}  // namespace

Status write_corpus_page(const std::vector<CorpusUnit>& units, const tool::BuildSubject& build,
                         const CorpusPage& page) {
  auto file = verifier::DataFile::create(page.path, true);
  if (!file) return file.error();
  std::string html(page_head);
  const CorpusUnit* worst = worst_unit(units, page.allow_truncated);
  const auto bad_count = std::count_if(units.begin(), units.end(),
                                       [&](const CorpusUnit& unit) { return !is_ok(unit, page.allow_truncated); });
  html += fmt::format("<h1 class={}>{} of {} traces are as recorded</h1>\n", bad_count == 0 ? "ok" : "bad",
                      units.size() - static_cast<std::size_t>(bad_count), units.size());
  html += "<p>" + html_text(build_line()) + "; engine <code>" + hex128(build.engine) + "</code>; " +
          html_text(build.options) + "; store " + html_text(page.store) + "</p>\n";
  html += summary(units, page.allow_truncated);
  if (worst != nullptr) html += worst_page(*worst, page.allow_truncated);
  html += table(units, page.allow_truncated) + "</body></html>\n";
  const Status written = file->write(html);
  return written ? file->close() : written;
}

}  // namespace ticktrue::cli
