// `ticktrue unsaved`: names what the save of a program forgets.
// SPDX-License-Identifier: MIT
#include "tool/experiment/unsaved/unsaved.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>

#include "tool/cli/commands.h"
#include "tool/cli/session/program_runs.h"
#include "tool/experiment/unsaved/unsaved_report.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::cli {
namespace {

struct UnsavedCommand {
  std::string trace;
  std::vector<std::string> words;
  std::uint64_t timeout_s = 600;
  bool json = false;
  std::string folder;
};

int run_unsaved_command(const UnsavedCommand& command) {
  if (command.words.empty())
    return fail_usage(Error{ErrorCode::usage, "unsaved: found no program, expected TRACE -- PROGRAM ARGUMENTS",
                            "behind -- stands the program: see `ticktrue unsaved --help`"});
  std::error_code failed;
  const std::string trace = std::filesystem::canonical(command.trace, failed).string();
  if (failed) return fail_usage(Error{ErrorCode::io, command.trace + ": " + failed.message(), ""});
  const auto folder = verifier::RunFolder::make("ticktrue-unsaved", command.folder);
  if (!folder) return fail_usage(folder.error());
  unsaved::UnsavedOptions options;
  options.trace = trace;
  options.launch.words = words_with_trace(command.words, trace);
  options.launch.folder = folder->path();
  options.launch.shim_path = shim_path();
  options.launch.time_s = static_cast<double>(command.timeout_s);
  catch_stop_signals();  // so that the folder is removed
  const Result<unsaved::UnsavedReport> report = unsaved::run_unsaved(options);
  if (!report) return fail_usage(report.error());
  print(command.json ? unsaved::unsaved_json(*report, command.trace) : unsaved::unsaved_text(*report, command.trace));
  return unsaved::exit_code(*report);
}

}  // namespace

void add_unsaved(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<UnsavedCommand>();
  CLI::App* command =
      app.add_subcommand("unsaved", "Name the variables and heap blocks that a save forgets and that move a column")
          ->group(group_session);
  command->add_option("TRACE", options->trace, "A trace that the program recorded")->required();
  command->add_option("PROGRAM", options->words,
                      "Behind --: the program and its arguments. {trace} stands for the trace; without it, "
                      "--verify TRACE is added");
  add_number(*command, "--timeout", options->timeout_s, "Seconds that the run may take (default 600)", {1, 1'000'000});
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.unsaved/1)");
  command
      ->add_option("--out", options->folder, "Folder for the files of the run; it is kept (default: a temporary one)")
      ->type_name("DIR");
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
