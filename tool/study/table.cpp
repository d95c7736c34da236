// Tables of a study: text of at most 120 columns, CSV, and curves for gnuplot.
// SPDX-License-Identifier: MIT
#include "tool/study/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::tool {

TextTable::TextTable(std::vector<std::string> head, std::size_t left) : left_(left) {
  rows_.push_back(std::move(head));
}

void TextTable::add(std::vector<std::string> row) {
  row.resize(rows_[0].size());
  rows_.push_back(std::move(row));
}

std::string TextTable::text() const {
  std::vector<std::size_t> widths(rows_[0].size(), 0);
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string out;
  for (const std::vector<std::size_t>& columns : blocks_of(widths)) {
    if (!out.empty()) out += "\n";
    for (const auto& row : rows_) {
      std::string line;
      for (const std::size_t i : columns) {
        const std::string blanks(widths[i] - row[i].size(), ' ');
        line += "  " + (i < left_ ? row[i] + blanks : blanks + row[i]);
      }
      while (!line.empty() && line.back() == ' ') line.pop_back();
      out += line + "\n";
    }
  }
  return out;
}

std::vector<std::vector<std::size_t>> TextTable::blocks_of(const std::vector<std::size_t>& widths) const {
  // Each block begins with the left columns, which name the row. If they leave no room for another column, only the
  // first is repeated.
  std::size_t named_count = std::min(left_, widths.size()), named_width = 0, widest = 0;
  for (std::size_t i = 0; i < widths.size(); ++i) {
    if (i < named_count)
      named_width += 2 + widths[i];
    else
      widest = std::max(widest, 2 + widths[i]);
  }
  if (named_width + widest > table_width_max) {
    named_count = std::min<std::size_t>(1, widths.size());
    named_width = named_count > 0 ? 2 + widths[0] : 0;
  }
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < named_count; ++i) named.push_back(i);
  std::vector<std::vector<std::size_t>> blocks{named};
  std::size_t width = named_width;
  for (std::size_t i = named_count; i < widths.size(); ++i) {
    if (width + 2 + widths[i] > table_width_max && blocks.back().size() > named_count) {
      blocks.push_back(named);
      width = named_width;
    }
    blocks.back().push_back(i);
    width += 2 + widths[i];
  }
  return blocks;
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    if (cells[i].find_first_of(",\"\n") == std::string::npos) {
      line += cells[i];
      continue;
    }
    line += '"';
    for (const char c : cells[i]) line += c == '"' ? std::string("\"\"") : std::string(1, c);
    line += '"';
  }
  return line + "\n";
}

std::string short_number(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  if (value == 0) return "0";
  char text[32];
  const double size = std::fabs(value);
  std::snprintf(text, sizeof text, size >= 0.001 && size < 1e5 ? "%.4g" : "%.2e", value);
  return text;
}

std::string full_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

std::string wrapped(std::string_view text, std::size_t indent) {
  std::string lines;
  const std::size_t width = table_width_max - indent;
  while (!text.empty()) {
    std::size_t size = std::min(text.size(), width);
    if (size < text.size())
      if (const std::size_t space = text.rfind(' ', size); space != std::string_view::npos && space > 0) size = space;
    lines += std::string(indent, ' ') + std::string(text.substr(0, size)) + "\n";
    text.remove_prefix(size);
    if (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  }
  return lines;
}

namespace {

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

bool can_plot(const Plot& plot, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!plot.log_x || x > 0) && (!plot.log_y || y > 0);
}

// Eight colours that colour-blind readers can tell apart (Okabe, Ito, "Color Universal Design", 2008), then the same
// colours dashed.
constexpr std::string_view line_types =
    "do for [i=0:1] {\n"
    "  j = 0\n"
    "  do for [c in '#0072b2 #d55e00 #009e73 #cc79a7 #000000 #e69f00 #56b4e9 #999999'] {\n"
    "    j = j + 1\n"
    "    set linetype 8 * i + j linecolor rgb c dashtype 1 + 2 * i pointtype 4 + j + i pointsize 0.5 linewidth 1.5\n"
    "  }\n"
    "}\n"
    "set linetype cycle 16\n";
constexpr std::size_t marked_count_max = 40;  // a curve with more points is a line without marks

std::size_t longest_name(const std::vector<Plot>& plots) {
  std::size_t longest = 0;
  for (const Plot& plot : plots)
    for (const PlotCurve& curve : plot.curves) longest = std::max(longest, curve.name.size());
  return longest;
}

// Whether the labels of an axis are too long to fit side by side and must be rotated.
bool are_long(const std::vector<std::string>& ticks) {
  return std::any_of(ticks.begin(), ticks.end(), [](const std::string& tick) { return tick.size() > 4; });
}

// "set logscale", format and tics of one axis.
std::string axis_of(char axis, bool is_log, const std::vector<std::string>& ticks) {
  const std::string name(1, axis);
  std::string text = "unset logscale " + name + "\nset " + name + "tics autofreq norotate\n";
  if (is_log) text = "set logscale " + name + "\nset " + name + "tics autofreq norotate\n";
  text += "set format " + name + (is_log ? " '10^{%T}'\n" : " '%g'\n");
  if (ticks.empty()) return text;
  text += "set " + name + "tics" + (are_long(ticks) ? " rotate by -60 font ',9'" : "") + " noenhanced (";
  for (std::size_t i = 0; i < ticks.size(); ++i)
    text += (i > 0 ? ", " : "") + quoted(ticks[i]) + " " + std::to_string(i + 1);
  return text + ")\nset xrange [0.5:" + std::to_string(ticks.size()) + ".5]\n";
}

std::string style_of(const Plot& plot, const PlotCurve& curve) {
  if (curve.dashed) return "lines dashtype 3 linecolor 'gray40'";
  if (!plot.joined) return "points";
  return curve.x.size() > marked_count_max ? "lines" : "linespoints";
}

// The data blocks and the plot command of one diagram.
std::string curves_of(const Plot& plot, std::size_t index) {
  std::string blocks, command;
  for (std::size_t c = 0; c < plot.curves.size(); ++c) {
    const PlotCurve& curve = plot.curves[c];
    const std::string name = "$data_" + std::to_string(index) + "_" + std::to_string(c);
    std::size_t count = 0;
    std::string block = name + " << EOD\n";
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      double y = curve.y[i];
      if (plot.y_most > 0 && !std::isnan(y)) y = std::clamp(y, plot.y_least, plot.y_most);
      if (!can_plot(plot, curve.x[i], y)) continue;
      block += full_number(curve.x[i]) + " " + full_number(y) + "\n";
      ++count;
    }
    if (count == 0) continue;
    blocks += block + "EOD\n";
    command += (command.empty() ? "plot " : ", ") + name + " using 1:2 with " + style_of(plot, curve) + " title " +
               quoted(curve.name);
  }
  if (command.empty())  // a logarithmic axis without values is an error of gnuplot
    command =
        "unset logscale\nset xrange [0:1]\nset yrange [0:1]\n"
        "set label 1 'no finite value' at graph .5,.5 center\nplot NaN notitle\nunset label 1";
  return blocks + command + "\n";
}

std::string script_of(const std::vector<Plot>& plots, const std::string& path) {
  constexpr std::size_t width = 1000, height = 480;  // of one diagram
  std::string script = "set terminal svg size " + std::to_string(width) + "," + std::to_string(height * plots.size()) +
                       " font 'sans-serif,12' background 'white'\nset output " + quoted(path) +
                       "\nset encoding utf8\n" + std::string(line_types) + "set multiplot layout " +
                       std::to_string(plots.size()) + ",1\nset grid\nset lmargin 12\nset rmargin " +
                       std::to_string(longest_name(plots) + 8) +
                       "\nset key outside right top Left reverse noenhanced maxcols 1 font ',10' spacing 1\n";
  for (std::size_t p = 0; p < plots.size(); ++p) {
    const Plot& plot = plots[p];
    script += "set title " + quoted(plot.title) + " noenhanced\nset xlabel " + quoted(plot.x_label) +
              " noenhanced\nset ylabel " + quoted(plot.y_label) + " noenhanced\nset xrange [*:*]\nset yrange [*:*]\n";
    script += are_long(plot.ticks) ? "set bmargin 9\n" : "set bmargin 4\n";
    script += axis_of('x', plot.log_x, plot.ticks) + axis_of('y', plot.log_y, {});
    if (plot.y_most > 0)
      script += "set yrange [" + full_number(plot.y_least / 2) + ":" + full_number(plot.y_most * 2) + "]\n";
    script += curves_of(plot, p);
  }
  return script + "unset multiplot\n";
}

#ifdef _WIN32
std::FILE* open_pipe() {
  return _popen("gnuplot >NUL 2>&1", "w");
}
int close_pipe(std::FILE* pipe) {
  return _pclose(pipe);
}
#else
std::FILE* open_pipe() {
  return ::popen("gnuplot >/dev/null 2>&1", "w");
}
int close_pipe(std::FILE* pipe) {
  return ::pclose(pipe);
}
#endif

}  // namespace

Status write_plots(const std::vector<Plot>& plots, const std::string& path, bool overwrite) {
  if (plots.empty()) return Error{ErrorCode::io, path + ": no curve to plot: found none, expected at least one", {}};
  const Result<verifier::RunFolder> folder = verifier::RunFolder::make("ticktrue-plot", "");
  if (!folder) return folder.error();
  const std::string drawn = folder->path() + "/plot.svg";
  std::FILE* pipe = open_pipe();
  if (!pipe) return Error{ErrorCode::io, path + ": gnuplot could not be started", "use --csv"};
  const std::string script = script_of(plots, drawn);
  std::fwrite(script.data(), 1, script.size(), pipe);
  const int status = close_pipe(pipe);
  std::ifstream file(drawn, std::ios::binary);
  const std::string picture{std::istreambuf_iterator<char>(file), {}};
  if (status == 0 && !picture.empty()) return verifier::write_data_file(path, picture, overwrite);
  return Error{ErrorCode::unsupported, path + ": no plot was made: found no working gnuplot, expected the program",
               "apt install gnuplot-nox, or use --csv"};
}

}  // namespace ticktrue::tool
