// `ticktrue corpus`: verifies a directory of traces against a store of verdicts, and reports what the store knows.
// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <memory>
#include <optional>

#include "base/count_text.h"
#include "base/hash128.h"
#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/cli/upkeep/corpus_commands.h"
#include "tool/corpus/run/corpus_run.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "verifier/corpus/trace_list.h"
#include "verifier/report/json_parts.h"
#include "verifier/report/report_ci.h"
#include "verifier/runs/data_file.h"
#include "verifier/store/claims.h"

namespace ticktrue::cli {
namespace {

using tool::CorpusUnit;
using tool::UnitSource;
using verifier::Report;
using verifier::StoreFolder;

constexpr std::size_t job_count_max = 1024;
constexpr std::uint64_t part_max_s = 1'000'000;

struct CorpusCommand {
  std::vector<std::string> traces;
  std::string store;
  std::string mode = "replay";
  std::string recheck = "0%";
  std::string shard;
  std::string junit;
  std::string html;
  std::uint64_t jobs = 0;  // 0: every core
  std::uint64_t lease_s = 60;
  std::uint64_t part_s = 60;
  bool claim = false;
  bool no_sync = false;
  bool json = false;
  bool allow_truncated = false;
  CorpusProgram program;
};

/// "5%" as 0.05. Errors: usage.
Result<double> parse_share(const std::string& text) {
  constexpr double percent_max = 100;
  double percent = -1;
  const char* end = text.data() + text.size() - (!text.empty() && text.back() == '%' ? 1 : 0);
  const auto [last, failure] = std::from_chars(text.data(), end, percent);
  if (failure == std::errc() && last == end && percent >= 0 && percent <= percent_max) return percent / percent_max;
  return Error{ErrorCode::usage, "--recheck: found \"" + text + "\", expected a share from 0% to 100%, such as 1%", ""};
}

/// The sources of verdicts, each with its number of units, in the order of the table.
std::string sources_text(const std::vector<CorpusUnit>& units) {
  std::string text;
  for (std::size_t i = 0; i < tool::unit_source_names.size(); ++i) {
    const auto count = std::count_if(units.begin(), units.end(),
                                     [&](const CorpusUnit& unit) { return unit.source == static_cast<UnitSource>(i); });
    const bool is_always_told = i <= static_cast<std::size_t>(UnitSource::verified);
    if (count == 0 && !is_always_told) continue;
    std::string name(tool::unit_source_names[i]);
    std::replace(name.begin(), name.end(), '_', ' ');
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + name;
  }
  return text;
}

std::vector<Report> reports_of(const std::vector<CorpusUnit>& units) {
  std::vector<Report> reports;
  for (const CorpusUnit& unit : units) reports.push_back(unit.report);
  return reports;
}

/// Messages of one kind: a full disk or a missing store has one for each of thousands of traces.
class BoundedMessages {
 public:
  bool may_print() { return ++count_ <= shown_max; }
  void finish(const std::string& what) const {
    if (count_ > shown_max) print_note("and " + std::to_string(count_ - shown_max) + " more " + what);
  }

 private:
  static constexpr std::size_t shown_max = 20;
  std::size_t count_ = 0;
};

void print_messages(const std::vector<CorpusUnit>& units) {
  BoundedMessages warnings, problems;
  for (const CorpusUnit& unit : units) {
    for (const std::string& warning : unit.warnings)
      if (warnings.may_print()) print_warning(warning);
    for (const Error& problem : unit.problems)
      if (problems.may_print()) print_error(problem);
  }
  warnings.finish("warnings");
  problems.finish("verdicts that could not be stored");
}

void print_corpus(const std::vector<CorpusUnit>& units) {
  BoundedMessages errors;
  for (const CorpusUnit& unit : units) {
    if (unit.report.verdict == verifier::Verdict::error) {
      if (errors.may_print()) print_error(Error{ErrorCode::io, unit.report.reason, unit.report.hint});
    } else if (unit.report.verdict != verifier::Verdict::match) {
      print(verifier::report_text(unit.report));
    }
  }
  errors.finish("traces without a verdict");
  std::string text = count_text(units.size(), "trace") + ":";
  const char* separator = " ";
  for (const verifier::VerdictInfo& info : verifier::verdicts) {
    const auto count = std::count_if(units.begin(), units.end(),
                                     [&](const CorpusUnit& unit) { return unit.report.verdict == info.verdict; });
    if (count == 0) continue;
    text += separator + std::to_string(count) + " " + std::string(info.name);
    separator = ", ";
  }
  print(text + "; " + sources_text(units) + "\n");
}

void print_corpus_json(const std::vector<CorpusUnit>& units, const CorpusCommand& command,
                       const tool::BuildSubject& build) {
  Json object = {{"schema", "ticktrue.corpus/2"}};
  object["store"] = command.store;
  object["engine"] = hex128(build.engine);
  object["libraries"] = hex128(build.libraries);
  object["options"] = build.options;
  verifier::add_counts(object, reports_of(units), command.allow_truncated);
  for (std::size_t i = 0; i < tool::unit_source_names.size(); ++i)
    object[std::string(tool::unit_source_names[i])] = std::count_if(
        units.begin(), units.end(), [&](const CorpusUnit& unit) { return unit.source == static_cast<UnitSource>(i); });
  Json rows = Json::array();
  for (const CorpusUnit& unit : units) {
    Json row = verifier::report_row_json(unit.report);
    row["key"] = unit.key.empty() ? Json(nullptr) : Json(unit.key);
    row["source"] = tool::unit_source_names[static_cast<std::size_t>(unit.source)];
    Json problems = Json::array();
    for (const Error& problem : unit.problems) problems.push_back(problem.message);
    row["store_problems"] = std::move(problems);
    row["store_warnings"] = unit.warnings;
    rows.push_back(std::move(row));
  }
  object["rows"] = std::move(rows);
  print_json(object);
}

Status write_junit(const std::vector<CorpusUnit>& units, const CorpusCommand& command) {
  if (command.junit.empty()) return {};
  auto file = verifier::DataFile::create(command.junit, true);
  if (!file) return file.error();
  const Status written = file->write(verifier::report_junit(reports_of(units), command.allow_truncated));
  return written ? file->close() : written;
}

Status check_options(const CorpusCommand& command) {
  if (!command.claim) return {};
  if (!verifier::can_claim())
    return Error{ErrorCode::usage, "--claim: this system has no claims", "share the work by --shard I/N"};
  return {};
}

using CorpusCall = Result<std::vector<CorpusUnit>> (*)(const std::vector<std::string>& files, const std::string& traces,
                                                       const verifier::VerdictStore& store,
                                                       const tool::CorpusOptions& options);

int run_corpus(const CorpusCommand& command, StoreFolder::Use use, CorpusCall call) {
  if (const Status status = check_options(command); !status) return fail_usage(status.error());
  const Result<double> recheck = parse_share(command.recheck);
  if (!recheck) return fail_usage(recheck.error());
  Result<std::vector<std::string>> files = verifier::list_traces(command.traces);
  if (!files) return fail_usage(files.error());
  for (const std::string& output : {command.junit, command.html})
    if (const Status status = verifier::check_not_read(output, *files); !status) return fail_usage(status.error());
  tool::CorpusOptions options;
  if (!command.shard.empty()) {
    const Result<verifier::Shard> shard = verifier::parse_shard(command.shard);
    if (!shard) return fail_usage(shard.error());
    options.shard = *shard;
  }
  options.mode = verify_mode_of(command.mode);
  auto program = open_program(command.program, command.mode);
  if (!program) return fail_usage(program.error());
  options.program = *std::move(program);
  const Result<tool::BuildSubject> build = tool::build_subject(options.mode, options.program.get());
  if (!build) return fail_usage(build.error());
  const Result<StoreFolder> folder = StoreFolder::open(command.store, use, !command.no_sync);
  if (!folder) return fail_usage(folder.error());
  const verifier::VerdictStore store(*folder);
  options.thread_count =
      command.jobs == 0 ? core_count() : static_cast<unsigned>(std::min<std::uint64_t>(command.jobs, job_count_max));
  options.claims = command.claim;
  options.lease_s = static_cast<double>(command.lease_s);
  options.part_s = static_cast<double>(command.part_s);
  options.recheck = *recheck;
  options.stops = stop_requested;
  catch_stop_signals();
  Progress bar("corpus", files->size(), "traces");
  options.progress = [&](std::size_t done, std::size_t of) { bar.update(done, of); };
  const Result<std::vector<CorpusUnit>> units = call(*files, command.traces.front(), store, options);
  bar.finish();
  if (!units) return fail_usage(units.error());

  print_messages(*units);
  if (command.json)
    print_corpus_json(*units, command, *build);
  else
    print_corpus(*units);
  int code = tool::corpus_exit_code(*units, command.allow_truncated);
  const auto write = [&](const Status& status) {
    if (status) return;
    print_error(status.error());
    code = exit_usage;
  };
  write(write_junit(*units, command));
  if (!command.html.empty())
    write(write_corpus_page(*units, *build, {command.html, command.store, command.allow_truncated}));
  return code;
}

void add_common(CLI::App& command, CorpusCommand& options) {
  command.add_option("--mode", options.mode, "What the verdicts prove: see `ticktrue verify --help`")
      ->check(CLI::IsMember(verify_mode_names()))
      ->capture_default_str();
  add_number(command, "-j,--jobs", options.jobs, "Threads: traces at once (default: every core)", {1, job_count_max});
  command.add_flag("--json", options.json, "One JSON object (schema ticktrue.corpus/2)");
  command.add_option("--junit", options.junit, "Write the results as JUnit XML too, over an older file")
      ->type_name("OUT.xml");
  command.add_flag("--allow-truncated", options.allow_truncated,
                   "A trace that ends early is fine if every tick it has matches");
}

}  // namespace

void add_corpus(CLI::App& app, CliContext& context) {
  CLI::App* command = app.add_subcommand("corpus", "Verify many traces, and none of them twice")->group(group_upkeep);
  command->require_subcommand(1);

  auto verify_options = std::make_shared<CorpusCommand>();
  CLI::App* verify = command->add_subcommand(
      "verify", "Verify every trace of which the store has no verdict by this build; any number of these at once");
  verify->add_option("DIR", verify_options->traces, "Traces, or directories: then every *.ttr in them")->required();
  verify->add_option("--cache", verify_options->store, "The store of verdicts: a directory, made where there is none")
      ->type_name("STORE")
      ->required();
  verify->add_flag("--claim", verify_options->claim,
                   "Share the traces with other workers on the same store, on this machine or others: each takes what "
                   "no other has");
  add_number(*verify, "--lease", verify_options->lease_s,
             "With --claim: seconds after which a worker that gives no sign of life has lost its traces (default 60)",
             {1, lease_max_s});
  verify
      ->add_option(
          "--shard", verify_options->shard,
          "Share I of N of the work, by what each trace cost before; all shards need the same store, or copies "
          "of one")
      ->type_name("I/N");
  add_number(*verify, "--part-seconds", verify_options->part_s,
             "Cut a trace that took longer than this before into parts, which workers share (default 60)",
             {0, part_max_s});
  verify
      ->add_option("--recheck", verify_options->recheck,
                   "Read and run again this share of the traces that the store knows, chosen at random (default 0%)")
      ->type_name("P%");
  verify->add_flag("--no-sync", verify_options->no_sync,
                   "Do not wait until a verdict is on the disk: after a loss of power some are verified again");
  add_program_options(*verify, verify_options->program, true);
  add_common(*verify, *verify_options);
  set_examples(*verify,
               "for n in 1 2 3; do ticktrue record \"stack?boxes=$n\" --ticks 60 -o \"stack$n.ttr\"; done\n"
               "ticktrue corpus verify . --cache verdicts\n"
               "ticktrue corpus verify . --cache verdicts --recheck 100% -j 2\n"
               "ticktrue corpus verify . --cache verdicts --claim --lease 30\n"
               "ticktrue corpus verify . --cache verdicts --json --junit results.xml",
               "A verdict is that of the bytes of the trace, the engine (sources, flags, compiler), the libraries\n"
               "that are loaded, the mode and the instruction set. Only `match` is taken from the store: any other\n"
               "verdict is found again by a run. Two verdicts that differ are exit 6, and both are kept.\n"
               "For a program with a session:\n"
               "  ticktrue corpus verify sessions --cache verdicts --command './mygame --verify {}'");
  verify->callback([verify_options, &context] {
    context.exit_code = run_corpus(*verify_options, StoreFolder::Use::writing, tool::verify_corpus);
  });

  auto report_options = std::make_shared<CorpusCommand>();
  CLI::App* report = command->add_subcommand(
      "report", "Report what the store knows of every trace; a trace without a verdict by this build is exit 2");
  report->add_option("STORE", report_options->store, "The store of verdicts")->required();
  report->add_option("DIR", report_options->traces, "Traces, or directories: then every *.ttr in them")->required();
  add_program_options(*report, report_options->program, false);
  add_common(*report, *report_options);
  report
      ->add_option("--html", report_options->html,
                   "Write a page with a table of the traces, in which the worst one plays, over an older file")
      ->type_name("OUT.html");
  set_examples(*report,
               "ticktrue record 'stack?boxes=10' --ticks 60 -o stack.ttr\n"
               "ticktrue corpus verify . --cache verdicts\n"
               "ticktrue corpus report verdicts . --junit results.xml --html all.html");
  report->callback([report_options, &context] {
    context.exit_code = run_corpus(*report_options, StoreFolder::Use::reading, tool::look_up_corpus);
  });
  add_corpus_log(*command, context);
  add_corpus_slurm(*command, context);
}

}  // namespace ticktrue::cli
