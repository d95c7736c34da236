// The output of `ticktrue accuracy`: tables, JSON and plots of its curves.
// SPDX-License-Identifier: MIT
#include "tool/cli/study/accuracy_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/count_text.h"
#include "base/hash.h"
#include "engine/math/trig.h"

namespace ticktrue::cli {
namespace {

using tool::AccuracyCurve;
using tool::AccuracyPoint;
using tool::Problem;
using tool::short_number;
using tool::StudyVerdict;
using tool::TextTable;
using tool::VerdictCounts;

constexpr double targets[]{0.01, 0.001, 0.0001};
constexpr tool::ProblemClass shape_classes[]{tool::ProblemClass::roll, tool::ProblemClass::slide,
                                             tool::ProblemClass::stack, tool::ProblemClass::bounce};

std::string_view state_name(tool::PointState state) {
  constexpr std::string_view names[]{"ok", "not_finite", "not_repeatable"};
  return names[static_cast<std::size_t>(state)];
}

std::string slope_text(const std::optional<double>& slope) {
  return slope ? fmt::format("{:.2f}", *slope) : "-";
}

std::string ms_text(const AccuracyPoint& point) {
  return fmt::format("{:.3g}", point.time_ms.min);
}

std::string cheapest_text(const AccuracyCurve& curve, double error, bool no_times) {
  const AccuracyPoint* point = no_times ? tool::coarsest(curve, error) : tool::cheapest(curve, error);
  if (!point) return "-";
  const std::string setting = tool::setting_text(curve.method, point->setting);
  return no_times ? setting : setting + " " + ms_text(*point);
}

std::string curve_table(const std::vector<const AccuracyCurve*>& curves, bool no_times) {
  TextTable table(
      {"method", "coarse", "fine", "slope", "theory", "verdict", no_times ? "1 %" : "1 %: ms/s", "0.1 %", "0.01 %"});
  std::vector<std::string> reasons;
  for (const AccuracyCurve* curve : curves) {
    const auto& judgement = curve->judgement;
    std::string mark;
    if (!judgement.reason.empty()) {
      const auto known = std::find(reasons.begin(), reasons.end(), judgement.reason);
      mark = fmt::format(" [{}]", known - reasons.begin() + 1);
      if (known == reasons.end()) reasons.push_back(judgement.reason);
    }
    const std::string verdict =
        (judgement.verdict == StudyVerdict::not_applicable ? "n/a" : std::string(verdict_name(judgement.verdict))) +
        mark;
    if (curve->points.empty()) {
      table.add({curve->method.name, "-", "-", "-", "-", verdict, "-", "-", "-"});
      continue;
    }
    std::vector<std::string> row{curve->method.name,
                                 short_number(curve->points.front().error),
                                 short_number(curve->points.back().error),
                                 slope_text(judgement.slope),
                                 slope_text(judgement.expected),
                                 verdict};
    for (const double target : targets) row.push_back(cheapest_text(*curve, target, no_times));
    table.add(std::move(row));
  }
  std::string text = table.text();
  for (std::size_t i = 0; i < reasons.size(); ++i) text += tool::wrapped(fmt::format("[{}] {}", i + 1, reasons[i]), 4);
  return text;
}

std::string point_table(const std::vector<const AccuracyCurve*>& curves, bool no_times) {
  std::vector<std::string> head{"method", "setting", "error RMS", "max", "floor", "energy J", "overlap", "gap", "hash"};
  if (!no_times) head.insert(head.end(), {"ms/s min", "median", "IQR"});
  TextTable table(std::move(head), 2);
  for (const AccuracyCurve* curve : curves)
    for (const AccuracyPoint& point : curve->points) {
      std::vector<std::string> row{curve->method.name,
                                   tool::setting_text(curve->method, point.setting),
                                   short_number(point.error),
                                   short_number(point.error_max),
                                   short_number(point.floor),
                                   short_number(point.energy),
                                   short_number(point.overlap_max),
                                   short_number(point.joint_gap_max),
                                   hex64(point.hash).substr(0, 8)};
      if (!no_times)
        row.insert(row.end(), {ms_text(point), fmt::format("{:.3g}", point.time_ms.median),
                               fmt::format("{:.2g}", point.time_ms.iqr)});
      table.add(std::move(row));
    }
  return table.text();
}

// One line a problem: the default method at the scene's settings and at its finest, and how its curves were judged.
std::string brief_table(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves) {
  TextTable table({"problem", "class", "precision", "default", "finest", "slope", "theory", "best of all", "pass",
                   "fail", "falls short", "not judged"},
                  3);
  std::string last;
  for (const Problem& problem : problems)
    for (const engine::Precision precision : {engine::Precision::f64, engine::Precision::f32}) {
      const AccuracyCurve* main = nullptr;
      VerdictCounts counts;
      double best = HUGE_VAL;
      for (const AccuracyCurve& curve : curves) {
        if (curve.problem != problem.name || curve.precision != precision) continue;
        if (!main) main = &curve;
        counts.add(curve.judgement.verdict);
        for (const AccuracyPoint& point : curve.points) best = std::min(best, point.error);
      }
      if (!main || main->points.empty()) continue;
      // The settings of a scene by default: 1/60 s, four substeps where there are any.
      const AccuracyPoint* usual = &main->points.front();
      for (const AccuracyPoint& point : main->points)
        if (point.setting.substeps == 4 || (point.setting.substeps == 1 && point.setting.dt > 0.99 / 60))
          usual = &point;
      table.add(
          {problem.name == last ? "" : problem.name, problem.name == last ? "" : std::string(class_name(problem.kind)),
           std::string(precision_name(precision)), short_number(usual->error), short_number(main->points.back().error),
           slope_text(main->judgement.slope), slope_text(main->judgement.expected), short_number(best),
           std::to_string(counts.of(StudyVerdict::pass)), std::to_string(counts.of(StudyVerdict::fail)),
           std::to_string(counts.of(StudyVerdict::falls_short)),
           std::to_string(counts.of(StudyVerdict::not_judged) + counts.of(StudyVerdict::not_applicable))});
      last = problem.name;
    }
  return "\n" + table.text();
}

// A shape of n corners and its kin are one problem.
std::string family_of(const AccuracyCurve& curve) {
  return curve.corner_count < 0 ? curve.problem : std::string(class_name(curve.kind));
}

// Why curves have a verdict, the most frequent reason first.
std::string reason_table(const std::vector<AccuracyCurve>& curves, StudyVerdict verdict, std::string_view title) {
  struct Reason {
    std::string text;
    int count = 0;
    std::vector<std::string> problems;
  };
  std::vector<Reason> reasons;
  for (const AccuracyCurve& curve : curves) {
    if (curve.judgement.verdict != verdict) continue;
    auto found = std::find_if(reasons.begin(), reasons.end(),
                              [&](const Reason& reason) { return reason.text == curve.judgement.reason; });
    if (found == reasons.end()) found = reasons.insert(found, {curve.judgement.reason, 0, {}});
    ++found->count;
    const std::string family = family_of(curve);
    if (std::find(found->problems.begin(), found->problems.end(), family) == found->problems.end())
      found->problems.push_back(family);
  }
  if (reasons.empty()) return {};
  std::sort(reasons.begin(), reasons.end(),
            [](const Reason& a, const Reason& b) { return a.count != b.count ? a.count > b.count : a.text < b.text; });
  std::string text = fmt::format("\n{}\n", title);
  for (const Reason& reason : reasons) {
    std::string line = fmt::format("{:>10} of {}  {}", count_text(static_cast<std::uint64_t>(reason.count), "curve"),
                                   count_text(reason.problems.size(), "problem"), reason.text);
    if (reason.problems.size() <= 6) line += fmt::format(": {}", fmt::join(reason.problems, ", "));
    text += tool::wrapped(line, 2);
  }
  return text;
}

std::size_t family_count(const std::vector<AccuracyCurve>& curves) {
  std::vector<std::string> families;
  for (const AccuracyCurve& curve : curves) families.push_back(family_of(curve));
  std::sort(families.begin(), families.end());
  return static_cast<std::size_t>(std::unique(families.begin(), families.end()) - families.begin());
}

// Error and time against the number of corners, at the settings that a scene has by default.
std::string shape_table(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                        engine::Precision precision, bool no_times) {
  std::string text;
  for (const auto kind : shape_classes) {
    std::vector<std::string> head{"corners"};
    for (const char* method : {"4 sub: error", "16 sub: error", "pgs: error", "impulse: error"}) {
      head.emplace_back(method);
      if (!no_times) head.emplace_back("ms/s");
    }
    TextTable table(std::move(head));
    for (const Problem& problem : problems) {
      if (problem.kind != kind) continue;
      std::vector<std::string> row{problem.corner_count == 0 ? "disc" : std::to_string(problem.corner_count)};
      const auto add = [&](std::string_view method, std::size_t index) {
        for (const AccuracyCurve& curve : curves)
          if (curve.problem == problem.name && curve.precision == precision && curve.method.name == method) {
            if (index >= curve.points.size()) break;
            row.push_back(short_number(curve.points[index].error));
            if (!no_times) row.push_back(ms_text(curve.points[index]));
            return;
          }
        row.insert(row.end(), no_times ? 1 : 2, "-");
      };
      add("tgs_soft", 2);
      add("tgs_soft", 4);
      add("pgs", 0);
      add("impulse", 0);
      table.add(std::move(row));
    }
    if (table.row_count() == 0) continue;
    text += fmt::format("\n{}  {}\n", class_name(kind), precision_name(precision)) + table.text();
    if (kind == tool::ProblemClass::stack)
      text += "    not applicable to odd polygons: they end in a corner, on which nothing lies\n";
  }
  return text;
}

// The automatic substeps at each target: what was wanted, kept, chosen and paid.
std::string target_table(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                         bool no_times) {
  std::vector<std::string> head{"problem", "precision", "target", "error / size", "kept", "substeps"};
  if (!no_times) head.emplace_back("ms/s");
  TextTable table(std::move(head), 2);
  for (const AccuracyCurve& curve : curves) {
    if (!curve.method.automatic || curve.corner_count >= 0) continue;
    const auto problem =
        std::find_if(problems.begin(), problems.end(), [&](const Problem& p) { return p.name == curve.problem; });
    if (problem == problems.end() || problem->size == 0) continue;
    for (const AccuracyPoint& point : curve.points) {
      const double error = point.error * problem->scale / problem->size;
      std::vector<std::string> row{
          curve.problem,       std::string(precision_name(curve.precision)), short_number(point.setting.target),
          short_number(error), error <= point.setting.target ? "yes" : "no", std::to_string(point.substeps_most)};
      if (!no_times) row.push_back(ms_text(point));
      table.add(std::move(row));
    }
  }
  if (table.row_count() == 0) return {};
  return "\ntarget_error  automatic substeps: what was asked for, found, chosen and paid\n" + table.text();
}

Json point_json(const AccuracyCurve& curve, const AccuracyPoint& point) {
  Json entry;
  entry["setting"] = tool::setting_text(curve.method, point.setting);
  entry["dt"] = point.setting.dt;
  entry["substeps"] = point.setting.substeps;
  entry["target"] = point.setting.target > 0 ? Json(point.setting.target) : Json(nullptr);
  entry["error_rms"] = number_json(point.error);
  entry["error_max"] = number_json(point.error_max);
  entry["floor"] = number_json(point.floor);
  entry["energy_j"] = number_json(point.energy);
  entry["momentum"] = number_json(point.momentum);
  entry["overlap_max_m"] = number_json(point.overlap_max);
  entry["joint_gap_max_m"] = number_json(point.joint_gap_max);
  entry["substeps_most"] = point.substeps_most;
  entry["ticks"] = point.tick_count;
  entry["ms_per_s"] = {{"min", point.time_ms.min}, {"median", point.time_ms.median}, {"iqr", point.time_ms.iqr}};
  entry["state"] = state_name(point.state);
  entry["hash"] = hex64(point.hash);
  return entry;
}

// Of each family of shapes: error and time against corners, at the settings of shape_table.
std::vector<tool::Plot> shape_plots(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                                    const std::vector<engine::Precision>& precisions) {
  struct Line {
    std::string_view name, method;
    std::size_t index;
  };
  constexpr Line lines[]{{"tgs_soft, 4 substeps", "tgs_soft", 2},
                         {"tgs_soft, 16 substeps", "tgs_soft", 4},
                         {"pgs", "pgs", 0},
                         {"impulse (the thesis')", "impulse", 0}};
  std::vector<tool::Plot> plots;
  for (const auto kind : shape_classes)
    for (const engine::Precision precision : precisions) {
      const std::string name = fmt::format("{} ({})", class_name(kind), precision_name(precision));
      tool::Plot errors{name + ": error by corners", "corners", "relative error (RMS)", false, true, {}};
      tool::Plot times{name + ": time by corners", "corners", "ms per simulated second", false, true, {}};
      for (const Problem& problem : problems)
        if (problem.kind == kind)
          errors.ticks.push_back(problem.corner_count == 0 ? "disc" : std::to_string(problem.corner_count));
      if (errors.ticks.empty()) continue;
      times.ticks = errors.ticks;
      for (const Line& line : lines) {
        tool::PlotCurve error{std::string(line.name), {}, {}, false}, time = error;
        double x = 0;
        for (const Problem& problem : problems) {
          if (problem.kind != kind) continue;
          ++x;
          for (const AccuracyCurve& curve : curves) {
            if (curve.problem != problem.name || curve.precision != precision || curve.method.name != line.method ||
                curve.points.size() <= line.index)
              continue;
            const AccuracyPoint& point = curve.points[line.index];
            error.x.push_back(x);
            error.y.push_back(point.error);
            time.x.push_back(x);
            time.y.push_back(point.time_ms.min);
          }
        }
        errors.curves.push_back(std::move(error));
        times.curves.push_back(std::move(time));
      }
      plots.push_back(std::move(errors));
      plots.push_back(std::move(times));
    }
  return plots;
}

}  // namespace

std::string_view class_name(tool::ProblemClass kind) {
  return tool::problem_class_names[static_cast<std::size_t>(kind)];
}

VerdictCounts verdicts_of(const std::vector<AccuracyCurve>& curves) {
  VerdictCounts counts;
  for (const AccuracyCurve& curve : curves) counts.add(curve.judgement.verdict);
  return counts;
}

std::string accuracy_text(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                          const AccuracyView& view, const std::vector<engine::Precision>& precisions) {
  std::string text;
  if (view.brief) text += brief_table(problems, curves);
  for (const Problem& problem : problems) {
    if (view.brief || (problem.corner_count >= 0 && !view.points)) continue;
    for (const engine::Precision precision : precisions) {
      std::vector<const AccuracyCurve*> own;
      for (const AccuracyCurve& curve : curves)
        if (curve.problem == problem.name && curve.precision == precision) own.push_back(&curve);
      text += fmt::format("\n{}  {}  {}\n", problem.name, precision_name(precision), problem.summary);
      text += view.points ? point_table(own, view.no_times) : curve_table(own, view.no_times);
    }
  }
  for (const engine::Precision precision : precisions)
    if (!view.brief) text += shape_table(problems, curves, precision, view.no_times);
  if (!view.brief) text += target_table(problems, curves, view.no_times);
  text += reason_table(curves, StudyVerdict::falls_short, "falls short  curves that miss a bar, as documented");
  text += reason_table(curves, StudyVerdict::not_judged,
                       "not judged  curves of which nothing is claimed, or that cannot show it");
  text += fmt::format("\n{} of {}: {}\n", count_text(curves.size(), "curve"),
                      count_text(family_count(curves), "problem"), counts_text(verdicts_of(curves)));
  for (const AccuracyCurve& curve : curves)
    if (curve.judgement.verdict == StudyVerdict::fail)
      text += fmt::format("  fail  {}  {}  {}: slope {}, theory {}: {}\n", curve.problem,
                          precision_name(curve.precision), curve.method.name, slope_text(curve.judgement.slope),
                          slope_text(curve.judgement.expected), curve.judgement.reason);
  return text;
}

Json accuracy_json(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                   const std::string& command_line) {
  Json object;
  object["schema"] = "ticktrue.accuracy/2";
  object["command"] = command_line;
  add_counts(object, verdicts_of(curves));
  object["problems"] = Json::array();
  const auto bars_json = [](const Problem& problem) {
    Json bars = Json::array();
    for (const tool::Bar& bar : problem.bars)
      bars.push_back({{"method", bar.method},
                      {"setting", bar.setting.empty() ? Json(nullptr) : Json(bar.setting)},
                      {"error", bar.error > 0 ? Json(bar.error) : Json(nullptr)},
                      {"energy_j", bar.energy > 0 ? Json(bar.energy) : Json(nullptr)}});
    return bars;
  };
  for (const Problem& problem : problems)
    object["problems"].push_back({{"name", problem.name},
                                  {"class", class_name(problem.kind)},
                                  {"summary", problem.summary},
                                  {"reference", problem.reference},
                                  {"duration_s", problem.duration},
                                  {"samples", problem.sample_count},
                                  {"scale", problem.scale},
                                  {"bars", bars_json(problem)},
                                  {"corners", problem.corner_count < 0 ? Json(nullptr) : Json(problem.corner_count)}});
  object["rows"] = Json::array();
  for (const AccuracyCurve& curve : curves) {
    Json row;
    row["problem"] = curve.problem;
    row["precision"] = precision_name(curve.precision);
    row["method"] = curve.method.name;
    row["verdict"] = verdict_name(curve.judgement.verdict);
    row["slope"] = optional_json(curve.judgement.slope);
    row["slope_expected"] = optional_json(curve.judgement.expected);
    row["reason"] = curve.judgement.reason;
    row["cheapest"] = Json::array();
    for (const double target : targets) {
      const AccuracyPoint* point = tool::cheapest(curve, target);
      row["cheapest"].push_back(
          {{"error", target},
           {"setting", point ? Json(tool::setting_text(curve.method, point->setting)) : Json(nullptr)},
           {"ms_per_s", point ? Json(point->time_ms.min) : Json(nullptr)}});
    }
    row["points"] = Json::array();
    for (const AccuracyPoint& point : curve.points) row["points"].push_back(point_json(curve, point));
    object["rows"].push_back(std::move(row));
  }
  return object;
}

std::string samples_csv(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves) {
  using tool::full_number;
  std::string text = tool::csv_line({"problem", "precision", "method", "setting", "time_s", "value", "found", "exact"});
  for (const AccuracyCurve& curve : curves) {
    const auto problem =
        std::find_if(problems.begin(), problems.end(), [&](const Problem& each) { return each.name == curve.problem; });
    for (const AccuracyPoint& point : curve.points)
      for (std::size_t i = 0; i < point.times.size(); ++i) {
        const std::vector<double> exact = problem->exact(point.times[i]);
        for (std::size_t k = 0; k < exact.size(); ++k) {
          const double scale = k < problem->value_scales.size() ? problem->value_scales[k] : 1;
          text += tool::csv_line({curve.problem, std::string(precision_name(curve.precision)), curve.method.name,
                                  tool::setting_text(curve.method, point.setting), full_number(point.times[i]),
                                  k < problem->value_names.size() ? problem->value_names[k] : std::to_string(k),
                                  full_number(point.samples[i][k] * scale), full_number(exact[k] * scale)});
        }
      }
  }
  return text;
}

std::string accuracy_csv(const std::vector<AccuracyCurve>& curves) {
  using tool::full_number;
  std::string text =
      tool::csv_line({"problem",        "class",        "corners",         "precision",     "method",
                      "setting",        "dt_s",         "substeps",        "error_rms",     "error_max",
                      "floor",          "energy_j",     "momentum",        "overlap_max_m", "joint_gap_max_m",
                      "substeps_most",  "ms_per_s_min", "ms_per_s_median", "ms_per_s_iqr",  "slope",
                      "slope_expected", "verdict",      "state",           "hash",          "reason"});
  for (const AccuracyCurve& curve : curves)
    for (const AccuracyPoint& point : curve.points)
      text += tool::csv_line({curve.problem,
                              std::string(class_name(curve.kind)),
                              curve.corner_count < 0 ? "" : std::to_string(curve.corner_count),
                              std::string(precision_name(curve.precision)),
                              curve.method.name,
                              tool::setting_text(curve.method, point.setting),
                              full_number(point.setting.dt),
                              std::to_string(point.setting.substeps),
                              full_number(point.error),
                              full_number(point.error_max),
                              full_number(point.floor),
                              full_number(point.energy),
                              full_number(point.momentum),
                              full_number(point.overlap_max),
                              full_number(point.joint_gap_max),
                              std::to_string(point.substeps_most),
                              full_number(point.time_ms.min),
                              full_number(point.time_ms.median),
                              full_number(point.time_ms.iqr),
                              curve.judgement.slope ? full_number(*curve.judgement.slope) : "",
                              curve.judgement.expected ? full_number(*curve.judgement.expected) : "",
                              std::string(verdict_name(curve.judgement.verdict)),
                              std::string(state_name(point.state)),
                              hex64(point.hash),
                              curve.judgement.reason});
  return text;
}

std::vector<tool::Plot> accuracy_plots(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                                       const std::vector<engine::Precision>& precisions) {
  std::vector<tool::Plot> plots = shape_plots(problems, curves, precisions);
  for (const Problem& problem : problems)
    for (const engine::Precision precision : precisions) {
      if (problem.corner_count >= 0) continue;
      tool::Plot plot{fmt::format("{} ({})", problem.name, precision_name(precision)),
                      "relative error (RMS)",
                      "ms per simulated second",
                      true,
                      true,
                      {}};
      double floor = 0, least = HUGE_VAL, most = 0;
      for (const AccuracyCurve& curve : curves) {
        if (curve.problem != problem.name || curve.precision != precision) continue;
        tool::PlotCurve line{curve.method.name, {}, {}, false};
        for (const AccuracyPoint& point : curve.points) {
          line.x.push_back(point.error);
          line.y.push_back(point.time_ms.min);
          floor = std::max(floor, point.floor);
          least = std::min(least, point.time_ms.min);
          most = std::max(most, point.time_ms.min);
        }
        plot.curves.push_back(std::move(line));
      }
      if (floor > 0) plot.curves.push_back({"rounding", {floor, floor}, {least, most}, true});
      plots.push_back(std::move(plot));
    }
  return plots;
}

}  // namespace ticktrue::cli
