// `ticktrue crosscheck`: the same scene in Box2D 2.4.1 or Box2D 3 and in the engine, criterion by criterion.
// SPDX-License-Identifier: MIT
#include "tool/crosscheck/crosscheck.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/crosscheck/peers.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/study/crosscheck_suite.h"

namespace ticktrue::cli {
namespace {

using tool::Agreement;
using tool::CriterionResult;
using tool::CrosscheckReport;
using tool::CrosscheckSolver;
using tool::PeerKind;

constexpr std::size_t text_width = 116;  // of a line

struct CrosscheckCommand {
  std::vector<std::string> scenes;  // one scene, or scenes of the suite
  bool suite = false;
  bool match_skin = false;
  std::vector<std::string> solvers;
  std::vector<std::string> peers;  // none: box2d2
  std::uint64_t seed_count = 5;
  double seconds = 0;              // 0: 20, or what the suite's scene says
  std::uint64_t thread_count = 0;  // 0: as many as there are cores
  bool json = false;
};

std::string_view verdict_name(Agreement verdict) {
  return tool::verdict_names[static_cast<std::size_t>(verdict)];
}

// Three digits, four decimals at most: the JSON has them all.
std::string brief_number(double value) {
  if (!std::isfinite(value)) return "-";
  if (std::fabs(value) >= 0.1) return fmt::format("{:.4g}", value);
  std::string text = fmt::format("{:.4f}", value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

// Mean of the seeds, with their range where it shows; infinite values (never at rest) counted apart.
std::string value_text(const std::vector<double>& values) {
  if (values.empty()) return "-";
  std::vector<double> finite;
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite), [](double v) { return std::isfinite(v); });
  if (finite.empty()) return "never";
  double mean = 0;
  for (const double value : finite) mean += value / static_cast<double>(finite.size());
  const auto [lowest, highest] = std::minmax_element(finite.begin(), finite.end());
  const std::string low = brief_number(*lowest);
  const std::string high = brief_number(*highest);
  std::string text = brief_number(mean);
  if (low != high) text += fmt::format(" ({}..{})", low, high);
  if (finite.size() < values.size()) text += fmt::format(" {} never", values.size() - finite.size());
  return text;
}

// Lines of at most text_width columns, indented.
std::string wrapped(std::string_view text, std::size_t indent) {
  std::string lines;
  while (!text.empty()) {
    std::size_t size = std::min(text.size(), text_width - indent);
    if (size < text.size())
      if (const std::size_t space = text.rfind(' ', size); space != std::string_view::npos && space > 0) size = space;
    lines += std::string(indent, ' ') + std::string(text.substr(0, size)) + "\n";
    text.remove_prefix(size);
    if (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  }
  return lines;
}

constexpr std::string_view row_format = "  {:<21}{:<24} {:<24} {:<8}{:<8}{:<14}{}\n";

std::string row_text(const CriterionResult& row) {
  if (row.verdict == Agreement::not_applicable)
    return fmt::format("  {:<21}not applicable: {}\n", row.criterion, row.reason);
  std::string text =
      fmt::format(row_format, row.criterion, value_text(row.ours), value_text(row.box2d), brief_number(row.difference),
                  brief_number(row.tolerance), row.unit, verdict_name(row.verdict));
  if (!row.reason.empty()) text += wrapped(row.reason, 4);
  return text;
}

const tool::PeerInfo& peer_info(PeerKind kind) {
  return engine::info_of(tool::peers, kind);
}

std::string report_text(const CrosscheckReport& report) {
  std::string text =
      fmt::format("crosscheck  {}  {} seeds of {:g} s ({} ticks), Box2D {} with {}\n", report.scene, report.seed_count,
                  report.seconds, report.tick_count, report.box2d_version, peer_info(report.peer).settings);
  if (report.match_skin && report.peer == PeerKind::box2d2)
    text += "  Box2D's polygons rest where their geometry touches, not a skin of 2 cm apart\n";
  if (report.length_scale != 1)
    text += fmt::format("  lengths scaled by {:g} for Box2D, which is tuned for bodies of 0.1 m to 10 m\n",
                        report.length_scale);
  if (report.thin_shape_count > 0)
    text += fmt::format(
        "  {} thinner than three of Box2D's skins: a skin of a quarter\n",
        report.thin_shape_count == 1 ? "1 shape is" : fmt::format("{} shapes are", report.thin_shape_count));
  for (const CrosscheckSolver& solver : report.solvers) {
    text += "\n" + fmt::format(row_format, "criterion", solver.solver, "Box2D", "apart", "allowed", "", "verdict");
    for (const CriterionResult& row : report.rows)
      if (row.solver == solver.solver) text += row_text(row);
  }
  text += "\n";
  for (const CrosscheckSolver& solver : report.solvers) text += solver.summary + "\n";
  return text;
}

Json numbers_json(const std::vector<double>& values) {
  Json array = Json::array();
  for (const double value : values) array.push_back(std::isfinite(value) ? Json(value) : Json(nullptr));
  return array;
}

Json peer_json(const CrosscheckReport& report) {
  Json peer{{"name", "Box2D"}, {"version", report.box2d_version}};
  if (report.peer == PeerKind::box2d2) {
    peer["velocity_iterations"] = report.velocity_iterations;
    peer["position_iterations"] = report.position_iterations;
  } else {
    peer["id"] = peer_info(report.peer).name;
    peer["settings"] = peer_info(report.peer).settings;
  }
  peer["length_scale"] = report.length_scale;
  peer["match_skin"] = report.match_skin;
  peer["thin_shapes"] = report.thin_shape_count;
  return peer;
}

Json solver_json(const CrosscheckReport& report, const CrosscheckSolver& solver) {
  Json entry;
  entry["solver"] = solver.solver;
  entry["agrees"] = solver.failed == 0 && solver.passed + solver.expected > 0;
  entry["passed"] = solver.passed;
  entry["failed"] = solver.failed;
  entry["expected"] = solver.expected;
  entry["not_applicable"] = solver.not_applicable;
  entry["stood"] = report.is_structure ? Json(solver.stood) : Json(nullptr);
  entry["box2d_stood"] = report.is_structure ? Json(report.box2d_stood) : Json(nullptr);
  entry["summary"] = solver.summary;
  return entry;
}

Json row_json(const CriterionResult& row) {
  Json entry;
  entry["solver"] = row.solver;
  entry["criterion"] = row.criterion;
  entry["verdict"] = verdict_name(row.verdict);
  entry["unit"] = row.unit;
  entry["ours"] = numbers_json(row.ours);
  entry["box2d"] = numbers_json(row.box2d);
  if (!row.ours_finest.empty()) entry["ours_finest"] = numbers_json(row.ours_finest);
  if (!row.box2d_finest.empty()) entry["box2d_finest"] = numbers_json(row.box2d_finest);
  entry["difference"] = std::isfinite(row.difference) ? Json(row.difference) : Json(nullptr);
  entry["tolerance"] = row.tolerance;
  entry["reason"] = row.reason;
  return entry;
}

/// One report for each peer, of the same scene. With several peers, `peers` lists them, and each solver and row names
/// its own. Requires: at least one report.
Json reports_json(const std::vector<CrosscheckReport>& reports) {
  const CrosscheckReport& first = reports.front();
  Json object;
  object["schema"] = "ticktrue.crosscheck/1";
  object["scene"] = first.scene;
  object["seeds"] = first.seed_count;
  object["seconds"] = first.seconds;
  object["ticks"] = first.tick_count;
  object["peer"] = peer_json(first);
  int passed = 0;
  int failed = 0;
  int expected = 0;
  int not_applicable = 0;
  Json all_peers = Json::array();
  Json solvers = Json::array();
  Json rows = Json::array();
  for (const CrosscheckReport& report : reports) {
    const std::string_view name = peer_info(report.peer).name;
    Json peer = peer_json(report);
    peer["id"] = name;
    all_peers.push_back(std::move(peer));
    for (const CrosscheckSolver& solver : report.solvers) {
      passed += solver.passed;
      failed += solver.failed;
      expected += solver.expected;
      not_applicable += solver.not_applicable;
      solvers.push_back(solver_json(report, solver));
      if (reports.size() > 1) solvers.back()["peer"] = name;
    }
    for (const CriterionResult& row : report.rows) {
      rows.push_back(row_json(row));
      if (reports.size() > 1) rows.back()["peer"] = name;
    }
  }
  object["passed"] = passed;
  object["failed"] = failed;
  object["expected"] = expected;
  object["not_applicable"] = not_applicable;
  if (reports.size() > 1) object["peers"] = std::move(all_peers);
  object["solvers"] = std::move(solvers);
  object["rows"] = std::move(rows);
  return object;
}

/// The peers that a command names, each once.
std::vector<PeerKind> peers_of(const CrosscheckCommand& command) {
  std::vector<PeerKind> kinds;
  for (const std::string& name : command.peers)
    if (const tool::PeerInfo* info = engine::find_choice(tool::peers, name))
      if (std::find(kinds.begin(), kinds.end(), info->kind) == kinds.end()) kinds.push_back(info->kind);
  if (kinds.empty()) kinds.push_back(PeerKind::box2d2);
  return kinds;
}

tool::CrosscheckOptions options_of(const CrosscheckCommand& command) {
  tool::CrosscheckOptions options;
  for (const std::string& name : command.solvers)
    if (const engine::SolverInfo* info = engine::find_choice(engine::solvers, name))
      options.solvers.push_back(info->kind);
  options.seed_count = static_cast<std::uint32_t>(command.seed_count);
  if (command.seconds > 0) options.seconds = command.seconds;
  options.match_skin = command.match_skin;
  options.thread_count = command.thread_count > 0 ? static_cast<unsigned>(command.thread_count) : core_count();
  return options;
}

/// Before anything runs: a peer that is not available here. Errors: those of its version.
Status check_available(const std::vector<PeerKind>& kinds) {
  for (const PeerKind kind : kinds)
    if (const Result<std::string> version = peer_info(kind).version(); !version) return version.error();
  return {};
}

// ---- The suite ----

struct SuiteRow {
  const tool::SuiteScene* scene;
  CrosscheckReport report;
};

// The verdict on a scene: the worst of its criteria.
Agreement verdict_on(const CrosscheckSolver& solver) {
  if (solver.failed > 0) return Agreement::differ;
  if (solver.expected > 0) return Agreement::expected;
  return solver.passed > 0 ? Agreement::agree : Agreement::not_applicable;
}

/// A verdict on one scene of the suite, with the word that is shown.
enum class SuiteVerdict : std::uint8_t { agree, differ, expected, not_applicable, falls_short, misjudged };
constexpr std::array<std::string_view, 6> suite_verdict_names{"agree",          "differ",      "expected",
                                                              "not_applicable", "falls_short", "misjudged"};

SuiteVerdict plain_verdict(const CrosscheckSolver& solver) {
  switch (verdict_on(solver)) {
    case Agreement::agree:
      return SuiteVerdict::agree;
    case Agreement::expected:
      return SuiteVerdict::expected;
    case Agreement::differ:
      return SuiteVerdict::differ;
    case Agreement::not_applicable:
      break;
  }
  return SuiteVerdict::not_applicable;
}

// Of a scene in which ours is known to fall: falls_short if the cross-check says so, misjudged if it does not. That
// the finest steps stand is known of box2d2 alone: where they do not stand in another peer, its plain verdict holds.
SuiteVerdict suite_verdict(const SuiteRow& row, const CrosscheckSolver& solver) {
  if (!row.scene->falls_short || solver.solver != engine::info_of(engine::solvers, engine::SolverKind::tgs_soft).name)
    return plain_verdict(solver);
  for (const CriterionResult& each : row.report.rows) {
    if (each.solver != solver.solver || each.criterion != tool::stands_criterion) continue;
    const bool is_told = each.verdict == Agreement::differ && !each.box2d_finest.empty() &&
                         tool::mean_of(each.ours) < tool::mean_of(each.box2d_finest);
    if (is_told) return SuiteVerdict::falls_short;
    return row.report.peer == PeerKind::box2d2 ? SuiteVerdict::misjudged : plain_verdict(solver);
  }
  return row.report.is_structure ? SuiteVerdict::misjudged : SuiteVerdict::not_applicable;
}

// As many names as fit the line, then how many more.
std::string some_criteria(const CrosscheckReport& report, const std::string& solver, Agreement verdict) {
  constexpr std::size_t width = 56;
  std::string text;
  int left_off = 0;
  for (const CriterionResult& row : report.rows) {
    if (row.solver != solver || row.verdict != verdict) continue;
    const bool fits = left_off == 0 && text.size() + row.criterion.size() + 2 <= width;
    if (fits)
      text += (text.empty() ? "" : ", ") + row.criterion;
    else
      ++left_off;
  }
  return left_off > 0 ? text + fmt::format(" +{}", left_off) : text;
}

std::string suite_text(const std::vector<SuiteRow>& rows) {
  constexpr std::string_view format = "{:<18}{:<10}{:<15}{:<8}{:<8}{}\n";
  std::string text = fmt::format(format, "scene", "solver", "verdict", "stood", "Box2D", "criteria of this verdict");
  for (const SuiteRow& row : rows) {
    for (const CrosscheckSolver& solver : row.report.solvers) {
      const SuiteVerdict verdict = suite_verdict(row, solver);
      const auto stood = [&](std::size_t count) {
        return row.report.is_structure && verdict != SuiteVerdict::not_applicable
                   ? fmt::format("{} of {}", count, row.report.seed_count)
                   : std::string("-");
      };
      text += fmt::format(
          format, row.scene->name, solver.solver, suite_verdict_names[static_cast<std::size_t>(verdict)],
          stood(solver.stood), stood(row.report.box2d_stood),
          verdict == SuiteVerdict::agree ? "" : some_criteria(row.report, solver.solver, verdict_on(solver)));
      while (text.size() > 1 && text[text.size() - 2] == ' ') text.erase(text.size() - 2, 1);
    }
  }
  return text;
}

struct SuiteCount {
  std::string solver;
  PeerKind peer = PeerKind::box2d2;
  int agree = 0, expected = 0, differ = 0, not_applicable = 0, falls_short = 0, misjudged = 0;
};

std::vector<SuiteCount> count_suite(const std::vector<SuiteRow>& rows) {
  std::vector<SuiteCount> counts;
  for (const SuiteRow& row : rows) {
    for (const CrosscheckSolver& solver : row.report.solvers) {
      const auto found = std::find_if(counts.begin(), counts.end(), [&](const SuiteCount& count) {
        return count.solver == solver.solver && count.peer == row.report.peer;
      });
      SuiteCount& count =
          found == counts.end() ? counts.emplace_back(SuiteCount{solver.solver, row.report.peer}) : *found;
      switch (suite_verdict(row, solver)) {
        case SuiteVerdict::agree:
          ++count.agree;
          break;
        case SuiteVerdict::expected:
          ++count.expected;
          break;
        case SuiteVerdict::differ:
          ++count.differ;
          break;
        case SuiteVerdict::not_applicable:
          ++count.not_applicable;
          break;
        case SuiteVerdict::falls_short:
          ++count.falls_short;
          break;
        case SuiteVerdict::misjudged:
          ++count.misjudged;
          break;
      }
    }
  }
  return counts;
}

Json suite_json(const std::vector<SuiteRow>& rows, const std::vector<SuiteCount>& counts) {
  Json object;
  object["schema"] = "ticktrue.crosscheck_suite/1";
  Json solvers = Json::array();
  SuiteCount all;
  for (const SuiteCount& count : counts) {
    solvers.push_back({{"solver", count.solver},
                       {"passed", count.agree},
                       {"failed", count.differ + count.misjudged},
                       {"expected", count.expected},
                       {"falls_short", count.falls_short},
                       {"misjudged", count.misjudged},
                       {"not_applicable", count.not_applicable}});
    if (count.peer != PeerKind::box2d2) solvers.back()["peer"] = peer_info(count.peer).name;
    all.agree += count.agree;
    all.differ += count.differ;
    all.expected += count.expected;
    all.not_applicable += count.not_applicable;
    all.falls_short += count.falls_short;
    all.misjudged += count.misjudged;
  }
  object["passed"] = all.agree;
  object["failed"] = all.differ + all.misjudged;
  object["expected"] = all.expected;
  object["falls_short"] = all.falls_short;
  object["misjudged"] = all.misjudged;
  object["not_applicable"] = all.not_applicable;
  object["solvers"] = std::move(solvers);
  Json list = Json::array();
  for (const SuiteRow& row : rows) {
    Json entry = reports_json({row.report});
    entry["scene"] = row.scene->name;
    entry["outcome"] = row.scene->outcome;
    for (std::size_t i = 0; i < row.report.solvers.size(); ++i)
      entry["solvers"][i]["suite_verdict"] =
          suite_verdict_names[static_cast<std::size_t>(suite_verdict(row, row.report.solvers[i]))];
    list.push_back(std::move(entry));
  }
  object["rows"] = std::move(list);
  return object;
}

// The table of one peer and its counts.
std::string peer_suite_text(const std::vector<SuiteRow>& rows, PeerKind kind, bool is_one_of_several) {
  std::vector<SuiteRow> own;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(own),
               [&](const SuiteRow& row) { return row.report.peer == kind; });
  std::string text;
  if ((is_one_of_several || kind != PeerKind::box2d2) && !own.empty())
    text += fmt::format("{}Box2D {} with {}\n", kind == rows.front().report.peer ? "" : "\n",
                        own.front().report.box2d_version, peer_info(kind).settings);
  text += suite_text(own) + "\n";
  for (const SuiteCount& count : count_suite(own)) {
    const auto with = [](int number, std::string_view what) {
      return number > 0 ? fmt::format(" ({} {})", number, what) : std::string();
    };
    text += fmt::format("{:<10} agree {} of {}{}{}{}\n", count.solver, count.agree + count.expected,
                        count.agree + count.expected + count.differ, with(count.expected, "expected"),
                        with(count.falls_short, "fall short as docs/crosscheck.md says"),
                        with(count.misjudged, "misjudged"));
  }
  return text;
}

int run_suite(const CrosscheckCommand& command) {
  std::vector<const tool::SuiteScene*> scenes;
  for (const tool::SuiteScene& scene : tool::crosscheck_suite())
    if (command.scenes.empty() ||
        std::find(command.scenes.begin(), command.scenes.end(), scene.name) != command.scenes.end())
      scenes.push_back(&scene);
  for (const std::string& name : command.scenes)
    if (std::none_of(scenes.begin(), scenes.end(), [&](const auto* scene) { return scene->name == name; })) {
      std::string known;
      for (const tool::SuiteScene& scene : tool::crosscheck_suite())
        known += (known.empty() ? "" : " ") + std::string(scene.name);
      return fail_usage({ErrorCode::usage, name + ": not a scene of the suite", "one of: " + known});
    }

  tool::CrosscheckOptions options = options_of(command);
  options.match_skin = true;
  const std::vector<PeerKind> kinds = peers_of(command);
  if (const Status available = check_available(kinds); !available) return fail_usage(available.error());
  std::vector<SuiteRow> rows;
  Progress progress("crosscheck", scenes.size() * kinds.size(), "scenes");
  for (const PeerKind kind : kinds) {
    options.peer = kind;
    for (const tool::SuiteScene* scene : scenes) {
      engine::Scene made = scene->make();
      made.name = scene->name;
      if (command.seconds == 0) options.seconds = scene->seconds;
      Result<CrosscheckReport> report = tool::crosscheck(made, options);
      if (!report) return fail_usage(report.error());
      rows.push_back({scene, std::move(*report)});
      progress.update(rows.size());
    }
  }
  progress.finish();

  const std::vector<SuiteCount> counts = count_suite(rows);
  if (command.json)
    print_json(suite_json(rows, counts));
  else
    for (const PeerKind kind : kinds) print(peer_suite_text(rows, kind, kinds.size() > 1));
  const bool differs =
      std::any_of(counts.begin(), counts.end(), [](const auto& count) { return count.differ + count.misjudged > 0; });
  return differs ? exit_finding : exit_ok;
}

int run_crosscheck(const CrosscheckCommand& command) {
  if (command.suite) return run_suite(command);
  if (command.scenes.size() != 1)
    return fail_usage({ErrorCode::usage,
                       fmt::format("SCENE: found {}, expected one, or --suite", command.scenes.size()),
                       "ticktrue crosscheck --help shows examples"});
  const Result<engine::Scene> scene = load_scene_argument(command.scenes.front());
  if (!scene) return fail_usage(scene.error());
  tool::CrosscheckOptions options = options_of(command);
  std::optional<Progress> progress;
  std::uint64_t total_shown = 0;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    if (total != total_shown) progress.emplace("crosscheck " + scene->name, total);
    total_shown = total;
    progress->update(done);
  };
  const std::vector<PeerKind> kinds = peers_of(command);
  if (const Status available = check_available(kinds); !available) return fail_usage(available.error());
  std::vector<CrosscheckReport> reports;
  for (const PeerKind kind : kinds) {
    options.peer = kind;
    Result<CrosscheckReport> report = tool::crosscheck(*scene, options);
    progress.reset();
    total_shown = 0;
    if (!report) return fail_usage(report.error());
    reports.push_back(*std::move(report));
  }
  bool failed = false;
  for (const CrosscheckReport& report : reports) {
    if (!command.json) print((&report == &reports.front() ? "" : "\n") + report_text(report));
    failed |= std::any_of(report.solvers.begin(), report.solvers.end(),
                          [](const CrosscheckSolver& solver) { return solver.failed > 0; });
  }
  if (command.json) print_json(reports_json(reports));
  return failed ? exit_finding : exit_ok;
}

}  // namespace

void add_crosscheck(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<CrosscheckCommand>();
  CLI::App* command =
      app.add_subcommand("crosscheck", "Run a scene in Box2D too and compare the outcome")->group(group_study);
  command->add_option(
      "SCENE", options->scenes,
      "Scene file (.json) or built-in scene, with parameters: stack?boxes=20; with --suite: scenes of it");
  command->add_flag("--suite", options->suite, "The suite of structures, or those named; Box2D's skin is matched");
  command->add_flag("--match-skin", options->match_skin,
                    "Give Box2D's polygons so thin a skin that they rest where their geometry touches");
  std::vector<std::string> peer_names;
  std::string peer_help = "Peers, may be repeated; default: box2d2";
  for (const tool::PeerInfo& info : tool::peers) {
    peer_names.emplace_back(info.name);
    peer_help += fmt::format("; {}: {}", info.name, info.summary);
  }
  command->add_option("--peer", options->peers, peer_help)
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(peer_names));
  std::vector<std::string> names;
  for (const engine::SolverInfo& info : engine::solvers) names.emplace_back(info.name);
  command->add_option("--solver", options->solvers, "Solver of ours, may be repeated; default: the scene's")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names));
  add_number(*command, "--seeds", options->seed_count, "Jittered starts; the first is not jittered", {1, 1000});
  command
      ->add_option("--seconds", options->seconds,
                   "Simulated time of each run, s; default: 20, in the suite each scene's")
      ->check(CLI::Range(1e-3, 1e6));
  add_number(*command, "-j,--jobs", options->thread_count, "Threads; default: one a core", {1, 1024});
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command,
               "ticktrue crosscheck 'stack?boxes=10' --solver tgs_soft --solver impulse\n"
               "ticktrue crosscheck 'pyramid?base=20' --seeds 3 --seconds 10 --json\n"
               "ticktrue crosscheck --suite --solver tgs_soft,impulse\n"
               "ticktrue crosscheck 'stack?boxes=10' --peer box2d2,box2d3");
  command->callback([options, &context] { context.exit_code = run_crosscheck(*options); });
}

}  // namespace ticktrue::cli
