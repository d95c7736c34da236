// Writes a report as text for people: a headline, and indented lines with a label each.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "base/build_info.h"
#include "base/count_text.h"
#include "base/hash.h"
#include "base/plain_text.h"
#include "verifier/report/content_text.h"
#include "verifier/report/fact_differences.h"
#include "verifier/report/likely_causes.h"
#include "verifier/report/report.h"

namespace ticktrue::verifier {
namespace {

constexpr char hex_digits[] = "0123456789abcdef";

}  // namespace

std::string content_side(bool is_text, std::uint64_t first, std::uint64_t offset,
                         const std::optional<ContentSide>& side) {
  if (!side) return "no such row";
  const auto& [bytes, size] = *side;
  if (size == 0) return is_text ? "\"\"" : "nothing";
  if (!is_text) {
    if (offset >= size) return "ends before it";
    const std::size_t skipped =
        static_cast<std::size_t>(std::min<std::uint64_t>(offset - std::min(first, offset), bytes.size()));
    const std::string_view behind = std::string_view(bytes).substr(skipped);
    return hex_bytes(behind) + (offset + std::min(behind.size(), hex_bytes_max) < size ? " ..." : "");
  }
  return (first > 0 ? "..." : "") + verifier::quoted(bytes) + (first + bytes.size() < size ? "..." : "");
}

std::size_t utf8_size(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t size = lead >= 0xc2 && lead < 0xe0   ? 2
                           : lead >= 0xe0 && lead < 0xf0 ? 3
                           : lead >= 0xf0 && lead < 0xf5 ? 4
                                                         : 0;
  if (size == 0 || size > text.size()) return 0;
  for (std::size_t i = 1; i < size; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  // Overlong encodings, surrogates, and values above U+10FFFF.
  if ((lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xed && byte(1) > 0x9f) || (lead == 0xf0 && byte(1) < 0x90) ||
      (lead == 0xf4 && byte(1) > 0x8f))
    return 0;
  return size;
}

std::string quoted(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const std::size_t size = utf8_size(text);
    const auto byte = static_cast<unsigned char>(text[0]);
    if (byte == '"' || byte == '\\') {
      out += '\\';
      out += text[0];
    } else if (byte == '\n') {
      out += "\\n";
    } else if (byte == '\t') {
      out += "\\t";
    } else if (size == 0 || byte < 0x20 || byte == 0x7f) {
      out += "\\x";
      out += hex_digits[byte >> 4];
      out += hex_digits[byte & 15];
    } else {
      out += text.substr(0, size);
    }
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
  return out + "\"";
}

std::string hex_bytes(std::string_view bytes) {
  std::string text;
  for (const char c : bytes.substr(0, hex_bytes_max)) {
    const auto byte = static_cast<unsigned char>(c);
    if (!text.empty()) text += ' ';
    text += hex_digits[byte >> 4];
    text += hex_digits[byte & 15];
  }
  return text;
}

std::string hex_text(std::string_view bytes) {
  std::string text;
  for (const char c : bytes) {
    text += hex_digits[static_cast<unsigned char>(c) >> 4];
    text += hex_digits[static_cast<unsigned char>(c) & 15];
  }
  return text;
}

std::optional<std::string> bytes_of_hex(std::string_view text) {
  const auto digit = [](char c) { return std::string_view(hex_digits).find(c); };
  if (text.size() % 2 != 0) return std::nullopt;
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); i += 2) {
    if (digit(text[i]) > 15 || digit(text[i + 1]) > 15) return std::nullopt;
    bytes += static_cast<char>(digit(text[i]) << 4 | digit(text[i + 1]));
  }
  return bytes;
}

std::string content_place(const std::string& place, std::optional<std::uint64_t> id, const std::string& name) {
  std::string text = place;
  if (!id && name.empty()) return text;
  text += "  (";
  if (id) text += "id " + std::to_string(*id);
  if (id && !name.empty()) text += ", ";
  if (!name.empty()) text += "name \"" + name + "\"";
  return text + ")";
}

std::string content_place(const ContentReport& content) {
  return content_place(content.place, content.id, content.name);
}

std::string content_values(const ContentReport& content, const std::string& expected_name,
                           const std::string& got_name) {
  const auto side = [&](const std::optional<std::string>& bytes, std::uint64_t size) {
    return content_side(content.is_text, content.first, content.offset,
                        bytes ? std::optional(ContentSide{*bytes, size}) : std::nullopt);
  };
  std::string text = expected_name + " " + side(content.expected, content.expected_size) + ".  " + got_name + " " +
                     side(content.got, content.got_size) + ".";
  if (!content.expected || !content.got) return text;
  text += content.character ? "  differs at character " + std::to_string(*content.character)
                            : "  differs at byte " + std::to_string(content.offset);
  if (content.expected_size != content.got_size)
    text += "; " + std::to_string(content.expected_size) + " and " + std::to_string(content.got_size) + " bytes";
  else if (!content.is_text)
    text += " of " + std::to_string(content.expected_size);
  return text;
}

namespace {

constexpr std::size_t rows_shown_max = 8;
constexpr std::size_t inputs_shown_max = 8;

std::string seconds(double time_s) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f s", time_s);
  return text;
}

/// Indented lines, each with a label.
class Lines {
 public:
  void add(std::string label, const std::string& content) {
    if (label.size() < 7) label.resize(7, ' ');
    text_ += "  " + label + " ";
    // Names and notes come from the file: they must not control a terminal.
    text_ += plain_line(content) + "\n";
  }
  /// Adds at most `shown_max` lines, and the number of further lines.
  void add_inputs(const std::string& inputs, std::size_t shown_max) {
    const std::vector<std::string> lines = split_lines(inputs);
    for (std::size_t i = 0; i < std::min(lines.size(), shown_max); ++i) add("input", lines[i]);
    if (lines.size() > shown_max) add("", "and " + count_text(lines.size() - shown_max, "more input"));
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

std::string of_recorded(const Report& report) {
  return report.ticks_recorded ? " of " + std::to_string(*report.ticks_recorded) : "";
}

std::string headline(const Report& report) {
  std::string text(verdict_info(report.verdict).name);
  if (!report.file.empty()) text += "  " + plain_line(report.file);
  if (report.divergence)
    return text + "  tick " + std::to_string(report.divergence->tick) + of_recorded(report) + " (" +
           seconds(report.divergence->time_s) + ")";
  if (!report.ticks_recorded && report.ticks_compared == 0) return text;
  return text + "  " + std::to_string(report.ticks_compared) + of_recorded(report) + " ticks compared (" +
         seconds(report.time_s) + ")";
}

std::string lane_name(const LaneReport& row) {
  std::string text = row.place.empty() ? "row " + std::to_string(row.row) : row.place;
  const bool has_id = row.id && row.place.empty();  // the place of a list element already names its owner
  if (has_id || !row.name.empty()) {
    text += " (";
    if (has_id) text += "id " + std::to_string(*row.id);
    if (has_id && !row.name.empty()) text += ", ";
    if (!row.name.empty()) text += "name \"" + row.name + "\"";
    text += ")";
  }
  if (row.lane_count > 1) text += ", lane " + std::to_string(row.lane);
  return text;
}

std::string value_text(const LaneReport& row, const std::optional<std::uint64_t>& bits) {
  return bits ? lane_hex(row.type, *bits) + " (" + lane_text(row.type, *bits) + ")" : "no such row";
}

std::string values(const LaneReport& row, const std::string& expected_name, const std::string& got_name) {
  std::string text =
      expected_name + " " + value_text(row, row.expected) + ".  " + got_name + " " + value_text(row, row.got);
  if (row.expected && row.got)
    if (const auto ulp = ulp_distance(row.type, *row.expected, *row.got)) text += ".  " + std::to_string(*ulp) + " ulp";
  return text;
}

std::string candidate_name(const Candidate& candidate) {
  std::string text =
      candidate.place.empty() ? candidate.table + " row " + std::to_string(candidate.row) : candidate.place;
  const bool has_id = candidate.id && candidate.place.empty();
  if (!has_id && candidate.name.empty()) return text;
  text += " (";
  if (has_id) text += "id " + std::to_string(*candidate.id);
  if (has_id && !candidate.name.empty()) text += ", ";
  if (!candidate.name.empty()) text += "name \"" + candidate.name + "\"";
  return text + ")";
}

/// Adds the rows that can have differed, according to the cells.
void add_candidates(const Divergence& divergence, const std::string& expected_name, const std::string& got_name,
                    Lines& lines) {
  for (const RowCountDifference& table : divergence.row_counts)
    lines.add("rows", table.table + ": " + expected_name + " " + std::to_string(table.expected) + ", " + got_name +
                          " " + std::to_string(table.got));
  if (!divergence.from_cells) return;
  for (std::size_t i = 0; i < std::min(divergence.candidates.size(), rows_shown_max); ++i)
    lines.add("where", candidate_name(divergence.candidates[i]));
  const std::size_t shown = std::min(divergence.candidates.size(), rows_shown_max);
  if (divergence.candidate_count > shown)
    lines.add("", "and " + count_text(divergence.candidate_count - shown, "more row") + " (--json lists the first)");
  if (divergence.owner_count == 0) return;
  std::string text = std::to_string(divergence.candidate_count) + " of " + count_text(divergence.owner_count, "row") +
                     " can have differed, with the rows that refer to them";
  if (divergence.candidate_count == 0 && divergence.unexplained_cells == 0)
    text = "every row has the values it should have: rows stand in another order";
  else if (divergence.unexplained_cells > 0)
    text += "; " + count_text(divergence.unexplained_cells, "cell") + " differ" +
            (divergence.unexplained_cells == 1 ? "s" : "") + " by a row that is not there";
  lines.add("", text);
}

/// Adds the spread 1, 2, 4, 8, ... ticks after the divergence, and at the last examined tick.
void add_spread(const Divergence& divergence, Lines& lines) {
  std::string text;
  for (const Spread& spread : divergence.spread) {
    text += text.empty() ? "" : "; ";
    text += "tick " + std::to_string(spread.tick) + ": ";
    if (spread.row_count == 0)
      text += "none";
    else if (spread.row_count == spread.of)
      text += "all of " + std::to_string(spread.of);
    else
      text += (spread.estimated && spread.row_count > 4 ? "about " : "") + std::to_string(spread.row_count) + " of " +
              std::to_string(spread.of);
  }
  if (!text.empty()) lines.add("spread", text);
}

void add_divergence(const Divergence& divergence, const std::string& expected_name, const std::string& got_name,
                    Lines& lines) {
  constexpr std::size_t column_width = 16;
  const auto padded = [](std::string text) {
    if (text.size() < column_width) text.resize(column_width, ' ');
    return text + "  ";
  };
  if (divergence.stage)
    lines.add("stage", padded(*divergence.stage) + divergence.stage_note);
  else if (!divergence.stage_note.empty())
    lines.add("stage", divergence.stage_note);

  if (divergence.rows.empty() && divergence.tables.empty())
    lines.add("column", divergence.from_cells ? "none: the hash of every column agrees"
                        : divergence.expected_root == divergence.got_root && divergence.got_root != 0
                            ? "none: the state at the end of the tick agrees"
                            : "not known: the trace stores only a hash of this tick");
  for (const TableDifference& table : divergence.tables) {
    std::string columns;
    for (const std::string& column : table.columns)
      columns += (columns.empty() ? "" : ", ") + table.table + "." + column;
    if (table.is_content) columns = table.table;
    // With one column and one lane, or one text, the next line has all the information.
    if (divergence.lane_count + divergence.content_count != 1) lines.add("columns", columns);
  }
  for (std::size_t i = 0; i < divergence.rows.size() && i < rows_shown_max; ++i) {
    const LaneReport& row = divergence.rows[i];
    lines.add("column", padded(row.table + "." + row.column) + lane_name(row));
    lines.add("value", values(row, expected_name, got_name));
  }
  for (std::size_t i = 0; i < divergence.contents.size() && i < rows_shown_max; ++i) {
    const ContentReport& content = divergence.contents[i];
    lines.add(content.is_text ? "text" : "bytes", content_place(content));
    lines.add("value", content_values(content, expected_name, got_name));
  }
  add_candidates(divergence, expected_name, got_name, lines);
  const std::size_t shown = std::min(divergence.rows.size(), rows_shown_max);
  if (divergence.lane_count > shown)
    lines.add("", "and " + count_text(divergence.lane_count - shown, "more lane") + " (--json lists the first)");
  const std::size_t contents_shown = std::min(divergence.contents.size(), rows_shown_max);
  if (divergence.content_count > contents_shown)
    lines.add(
        "", "and " + count_text(divergence.content_count - contents_shown, "more text") + " (--json lists the first)");
  if (divergence.expected_root != divergence.got_root)
    lines.add("hash", expected_name + " " + hex64(divergence.expected_root) + ".  " + got_name + " " +
                          hex64(divergence.got_root));

  lines.add_inputs(divergence.inputs, inputs_shown_max);
  add_spread(divergence, lines);
}

/// Adds the first difference of marks, in the diverged tick or an earlier one.
void add_marks(const Report& report, Lines& lines) {
  if (!report.marks) {
    if (report.compared.marks > 0)
      lines.add("marks", "as recorded, in " + count_text(report.compared.marks, "tick") + " up to this one");
    return;
  }
  const std::uint64_t tick = report.marks->tick;
  const std::uint64_t diverged = report.divergence->tick;
  lines.add("marks", "differ first " +
                         (tick >= diverged ? std::string("in this tick")
                                           : "at tick " + std::to_string(tick) + ", " +
                                                 count_text(diverged - tick, "tick") + " before") +
                         ": " + marks_text(*report.marks));
}

std::string range_text(const replay::IntactRange& range) {
  return "ticks " + std::to_string(range.first_tick) + ".." + std::to_string(range.last_tick) +
         (range.has_checkpoint ? " (with a checkpoint)" : "");
}

void add_end(const Report& report, Lines& lines) {
  const replay::TraceTail& tail = report.end->tail;
  if (tail.condition == replay::TraceCondition::complete) {
    if (!tail.end) return;
    for (const replay::EndReasonInfo& info : replay::end_reasons)
      if (info.reason == tail.end->reason && info.reason != replay::EndReason::complete)
        lines.add("end", std::string(info.name) + ": " + std::string(info.summary) +
                             (tail.end->note.empty() ? "" : " (" + tail.end->note + ")"));
    return;
  }
  lines.add("end", std::string(tail.condition == replay::TraceCondition::damaged ? "damaged" : "cut off") +
                       (tail.message.empty() ? "" : ": " + tail.message));
  lines.add("proven", tail.ticks_intact == 0
                          ? std::string("no tick is intact")
                          : "last good tick " + std::to_string(tail.ticks_intact - 1) + ": ticks 0.." +
                                std::to_string(tail.ticks_intact - 1) + " are intact");
  if (report.end->salvaged_from)
    lines.add("", "ticks " + std::to_string(*report.end->salvaged_from) + ".." + std::to_string(tail.ticks_intact - 1) +
                      " by the checks of their records alone: their chunk is damaged behind them");
  for (const replay::IntactRange& range : tail.intact_after) lines.add("", "behind the damage: " + range_text(range));
  if (tail.has_pending_inputs) {
    lines.add("pending", "tick " + std::to_string(tail.ticks_intact) + " was in flight, " +
                             (tail.pending_inputs.empty()
                                  ? "without inputs"
                                  : std::to_string(tail.pending_inputs.size()) + " bytes of inputs were written"));
    lines.add_inputs(report.end->pending_inputs, inputs_shown_max);
  }
}

/// Adds the builds of the two programs, if one of them states its build.
void add_programs(const Report& report, Lines& lines) {
  const std::string recorded = program_line(report.recorded_build);
  const std::string here = program_line(report.here_build);
  if (recorded.empty() && here.empty()) return;
  lines.add("program", "recorded " + (recorded.empty() ? std::string("not known") : recorded));
  if (!report.here_build.empty()) lines.add("", "here " + (here.empty() ? std::string("not known") : here));
  const char* label = "differs";
  for (const FactDifference& difference : fact_differences(report.recorded_build, report.here_build)) {
    lines.add(label, difference_line(difference, "recorded", "here"));
    label = "";
  }
}

}  // namespace

std::string divergence_text(const Divergence& divergence, const char* expected_name, const char* got_name) {
  Lines lines;
  add_divergence(divergence, expected_name, got_name, lines);
  return lines.take();
}

std::string report_text(const Report& report) {
  Lines lines;
  const bool end_says_it = report.end && !report.end->tail.message.empty() && report.reason == report.end->tail.message;
  if (!report.reason.empty() && !end_says_it) lines.add("reason", report.reason);
  const bool between_builds = report.against && report.against->is_expected;
  if (report.divergence)
    add_divergence(*report.divergence, between_builds ? "there" : "expected", between_builds ? "here" : "got", lines);
  if (report.divergence) add_marks(report, lines);
  const char* why = "why";
  for (const std::string& line : cause_lines(likely_causes(report))) lines.add(std::exchange(why, ""), line);
  if (report.end) add_end(report, lines);
  for (const std::string& note : report.notes) lines.add("note", note);
  for (const std::string& warning : report.warnings) lines.add("warning", warning);
  const bool judged_by_build = report.verdict != Verdict::match && report.verdict != Verdict::error;
  if (judged_by_build && !report.recorded_build.empty()) {
    lines.add("builds", "recorded " + facts_line(report.recorded_build));
    lines.add("", "here " + (report.here_build.empty() ? build_line() : facts_line(report.here_build)));
    if (report.against && !report.against->facts.empty()) lines.add("", "there " + facts_line(report.against->facts));
    add_programs(report, lines);
  }
  if (!report.hint.empty()) lines.add("next", report.hint);
  for (const std::string& command : report.again) lines.add("again", command);
  return headline(report) + "\n" + lines.take();
}

}  // namespace ticktrue::verifier
