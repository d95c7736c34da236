// `ticktrue bisect`: the first commit whose program no longer runs a trace as recorded.
// SPDX-License-Identifier: MIT
#include "tool/experiment/bisect/bisect.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <system_error>

#include "tool/cli/commands.h"
#include "tool/output/progress.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* default_program = "build/release/ticktrue verify {} --json -j 1";
constexpr const char* default_identity = "build/release/ticktrue env --json | grep '\"engine_digest\": \"'";

struct BisectCommand {
  bisect::BisectOptions options;
  std::string identity;
  std::string store;
  std::uint64_t build_time_s = 3600;
  std::uint64_t verify_time_s = 600;
  bool json = false;
};

/// Completes the options. Errors: usage, io.
Status complete(BisectCommand& command, const std::string& folder) {
  bisect::BisectOptions& options = command.options;
  for (std::string& trace : options.judge.traces) {
    std::error_code failed;
    const fs::path path = fs::canonical(trace, failed);
    if (failed) return Error{ErrorCode::io, trace + ": " + failed.message(), ""};
    trace = path.string();
  }
  if (options.judge.program.empty()) {
    options.judge.program = default_program;
    if (command.identity.empty()) command.identity = default_identity;
  }
  if (options.judge.program.find(bisect::trace_mark) == std::string::npos)
    return Error{ErrorCode::usage,
                 "--program: found \"" + options.judge.program + "\", expected {} where the trace belongs",
                 "as in --program './mygame --verify {}'"};
  if (!command.identity.empty()) options.judge.identity = command.identity;
  options.judge.build_time_s = static_cast<double>(command.build_time_s);
  options.judge.verify_time_s = static_cast<double>(command.verify_time_s);
  options.judge.folder = options.work_folder = folder;
  return {};
}

int run_bisect_command(BisectCommand command) {
  const auto folder = verifier::RunFolder::make("ticktrue-bisect", "");
  if (!folder) return fail_usage(folder.error());
  if (const Status status = complete(command, folder->path()); !status) return fail_usage(status.error());
  // Without --store, verdicts live as long as this run: builds that are the same are run once.
  const std::string verdicts = command.store.empty() ? folder->path() + "/verdicts" : command.store;
  const auto store_folder =
      verifier::StoreFolder::open(verdicts, verifier::StoreFolder::Use::writing, !command.store.empty());
  if (!store_folder) return fail_usage(store_folder.error());
  const verifier::VerdictStore store(*store_folder);
  catch_stop_signals();  // so that the work tree is removed
  Progress progress("bisect", 0, "commits");
  std::uint64_t judged_count = 0;
  command.options.progress = [&](const bisect::JudgedCommit&) {
    progress.update(++judged_count);
    return !stop_requested();
  };
  const auto report = bisect::run_bisect(command.options, store);
  progress.finish();
  if (!report) return fail_usage(report.error());
  print(command.json ? bisect::bisect_json(*report, command.options) : bisect::bisect_text(*report));
  return report->suspects.size() == 1 ? exit_ok : exit_incomplete;
}

}  // namespace

void add_bisect(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<BisectCommand>();
  bisect::BisectOptions& bisection = options->options;
  CLI::App* command = app.add_subcommand("bisect", "Find the commit from which on a trace no longer runs as recorded")
                          ->group(group_upkeep);
  command->add_option("GOOD", bisection.good, "A commit that runs every trace as recorded")->required();
  command->add_option("BAD", bisection.bad, "A later commit that does not")->required();
  command->add_option("TRACE", bisection.judge.traces, "Traces")->required();
  bisection.repository = ".";
  command->add_option("--repository", bisection.repository, "A folder of the repository (default: the working folder)")
      ->type_name("DIR");
  command
      ->add_option("--build", bisection.judge.build, "Builds a commit, in its work tree; without it nothing is built")
      ->type_name("COMMAND");
  command
      ->add_option(
          "--program", bisection.judge.program,
          std::string("Verifies the trace that stands for {}, in the work tree (default: ") + default_program + ")")
      ->type_name("COMMAND");
  command
      ->add_option("--paths", bisection.judge.paths,
                   "What a verdict depends on: commits with the same content there are judged once (default: all)")
      ->delimiter(',')
      ->type_name("LIST");
  command
      ->add_option("--identity", options->identity,
                   "Prints what was built: builds of the same identity are run once (default: the engine digest, "
                   "where --program is left out)")
      ->type_name("COMMAND");
  command->add_option("--store", options->store, "Folder that keeps verdicts for the next time")->type_name("DIR");
  add_number(*command, "--build-timeout", options->build_time_s, "Seconds that a build may take (default 3600)",
             {1, 1'000'000});
  add_number(*command, "--timeout", options->verify_time_s, "Seconds that a program may take (default 600)",
             {1, 1'000'000});
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.bisect/1)");
  command->footer(
      "In a repository:\n"
      "  ticktrue bisect v1.0 main desync.ttr --build 'make -j2' --program './mygame --verify {}' --store verdicts\n"
      "  ticktrue bisect v1.0 HEAD traces/stack.ttr --paths base,engine,replay,verifier,cmake "
      "--build 'cmake --preset release && cmake --build build/release --target ticktrue'\n\n"
      "A commit is good if every trace matches, bad if one diverges or the program crashes, and skipped if it\n"
      "does not build or cannot judge a trace. The checkout of the repository stays as it is.\n"
      "Exit codes: 0 one commit is named. 3 several may be the one, since some were skipped. 2 usage, git.");
  command->callback([options, &context] { context.exit_code = run_bisect_command(*options); });
}

}  // namespace ticktrue::cli
