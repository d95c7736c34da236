// Tables of a study: text of at most 120 columns, CSV, and curves for gnuplot.
// SPDX-License-Identifier: MIT
#include "verifier/study/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace ticktrue::verifier {

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
  for (const auto& row : rows_) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string blanks(widths[i] - row[i].size(), ' ');
      line += "  " + (i < left_ ? row[i] + blanks : blanks + row[i]);
    }
    while (!line.empty() && line.back() == ' ') line.pop_back();
    if (line.size() > table_width_max) line.resize(table_width_max);
    out += line + "\n";
  }
  return out;
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

std::string script_of(const std::vector<Plot>& plots, const std::string& path) {
  std::string script = "set terminal svg size 900," + std::to_string(520 * plots.size()) +
                       " font 'sans-serif,12' background 'white'\nset output " + quoted(path) +
                       "\nset encoding utf8\nset multiplot layout " + std::to_string(plots.size()) + ",1\n";
  for (std::size_t p = 0; p < plots.size(); ++p) {
    const Plot& plot = plots[p];
    script += "unset logscale\nset title " + quoted(plot.title) + " noenhanced\nset xlabel " + quoted(plot.x_label) +
              " noenhanced\nset ylabel " + quoted(plot.y_label) +
              " noenhanced\nset key outside right noenhanced\nset grid\n";
    if (plot.log_x) script += "set logscale x\nset format x '%.0e'\n";
    if (!plot.log_x) script += "set format x '%g'\n";
    if (plot.log_y) script += "set logscale y\nset format y '%.0e'\n";
    if (!plot.log_y) script += "set format y '%g'\n";
    std::string command;
    for (std::size_t c = 0; c < plot.curves.size(); ++c) {
      const PlotCurve& curve = plot.curves[c];
      const std::string name = "$data_" + std::to_string(p) + "_" + std::to_string(c);
      std::size_t count = 0;
      std::string block = name + " << EOD\n";
      for (std::size_t i = 0; i < curve.x.size(); ++i) {
        if (!can_plot(plot, curve.x[i], curve.y[i])) continue;
        block += full_number(curve.x[i]) + " " + full_number(curve.y[i]) + "\n";
        ++count;
      }
      if (count == 0) continue;
      script += block + "EOD\n";
      command += (command.empty() ? "plot " : ", ") + name + " using 1:2 with " +
                 (curve.dashed ? "lines dashtype 2 linecolor 'gray'" : "linespoints") + " title " + quoted(curve.name);
    }
    script += (command.empty() ? std::string("plot NaN notitle") : command) + "\n";
  }
  return script + "unset multiplot\n";
}

}  // namespace

Status write_plots(const std::vector<Plot>& plots, const std::string& path) {
  if (plots.empty()) return Error{ErrorCode::io, path + ": no curve to plot: found none, expected at least one", {}};
  std::FILE* probe = std::fopen(path.c_str(), "wb");
  if (!probe) return Error{ErrorCode::io, path + ": cannot be written", {}};
  std::fclose(probe);
#ifdef _WIN32
  std::remove(path.c_str());
  return Error{ErrorCode::unsupported, path + ": plots need gnuplot as a program, which this build does not start",
               "use --csv"};
#else
  std::FILE* pipe = ::popen("gnuplot >/dev/null 2>&1", "w");
  if (!pipe) return Error{ErrorCode::io, path + ": gnuplot could not be started", "use --csv"};
  const std::string script = script_of(plots, path);
  std::fwrite(script.data(), 1, script.size(), pipe);
  const int status = ::pclose(pipe);
  if (status == 0) return {};
  std::remove(path.c_str());
  return Error{ErrorCode::unsupported, path + ": no plot was made: found no working gnuplot, expected the program",
               "apt install gnuplot-nox, or use --csv"};
#endif
}

}  // namespace ticktrue::verifier
