// `ticktrue unsaved`: names what the save of a program forgets.
// SPDX-License-Identifier: MIT
#include "tool/experiment/unsaved/unsaved.h"

#include <CLI/CLI.hpp>

#include "tool/cli/commands.h"
#include "tool/cli/session/program_runs.h"
#include "tool/experiment/unsaved/unsaved_report.h"

namespace ticktrue::cli {
namespace {

int run_unsaved_command(const ProgramOptions& command) {
  const Result<ProgramRun> run = prepare_run("unsaved", command);
  if (!run) return fail_usage(run.error());
  unsaved::UnsavedOptions options;
  options.trace = run->trace;
  options.launch = run->launch;
  options.launch.words = run->words;
  options.shake_command = shake::shake_command(command.trace, command.words);
  const Result<unsaved::UnsavedReport> report = unsaved::run_unsaved(options);
  if (!report) return fail_usage(report.error());
  print(command.json ? unsaved::unsaved_json(*report, command.trace) : unsaved::unsaved_text(*report, command.trace));
  return unsaved::exit_code(*report);
}

}  // namespace

void add_unsaved(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<ProgramOptions>();
  CLI::App* command =
      app.add_subcommand("unsaved", "Name the variables and heap blocks that a save forgets and that move a column")
          ->group(group_session);
  add_program_words(*command, *options);
  add_program_options(*command, *options, "ticktrue.unsaved/1");
  command->footer(
      "For a program with a session and the callbacks save and load:\n"
      "  ticktrue unsaved session.ttr -- ./game\n"
      "  ticktrue unsaved session.ttr --json -- ./game --replay {trace}\n\n"
      "Save and load are called every few ticks. What load leaves otherwise than it was is written into copies of\n"
      "the process, which run the next ticks. What makes such a copy differ is named. GNU/Linux alone.\n"
      "Exit codes: 0 nothing unsaved moves a column. 1 something does. 2 the program fails, or usage.\n"
      "6 the same ticks from the same memory end otherwise.");
  command->callback([options, &context] {
    options->words.insert(options->words.end(), context.program.begin(), context.program.end());
    context.exit_code = run_unsaved_command(*options);
  });
}

}  // namespace ticktrue::cli
