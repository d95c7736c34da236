// Reads a table of reference values, and interpolates between its rows.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/reference_table.h"

#include <algorithm>

#include "engine/json/json_tree.h"
#include "engine/json/number_text.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t row_count_max = 1'000'000;

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

/// Parses the numbers of a line. Absent if a cell is not a number.
std::optional<std::vector<double>> numbers_of(std::string_view line) {
  std::vector<double> numbers;
  while (true) {
    const std::size_t comma = std::min(line.find(','), line.size());
    const auto number = engine::parse_number(trimmed(line.substr(0, comma)));
    if (!number) return {};
    numbers.push_back(*number);
    if (comma == line.size()) return numbers;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

Result<ReferenceTable> ReferenceTable::parse(std::string_view text, const std::string& place, std::size_t value_count) {
  ReferenceTable table;
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
    const auto numbers = numbers_of(line);
    if (!numbers && number == 1) continue;  // the first line may hold the names of the columns
    if (!numbers || numbers->size() != value_count + 1)
      return wrong("found " + engine::in_quotes(engine::shortened(line)) + ", expected a time and " +
                   std::to_string(value_count) + (value_count == 1 ? " value" : " values"));
    if (!table.times_.empty() && !(numbers->front() > table.times_.back()))
      return wrong("found time " + engine::number_text(numbers->front()) + ", expected one after " +
                   engine::number_text(table.times_.back()));
    if (table.times_.size() == row_count_max)
      return Error{ErrorCode::limit, place + ": found more rows, expected at most " + std::to_string(row_count_max),
                   ""};
    table.times_.push_back(numbers->front());
    table.values_.emplace_back(numbers->begin() + 1, numbers->end());
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

}  // namespace ticktrue::verifier
