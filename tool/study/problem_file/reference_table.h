// A reference solution: a table of times and values from a CSV file.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::tool {

/// Values at ascending times.
class ReferenceTable {
 public:
  /// Parses lines "time, value, ..." with a value for each of `names`. Skips lines that begin with #. The first other
  /// line may hold the names of the columns: if `time` and all of `names` are among these, they choose the columns, and
  /// all other columns are ignored. Messages begin with `place`. Errors: corrupt, with the line; limit.
  static Result<ReferenceTable> parse(std::string_view text, const std::string& place,
                                      const std::vector<std::string>& names);

  double first_time() const { return times_.front(); }
  double last_time() const { return times_.back(); }
  /// The values at a time, interpolated by the cubic through the four rows around that time. The error is of order 4 in
  /// the spacing of the rows. Requires: a time between the first and the last.
  std::vector<double> at(double time) const;

 private:
  std::vector<double> times_;                // s
  std::vector<std::vector<double>> values_;  // [row][value]
};

}  // namespace ticktrue::tool
