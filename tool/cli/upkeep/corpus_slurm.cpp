// `ticktrue corpus slurm`: prints a script that verifies a corpus on a cluster.
// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/cli/upkeep/corpus_commands.h"
#include "tool/corpus/slurm_script.h"
#include "tool/output/progress.h"
#include "verifier/corpus/trace_list.h"
#include "verifier/store/claims.h"

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;
using verifier::StoreFolder;

constexpr std::uint64_t cpu_count_max = 1024;
constexpr std::uint64_t task_count_max = 100'000;
constexpr std::uint64_t minutes_max = 10'000;

struct SlurmCommand {
  std::vector<std::string> traces;
  std::string store;
  std::string mode = "replay";
  std::string sbatch;
  std::string junit;
  std::string html;
  std::uint64_t cpus = 1;
  std::uint64_t tasks_max = 1000;
  std::uint64_t minutes = 10;
  std::uint64_t lease_s = 60;
  bool allow_truncated = false;
  CorpusProgram program;
};

std::string absolute(const std::string& path) {
  std::error_code failure;
  const fs::path whole = fs::absolute(path, failure).lexically_normal();
  return failure ? path : whole.string();
}

std::string own_path() {
  std::error_code failure;
  const fs::path path = fs::read_symlink("/proc/self/exe", failure);
  return failure ? "ticktrue" : path.string();
}

Status check_words(const SlurmCommand& command) {
  if (!verifier::can_claim())
    return Error{ErrorCode::usage, "corpus slurm: this system has no claims", "share the work by --shard I/N"};
  if (command.sbatch.find('\n') != std::string::npos)
    return Error{ErrorCode::usage, "--sbatch: found a line break, expected words", ""};
  return {};
}

/// The words may name files beside the folder in which the script is made.
void add_program_words(const CorpusProgram& program, tool::SlurmJob& job) {
  job.folder = absolute(".");
  for (auto* words : {&job.verify_words, &job.report_words}) {
    words->insert(words->end(), {"--command", *program.words});
    for (const std::string& file : program.files) words->insert(words->end(), {"--program-file", file});
  }
  job.verify_words.insert(job.verify_words.end(),
                          {"--timeout", std::to_string(program.timeout_s), "--program-commit", program.commit});
}

int run_slurm(const SlurmCommand& command) {
  if (const Status status = check_words(command); !status) return fail_usage(status.error());
  const Result<std::vector<std::string>> files = verifier::list_traces(command.traces);
  if (!files) return fail_usage(files.error());
  const Result<StoreFolder> folder = StoreFolder::open(command.store, StoreFolder::Use::writing, true);
  if (!folder) return fail_usage(folder.error());
  const verifier::VerdictStore store(*folder);
  tool::CorpusOptions options;
  options.mode = verify_mode_of(command.mode);
  options.thread_count = core_count();
  auto program = open_program(command.program, command.mode);
  if (!program) return fail_usage(program.error());
  options.program = *std::move(program);
  const Result<std::vector<double>> costs = tool::open_costs(*files, command.traces.front(), store, options);
  if (!costs) return fail_usage(costs.error());

  tool::SlurmJob job;
  job.tool = own_path();
  for (const std::string& trace : command.traces) job.traces.push_back(absolute(trace));
  job.store = absolute(command.store);
  job.verify_words = {"--mode", command.mode, "--lease", std::to_string(command.lease_s)};
  job.report_words = {"--mode", command.mode};
  if (command.allow_truncated)
    for (auto* words : {&job.verify_words, &job.report_words}) words->emplace_back("--allow-truncated");
  for (const auto& [option, path] : {std::pair("--junit", command.junit), std::pair("--html", command.html)}) {
    if (path.empty()) continue;
    job.report_words.emplace_back(option);
    job.report_words.push_back(absolute(path));
  }
  if (options.program) add_program_words(command.program, job);
  job.sbatch_words = command.sbatch;
  job.cpu_count = command.cpus;
  job.task_count_max = command.tasks_max;
  job.task_minutes = command.minutes;
  print(tool::slurm_script(job, tool::slurm_size(*costs, job)));
  return exit_ok;
}

}  // namespace

void add_corpus_slurm(CLI::App& corpus, CliContext& context) {
  auto options = std::make_shared<SlurmCommand>();
  CLI::App* command =
      corpus.add_subcommand("slurm", "Print a script that verifies the traces on a Slurm cluster, sized by their cost");
  command->add_option("DIR", options->traces, "Traces, or directories: then every *.ttr in them")->required();
  command->add_option("--cache", options->store, "The store of verdicts, on a file system that all nodes see")
      ->type_name("STORE")
      ->required();
  add_number(*command, "--cpus", options->cpus, "Processors of a task (default 1)", {1, cpu_count_max});
  add_number(*command, "--minutes", options->minutes, "Work that a task should have (default 10)", {1, minutes_max});
  add_number(*command, "--tasks-max", options->tasks_max, "Tasks at most (default 1000)", {1, task_count_max});
  add_number(*command, "--lease", options->lease_s,
             "Seconds after which a worker that gives no sign of life has lost its traces (default 60)",
             {1, lease_max_s});
  command->add_option("--sbatch", options->sbatch, "More words for sbatch, such as '--partition=long --mem=2G'")
      ->type_name("WORDS");
  command->add_option("--mode", options->mode, "What the verdicts prove: see `ticktrue verify --help`")
      ->check(CLI::IsMember(verify_mode_names()))
      ->capture_default_str();
  add_program_options(*command, options->program, true);
  command->add_option("--junit", options->junit, "The report writes this file")->type_name("OUT.xml");
  command->add_option("--html", options->html, "The report writes this page")->type_name("OUT.html");
  command->add_flag("--allow-truncated", options->allow_truncated,
                    "A trace that ends early is fine if every tick it has matches");
  set_examples(*command,
               "for n in 1 2 3; do ticktrue record \"stack?boxes=$n\" --ticks 60 -o \"stack$n.ttr\"; done\n"
               "ticktrue corpus slurm . --cache verdicts --cpus 2 --html all.html > job.sh\n"
               "sh job.sh worker && sh job.sh report",
               "`sh job.sh` submits an array of workers that share the store by claims, and a report that starts when\n"
               "all of them have ended. A task is queued again, three times at most, where its node failed, or after\n"
               "exit code 2 or a signal. What is found in a trace (1, 3, 4, 5, 6) never queues a task again.");
  command->callback([options, &context] { context.exit_code = run_slurm(*options); });
}

}  // namespace ticktrue::cli
