// `ticktrue accuracy`: error against run time on problems whose answers are known.
// SPDX-License-Identifier: MIT
#include "verifier/study/accuracy.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "base/hash.h"
#include "engine/math/trig.h"
#include "verifier/cli/commands.h"
#include "verifier/cli/json_output.h"
#include "verifier/cli/progress.h"
#include "verifier/cli/study_output.h"
#include "verifier/parallel.h"
#include "verifier/study/peer_curves.h"

namespace ticktrue::cli {
namespace {

using verifier::AccuracyCurve;
using verifier::AccuracyPoint;
using verifier::Problem;
using verifier::short_number;
using verifier::StudyVerdict;
using verifier::TextTable;
using verifier::VerdictCounts;

constexpr double targets[]{0.01, 0.001, 0.0001};
constexpr verifier::ProblemClass shape_classes[]{verifier::ProblemClass::roll, verifier::ProblemClass::slide,
                                                 verifier::ProblemClass::stack, verifier::ProblemClass::bounce};

struct AccuracyCommand {
  std::vector<std::string> problems;
  std::vector<std::string> precisions;
  std::string peer;
  std::uint64_t repeat_count = 7;
  std::uint64_t thread_count = 0;  // 0: as many as there are cores
  bool points = false;
  bool brief = false;
  bool no_times = false;
  bool list = false;
  StudyFiles files;
};

std::string_view class_name(verifier::ProblemClass kind) {
  return verifier::problem_class_names[static_cast<std::size_t>(kind)];
}
std::string_view state_name(verifier::PointState state) {
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
  const AccuracyPoint* point = no_times ? verifier::coarsest(curve, error) : verifier::cheapest(curve, error);
  if (!point) return "-";
  const std::string setting = verifier::setting_text(curve.method, point->setting);
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
  for (std::size_t i = 0; i < reasons.size(); ++i)
    text += verifier::wrapped(fmt::format("[{}] {}", i + 1, reasons[i]), 4);
  return text;
}

std::string point_table(const std::vector<const AccuracyCurve*>& curves, bool no_times) {
  std::vector<std::string> head{"method", "setting", "error RMS", "max", "floor", "energy J", "overlap", "gap", "hash"};
  if (!no_times) head.insert(head.end(), {"ms/s min", "median", "IQR"});
  TextTable table(std::move(head), 2);
  for (const AccuracyCurve* curve : curves)
    for (const AccuracyPoint& point : curve->points) {
      std::vector<std::string> row{curve->method.name,
                                   verifier::setting_text(curve->method, point.setting),
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
                   "explained", "fail"},
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
           std::to_string(counts.of(StudyVerdict::pass)),
           std::to_string(counts.of(StudyVerdict::expected) + counts.of(StudyVerdict::not_applicable)),
           std::to_string(counts.of(StudyVerdict::fail))});
      last = problem.name;
    }
  return "\n" + table.text();
}

// Why curves without pass or fail have neither.
std::string explained_table(const std::vector<AccuracyCurve>& curves) {
  struct Reason {
    std::string text;
    int count = 0;
    std::vector<std::string> problems;
  };
  std::vector<Reason> reasons;
  for (const AccuracyCurve& curve : curves) {
    if (curve.judgement.verdict != StudyVerdict::expected) continue;
    auto found = std::find_if(reasons.begin(), reasons.end(),
                              [&](const Reason& reason) { return reason.text == curve.judgement.reason; });
    if (found == reasons.end()) found = reasons.insert(found, {curve.judgement.reason, 0, {}});
    ++found->count;
    if (std::find(found->problems.begin(), found->problems.end(), curve.problem) == found->problems.end())
      found->problems.push_back(curve.problem);
  }
  if (reasons.empty()) return {};
  std::sort(reasons.begin(), reasons.end(),
            [](const Reason& a, const Reason& b) { return a.count != b.count ? a.count > b.count : a.text < b.text; });
  std::string text = "\nexplained  curves of which no order is claimed, or that cannot show it\n";
  for (const Reason& reason : reasons) {
    std::string line = fmt::format("{:>4} curves  {}", reason.count, reason.text);
    if (reason.problems.size() <= 6) line += fmt::format(": {}", fmt::join(reason.problems, ", "));
    text += verifier::wrapped(line, 2);
  }
  return text;
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
    if (kind == verifier::ProblemClass::stack)
      text += "    not applicable to odd polygons: they end in a corner, on which nothing lies\n";
  }
  return text;
}

VerdictCounts verdicts_of(const std::vector<AccuracyCurve>& curves) {
  VerdictCounts counts;
  for (const AccuracyCurve& curve : curves) counts.add(curve.judgement.verdict);
  return counts;
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

std::string report_text(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                        const AccuracyCommand& command, const std::vector<engine::Precision>& precisions) {
  std::string text;
  if (command.brief) text += brief_table(problems, curves);
  for (const Problem& problem : problems) {
    if (command.brief || (problem.corner_count >= 0 && !command.points)) continue;
    for (const engine::Precision precision : precisions) {
      std::vector<const AccuracyCurve*> own;
      for (const AccuracyCurve& curve : curves)
        if (curve.problem == problem.name && curve.precision == precision) own.push_back(&curve);
      text += fmt::format("\n{}  {}  {}\n", problem.name, precision_name(precision), problem.summary);
      text += command.points ? point_table(own, command.no_times) : curve_table(own, command.no_times);
    }
  }
  for (const engine::Precision precision : precisions)
    if (!command.brief) text += shape_table(problems, curves, precision, command.no_times);
  if (!command.brief) text += target_table(problems, curves, command.no_times);
  text += explained_table(curves);
  text += fmt::format("\n{} curves: {}\n", curves.size(), counts_text(verdicts_of(curves)));
  for (const AccuracyCurve& curve : curves)
    if (curve.judgement.verdict == StudyVerdict::fail)
      text += fmt::format("  fail  {}  {}  {}: slope {}, theory {}: {}\n", curve.problem,
                          precision_name(curve.precision), curve.method.name, slope_text(curve.judgement.slope),
                          slope_text(curve.judgement.expected), curve.judgement.reason);
  return text;
}

Json point_json(const AccuracyCurve& curve, const AccuracyPoint& point) {
  Json entry;
  entry["setting"] = verifier::setting_text(curve.method, point.setting);
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

Json report_json(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                 const std::string& command_line) {
  Json object;
  object["schema"] = "ticktrue.accuracy/1";
  object["command"] = command_line;
  add_counts(object, verdicts_of(curves));
  object["problems"] = Json::array();
  for (const Problem& problem : problems)
    object["problems"].push_back({{"name", problem.name},
                                  {"class", class_name(problem.kind)},
                                  {"summary", problem.summary},
                                  {"reference", problem.reference},
                                  {"duration_s", problem.duration},
                                  {"samples", problem.sample_count},
                                  {"scale", problem.scale},
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
      const AccuracyPoint* point = verifier::cheapest(curve, target);
      row["cheapest"].push_back(
          {{"error", target},
           {"setting", point ? Json(verifier::setting_text(curve.method, point->setting)) : Json(nullptr)},
           {"ms_per_s", point ? Json(point->time_ms.min) : Json(nullptr)}});
    }
    row["points"] = Json::array();
    for (const AccuracyPoint& point : curve.points) row["points"].push_back(point_json(curve, point));
    object["rows"].push_back(std::move(row));
  }
  return object;
}

std::string csv_of(const std::vector<AccuracyCurve>& curves) {
  using verifier::full_number;
  std::string text =
      verifier::csv_line({"problem",        "class",        "corners",         "precision",     "method",
                          "setting",        "dt_s",         "substeps",        "error_rms",     "error_max",
                          "floor",          "energy_j",     "momentum",        "overlap_max_m", "joint_gap_max_m",
                          "substeps_most",  "ms_per_s_min", "ms_per_s_median", "ms_per_s_iqr",  "slope",
                          "slope_expected", "verdict",      "state",           "hash",          "reason"});
  for (const AccuracyCurve& curve : curves)
    for (const AccuracyPoint& point : curve.points)
      text += verifier::csv_line({curve.problem,
                                  std::string(class_name(curve.kind)),
                                  curve.corner_count < 0 ? "" : std::to_string(curve.corner_count),
                                  std::string(precision_name(curve.precision)),
                                  curve.method.name,
                                  verifier::setting_text(curve.method, point.setting),
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

// Of each family of shapes: error and time against corners, at the settings of shape_table.
std::vector<verifier::Plot> shape_plots(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                                        const std::vector<engine::Precision>& precisions) {
  struct Line {
    std::string_view name, method;
    std::size_t index;
  };
  constexpr Line lines[]{{"tgs_soft, 4 substeps", "tgs_soft", 2},
                         {"tgs_soft, 16 substeps", "tgs_soft", 4},
                         {"pgs", "pgs", 0},
                         {"impulse (the thesis')", "impulse", 0}};
  std::vector<verifier::Plot> plots;
  for (const auto kind : shape_classes)
    for (const engine::Precision precision : precisions) {
      const std::string name = fmt::format("{} ({})", class_name(kind), precision_name(precision));
      verifier::Plot errors{name + ": error by corners", "corners", "relative error (RMS)", false, true, {}};
      verifier::Plot times{name + ": time by corners", "corners", "ms per simulated second", false, true, {}};
      for (const Problem& problem : problems)
        if (problem.kind == kind)
          errors.ticks.push_back(problem.corner_count == 0 ? "disc" : std::to_string(problem.corner_count));
      if (errors.ticks.empty()) continue;
      times.ticks = errors.ticks;
      for (const Line& line : lines) {
        verifier::PlotCurve error{std::string(line.name), {}, {}, false}, time = error;
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

// One diagram a problem and precision: error across, time upwards; the floor of rounding as a line.
std::vector<verifier::Plot> plots_of(const std::vector<Problem>& problems, const std::vector<AccuracyCurve>& curves,
                                     const std::vector<engine::Precision>& precisions) {
  std::vector<verifier::Plot> plots = shape_plots(problems, curves, precisions);
  for (const Problem& problem : problems)
    for (const engine::Precision precision : precisions) {
      if (problem.corner_count >= 0) continue;
      verifier::Plot plot{fmt::format("{} ({})", problem.name, precision_name(precision)),
                          "relative error (RMS)",
                          "ms per simulated second",
                          true,
                          true,
                          {}};
      double floor = 0, least = HUGE_VAL, most = 0;
      for (const AccuracyCurve& curve : curves) {
        if (curve.problem != problem.name || curve.precision != precision) continue;
        verifier::PlotCurve line{curve.method.name, {}, {}, false};
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

Result<std::vector<Problem>> chosen_problems(const std::vector<std::string>& names) {
  std::vector<Problem> all = verifier::verification_problems();
  std::vector<Problem> shapes = verifier::shape_problems();
  all.insert(all.end(), std::make_move_iterator(shapes.begin()), std::make_move_iterator(shapes.end()));
  if (names.empty()) return all;
  std::vector<std::string> known{"shapes"};
  for (const Problem& problem : all) known.push_back(problem.name);
  for (const std::string_view name : verifier::problem_class_names) known.emplace_back(name);
  std::vector<Problem> chosen;
  for (const std::string& name : names) {
    const std::size_t before = chosen.size();
    for (const Problem& problem : all)
      if (problem.name == name ||
          (problem.name != name && class_name(problem.kind) == name &&
           std::none_of(all.begin(), all.end(), [&](const Problem& p) { return p.name == name; })) ||
          (name == "shapes" && problem.corner_count >= 0))
        chosen.push_back(problem);
    if (chosen.size() > before) continue;
    const std::string nearest = nearest_name(name, known);
    return Error{ErrorCode::usage, "accuracy: found problem \"" + name + "\", expected one of --list",
                 nearest.empty() ? "see `ticktrue accuracy --list`" : "did you mean " + nearest + "?"};
  }
  return chosen;
}

int list_problems(const std::vector<Problem>& problems) {
  TextTable table({"problem", "class", "what", "reference"}, 4);
  for (const Problem& problem : problems)
    table.add({problem.name, std::string(class_name(problem.kind)), problem.summary, ""});
  print(table.text());
  return exit_ok;
}

int run_peer(const AccuracyCommand& command, unsigned thread_count);

int run_accuracy_command(const AccuracyCommand& command) {
  const unsigned thread_count =
      command.thread_count > 0 ? static_cast<unsigned>(command.thread_count) : verifier::core_count();
  if (!command.peer.empty()) return run_peer(command, thread_count);
  const Result<std::vector<Problem>> problems = chosen_problems(command.problems);
  if (!problems) return fail_usage(problems.error());
  if (command.list) return list_problems(*problems);
  verifier::AccuracyOptions options;
  options.precisions.clear();
  for (const std::string& name : command.precisions)
    options.precisions.push_back(engine::find_choice(engine::precisions, name)->kind);
  options.repeat_max = command.no_times ? 1 : static_cast<int>(command.repeat_count);
  options.thread_count = thread_count;
  Progress progress("accuracy", 1, "curves");
  options.progress = [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
  const auto curves = verifier::run_accuracy(*problems, options);
  progress.finish();
  if (!curves) return fail_usage(curves.error());
  std::string command_line = "ticktrue accuracy";
  for (const std::string& name : command.problems) command_line += " " + name;
  for (const engine::Precision precision : options.precisions)
    command_line += " --precision " + std::string(precision_name(precision));
  if (command.brief) command_line += " --brief";
  if (command.no_times)
    command_line += " --no-times";
  else
    command_line += fmt::format(" --repeats {} -j {}", options.repeat_max, thread_count);
  if (command.files.json)
    print_json(report_json(*problems, *curves, command_line));
  else
    print("accuracy  " + command_line + "\n" + report_text(*problems, *curves, command, options.precisions));
  if (const int code =
          write_study_files(command.files, csv_of(*curves), plots_of(*problems, *curves, options.precisions));
      code != exit_ok)
    return code;
  return verdicts_of(*curves).of(StudyVerdict::fail) > 0 ? exit_finding : exit_ok;
}

// ---- Beside Box2D ----

Json peer_json(const std::vector<verifier::PeerCurves>& scenes) {
  Json object;
  object["schema"] = "ticktrue.accuracy_peer/1";
  object["peer"] = {{"name", "Box2D"}, {"version", verifier::peer_version()}};
  int passed = 0;
  for (const auto& scene : scenes) passed += scene.holds ? 1 : 0;
  object["passed"] = passed;
  object["failed"] = static_cast<int>(scenes.size()) - passed;
  object["expected"] = 0;
  object["not_applicable"] = 0;
  object["rows"] = Json::array();
  for (const auto& scene : scenes) {
    Json row{{"scene", scene.name}, {"measure", scene.measure}, {"verdict", scene.holds ? "pass" : "fail"}};
    row["ratio"] = number_json(scene.ratio);
    const auto points_json = [](const std::vector<verifier::PeerPoint>& points) {
      Json array = Json::array();
      for (const auto& point : points)
        array.push_back({{"setting", point.setting},
                         {"error_m", number_json(point.error)},
                         {"error_max_m", number_json(point.error_max)},
                         {"stands", point.stands},
                         {"ms_per_tick",
                          {{"min", point.time_ms.min}, {"median", point.time_ms.median}, {"iqr", point.time_ms.iqr}}}});
      return array;
    };
    row["ours"] = points_json(scene.ours);
    row["box2d"] = points_json(scene.box2d);
    object["rows"].push_back(std::move(row));
  }
  return object;
}

std::string peer_text(const std::vector<verifier::PeerCurves>& scenes) {
  std::string text = "accuracy  ticktrue accuracy --peer box2d  Box2D " + verifier::peer_version() + "\n";
  for (const auto& scene : scenes) {
    text += fmt::format("\n{}  {}\n", scene.name, scene.measure);
    TextTable table(
        {"engine", "setting", "error mm", "max mm", "ms/tick", "min", "IQR", "ours at no more time: error mm", "ratio"},
        2);
    const auto add = [&](std::string_view engine, const verifier::PeerPoint& point, bool is_peer) {
      std::vector<std::string> row{std::string(engine),
                                   point.setting,
                                   point.stands        ? short_number(point.error * 1e3)
                                   : point.error > 1e8 ? std::string("not finite")
                                                       : "fell " + short_number(point.error * 1e3),
                                   short_number(point.error_max * 1e3),
                                   fmt::format("{:.4f}", point.time_ms.median),
                                   fmt::format("{:.4f}", point.time_ms.min),
                                   fmt::format("{:.4f}", point.time_ms.iqr)};
      if (is_peer) {
        const verifier::PeerPoint* ours = verifier::best_within(scene.ours, point.time_ms.min);
        row.push_back(ours ? short_number(ours->error * 1e3) + " (" + ours->setting + ")" : "none so quick");
        row.push_back(ours && point.error > 0 ? short_number(ours->error / point.error) : "-");
      }
      table.add(std::move(row));
    };
    for (const auto& point : scene.ours) add("tgs_soft", point, false);
    for (const auto& point : scene.box2d) add("Box2D", point, true);
    text += table.text();
    text += verifier::wrapped(scene.conclusion, 4);
  }
  return text;
}

int run_peer(const AccuracyCommand& command, unsigned) {
  Progress progress("accuracy --peer box2d", 1, "runs");
  const auto scenes =
      verifier::run_peer_curves(command.problems, static_cast<int>(command.repeat_count),
                                [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); });
  progress.finish();
  if (!scenes) return fail_usage(scenes.error());
  if (command.files.json)
    print_json(peer_json(*scenes));
  else
    print(peer_text(*scenes));
  std::string csv = verifier::csv_line({"scene", "engine", "setting", "error_m", "error_max_m", "stands",
                                        "ms_per_tick_min", "ms_per_tick_median", "ms_per_tick_iqr"});
  std::vector<verifier::Plot> plots;
  for (const auto& scene : *scenes) {
    verifier::Plot plot{scene.name, "error, m", "ms per tick", true, true, {}};
    for (const auto* points : {&scene.ours, &scene.box2d}) {
      const std::string name = points == &scene.ours ? "tgs_soft" : "Box2D";
      verifier::PlotCurve line{name, {}, {}, false};
      for (const auto& point : *points) {
        if (point.stands) {  // how far a heap is from the stack that it was says nothing
          line.x.push_back(point.error);
          line.y.push_back(point.time_ms.min);
        }
        csv += verifier::csv_line(
            {scene.name, name, point.setting, verifier::full_number(point.error),
             verifier::full_number(point.error_max), point.stands ? "1" : "0", verifier::full_number(point.time_ms.min),
             verifier::full_number(point.time_ms.median), verifier::full_number(point.time_ms.iqr)});
      }
      plot.curves.push_back(std::move(line));
    }
    plots.push_back(std::move(plot));
  }
  if (const int code = write_study_files(command.files, csv, plots); code != exit_ok) return code;
  return std::all_of(scenes->begin(), scenes->end(), [](const auto& scene) { return scene.holds; }) ? exit_ok
                                                                                                    : exit_finding;
}

}  // namespace

void add_accuracy(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<AccuracyCommand>();
  CLI::App* command =
      app.add_subcommand("accuracy", "Error against run time on problems whose answers are known")->group(group_study);
  command->add_option("PROBLEM", options->problems,
                      "Problems or classes of --list, or shapes; default: all. With --peer: its scenes");
  std::vector<std::string> names;
  for (const auto& info : engine::precisions) names.emplace_back(info.name);
  options->precisions = {"f64", "f32"};
  command->add_option("--precision", options->precisions, "f64, f32; default: both")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  add_number(*command, "--repeats", options->repeat_count, "Timed runs of a point at most; default: 7", {1, 1000});
  command->add_option("--peer", options->peer, "Error against time beside another engine on four scenes")
      ->check(CLI::IsMember({"box2d"}));
  command->add_flag("--points", options->points, "Every point of every curve, instead of one line a curve");
  command->add_flag("--brief", options->brief, "One line a problem");
  command->add_flag("--no-times", options->no_times, "What is the same on every machine, to the last digit");
  command->add_flag("--list", options->list, "List the problems, run none");
  add_number(*command, "-j,--jobs", options->thread_count, "Threads; default: one a core. 1 gives the quietest times",
             {1, 1024});
  add_study_files(*command, options->files);
  set_examples(*command,
               "ticktrue accuracy\n"
               "ticktrue accuracy pendulum kepler --precision f64 --plot pendulum.svg\n"
               "ticktrue accuracy shapes --csv shapes.csv\n"
               "ticktrue accuracy --peer box2d");
  command->callback([options, &context] { context.exit_code = run_accuracy_command(*options); });
}

}  // namespace ticktrue::cli
