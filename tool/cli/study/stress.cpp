// `ticktrue stress`: stiff and extreme cases, with the number behind each verdict.
// SPDX-License-Identifier: MIT
#include "tool/study/stress/stress.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/cli/study/study_output.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/study/problem_file/stress_file.h"
#include "tool/study/stress/stress_run_time.h"

namespace ticktrue::cli {
namespace {

using tool::full_number;
using tool::RunTimeRow;
using tool::short_number;
using tool::StabilityRow;
using tool::StressRow;
using tool::StudyVerdict;
using tool::TextTable;
using tool::VerdictCounts;

struct StressCommand {
  std::vector<std::string> cases;
  std::vector<std::string> precisions;
  std::uint64_t thread_count = 0;  // 0: as many as there are cores
  bool with_long = false;
  bool no_limits = false;
  bool limits_alone = false;
  bool run_time = false;
  std::string loads = "measured";
  std::uint64_t budget = engine::default_substep_budget;
  bool brief = false;
  bool list = false;
  bool example = false;
  StudyFiles files;
};

std::string bound_text(const StressRow& row) {
  if (std::isinf(row.lower) || (row.lower == 0 && row.upper > 0)) return "<= " + short_number(row.upper);
  return row.lower == row.upper ? "= " + short_number(row.upper)
                                : short_number(row.lower) + ".." + short_number(row.upper);
}

// Beside a number that is outside its bounds.
std::string_view mark_of(StudyVerdict verdict) {
  return verdict == StudyVerdict::fail                                                 ? "!"
         : verdict == StudyVerdict::not_judged || verdict == StudyVerdict::falls_short ? "~"
                                                                                       : " ";
}

std::string cases_text(const std::vector<StressRow>& rows) {
  std::string text;
  for (std::size_t i = 0; i < rows.size();) {
    const StressRow& first = rows[i];
    text += fmt::format("\n{}  {}\n", first.name, precision_name(first.precision));
    text += tool::wrapped(
        fmt::format("{}; {}{}{}", first.what, bound_text(first), first.unit.empty() ? "" : " ", first.unit), 4);
    if (!first.best_known.empty())
      text += tool::wrapped(fmt::format("best known: {} ({})", first.best_known, first.source), 4);
    for (; i < rows.size() && rows[i].name == first.name && rows[i].precision == first.precision; ++i) {
      const StressRow& row = rows[i];
      const bool is_left_out = row.verdict == StudyVerdict::not_applicable;
      std::string line = fmt::format("{:<22}{:>10}  {:<11} {}", row.method, is_left_out ? "-" : short_number(row.value),
                                     is_left_out ? "n/a" : verdict_name(row.verdict), row.reason);
      while (line.back() == ' ') line.pop_back();
      text += tool::wrapped(line, 4);
    }
  }
  return text;
}

// Rows and columns change places.
std::vector<std::vector<std::string>> turned_over(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::vector<std::string>> out(rows[0].size());
  for (const std::vector<std::string>& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) out[i].push_back(row[i]);
  return out;
}

// One line a case, one table for cases of the same methods; of many methods, one line a method. Failures are marked.
std::string brief_text(const std::vector<StressRow>& rows) {
  constexpr std::size_t method_count_max = 5;
  struct Group {
    std::vector<std::string> methods;
    std::vector<std::vector<std::string>> lines;
  };
  std::vector<Group> groups;
  for (std::size_t i = 0; i < rows.size();) {
    const StressRow& first = rows[i];
    std::vector<std::string> methods;
    std::vector<std::string> line{first.name, std::string(precision_name(first.precision)), bound_text(first)};
    for (; i < rows.size() && rows[i].name == first.name && rows[i].precision == first.precision; ++i) {
      methods.push_back(rows[i].method);
      line.push_back(rows[i].verdict == StudyVerdict::not_applicable
                         ? "n/a"
                         : short_number(rows[i].value) + std::string(mark_of(rows[i].verdict)));
    }
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.methods == methods; });
    if (group == groups.end()) group = groups.insert(group, {std::move(methods), {}});
    group->lines.push_back(std::move(line));
  }
  std::string text;
  for (const Group& group : groups) {
    std::vector<std::string> head{"case", "precision", "bounds"};
    head.insert(head.end(), group.methods.begin(), group.methods.end());
    const bool is_wide = group.methods.size() > method_count_max;
    std::vector<std::vector<std::string>> all{std::move(head)};
    all.insert(all.end(), group.lines.begin(), group.lines.end());
    if (is_wide) all = turned_over(all);
    TextTable table(all[0], is_wide ? 1 : 3);
    for (std::size_t i = 1; i < all.size(); ++i) table.add(all[i]);
    text += "\n" + table.text();
  }
  return text +
         "    !: fails.  ~: outside the bounds: a baseline, or falls short as docs/study.md says, or another method "
         "passes\n";
}

std::string limits_text(const std::vector<StabilityRow>& limits) {
  if (limits.empty()) return {};
  TextTable table({"integrator", "precision", "found", "theory", "verdict"}, 2);
  for (const StabilityRow& row : limits)
    table.add({std::string(engine::info_of(engine::integrators, row.integrator).name),
               std::string(precision_name(row.precision)),
               std::isinf(row.found) ? "none" : fmt::format("{:.3f}", row.found),
               std::isinf(row.theory) ? "none" : fmt::format("{:.4f}", row.theory),
               tool::stability_holds(row) ? "pass" : "fail"});
  return "\nstability limits  largest w h at which an undamped oscillation does not grow, by bisection\n" +
         table.text();
}

VerdictCounts verdicts_of(const std::vector<StressRow>& rows, const std::vector<StabilityRow>& limits) {
  VerdictCounts counts;
  for (const StressRow& row : rows) counts.add(row.verdict);
  for (const StabilityRow& row : limits)
    counts.add(tool::stability_holds(row) ? StudyVerdict::pass : StudyVerdict::fail);
  return counts;
}

std::string summary_text(const std::vector<StressRow>& rows, const VerdictCounts& counts) {
  std::string text = "\n" + counts_text(counts) + "\n";
  for (const StressRow& row : rows)
    if (row.verdict == StudyVerdict::fail)
      text += fmt::format("  fail  {}  {}  {}: found {}, expected {}{}{}{}\n", row.name, precision_name(row.precision),
                          row.method, short_number(row.value), bound_text(row), row.unit.empty() ? "" : " ", row.unit,
                          row.reason.empty() ? "" : ": " + row.reason);
  return text;
}

Json report_json(const std::vector<StressRow>& rows, const std::vector<StabilityRow>& limits,
                 const std::string& command_line) {
  Json object;
  object["schema"] = "ticktrue.stress/2";
  object["command"] = command_line;
  add_counts(object, verdicts_of(rows, limits));
  object["rows"] = Json::array();
  for (const StressRow& row : rows)
    object["rows"].push_back(
        {{"case", row.name},
         {"method", row.method},
         {"precision", precision_name(row.precision)},
         {"verdict", verdict_name(row.verdict)},
         {"value", row.verdict == StudyVerdict::not_applicable ? Json(nullptr) : number_json(row.value)},
         {"lower", number_json(row.lower)},
         {"upper", number_json(row.upper)},
         {"unit", row.unit},
         {"what", row.what},
         {"reason", row.reason},
         {"best_known", row.best_known},
         {"source", row.source}});
  object["stability_limits"] = Json::array();
  for (const StabilityRow& row : limits)
    object["stability_limits"].push_back({{"integrator", engine::info_of(engine::integrators, row.integrator).name},
                                          {"precision", precision_name(row.precision)},
                                          {"found", number_json(row.found)},
                                          {"theory", number_json(row.theory)},
                                          {"verdict", tool::stability_holds(row) ? "pass" : "fail"}});
  return object;
}

std::string run_time_text(const std::vector<RunTimeRow>& rows) {
  TextTable table({"scene", "precision", "ticks", "auto ms", "64 sub ms", "ratio", "worst", "over 4", "later",
                   "substeps", "at most", "cut", "limited", "overlap", "gap m"},
                  2);
  for (const RunTimeRow& row : rows) {
    const auto per_tick = [&](double seconds) { return seconds * 1e3 / static_cast<double>(row.tick_count); };
    table.add({row.scene, std::string(precision_name(row.precision)), std::to_string(row.tick_count),
               fmt::format("{:.3g}", per_tick(row.automatic_s)), fmt::format("{:.3g}", per_tick(row.fixed_s)),
               fmt::format("{:.2f}", row.ratio()), fmt::format("{:.2f}", row.worst_ratio),
               fmt::format("{:.2f}", row.default_ratio()), fmt::format("{:.2f}", row.default_later_ratio()),
               std::to_string(row.substeps_most), std::to_string(row.ticks_at_most), std::to_string(row.cut_ticks),
               std::to_string(row.limited_ticks), short_number(row.overlap), short_number(row.gap)});
  }
  return "\nrun time  of a tick, automatic substeps and 64 fixed ones in turns on one thread\n" + table.text() +
         tool::wrapped(fmt::format("ratio: auto over 64. worst: the same of {} ticks. over 4: auto over four "
                                   "substeps. later: the same without the first {} ticks. substeps: the most of an "
                                   "island. at most: ticks in which an island "
                                   "had the most that the scene allows. cut: ticks in which the budget left a "
                                   "shock unsettled. limited: ticks in which it took substeps from an island. "
                                   "overlap: deepest, of the smallest size. gap: widest. Reported, not judged",
                                   tool::run_time_window, tool::run_time_settling),
                       4);
}

Json run_time_json(const std::vector<RunTimeRow>& rows, const std::string& command_line) {
  Json object;
  object["schema"] = "ticktrue.stress_run_time/1";
  object["command"] = command_line;
  object["rows"] = Json::array();
  for (const RunTimeRow& row : rows)
    object["rows"].push_back({{"scene", row.scene},
                              {"what", row.what},
                              {"precision", precision_name(row.precision)},
                              {"ticks", row.tick_count},
                              {"automatic_s", row.automatic_s},
                              {"fixed_s", row.fixed_s},
                              {"default_s", row.default_s},
                              {"automatic_later_s", row.automatic_later_s},
                              {"default_later_s", row.default_later_s},
                              {"ratio", row.ratio()},
                              {"worst_ratio", row.worst_ratio},
                              {"substeps_most", row.substeps_most},
                              {"ticks_at_most", row.ticks_at_most},
                              {"cut_ticks", row.cut_ticks},
                              {"limited_ticks", row.limited_ticks},
                              {"overlap", number_json(row.overlap)},
                              {"gap", number_json(row.gap)}});
  return object;
}

std::string run_time_csv(const std::vector<RunTimeRow>& rows) {
  std::string text = tool::csv_line({"scene", "precision", "ticks", "automatic_s", "fixed_s", "default_s",
                                     "automatic_later_s", "default_later_s", "ratio", "worst_ratio", "substeps_most",
                                     "ticks_at_most", "cut_ticks", "limited_ticks", "overlap", "gap_m"});
  for (const RunTimeRow& row : rows)
    text += tool::csv_line({row.scene, std::string(precision_name(row.precision)), std::to_string(row.tick_count),
                            full_number(row.automatic_s), full_number(row.fixed_s), full_number(row.default_s),
                            full_number(row.automatic_later_s), full_number(row.default_later_s),
                            full_number(row.ratio()), full_number(row.worst_ratio), std::to_string(row.substeps_most),
                            std::to_string(row.ticks_at_most), std::to_string(row.cut_ticks),
                            std::to_string(row.limited_ticks), full_number(row.overlap), full_number(row.gap)});
  return text;
}

// A point for each scene: automatic substeps over 64 fixed ones, a curve for each precision.
std::vector<tool::Plot> run_time_plots(const std::vector<RunTimeRow>& rows) {
  tool::Plot plot{"run time of automatic substeps", "", "over 64 fixed substeps", false, true, {}};
  plot.joined = false;
  for (const auto& info : engine::precisions) {
    tool::PlotCurve curve{std::string(info.name), {}, {}, false};
    for (const RunTimeRow& row : rows) {
      auto tick = std::find(plot.ticks.begin(), plot.ticks.end(), row.scene);
      if (tick == plot.ticks.end()) tick = plot.ticks.insert(tick, row.scene);
      if (row.precision != info.kind) continue;
      curve.x.push_back(static_cast<double>(tick - plot.ticks.begin()) + 1);
      curve.y.push_back(row.ratio());
    }
    if (!curve.x.empty()) plot.curves.push_back(std::move(curve));
  }
  return {plot};
}

std::string csv_of(const std::vector<StressRow>& rows) {
  std::string text = tool::csv_line(
      {"case", "method", "precision", "verdict", "value", "lower", "upper", "unit", "reason", "best_known", "source"});
  for (const StressRow& row : rows)
    text += tool::csv_line(
        {row.name, row.method, std::string(precision_name(row.precision)), std::string(verdict_name(row.verdict)),
         row.verdict == StudyVerdict::not_applicable ? "" : full_number(row.value), full_number(row.lower),
         full_number(row.upper), row.unit, row.reason, row.best_known, row.source});
  return text;
}

// One diagram a precision: how far each case is from its upper bound, per method.
std::vector<tool::Plot> plots_of(const std::vector<StressRow>& rows) {
  std::vector<tool::Plot> plots;
  for (const auto& info : engine::precisions) {
    const engine::Precision precision = info.kind;
    if (std::none_of(rows.begin(), rows.end(), [&](const StressRow& row) { return row.precision == precision; }))
      continue;
    tool::Plot plot{
        fmt::format("stress ({})", precision_name(precision)), "", "found over the upper bound", false, true, {}};
    plot.joined = false;
    plot.y_least = 1e-4;
    plot.y_most = 1e4;
    std::string name;
    for (const StressRow& row : rows) {
      if (row.precision != precision) continue;
      if (row.name != name) plot.ticks.push_back(row.name);
      name = row.name;
      if (row.verdict == StudyVerdict::not_applicable || !(row.upper > 0)) continue;
      auto curve =
          std::find_if(plot.curves.begin(), plot.curves.end(), [&](const auto& c) { return c.name == row.method; });
      if (curve == plot.curves.end()) curve = plot.curves.insert(curve, {row.method, {}, {}, false});
      curve->x.push_back(static_cast<double>(plot.ticks.size()));
      curve->y.push_back(row.value / row.upper);
    }
    plot.curves.push_back({"bound", {0.5, static_cast<double>(plot.ticks.size()) + 0.5}, {1, 1}, true});
    plots.push_back(std::move(plot));
  }
  return plots;
}

int list_cases() {
  TextTable table({"case", "what"}, 2);
  for (const tool::StressCase& each : tool::stress_cases())
    table.add({each.name + (each.is_long ? " (--long)" : ""), each.what});
  print(table.text());
  return exit_ok;
}

std::vector<engine::Precision> precisions_of(const StressCommand& command) {
  std::vector<engine::Precision> precisions;
  for (const std::string& name : command.precisions)
    precisions.push_back(engine::find_choice(engine::precisions, name)->kind);
  return precisions;
}

/// The precisions of --precision. Without the option: f32 alone.
std::vector<engine::Precision> precisions_or_f32(const StressCommand& command) {
  const std::vector<engine::Precision> precisions = precisions_of(command);
  return precisions.empty() ? std::vector{engine::Precision::f32} : precisions;
}

int run_run_times(const StressCommand& command) {
  tool::RunTimeOptions options;
  options.names = command.cases;
  options.precisions = precisions_or_f32(command);
  options.loads = engine::find_choice(engine::substep_loads, command.loads)->kind;
  options.budget = static_cast<int>(command.budget);
  Progress progress("stress --run-time", 1, "ticks");
  options.progress = [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
  const auto rows = tool::run_times(options);
  progress.finish();
  if (!rows) return fail_usage(rows.error());
  std::string command_line = "ticktrue stress --run-time" + words_text(command.cases);
  for (const std::string& name : command.precisions) command_line += " --precision " + name;
  if (command.loads != "measured") command_line += " --loads " + command.loads;
  if (command.budget != engine::default_substep_budget) command_line += " --budget " + std::to_string(command.budget);
  if (command.files.json)
    print_json(run_time_json(*rows, command_line));
  else
    print("stress  " + command_line + "\n" + run_time_text(*rows));
  return write_study_files(command.files, run_time_csv(*rows), run_time_plots(*rows));
}

/// Warns of each case of a user's file of which nothing was judged. True if there is none.
bool warn_of_own(const std::vector<tool::StressCase>& own, const std::vector<StressRow>& rows) {
  bool all_are_judged = true;
  for (const tool::StressCase& mine : own) {
    const bool is_judged = std::any_of(rows.begin(), rows.end(), [&](const StressRow& row) {
      return row.name == mine.name && row.verdict != StudyVerdict::not_judged &&
             row.verdict != StudyVerdict::not_applicable;
    });
    if (!is_judged) print_warning(mine.name + ": nothing was judged of what the file claims");
    all_are_judged = all_are_judged && is_judged;
  }
  return all_are_judged;
}

int run_stress_command(const StressCommand& command) {
  if (command.list) return list_cases();
  if (command.example) {
    print(tool::example_stress);
    return exit_ok;
  }
  if (const Status status = check_study_files(command.files, own_files(command.cases)); !status)
    return fail_usage(status.error());
  if (command.run_time) return run_run_times(command);
  tool::StressOptions options;
  for (const std::string& name : command.cases) {
    if (std::filesystem::path(name).extension() != ".json") {
      options.names.push_back(name);
      continue;
    }
    auto own = tool::read_stress_file(name);
    if (!own) return fail_usage(own.error());
    const auto is_taken = [&](const tool::StressCase& mine) {
      return std::any_of(options.own.begin(), options.own.end(),
                         [&](const tool::StressCase& other) { return other.name == mine.name; });
    };
    if (std::any_of(own->begin(), own->end(), is_taken))
      for (tool::StressCase& mine : *own) mine.name += " (" + name + ")";
    std::move(own->begin(), own->end(), std::back_inserter(options.own));
  }
  options.with_long = command.with_long;
  options.thread_count = command.thread_count > 0 ? static_cast<unsigned>(command.thread_count) : core_count();
  options.precisions = precisions_of(command);
  Progress progress("stress", 1, "runs");
  options.progress = [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
  Result<std::vector<StressRow>> rows = std::vector<StressRow>();
  if (!command.limits_alone) rows = tool::run_stress(options);
  progress.finish();
  if (!rows) return fail_usage(rows.error());
  std::vector<StabilityRow> limits;
  if (command.cases.empty() && !command.no_limits) {
    auto found = tool::stability_limits(precisions_or_f32(command), options.thread_count);
    if (!found) return fail_usage(found.error());
    limits = *std::move(found);
  }
  std::string command_line = "ticktrue stress" + words_text(command.cases);
  for (const engine::Precision precision : options.precisions)
    command_line += " --precision " + std::string(precision_name(precision));
  if (command.with_long) command_line += " --long";
  if (command.brief) command_line += " --brief";
  if (command.limits_alone) command_line += " --limits";
  if (command.no_limits) command_line += " --no-limits";
  const VerdictCounts counts = verdicts_of(*rows, limits);
  if (command.files.json)
    print_json(report_json(*rows, limits, command_line));
  else
    print("stress  " + command_line + "\n" + (command.brief ? brief_text(*rows) : cases_text(*rows)) +
          limits_text(limits) + summary_text(*rows, counts) +
          (command.cases.empty() ? "spinning tops and gyroscopic terms: not applicable in two dimensions\n" : ""));
  if (const int code = write_study_files(command.files, csv_of(*rows), plots_of(*rows)); code != exit_ok) return code;
  const bool all_are_judged = warn_of_own(options.own, *rows);
  return counts.of(StudyVerdict::fail) > 0 || !all_are_judged ? exit_finding : exit_ok;
}

}  // namespace

void add_stress(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<StressCommand>();
  CLI::App* command = app.add_subcommand("stress", "Stiff and extreme cases: pass or fail, and the number behind it")
                          ->group(group_study);
  command->add_option(
      "CASE", options->cases,
      "Cases of --list, how their names begin, or files of one's own (my.json: docs/study.md); default: all");
  std::vector<std::string> names;
  for (const auto& info : engine::precisions) names.emplace_back(info.name);
  command
      ->add_option("--precision", options->precisions,
                   "f32, f64; default: f32, and of a file of one's own what its scene says")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names));
  command->add_flag("--long", options->with_long, "Cases that take minutes too");
  auto* no_limits = command->add_flag("--no-limits", options->no_limits, "Without the table of stability limits");
  auto* limits =
      command->add_flag("--limits", options->limits_alone, "The table of stability limits alone")->excludes(no_limits);
  auto* run_time =
      command
          ->add_flag("--run-time", options->run_time,
                     "Run time of automatic substeps beside 64 fixed ones, in scenes of its own (CASE: their names)")
          ->excludes(limits);
  std::vector<std::string> loads;
  for (const auto& info : engine::substep_loads) loads.emplace_back(info.name);
  command->add_option("--loads", options->loads, "Of --run-time: substep_loads of the scenes; default: measured")
      ->needs(run_time)
      ->check(CLI::IsMember(loads));
  add_number(*command, "--budget", options->budget,
             "Of --run-time: substep_budget of the scenes, 0: no limit; default: 184",
             {0, static_cast<std::uint64_t>(engine::ranges::substep_budget.max)})
      ->needs(run_time);
  command->add_flag("--brief", options->brief, "One line a case");
  command->add_flag("--list", options->list, "List the cases, run none");
  command->add_flag("--example", options->example, "Print a file of one's own to begin with, run none");
  add_number(*command, "-j,--jobs", options->thread_count, "Threads; default: one a core", {1, 1024});
  add_study_files(*command, options->files);
  set_examples(*command,
               "ticktrue stress\nticktrue stress tower top_heavy --precision f32,f64\nticktrue stress spring --json\n"
               "ticktrue stress --example > my.json\n"
               "ticktrue stress my.json");
  command->callback([options, &context] { context.exit_code = run_stress_command(*options); });
}

}  // namespace ticktrue::cli
