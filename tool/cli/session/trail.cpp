// `ticktrue trail`: names the first call that a program makes otherwise than was recorded, or than another build.
// SPDX-License-Identifier: MIT
#include "tool/experiment/trail/trail.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>

#include "tool/cli/commands.h"
#include "tool/cli/session/program_runs.h"
#include "tool/experiment/trail/trail_report.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::cli {
namespace {

struct TrailCommand {
  std::string trace;
  std::vector<std::string> words;
  std::string against;
  std::vector<std::string> calls;
  std::uint64_t timeout_s = 600;
  bool json = false;
  std::string folder;
};

int run_trail_command(const TrailCommand& command) {
  if (command.words.empty())
    return fail_usage(Error{ErrorCode::usage, "trail: found no program, expected TRACE -- PROGRAM ARGUMENTS",
                            "behind -- stands the program: see `ticktrue trail --help`"});
  std::error_code failed;
  const std::string trace = std::filesystem::canonical(command.trace, failed).string();
  if (failed) return fail_usage(Error{ErrorCode::io, command.trace + ": " + failed.message(), ""});
  const auto folder = verifier::RunFolder::make("ticktrue-trail", command.folder);
  if (!folder) return fail_usage(folder.error());
  trail::TrailSubject subject{command.trace, command.words, command.against, ""};
  for (const std::string& group : command.calls) subject.calls += (subject.calls.empty() ? "" : ",") + group;
  trail::TrailOptions options;
  options.trace = trace;
  options.words = words_with_trace(command.words, trace);
  if (!command.against.empty()) {
    options.against = options.words;
    options.against.front() = command.against;
  }
  options.calls = subject.calls;
  options.launch.folder = folder->path();
  options.launch.shim_path = shim_path();
  options.launch.time_s = static_cast<double>(command.timeout_s);
  catch_stop_signals();  // so that the folder is removed
  const Result<trail::TrailReport> report = trail::run_trail(options);
  if (!report) return fail_usage(report.error());
  print(command.json ? trail::trail_json(*report, subject) : trail::trail_text(*report, subject));
  return trail::exit_code(*report);
}

}  // namespace

void add_trail(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<TrailCommand>();
  CLI::App* command =
      app.add_subcommand("trail", "Name the first call that a program makes otherwise, by the marks of each tick")
          ->group(group_session);
  command->add_option("TRACE", options->trace, "A trace that the program recorded")->required();
  command->add_option("PROGRAM", options->words,
                      "Behind --: the program and its arguments. {trace} stands for the trace; without it, "
                      "--verify TRACE is added");
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
  add_number(*command, "--timeout", options->timeout_s, "Seconds that a run may take (default 600)", {1, 1'000'000});
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.trail/1)");
  command->add_option("--out", options->folder, "Folder for the files of runs; it is kept (default: a temporary one)")
      ->type_name("DIR");
  command->footer(
      "For a program with a session:\n"
      "  ticktrue trail session.ttr -- ./game\n"
      "  ticktrue trail session.ttr --against ./game-of-yesterday -- ./game\n"
      "  ticktrue trail session.ttr --calls random,libm --against ./game-of-yesterday -- ./game\n\n"
      "PROGRAM has a session of the C interface. The trace has marks if it was recorded with TICKTRUE_MARKS.\n"
      "Exit codes: 0 marks and states are as recorded. 1 marks or states differ. 2 the program fails, or\n"
      "usage. 6 a program made other marks when it ran again.");
  command->callback([options, &context] {
    options->words.insert(options->words.end(), context.program.begin(), context.program.end());
    context.exit_code = run_trail_command(*options);
  });
}

}  // namespace ticktrue::cli
