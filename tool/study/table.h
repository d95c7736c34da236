// Tables of a study: text of at most 120 columns, CSV, and curves for gnuplot.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::tool {

inline constexpr std::size_t table_width_max = 120;  // columns of a line of text

/// Rows of cells; the first row is the head.
class TextTable {
 public:
  /// `left`: the number of columns aligned to the left. The other columns hold numbers and are aligned to the right.
  explicit TextTable(std::vector<std::string> head, std::size_t left = 1);
  void add(std::vector<std::string> row);
  std::size_t row_count() const { return rows_.size() - 1; }
  /// A column is as wide as its widest cell. Two blanks separate columns and indent lines. Columns beyond
  /// table_width_max follow in another block of lines, which repeats the left columns. No cell is cut: a line with a
  /// wider cell is longer.
  std::string text() const;

 private:
  /// The column indices of each block.
  std::vector<std::vector<std::size_t>> blocks_of(const std::vector<std::size_t>& widths) const;

  std::size_t left_;
  std::vector<std::vector<std::string>> rows_;
};

/// Quotes cells where RFC 4180 requires quotes. The line ends with \n.
std::string csv_line(const std::vector<std::string>& cells);

/// Four digits, with an exponent for very small and very large numbers; "nan", "inf" or "-inf" for values that are not
/// finite.
std::string short_number(double value);
/// The shortest text that parses to the same double; empty for a value that is not finite.
std::string full_number(double value);

/// A paragraph of at most table_width_max columns; each line is indented.
std::string wrapped(std::string_view text, std::size_t indent);

struct PlotCurve {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  bool dashed = false;  // a guide line, not a measurement
};
struct Plot {
  std::string title;
  std::string x_label;
  std::string y_label;
  bool log_x = true;
  bool log_y = true;
  std::vector<PlotCurve> curves;
  std::vector<std::string> ticks = {};  // labels of x = 1, 2, ...; empty: numbers
  bool joined = true;                   // a line joins the points
  double y_least = 0, y_most = 0;       // values outside are drawn at the edge; 0, 0: no bounds
};
/// Draws the plots as SVG, one below the other, with the program gnuplot. An existing file is replaced with `overwrite`
/// alone, and only by a whole picture. Errors: io; unsupported if gnuplot is missing.
Status write_plots(const std::vector<Plot>& plots, const std::string& path, bool overwrite);

}  // namespace ticktrue::tool
