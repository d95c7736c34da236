// `ticktrue trail`: names the first call that a program makes otherwise than was recorded, or than another build.
// SPDX-License-Identifier: MIT
#include "tool/experiment/trail/trail.h"

#include <CLI/CLI.hpp>

#include "tool/cli/commands.h"
#include "tool/cli/session/program_runs.h"
#include "tool/experiment/trail/trail_report.h"

namespace ticktrue::cli {
namespace {

struct TrailCommand {
  ProgramOptions program;
  std::string against;
  std::vector<std::string> calls;
};

int run_trail_command(const TrailCommand& command) {
  const Result<ProgramRun> run = prepare_run("trail", command.program);
  if (!run) return fail_usage(run.error());
  trail::TrailSubject subject{command.program.trace, command.program.words, command.against, ""};
  for (const std::string& group : command.calls) subject.calls += (subject.calls.empty() ? "" : ",") + group;
  trail::TrailOptions options;
  options.trace = run->trace;
  options.words = run->words;
  if (!command.against.empty()) {
    options.against = options.words;
    options.against.front() = command.against;
  }
  options.calls = subject.calls;
  options.launch = run->launch;
  const Result<trail::TrailReport> report = trail::run_trail(options);
  if (!report) return fail_usage(report.error());
  print(command.program.json ? trail::trail_json(*report, subject) : trail::trail_text(*report, subject));
  return trail::exit_code(*report);
}

}  // namespace

void add_trail(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<TrailCommand>();
  CLI::App* command =
      app.add_subcommand("trail", "Name the first call that a program makes otherwise, by the marks of each tick")
          ->group(group_session);
  add_program_words(*command, options->program);
  command
      ->add_option("--against", options->against,
                   "Another build of the program, run with the same arguments: compared with it, not with the trace")
      ->type_name("PROGRAM");
  command
      ->add_option("--calls", options->calls,
                   "Calls of the C library that are marked without a change of the program: random, libm")
      ->delimiter(',')
      ->check(CLI::IsMember({"random", "libm"}))
      ->type_name("LIST");
  add_program_options(*command, options->program, "ticktrue.trail/1");
  command->footer(
      "For a program with a session:\n"
      "  ticktrue trail session.ttr -- ./game\n"
      "  ticktrue trail session.ttr --against ./game-of-yesterday -- ./game\n"
      "  ticktrue trail session.ttr --calls random,libm --against ./game-of-yesterday -- ./game\n\n"
      "PROGRAM has a session of the C interface. The trace has marks if it was recorded with TICKTRUE_MARKS.\n"
      "Exit codes: 0 marks and states are as recorded. 1 marks or states differ. 2 the program fails, or\n"
      "usage. 6 a program made other marks when it ran again.");
  command->callback([options, &context] {
    options->program.words.insert(options->program.words.end(), context.program.begin(), context.program.end());
    context.exit_code = run_trail_command(*options);
  });
}

}  // namespace ticktrue::cli
