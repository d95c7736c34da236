// Reads and changes the manifest of golden traces, and finds the changed ticks of a trace.
// SPDX-License-Identifier: MIT
#include "verifier/corpus/golden.h"

#include <algorithm>
#include <charconv>
#include <tuple>
#include <utility>
#include <variant>

#include "base/limits.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t column_count = 8;
constexpr std::size_t ranges_shown_max = 8;

std::vector<std::string> split_columns(std::string_view line) {
  std::vector<std::string> columns;
  for (;;) {
    const std::size_t end = line.find('\t');
    columns.emplace_back(line.substr(0, end));
    if (end == std::string_view::npos) return columns;
    line.remove_prefix(end + 1);
  }
}

bool read_number(const std::string& text, std::uint64_t& value) {
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
  return failure == std::errc() && end == text.data() + text.size();
}

bool is_hash(const std::string& text) {
  return text == "-" || (text.size() == 16 && text.find_first_not_of("0123456789abcdef") == std::string::npos);
}

/// Only names inside the directory: a manifest cannot refer to other directories.
bool is_plain_name(const std::string& name) {
  return !name.empty() && name.front() != '.' && name.find('/') == std::string::npos &&
         name.find('\\') == std::string::npos;
}

Result<GoldenRow> parse_row(std::string_view line, const std::string& place) {
  const auto refuse = [&](const std::string& what) { return Error{ErrorCode::invalid_input, place + ": " + what, ""}; };
  const std::vector<std::string> columns = split_columns(line);
  if (columns.size() != column_count)
    return refuse("columns: found " + std::to_string(columns.size()) + ", expected " + std::to_string(column_count) +
                  " separated by tabs: file, scene, inputs, ticks, detail, hash, bytes, why");
  GoldenRow row;
  row.file = columns[0];
  row.scene = columns[1];
  row.inputs = columns[2] == "-" ? "" : columns[2];
  row.detail = columns[4];
  row.hash = columns[5];
  row.why = columns[7];
  std::uint64_t ticks = 0;
  if (!is_plain_name(row.file)) return refuse("file: found \"" + row.file + "\", expected a name without folders");
  if (columns[3] != "-") {
    if (!read_number(columns[3], ticks) || ticks == 0 || ticks > limits::tick_count_max)
      return refuse("ticks: found \"" + columns[3] + "\", expected a number from 1 on, or -");
    row.tick_count = ticks;
  }
  if (!is_hash(row.hash)) return refuse("hash: found \"" + row.hash + "\", expected 16 hexadecimal digits, or -");
  if (!read_number(columns[6], row.size)) return refuse("bytes: found \"" + columns[6] + "\", expected a number");
  return row;
}

/// Whether the rows are equal, apart from the lines above them.
bool is_same_row(const GoldenRow& a, const GoldenRow& b) {
  const auto key = [](const GoldenRow& row) {
    return std::tie(row.file, row.scene, row.inputs, row.tick_count, row.detail, row.hash, row.size, row.why);
  };
  return key(a) == key(b);
}

std::string range_words(std::uint64_t first, std::uint64_t last) {
  return first == last ? std::to_string(first) : std::to_string(first) + ".." + std::to_string(last);
}

/// The root hash of the next tick; nothing: the end.
std::optional<std::uint64_t> next_hash(replay::TraceReader& reader) {
  for (;;) {
    const auto& item = reader.next();
    if (const auto* record = std::get_if<replay::TickRecord>(&item)) return record->root_hash;
    if (std::holds_alternative<std::monostate>(item)) return std::nullopt;
  }
}

}  // namespace

Result<GoldenManifest> parse_manifest(std::string_view text, const std::string& name) {
  GoldenManifest manifest;
  std::string before;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const bool is_head = line.substr(0, line.find('\t')) == "file" && manifest.rows.empty();
    if (line.empty() || line.front() == '#' || is_head) {
      before += std::string(line) + "\n";
      continue;
    }
    const std::string place = name + ":" + std::to_string(number);
    Result<GoldenRow> row = parse_row(line, place);
    if (!row) return row.error();
    for (const GoldenRow& other : manifest.rows)
      if (other.file == row->file)
        return Error{ErrorCode::invalid_input, place + ": file: found " + row->file + " again, expected each once", ""};
    row->before = std::exchange(before, "");
    manifest.rows.push_back(std::move(*row));
  }
  manifest.after = before;
  return manifest;
}

std::string manifest_text(const GoldenManifest& manifest) {
  std::string text;
  for (const GoldenRow& row : manifest.rows)
    text += row.before + row.file + "\t" + row.scene + "\t" + (row.inputs.empty() ? "-" : row.inputs) + "\t" +
            (row.tick_count ? std::to_string(*row.tick_count) : "-") + "\t" + row.detail + "\t" + row.hash + "\t" +
            std::to_string(row.size) + "\t" + row.why + "\n";
  return text + manifest.after;
}

Status add_row(GoldenManifest& manifest, GoldenRow row, const std::string& name) {
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    return Error{ErrorCode::usage, name + ": " + row.file + ": " + what, hint};
  };
  for (const GoldenRow& other : manifest.rows)
    if (other.file == row.file) return refuse("found a row of this name, expected none", "give another --name");
  GoldenManifest alone;
  alone.rows = {row};
  alone.rows[0].before.clear();
  const auto read = parse_manifest(manifest_text(alone), name);
  const bool is_same = read && read->rows.size() == 1 && read->after.empty() && is_same_row(read->rows[0], row);
  if (!is_same)
    return refuse("found a text that the file cannot hold, expected none with a tab or a line end" +
                      (read ? "" : ": " + read.error().message),
                  "a name begins with a letter or a digit, and has no folder");
  if (manifest.rows.empty()) row.before = std::exchange(manifest.after, "");
  manifest.rows.push_back(std::move(row));
  return {};
}

std::string changed_ticks(replay::TraceReader& a, replay::TraceReader& b) {
  a.rewind();
  b.rewind();
  std::string text;
  std::size_t range_count = 0;
  bool is_open = false;     // in a range of differing ticks
  std::uint64_t first = 0;  // the first tick of this range
  std::uint64_t tick = 0;
  const auto close = [&] {
    if (!is_open) return;
    if (++range_count <= ranges_shown_max) text += (text.empty() ? "" : ", ") + range_words(first, tick - 1);
    is_open = false;
  };
  for (;; ++tick) {
    const auto hash_a = next_hash(a);
    const auto hash_b = next_hash(b);
    if (hash_a == hash_b) close();
    if (!hash_a && !hash_b) break;
    if (hash_a == hash_b || is_open) continue;
    is_open = true;
    first = tick;
  }
  if (range_count > ranges_shown_max)
    text += ", and " + std::to_string(range_count - ranges_shown_max) + " more ranges";
  return text.empty() ? "" : text + " of " + std::to_string(tick);
}

}  // namespace ticktrue::verifier
