// Each finding is a thing and the first column that it moves.
// SPDX-License-Identifier: MIT
#include "tool/experiment/unsaved/unsaved_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/count_text.h"
#include "base/plain_text.h"
#include "verifier/report/exit_codes.h"

namespace ticktrue::unsaved {
namespace {

constexpr std::size_t columns_shown_max = 4;
constexpr std::size_t things_shown_max = 4;
constexpr std::size_t harmless_shown_max = 12;

class Lines {
 public:
  void add(std::string label, const std::string& content) {
    if (label.size() < 9) label.resize(9, ' ');
    text_ += "  " + label + " " + plain_line(content) + "\n";
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string columns_text(const std::vector<std::string>& columns) {
  std::string text;
  for (std::size_t i = 0; i < std::min(columns.size(), columns_shown_max); ++i)
    text += (i > 0 ? ", " : "") + columns[i];
  if (columns.size() > columns_shown_max) text += " and " + count_text(columns.size() - columns_shown_max, "other");
  return text;
}

void add_finding(const UnsavedFinding& finding, Lines& lines) {
  for (std::size_t i = 0; i < std::min(finding.things.size(), things_shown_max); ++i) {
    const Thing& thing = finding.things[i];
    const std::string label = i > 0 ? "" : name_of(thing.kind);
    lines.add(label, (i > 0 ? (finding.is_joint ? "and " : "with ") : "") + thing.text());
  }
  if (finding.things.size() > things_shown_max)
    lines.add("", "and " + count_text(finding.things.size() - things_shown_max, "more thing") + " (--json has all)");
  lines.add("", std::string(finding.is_joint ? "together they first move " : "first moves ") +
                    columns_text(finding.columns) + " at tick " + std::to_string(finding.tick));
}

nlohmann::ordered_json thing_json(const Thing& thing) {
  return {{"kind", name_of(thing.kind)},
          {"name", thing.name},
          {"file", plain_line(thing.file)},
          {"line", thing.line},
          {"function", thing.function},
          {"holder", thing.holder},
          {"module", plain_line(thing.module)},
          {"size", thing.size},
          {"first_byte", thing.first},
          {"last_byte", thing.last},
          {"text", thing.text()}};
}

nlohmann::ordered_json findings_json(const std::vector<UnsavedFinding>& findings) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const UnsavedFinding& finding : findings) {
    nlohmann::ordered_json things = nlohmann::ordered_json::array();
    for (const Thing& thing : finding.things) things.push_back(thing_json(thing));
    list.push_back({{"things", std::move(things)},
                    {"joint", finding.is_joint},
                    {"columns", finding.columns},
                    {"tick", finding.tick},
                    {"save", finding.window}});
  }
  return list;
}

std::string headline(const UnsavedReport& report, const std::string& trace) {
  const std::string file = "  " + plain_line(trace) + "  ";
  const std::string extent = count_text(report.tick_count, "tick") + ", " + count_text(report.window_count, "save") +
                             " loaded, " + count_text(report.trial_count, "trial");
  switch (report.verdict) {
    case UnsavedVerdict::found:
      return "unsaved" + file + extent;
    case UnsavedVerdict::not_reproducible:
      return "not_reproducible" + file + extent;
    case UnsavedVerdict::nothing:
      break;
  }
  return "nothing unsaved moves a column" + file + extent;
}

}  // namespace

int exit_code(const UnsavedReport& report) {
  switch (report.verdict) {
    case UnsavedVerdict::found:
      return verifier::exit_finding;
    case UnsavedVerdict::not_reproducible:
      return verifier::exit_not_reproducible;
    case UnsavedVerdict::nothing:
      break;
  }
  return verifier::exit_ok;
}

std::string unsaved_text(const UnsavedReport& report, const std::string& trace) {
  Lines lines;
  for (const UnsavedFinding& finding : report.findings) add_finding(finding, lines);
  for (const UnsavedFinding& finding : report.not_loaded)
    lines.add("column", columns_text(finding.columns) + ": load does not bring back what it was at tick " +
                            std::to_string(finding.tick));
  for (const UnsavedFinding& finding : report.unexplained)
    lines.add("unknown", columns_text(finding.columns) + " at tick " + std::to_string(finding.tick) +
                             ": moved by nothing in the memory that was compared: a file, a register, a library");
  for (std::size_t i = 0; i < std::min(report.harmless.size(), harmless_shown_max); ++i)
    lines.add(i == 0 ? "harmless" : "", report.harmless[i].text());
  if (report.harmless.size() > harmless_shown_max)
    lines.add("", "and " + count_text(report.harmless.size() - harmless_shown_max, "other") + " (--json has all)");
  for (const std::string& note : report.notes) lines.add("note", note);
  std::string text = headline(report, trace) + "\n" + lines.take();
  for (const std::string& step : report.next) text += "next  " + plain_line(step) + "\n";
  return text;
}

std::string unsaved_json(const UnsavedReport& report, const std::string& trace) {
  nlohmann::ordered_json json{{"schema", "ticktrue.unsaved/1"},      {"verdict", name_of(report.verdict)},
                              {"trace", plain_line(trace)},          {"ticks", report.tick_count},
                              {"saves_loaded", report.window_count}, {"trials", report.trial_count}};
  json["findings"] = findings_json(report.findings);
  json["not_loaded"] = findings_json(report.not_loaded);
  json["unexplained"] = findings_json(report.unexplained);
  nlohmann::ordered_json harmless = nlohmann::ordered_json::array();
  for (const Thing& thing : report.harmless) harmless.push_back(thing_json(thing));
  json["harmless"] = std::move(harmless);
  json["notes"] = report.notes;
  json["next"] = report.next;
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace ticktrue::unsaved
