// `ticktrue crosscheck`: the same scene in Box2D 2.4.1 and in the engine, criterion by criterion.
// SPDX-License-Identifier: MIT
#include "verifier/crosscheck.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "verifier/cli/commands.h"
#include "verifier/cli/json_output.h"
#include "verifier/cli/progress.h"
#include "verifier/parallel.h"

namespace ticktrue::cli {
namespace {

using verifier::Agreement;
using verifier::CrosscheckReport;
using verifier::CrosscheckRow;
using verifier::CrosscheckSolver;

constexpr std::size_t text_width = 116;  // of a line

struct CrosscheckCommand {
  std::string scene;
  std::vector<std::string> solvers;
  std::uint64_t seed_count = 5;
  double seconds = 20;
  std::uint64_t thread_count = 0;  // 0: as many as there are cores
  bool json = false;
};

std::string_view verdict_name(Agreement verdict) {
  return verifier::verdict_names[static_cast<std::size_t>(verdict)];
}

// Three digits, four decimals at most: the JSON has them all.
std::string number_text(double value) {
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
  const std::string low = number_text(*lowest);
  const std::string high = number_text(*highest);
  std::string text = number_text(mean);
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

std::string row_text(const CrosscheckRow& row) {
  if (row.verdict == Agreement::not_applicable)
    return fmt::format("  {:<21}not applicable: {}\n", row.criterion, row.reason);
  std::string text =
      fmt::format(row_format, row.criterion, value_text(row.ours), value_text(row.box2d), number_text(row.difference),
                  number_text(row.tolerance), row.unit, verdict_name(row.verdict));
  if (!row.reason.empty()) text += wrapped(row.reason, 4);
  return text;
}

std::string report_text(const CrosscheckReport& report) {
  std::string text = fmt::format("crosscheck  {}  {} seeds of {:g} s ({} ticks), Box2D {} with {}/{} iterations\n",
                                 report.scene, report.seed_count, report.seconds, report.tick_count,
                                 report.box2d_version, report.velocity_iterations, report.position_iterations);
  if (report.length_scale != 1)
    text += fmt::format("  lengths scaled by {:g} for Box2D, which is tuned for bodies of 0.1 m to 10 m\n",
                        report.length_scale);
  for (const CrosscheckSolver& solver : report.solvers) {
    text += "\n" + fmt::format(row_format, "criterion", solver.solver, "Box2D", "apart", "allowed", "", "verdict");
    for (const CrosscheckRow& row : report.rows)
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

Json report_json(const CrosscheckReport& report) {
  Json object;
  object["schema"] = "ticktrue.crosscheck/1";
  object["scene"] = report.scene;
  object["seeds"] = report.seed_count;
  object["seconds"] = report.seconds;
  object["ticks"] = report.tick_count;
  object["peer"] = {{"name", "Box2D"},
                    {"version", report.box2d_version},
                    {"velocity_iterations", report.velocity_iterations},
                    {"position_iterations", report.position_iterations},
                    {"length_scale", report.length_scale}};
  int passed = 0;
  int failed = 0;
  int expected = 0;
  int not_applicable = 0;
  Json solvers = Json::array();
  for (const CrosscheckSolver& solver : report.solvers) {
    passed += solver.passed;
    failed += solver.failed;
    expected += solver.expected;
    not_applicable += solver.not_applicable;
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
    solvers.push_back(std::move(entry));
  }
  object["passed"] = passed;
  object["failed"] = failed;
  object["expected"] = expected;
  object["not_applicable"] = not_applicable;
  object["solvers"] = std::move(solvers);
  Json rows = Json::array();
  for (const CrosscheckRow& row : report.rows) {
    Json entry;
    entry["solver"] = row.solver;
    entry["criterion"] = row.criterion;
    entry["verdict"] = verdict_name(row.verdict);
    entry["unit"] = row.unit;
    entry["ours"] = numbers_json(row.ours);
    entry["box2d"] = numbers_json(row.box2d);
    entry["difference"] = std::isfinite(row.difference) ? Json(row.difference) : Json(nullptr);
    entry["tolerance"] = row.tolerance;
    entry["reason"] = row.reason;
    rows.push_back(std::move(entry));
  }
  object["rows"] = std::move(rows);
  return object;
}

int run_crosscheck(const CrosscheckCommand& command) {
  const Result<engine::Scene> scene = load_scene_argument(command.scene);
  if (!scene) return fail_usage(scene.error());
  verifier::CrosscheckOptions options;
  for (const std::string& name : command.solvers)
    if (const engine::SolverInfo* info = engine::find_choice(engine::solvers, name))
      options.solvers.push_back(info->kind);
  options.seed_count = static_cast<std::uint32_t>(command.seed_count);
  options.seconds = command.seconds;
  options.thread_count =
      command.thread_count > 0 ? static_cast<unsigned>(command.thread_count) : verifier::core_count();
  std::optional<Progress> progress;
  std::uint64_t total_shown = 0;
  options.progress = [&](std::uint64_t done, std::uint64_t total) {
    if (total != total_shown) progress.emplace("crosscheck " + scene->name, total);
    total_shown = total;
    progress->update(done);
  };
  const Result<CrosscheckReport> report = verifier::crosscheck(*scene, options);
  progress.reset();
  if (!report) return fail_usage(report.error());
  if (command.json)
    print_json(report_json(*report));
  else
    print(report_text(*report));
  const bool failed = std::any_of(report->solvers.begin(), report->solvers.end(),
                                  [](const CrosscheckSolver& solver) { return solver.failed > 0; });
  return failed ? exit_finding : exit_ok;
}

}  // namespace

void add_crosscheck(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<CrosscheckCommand>();
  CLI::App* command =
      app.add_subcommand("crosscheck", "Run a scene in Box2D 2.4.1 too and compare the outcome")->group(group_study);
  command->add_option("SCENE", options->scene, "Scene file (.json) or built-in scene, with parameters: stack?boxes=20")
      ->required();
  std::vector<std::string> names;
  for (const engine::SolverInfo& info : engine::solvers) names.emplace_back(info.name);
  command->add_option("--solver", options->solvers, "Solver of ours, may be repeated; default: the scene's")
      ->delimiter(',')
      ->check(CLI::IsMember(names));
  add_number(*command, "--seeds", options->seed_count, "Jittered starts; the first is not jittered", {1, 1000});
  command->add_option("--seconds", options->seconds, "Simulated time of each run, s")
      ->check(CLI::Range(1e-3, 1e6))
      ->capture_default_str();
  add_number(*command, "-j,--jobs", options->thread_count, "Threads; default: one a core", {1, 1024});
  command->add_flag("--json", options->json, "One JSON object");
  set_examples(*command,
               "ticktrue crosscheck 'stack?boxes=10' --solver tgs_soft --solver impulse\n"
               "ticktrue crosscheck 'pyramid?base=20' --seeds 3 --seconds 10 --json");
  command->callback([options, &context] { context.exit_code = run_crosscheck(*options); });
}

}  // namespace ticktrue::cli
