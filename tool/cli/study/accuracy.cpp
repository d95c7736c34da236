// `ticktrue accuracy`: error against run time on problems whose answers are known.
// SPDX-License-Identifier: MIT
#include "tool/study/accuracy.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <limits>
#include <set>
#include <string>

#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/cli/study/accuracy_peer.h"
#include "tool/cli/study/accuracy_report.h"
#include "tool/cli/study/study_output.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "tool/study/problem_file/problem_file.h"
#include "verifier/runs/data_file.h"

namespace ticktrue::cli {
namespace {

using tool::Problem;
using tool::StudyVerdict;
using tool::TextTable;

struct AccuracyCommand {
  std::vector<std::string> problems;
  std::vector<std::string> precisions;
  std::vector<std::string> peers;
  std::string engine_program;
  std::uint64_t repeat_count = 7;
  std::uint64_t thread_count = 0;  // 0: as many as there are cores
  AccuracyView view;
  bool list = false;
  bool example = false;
  StudyFiles files;
};

Result<std::vector<Problem>> chosen_problems(const std::vector<std::string>& names) {
  std::vector<Problem> all = tool::verification_problems();
  std::vector<Problem> shapes = tool::shape_problems();
  all.insert(all.end(), std::make_move_iterator(shapes.begin()), std::make_move_iterator(shapes.end()));
  if (names.empty()) return all;
  std::vector<std::string> known{"shapes"};
  for (const Problem& problem : all) known.push_back(problem.name);
  for (const std::string_view name : tool::problem_class_names) known.emplace_back(name);
  std::vector<Problem> chosen;
  for (const std::string& name : names) {
    const std::size_t before = chosen.size();
    if (name.size() > 5 && name.compare(name.size() - 5, 5, ".json") == 0) {
      Result<Problem> own = tool::read_problem(name);
      if (!own) return own.error();
      const auto has_name = [&](const Problem& problem) { return problem.name == own->name; };
      if (std::any_of(chosen.begin(), chosen.end(), has_name)) own->name += " (" + name + ")";
      chosen.push_back(*std::move(own));
      continue;
    }
    for (const Problem& problem : all)
      if (problem.name == name ||
          (problem.name != name && class_name(problem.kind) == name &&
           std::none_of(all.begin(), all.end(), [&](const Problem& p) { return p.name == name; })) ||
          (name == "shapes" && problem.corner_count >= 0))
        chosen.push_back(problem);
    if (chosen.size() > before) continue;
    const std::string nearest = nearest_name(name, known);
    return Error{ErrorCode::usage, "accuracy: found problem \"" + name + "\", expected one of --list",
                 nearest.empty() ? "see `ticktrue accuracy --list`; the name of a file of one's own ends in .json"
                                 : "did you mean " + nearest + "?"};
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

/// Errors: io, usage.
Status check_targets(const AccuracyCommand& command) {
  std::vector<std::string> read = own_files(command.problems);
  if (!command.engine_program.empty()) read.push_back(command.engine_program);
  return check_study_files(command.files, read);
}

/// The command line that prints the same table again.
std::string command_line_of(const AccuracyCommand& command, int repeat_max, unsigned thread_count) {
  std::string line = "ticktrue accuracy" + words_text(command.problems);
  for (const std::string& precision : command.precisions) line += " --precision " + precision;
  if (command.view.points) line += " --points";
  if (command.view.brief) line += " --brief";
  if (command.view.no_times) return line + " --no-times";
  return line + fmt::format(" --repeats {} -j {}", repeat_max, thread_count);
}

/// The methods that the file has a bar or a slope for, and that the scene does not allow.
std::set<std::string> methods_claimed_in_vain(const Problem& problem, const std::vector<tool::AccuracyCurve>& curves) {
  std::set<std::string> claimed;
  for (const tool::Bar& bar : problem.bars) claimed.insert(bar.method);
  for (const auto& [method, slope] : problem.slopes) claimed.insert(method);
  for (const tool::AccuracyCurve& curve : curves)
    if (curve.problem == problem.name && curve.judgement.verdict != StudyVerdict::not_applicable)
      claimed.erase(curve.method.name);
  return claimed;
}

/// Warns of each problem file with a claim that could not be judged. True if there is none.
bool warn_of_claims(const std::vector<Problem>& problems, const std::vector<tool::AccuracyCurve>& curves) {
  bool all_are_judged = true;
  for (const Problem& problem : problems) {
    if (!tool::claims_of_own(problem)) continue;
    const bool is_judged = std::any_of(curves.begin(), curves.end(), [&](const tool::AccuracyCurve& curve) {
      return curve.problem == problem.name && curve.judgement.verdict != StudyVerdict::not_judged &&
             curve.judgement.verdict != StudyVerdict::not_applicable;
    });
    if (!is_judged) print_warning(problem.name + ": nothing was judged of what the file claims");
    all_are_judged = all_are_judged && is_judged;
    if (!is_judged) continue;
    for (const std::string& method : methods_claimed_in_vain(problem, curves)) {
      print_warning(problem.name + ": not judged what the file claims of " + method + ", which is not applicable");
      all_are_judged = false;
    }
  }
  return all_are_judged;
}

/// Without a time, JSON has null and CSV has an empty cell.
void leave_out_times(std::vector<tool::AccuracyCurve>& curves) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (tool::AccuracyCurve& curve : curves)
    for (tool::AccuracyPoint& point : curve.points) point.time_ms = {none, none, none};
}

int run_accuracy_command(const AccuracyCommand& command) {
  const unsigned thread_count = command.thread_count > 0 ? static_cast<unsigned>(command.thread_count) : core_count();
  if (!command.list && !command.example)
    if (const Status status = check_targets(command); !status) return fail_usage(status.error());
  if (!command.peers.empty())
    return run_accuracy_peer(
        {command.problems, command.peers, command.engine_program, static_cast<int>(command.repeat_count)},
        command.files);
  const Result<std::vector<Problem>> problems = chosen_problems(command.problems);
  if (!problems) return fail_usage(problems.error());
  if (command.list) return list_problems(*problems);
  if (command.example) {
    print(tool::example_problem);
    return exit_ok;
  }
  tool::AccuracyOptions options;
  options.precisions.clear();
  for (const std::string& name : command.precisions)
    options.precisions.push_back(engine::find_choice(engine::precisions, name)->kind);
  options.repeat_max = command.view.no_times ? 1 : static_cast<int>(command.repeat_count);
  options.thread_count = thread_count;
  options.keep_samples = !command.files.samples.empty();
  Progress progress("accuracy", 1, "curves");
  options.progress = [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); };
  auto curves = tool::run_accuracy(*problems, options);
  progress.finish();
  if (!curves) return fail_usage(curves.error());
  const std::vector<tool::Plot> plots = accuracy_plots(*problems, *curves, options.precisions);
  if (command.view.no_times) leave_out_times(*curves);
  const std::string command_line = command_line_of(command, options.repeat_max, thread_count);
  if (command.files.json)
    print_json(accuracy_json(*problems, *curves, command_line));
  else
    print("accuracy  " + command_line + "\n" + accuracy_text(*problems, *curves, command.view, options.precisions));
  if (const int code = write_study_files(command.files, accuracy_csv(*curves), plots); code != exit_ok) return code;
  if (options.keep_samples)
    if (const Status written =
            verifier::write_data_file(command.files.samples, samples_csv(*problems, *curves), command.files.force);
        !written)
      return fail_usage(written.error());
  const bool all_claims_are_judged = warn_of_claims(*problems, *curves);
  return verdicts_of(*curves).of(StudyVerdict::fail) > 0 || !all_claims_are_judged ? exit_finding : exit_ok;
}

}  // namespace

void add_accuracy(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<AccuracyCommand>();
  CLI::App* command =
      app.add_subcommand("accuracy", "Error against run time on problems whose answers are known")->group(group_study);
  command->add_option("PROBLEM", options->problems,
                      "Problems or classes of --list, shapes, or files of one's own (my.json: docs/study.md); "
                      "default: all. With --peer: its scenes");
  std::vector<std::string> names;
  for (const auto& info : engine::precisions) names.emplace_back(info.name);
  options->precisions = {"f64", "f32"};
  command->add_option("--precision", options->precisions, "f64, f32; default: both")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names));
  add_number(*command, "--repeats", options->repeat_count, "Timed runs of a point at most; default: 7", {1, 1000});
  command
      ->add_option("--peer", options->peers,
                   "Error against time beside other engines on six scenes: box2d2 (or box2d), box2d3")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"box2d", "box2d2", "box2d3"}));
  command
      ->add_option("--engine", options->engine_program,
                   "With --peer: our engine as engine_run of another build; a .js file runs in node, as Box2D 3 does")
      ->needs("--peer")
      ->type_name("FILE");
  command->add_flag("--points", options->view.points, "Every point of every curve, instead of one line a curve");
  command->add_flag("--brief", options->view.brief, "One line a problem");
  command->add_flag("--no-times", options->view.no_times, "What is the same on every machine, to the last digit");
  command->add_flag("--list", options->list, "List the problems, run none");
  command->add_flag("--example", options->example, "Print a problem file to begin with, run none");
  add_number(*command, "-j,--jobs", options->thread_count, "Threads; default: one a core. 1 gives the quietest times",
             {1, 1024});
  add_study_files(*command, options->files);
  command
      ->add_option("--samples", options->files.samples,
                   "To a CSV file too: each value at each sampled time, as found and exact")
      ->excludes("--peer")
      ->type_name("FILE");
  set_examples(*command,
               "ticktrue accuracy\n"
               "ticktrue accuracy pendulum kepler --precision f64 --plot pendulum.svg\n"
               "ticktrue accuracy shapes --csv shapes.csv\n"
               "ticktrue accuracy --example > my.json\n"
               "ticktrue accuracy my.json --precision f64 --plot my.svg --samples samples.csv\n"
               "ticktrue accuracy --peer box2d\n"
               "ticktrue accuracy --peer box2d2,box2d3\n"
               "ticktrue accuracy --peer box2d3 --engine build/wasm/engine_run.js");
  command->callback([options, &context] { context.exit_code = run_accuracy_command(*options); });
}

}  // namespace ticktrue::cli
