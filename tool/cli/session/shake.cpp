// `ticktrue shake`: runs a recorded program again with one source of nondeterminism changed at a time.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/shake.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "base/parallel/jobs.h"
#include "base/plain_text.h"
#include "replay/trace_reader.h"
#include "tool/cli/commands.h"
#include "tool/cli/session/program_runs.h"
#include "tool/experiment/shake/shake_report.h"
#include "tool/output/progress.h"
#include "tool/session/session_inputs.h"
#include "tool/session/simulations.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;

struct ShakeCommand {
  std::string trace;
  std::vector<std::string> words;
  std::vector<std::string> vary;
  std::vector<std::string> classes;
  std::uint64_t seed_count = 1;
  std::optional<std::uint64_t> time_s;
  std::uint64_t timeout_s = 600;
  std::uint64_t jobs = 1;
  bool no_narrow = false;
  bool alone = false;
  std::string rebuild;
  std::uint64_t tick_count = 600;
  bool list = false;
  bool json = false;
  bool github = false;
  std::string junit;
  std::string folder;
};

Error usage(const std::string& what, const std::string& hint = "") {
  return Error{ErrorCode::usage, what, hint};
}

std::vector<std::string> perturbation_names() {
  std::vector<std::string> names;
  for (const shake::Perturbation& row : shake::perturbations()) names.emplace_back(row.name);
  return names;
}

std::string class_word(const shake::Perturbation& row) {
  return std::string(1, static_cast<char>(row.kind));
}

/// "libm_ulp.calls=1..400": calls of the function's group, counted from 1. "stack_fill.ticks=5..9".
Status set_limit(shake::Choice& choice, const std::string& item, const std::string& limit) {
  const std::size_t equals = limit.find('=');
  const std::string key = limit.substr(0, equals);
  if (equals == std::string::npos || (key != "calls" && key != "ticks"))
    return usage("--vary: " + item + ": found ." + limit + ", expected .calls=A..B or .ticks=A..B");
  const Result<TickRange> range = parse_tick_range(limit.substr(equals + 1), "--vary " + item);
  if (!range) return range.error();
  if (key == "ticks") {
    choice.ticks = {{range->first, range->last}};
    return {};
  }
  if (range->first == 0) return usage("--vary: " + item + ": found call 0, expected calls from 1 on");
  choice.calls = shim::CallRange{range->first - 1, range->last};
  return {};
}

/// The rows of the classes, then what --vary adds and removes, in the order of its words.
Result<std::vector<shake::Choice>> choices_of(const ShakeCommand& command) {
  const auto is_in_classes = [&](const shake::Perturbation& row) {
    if (command.classes.empty()) return row.kind != shake::Kind::c;
    return std::find(command.classes.begin(), command.classes.end(), class_word(row)) != command.classes.end();
  };
  std::vector<shake::Choice> choices;
  const auto add = [&](const shake::Perturbation& row) -> shake::Choice& {
    for (shake::Choice& choice : choices)
      if (choice.perturbation == &row) return choice;
    return choices.emplace_back(shake::Choice{&row, {}, {}});
  };
  const bool starts_empty =
      !command.vary.empty() && command.vary.front().compare(0, 1, "-") != 0 && command.vary.front() != "+all";
  if (!starts_empty)
    for (const shake::Perturbation& row : shake::perturbations())
      if (is_in_classes(row)) add(row);
  for (const std::string& word : command.vary) {
    const bool is_removed = word.compare(0, 1, "-") == 0;
    const std::string item = is_removed || word.compare(0, 1, "+") == 0 ? word.substr(1) : word;
    const std::string name = item.substr(0, item.find('.'));
    if (name == "all") {
      if (is_removed) choices.clear();
      for (const shake::Perturbation& row : shake::perturbations())
        if (!is_removed && is_in_classes(row)) add(row);
      continue;
    }
    const shake::Perturbation* row = shake::find_perturbation(name);
    if (row == nullptr) {
      const std::string nearest = nearest_name(name, perturbation_names());
      return usage("--vary: found \"" + name + "\", expected a perturbation",
                   nearest.empty() ? "`ticktrue shake --list` names them" : "did you mean " + nearest + "?");
    }
    if (is_removed) {
      std::erase_if(choices, [&](const shake::Choice& choice) { return choice.perturbation == row; });
      continue;
    }
    shake::Choice& choice = add(*row);
    if (item.size() > name.size())
      if (const Status status = set_limit(choice, item, item.substr(name.size() + 1)); !status) return status.error();
  }
  if (choices.empty()) return usage("--vary, --class: found no perturbation that is left");
  return choices;
}

std::string list_text() {
  std::string text;
  constexpr std::size_t width = 18;
  for (const shake::Perturbation& row : shake::perturbations()) {
    std::string name(row.name);
    name.resize(width, ' ');
    text += class_word(row) + "  " + name + std::string(row.what) + "\n";
  }
  return text;
}

/// A trace, and the program that runs again.
struct Subject {
  std::string trace;  // whole path
  std::uint64_t tick_count = 0;
  std::vector<std::string> words;  // with {trace} in them
};

/// Without a program: this tool verifies the trace, which it recorded itself if a scene was given.
Result<Subject> subject_of(const ShakeCommand& command, const std::string& folder) {
  Subject subject;
  subject.trace = command.trace;
  subject.words = command.words;
  const bool is_own = command.words.empty();
  if (is_own && !is_trace_argument(command.trace)) {
    const Result<std::string> recorded = record_scene(command.trace, command.tick_count, folder);
    if (!recorded) return recorded.error();
    subject.trace = *recorded;
  }
  Result<replay::TraceReader> reader = replay::TraceReader::open(subject.trace);
  if (!reader) return reader.error();
  const std::string simulation = reader->setup().simulation;
  if (is_own && tool::find_simulation(simulation) == nullptr)
    return usage("shake: found no program, and a trace of \"" + simulation + "\", expected TRACE -- PROGRAM ARGUMENTS",
                 "behind -- stands the program that recorded the trace: see `ticktrue shake --help`");
  if (is_own) subject.words = verify_words();
  subject.tick_count = reader->tick_count_hint().value_or(0);
  std::error_code failed;
  subject.trace = fs::canonical(subject.trace, failed).string();
  if (failed) return Error{ErrorCode::io, command.trace + ": " + failed.message(), ""};
  return subject;
}

/// A hint may be of several lines: what another program said at its end.
int fail_in_lines(const Error& error) {
  const int code = fail_usage(Error{error.code, error.message, ""});
  std::istringstream lines(error.hint);
  for (std::string line; std::getline(lines, line);) std::fprintf(stderr, "  %s\n", plain_line(line).c_str());
  return code;
}

int run_shake_command(const ShakeCommand& command) {
  if (command.list) {
    print(list_text());
    return exit_ok;
  }
  if (command.trace.empty())
    return fail_usage(usage("shake: found no trace, expected TRACE -- PROGRAM ARGUMENTS",
                            "behind -- stands the program that recorded the trace: see `ticktrue shake --help`"));
  const auto choices = choices_of(command);
  if (!choices) return fail_usage(choices.error());
  const auto folder = verifier::RunFolder::make("ticktrue-shake", command.folder);
  if (!folder) return fail_usage(folder.error());
  const Result<Subject> found = subject_of(command, folder->path());
  if (!found) return fail_usage(found.error());
  shake::ShakeSubject subject;
  subject.trace = command.trace;
  subject.words = found->words;
  subject.tick_count = found->tick_count;
  subject.fails_for_b = std::find(command.classes.begin(), command.classes.end(), "B") != command.classes.end();

  shake::ShakeOptions options;
  options.launch.words = words_with_trace(found->words, found->trace);
  options.launch.folder = folder->path();
  set_shim(options.launch);
  options.launch.time_s = static_cast<double>(command.timeout_s);
  options.choices = *choices;
  options.seed_count = static_cast<unsigned>(command.seed_count);
  options.thread_count = static_cast<unsigned>(command.jobs);
  options.narrows = !command.no_narrow;
  options.each_alone = command.alone;
  options.rebuild = command.rebuild;
  if (command.time_s) options.time_s = static_cast<double>(*command.time_s);
  catch_stop_signals();  // so that the folder is removed
  Progress progress("shake", 1, "runs");
  options.progress = [&](std::uint64_t done, std::uint64_t expected) { progress.update(done, expected); };
  const Result<shake::ShakeReport> report = shake::run_shake(options);
  progress.finish();
  if (!report) return fail_in_lines(report.error());
  print(command.json ? shake::shake_json(*report, subject) : shake::shake_text(*report, subject));
  if (!command.junit.empty())
    if (const Status status = verifier::write_data_file(command.junit, shake::shake_junit(*report, subject)); !status)
      return fail_usage(status.error());
  if (command.github) {
    const std::string lines = shake::shake_github(*report, subject);
    std::fwrite(lines.data(), 1, lines.size(), stderr);
  }
  return shake::exit_code(*report, subject);
}

}  // namespace

void add_shake(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ShakeCommand>();
  CLI::App* command =
      app.add_subcommand("shake", "Run a recorded program again, with one source of differences changed at a time")
          ->group(group_session);
  command->add_option("TRACE", options->trace,
                      "A trace that the program recorded. Without a program: a trace of the engine or of a --plugin, "
                      "or a scene that is recorded first; `ticktrue verify` runs it again");
  command->add_option("PROGRAM", options->words,
                      "Behind --: the program and its arguments. {trace} stands for the trace; without it, "
                      "--verify TRACE is added");
  command
      ->add_option("--vary", options->vary,
                   "Perturbations: a name or +name adds, -name removes, +all adds all. NAME.calls=A..B and "
                   "NAME.ticks=A..B change those calls or ticks alone")
      ->delimiter(',')
      ->type_name("LIST");
  command
      ->add_option("--class", options->classes,
                   "A: must never matter. B: differs between machines. C: measures sensitivity. Default: A,B; "
                   "then only A makes the exit code 1")
      ->delimiter(',')
      ->check(CLI::IsMember({"A", "B", "C"}))
      ->type_name("LIST");
  add_number(*command, "--seeds", options->seed_count, "Runs of each variant of a perturbation (default 1)", {1, 1000});
  add_number(*command, "--time", options->time_s, "Begin no run after so many seconds", {1, 1'000'000});
  add_number(*command, "--timeout", options->timeout_s, "Seconds that a run may take (default 600)", {1, 1'000'000});
  add_number(*command, "-j,--jobs", options->jobs, "Runs at once (default 1)", {1, 1024});
  command->add_flag("--no-narrow", options->no_narrow,
                    "Do not look for the call, its tick and its place in the source");
  command->add_flag("--alone", options->alone,
                    "Run each perturbation by itself, also those that move nothing together");
  command
      ->add_option("--rebuild", options->rebuild,
                   "A shell command that builds the program with CC, CXX, CFLAGS and CXXFLAGS of its environment, "
                   "as the file that TICKTRUE_PROGRAM names. Other compilers and flags are then perturbations, too")
      ->type_name("CMD");
  add_number(*command, "--ticks", options->tick_count, "How many ticks of a scene are recorded (default 600)",
             {1, 1'000'000});
  command->add_flag("--list", options->list, "List the perturbations");
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.shake/2)");
  command->add_option("--junit", options->junit, "Write the results as JUnit XML too, over an older file")
      ->type_name("OUT.xml");
  command->add_flag("--github", options->github, "Annotations for GitHub Actions on standard error");
  command->add_option("--out", options->folder, "Folder for the files of runs; it is kept (default: a temporary one)")
      ->type_name("DIR");
  set_examples(
      *command,
      "ticktrue shake --list\n"
      "ticktrue record 'stack?boxes=5' --ticks 60 -o stack.ttr\n"
      "ticktrue shake stack.ttr --vary heap_fill,locale\n"
      "ticktrue shake 'pyramid?base=5' --ticks 60 --class A\n"
      "ticktrue shake stack.ttr --vary=-cpu_model --junit shake.xml -j 2 -- ticktrue verify {trace} -j 1 --json\n"
      "ticktrue shake stack.ttr --class A --time 20 --no-narrow -- ticktrue verify {trace} -j 1 --json",
      "PROGRAM has a session of the C interface, or prints a report of schema ticktrue.verify/2.\n"
      "Exit codes: 0 nothing of class A moved the program. 1 something did. 2 the program fails or diverges as it\n"
      "is, or usage. 6 the program does not repeat itself; the report tells what has to be held still.");
  command->callback([options, &context] {
    options->words.insert(options->words.end(), context.program.begin(), context.program.end());
    context.exit_code = run_shake_command(*options);
  });
}

}  // namespace ticktrue::cli
