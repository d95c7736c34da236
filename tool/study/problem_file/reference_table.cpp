// Reads a table of reference values, and interpolates between its rows.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/reference_table.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/json/json_tree.h"
#include "engine/json/number_text.h"

namespace ticktrue::tool {
namespace {

constexpr std::size_t row_count_max = 1'000'000;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = std::min(line.find(','), line.size());
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == line.size()) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// The numbers of a line. Absent if a cell is not a number.
std::optional<std::vector<double>> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  for (const std::string_view cell : cells_of(line)) {
    const auto number = engine::parse_number(cell);
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
  return text;
}

/// Which columns hold the time and the values.
struct TableColumns {
  std::size_t count = 0;            // of a line
  std::vector<std::size_t> chosen;  // the time, then each value
};

/// Columns in the order of the values, if no line names them.
TableColumns columns_in_order(std::size_t value_count) {
  TableColumns columns{value_count + 1, {}};
  for (std::size_t i = 0; i < columns.count; ++i) columns.chosen.push_back(i);
  return columns;
}

/// Columns by their names. Absent if one of `time` and `names` is missing.
std::optional<TableColumns> columns_by_name(const std::vector<std::string_view>& heads,
                                            const std::vector<std::string>& names) {
  TableColumns columns{heads.size(), {}};
  const auto add = [&](std::string_view name) {
    const auto found = std::find(heads.begin(), heads.end(), name);
    columns.chosen.push_back(static_cast<std::size_t>(found - heads.begin()));
    return found != heads.end();
  };
  bool has_all = add("time");
  for (const std::string& name : names) has_all = add(name) && has_all;
  return has_all ? std::optional(columns) : std::nullopt;
}

}  // namespace

Result<ReferenceTable> ReferenceTable::parse(std::string_view text, const std::string& place,
                                             const std::vector<std::string>& names) {
  ReferenceTable table;
  TableColumns columns = columns_in_order(names.size());
  bool is_first = true;
  std::size_t number = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    ++number;
    if (line.empty() || line[0] == '#') continue;
    const auto wrong = [&](const std::string& what) {
      return Error{ErrorCode::corrupt, place + ":" + std::to_string(number) + ": " + what, ""};
    };
    const std::vector<std::string_view> heads = cells_of(line);
    if (std::exchange(is_first, false) && !engine::parse_number(heads.front())) {
      const auto named = columns_by_name(heads, names);
      if (named)
        columns = *named;
      else if (heads.front() == "tick")  // of `ticktrue replay --format csv`
        return wrong("found columns " + engine::in_quotes(engine::shortened(line)) + ", expected time," +
                     joined(names));
      continue;
    }
    const auto numbers = numbers_of(line);
    if (!numbers || numbers->size() != columns.count)
      return wrong("found " + engine::in_quotes(engine::shortened(line)) + ", expected " +
                   std::to_string(columns.count) + " numbers: time," + joined(names));
    const double time_s = (*numbers)[columns.chosen.front()];
    if (!table.times_.empty() && !(time_s > table.times_.back()))
      return wrong("found time " + engine::number_text(time_s) + ", expected one after " +
                   engine::number_text(table.times_.back()));
    if (table.times_.size() == row_count_max)
      return Error{ErrorCode::limit, place + ": found more rows, expected at most " + std::to_string(row_count_max),
                   ""};
    table.times_.push_back(time_s);
    table.values_.emplace_back();
    for (std::size_t i = 1; i < columns.chosen.size(); ++i)
      table.values_.back().push_back((*numbers)[columns.chosen[i]]);
  }
  if (table.times_.size() < 2)
    return Error{ErrorCode::corrupt,
                 place + ": found " + std::to_string(table.times_.size()) + " rows, expected at least 2", ""};
  return table;
}

std::vector<double> ReferenceTable::at(double time) const {
  const std::size_t used = std::min<std::size_t>(4, times_.size());
  const auto behind = std::lower_bound(times_.begin(), times_.end(), time);
  const auto next = static_cast<std::size_t>(behind - times_.begin());
  const std::size_t first = std::min(next < 2 ? 0 : next - 2, times_.size() - used);
  std::vector<double> values(values_.front().size(), 0);
  for (std::size_t i = first; i < first + used; ++i) {
    double weight = 1;
    for (std::size_t k = first; k < first + used; ++k)
      if (k != i) weight *= (time - times_[k]) / (times_[i] - times_[k]);
    for (std::size_t value = 0; value < values.size(); ++value) values[value] += weight * values_[i][value];
  }
  return values;
}

}  // namespace ticktrue::tool
