// `ticktrue verify`: re-simulates traces and reports the first divergence of each.
// SPDX-License-Identifier: MIT
#include "verifier/verify.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <system_error>

#include "verifier/cli/commands.h"
#include "verifier/cli/progress.h"
#include "verifier/cli/trace_words.h"
#include "verifier/report.h"
#include "verifier/simulations.h"

namespace ticktrue::cli {
namespace {

using verifier::Report;
using verifier::Verdict;

struct VerifyCommand {
  std::vector<std::string> files;
  std::string mode = "replay";
  std::optional<std::uint64_t> from;
  std::optional<std::uint64_t> to;
  bool to_end = false;
  bool json = false;
  bool git_bisect = false;
  bool allow_truncated = false;
};

std::vector<std::string> mode_names() {
  std::vector<std::string> names;
  for (const verifier::VerifyModeInfo& info : verifier::verify_modes) names.emplace_back(info.name);
  return names;
}

std::string mode_help() {
  std::string text = "What to prove.";
  for (const verifier::VerifyModeInfo& info : verifier::verify_modes)
    text += " " + std::string(info.name) + ": " + std::string(info.summary) + ".";
  return text;
}

/// The files meant: a directory stands for the traces in it, by name.
Result<std::vector<std::string>> expand(const std::vector<std::string>& words) {
  std::vector<std::string> files;
  for (const std::string& word : words) {
    std::error_code failure;
    if (!std::filesystem::is_directory(word, failure)) {
      files.push_back(word);
      continue;
    }
    std::vector<std::string> found;
    std::filesystem::directory_iterator entry(word, failure);
    for (; !failure && entry != std::filesystem::directory_iterator(); entry.increment(failure))
      if (entry->path().extension() == ".ttr") found.push_back(entry->path().string());
    if (failure) return Error{ErrorCode::io, word + ": cannot be listed: " + failure.message(), ""};
    if (found.empty()) return Error{ErrorCode::io, word + ": no trace in this directory: found no *.ttr", ""};
    std::sort(found.begin(), found.end());
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

Report verify_file(const std::string& file, const VerifyCommand& command) {
  Result<replay::TraceReader> reader = replay::TraceReader::open(file);
  if (!reader) return verifier::open_error_report(file, reader.error());
  if (command.from)
    if (const Status known = check_tick(file + ": --from", *command.from, reader->tick_count_hint()); !known)
      return verifier::open_error_report(file, known.error());
  verifier::VerifyOptions options;
  options.simulation = verifier::find_simulation(reader->setup().simulation);
  for (const verifier::VerifyModeInfo& info : verifier::verify_modes)
    if (info.name == command.mode) options.mode = info.mode;
  options.from = command.from.value_or(0);
  options.to = command.to;
  options.to_end = command.to_end;
  Progress progress("verify " + file, reader->tick_count_hint().value_or(0));
  options.progress = [&](std::uint64_t ticks_done) { progress.update(ticks_done); };
  Report report = verifier::verify(*reader, options);
  progress.finish();
  if (options.simulation == nullptr && report.hint.empty())
    report.hint = "this build has " + verifier::simulation_names() +
                  "; a plug-in brings another: --plugin LIB.so; a program that owns its loop verifies itself";
  if (report.verdict == Verdict::incomplete && report.exit_code(command.allow_truncated) == verifier::exit_ok) {
    report.hint.clear();
    report.notes.push_back("accepted: every tick up to the cut matches (--allow-truncated)");
  }
  return report;
}

void print_summary(const std::vector<Report>& reports) {
  std::string text = std::to_string(reports.size()) + " traces:";
  const char* separator = " ";
  for (const verifier::VerdictInfo& info : verifier::verdicts) {
    const auto count = std::count_if(reports.begin(), reports.end(),
                                     [&](const Report& report) { return report.verdict == info.verdict; });
    if (count == 0) continue;
    text += separator + std::to_string(count) + " " + std::string(info.name);
    separator = ", ";
  }
  print(text + "\n");
}

int run_verify(const VerifyCommand& command) {
  if (command.from && command.to && *command.from > *command.to)
    return fail_usage(Error{
        ErrorCode::usage,
        "--from: found " + std::to_string(*command.from) + ", expected at most --to " + std::to_string(*command.to),
        ""});
  if (command.to_end && command.mode != "restore")
    return fail_usage(Error{ErrorCode::usage, "--to-end: found --mode " + command.mode + ", expected restore",
                            "the other modes always run to the end"});
  if (command.mode == "twice" && command.from)
    return fail_usage(Error{ErrorCode::usage, "--from: found --mode twice, expected replay or restore",
                            "both runs begin with the setup"});
  const Result<std::vector<std::string>> files = expand(command.files);
  if (!files) return fail_usage(files.error());

  std::vector<Report> reports;
  std::vector<int> codes;
  for (const std::string& file : *files) {
    Report report = verify_file(file, command);
    codes.push_back(report.exit_code(command.allow_truncated));
    if (report.verdict == Verdict::error)
      print_error(Error{ErrorCode::io, report.reason, report.hint});
    else if (!command.json)
      print(verifier::report_text(report));
    reports.push_back(std::move(report));
  }
  if (command.json)
    print(verifier::report_json(reports, command.allow_truncated));
  else if (reports.size() > 1)
    print_summary(reports);
  const int worst = worst_exit_code(codes);
  return command.git_bisect ? verifier::git_bisect_exit_code(worst) : worst;
}

}  // namespace

void add_verify(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<VerifyCommand>();
  CLI::App* command =
      app.add_subcommand("verify", "Re-simulate a trace and report the first divergence")->group(group_session);
  command->add_option("FILE", options->files, "Traces, or directories: then every *.ttr in them")->required();
  command->add_option("--mode", options->mode, mode_help())->check(CLI::IsMember(mode_names()))->capture_default_str();
  add_number(*command, "--from", options->from,
             "First tick to compare; the run begins at the last checkpoint before it");
  add_number(*command, "--to", options->to, "Last tick to compare; the trace is not read beyond it");
  command->add_flag("--to-end", options->to_end,
                    "With --mode restore: run from each checkpoint to the end, not only to the next checkpoint");
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.verify/1)");
  command->add_flag(
      "--git-bisect", options->git_bisect,
      "Exit with 125 (skip this commit) instead of 2, 4, 5 and 6: for `git bisect run`. 3 stays 3, which counts as "
      "bad, unless --allow-truncated makes it 0");
  command->add_flag("--allow-truncated", options->allow_truncated,
                    "A trace that ends early is fine if every tick it has matches");
  set_examples(*command,
               "ticktrue record 'stack?boxes=10' --ticks 600 -o stack.ttr\n"
               "ticktrue verify stack.ttr\n"
               "ticktrue verify stack.ttr --mode restore\n"
               "ticktrue verify . --json\n"
               "head -c 4000 stack.ttr > cut.ttr; ticktrue verify cut.ttr --allow-truncated\n"
               "git bisect run sh -c './dev build && build/release/ticktrue verify traces --git-bisect'");
  command->callback([options, &context] { context.exit_code = run_verify(*options); });
}

}  // namespace ticktrue::cli
