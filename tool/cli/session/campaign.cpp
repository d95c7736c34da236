// `ticktrue campaign`: records a program with many seeds, verifies each trace, and goes on where it was stopped.
// SPDX-License-Identifier: MIT
#include "tool/campaign/campaign.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <system_error>

#include "base/parallel/jobs.h"
#include "tool/cli/commands.h"
#include "tool/output/json_output.h"
#include "tool/output/progress.h"
#include "verifier/programs/command_words.h"
#include "verifier/report/report_ci.h"
#include "verifier/runs/data_file.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::cli {
namespace {

namespace fs = std::filesystem;
using campaign::SeedResult;
using verifier::Verdict;

constexpr std::uint64_t seed_count_max = 1'000'000;

struct CampaignCommand {
  std::string record;
  std::string verify;
  std::string seeds;
  std::string out;
  std::string junit;
  std::uint64_t jobs = 0;  // 0: every core
  std::uint64_t timeout_s = 600;
  bool restore = false;
  bool keep = false;
  bool again = false;
  bool json = false;
};

/// One seed of the campaign.
struct Entry {
  std::optional<SeedResult> result;
  bool is_new = false;  // of this run
};

Result<TickRange> parse_seeds(const std::string& text) {
  const Result<TickRange> range = parse_tick_range(text, "--seeds");
  if (!range)
    return Error{ErrorCode::usage, "--seeds: found \"" + text + "\", expected A..B or one seed, with A <= B", ""};
  if (range->last - range->first >= seed_count_max)
    return Error{ErrorCode::usage,
                 "--seeds: found \"" + text + "\", expected at most " + std::to_string(seed_count_max) + " seeds",
                 "several campaigns may have folders of their own"};
  return range;
}

Result<campaign::CampaignOptions> options_of(const CampaignCommand& command) {
  campaign::CampaignOptions options;
  auto record = verifier::split_command(command.record, "--command");
  if (!record) return record.error();
  options.record = *std::move(record);
  std::vector<std::string> words = options.record;
  const verifier::CommandMark seed[] = {{"{seed}", "1"}};
  if (!verifier::replace_marks(words, seed)[0])
    return Error{ErrorCode::usage, "--command: found no {seed}, expected it among the words",
                 "as in --command './mygame --bot {seed} --record {trace}'"};
  if (!command.verify.empty()) {
    auto verify = verifier::split_command(command.verify, "--verify");
    if (!verify) return verify.error();
    options.verify = *std::move(verify);
  } else if (command.restore) {
    return Error{ErrorCode::usage, "--restore: found no --verify, expected one", "it is verification from saves"};
  }
  options.restore = command.restore;
  options.keeps_traces = command.keep;
  options.time_s = static_cast<double>(command.timeout_s);
  std::error_code failure;
  fs::create_directory(command.out, failure);
  options.folder = fs::canonical(command.out, failure).string();
  if (failure) return Error{ErrorCode::io, command.out + ": " + failure.message(), ""};
  return options;
}

std::string result_text(const campaign::CampaignOptions& options, const SeedResult& result, const std::string& folder) {
  std::string text =
      fmt::format("{}  seed {}  {}\n", verifier::verdict_info(result.verdict).name, result.seed, result.reason);
  if (!result.trace.empty()) text += "  trace   " + (fs::path(folder) / result.trace).string() + "\n";
  return text + "  again   " + campaign::again_command(options, result, folder) + "\n";
}

class Campaign {
 public:
  Campaign(const CampaignCommand& command, campaign::CampaignOptions options, campaign::ResultsFile file,
           TickRange seeds, std::string program)
      : command_(command),
        options_(std::move(options)),
        file_(std::move(file)),
        first_(seeds.first),
        entries_(static_cast<std::size_t>(seeds.last - seeds.first + 1)),
        program_(std::move(program)) {}

  int run() {
    const auto folder = verifier::RunFolder::make("ticktrue-campaign", "");
    if (!folder) return fail_usage(folder.error());
    catch_stop_signals();
    take_earlier();
    const std::vector<std::size_t> open = open_entries();
    const auto threads = command_.jobs == 0 ? core_count() : static_cast<unsigned>(command_.jobs);
    Progress bar("campaign", open.size(), "seeds");
    print_known();
    const Status status = run_jobs(open.size(), threads, [&](std::size_t i) {
      judge(open[i], folder->path());
      const std::lock_guard<std::mutex> guard(lock_);
      bar.finish();
      print_known();
      bar.update(judged_count_);
    });
    bar.finish();
    verifier::end_escaped(escaped_);
    if (!status) return fail(status.error());
    return finish();
  }

 private:
  std::uint64_t seed_of(std::size_t index) const { return first_ + index; }

  void take_earlier() {
    if (command_.again) return;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      const auto found = file_.before().find(seed_of(i));
      if (found == file_.before().end() || found->second.program != program_) continue;
      entries_[i].result = found->second;
    }
  }

  std::vector<std::size_t> open_entries() const {
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < entries_.size(); ++i)
      if (!entries_[i].result) open.push_back(i);
    return open;
  }

  void judge(std::size_t index, const std::string& run_folder) {
    if (stop_requested()) return;
    campaign::Judged judged = campaign::judge_seed(options_, seed_of(index), run_folder);
    judged.result.program = program_;
    const std::lock_guard<std::mutex> guard(lock_);
    escaped_.insert(escaped_.end(), judged.escaped.begin(), judged.escaped.end());
    // What a stop signal ended says nothing of the seed.
    if (stop_requested() && judged.result.verdict != Verdict::match) return;
    ++judged_count_;
    entries_[index] = {judged.result, true};
    if (judged.result.verdict == Verdict::error) return;  // the machine may be mended: the seed is run again
    if (const Status written = file_.append(judged.result); !written && !problem_) problem_ = written.error();
  }

  /// Red seeds in their order, each as soon as those before it are known.
  void print_known() {
    for (; printed_ < entries_.size() && entries_[printed_].result; ++printed_) {
      const SeedResult& result = *entries_[printed_].result;
      if (!command_.json && result.verdict != Verdict::match) print(result_text(options_, result, command_.out));
    }
  }

  std::vector<verifier::Report> reports() const {
    std::vector<verifier::Report> list;
    for (const Entry& entry : entries_) {
      if (!entry.result) continue;
      verifier::Report& report = list.emplace_back();
      report.file = "seed " + std::to_string(entry.result->seed);
      report.mode = "replay";
      report.verdict = entry.result->verdict;
      report.reason = entry.result->reason;
      report.ticks_compared = entry.result->ticks;
    }
    return list;
  }

  int finish() {
    for (; printed_ < entries_.size(); ++printed_)  // behind a seed that was not judged
      if (entries_[printed_].result && !command_.json && entries_[printed_].result->verdict != Verdict::match)
        print(result_text(options_, *entries_[printed_].result, command_.out));
    const std::vector<verifier::Report> found = reports();
    std::vector<int> codes;
    for (const verifier::Report& report : found) codes.push_back(report.exit_code());
    if (command_.json)
      print_json(json());
    else
      print(summary());
    if (!command_.junit.empty())
      if (const Status written = verifier::write_data_file(command_.junit, verifier::report_junit(found, false));
          !written)
        codes.push_back(fail_usage(written.error()));
    if (problem_) codes.push_back(fail_usage(*problem_));
    if (found.size() < entries_.size())
      codes.push_back(
          fail_usage(Error{ErrorCode::usage,
                           fmt::format("campaign: stopped: found {} of {} seeds judged", found.size(), entries_.size()),
                           "the same command goes on with the others"}));
    return worst_exit_code(codes);
  }

  std::size_t earlier_count() const {
    return static_cast<std::size_t>(std::count_if(entries_.begin(), entries_.end(),
                                                  [](const Entry& entry) { return entry.result && !entry.is_new; }));
  }

  std::string summary() const {
    std::string text = std::to_string(entries_.size()) + " seeds:";
    const char* separator = " ";
    for (const verifier::VerdictInfo& info : verifier::verdicts) {
      const auto count = std::count_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
        return entry.result && entry.result->verdict == info.verdict;
      });
      if (count == 0) continue;
      text += separator + std::to_string(count) + " " + std::string(info.name);
      separator = ", ";
    }
    if (earlier_count() > 0) text += "; " + std::to_string(earlier_count()) + " of them judged before";
    return text + "\n";
  }

  Json json() const {
    Json object = {{"schema", "ticktrue.campaign/1"}, {"folder", command_.out}, {"program", program_}};
    std::size_t passed = 0, judged = 0;
    Json rows = Json::array();
    for (const Entry& entry : entries_) {
      if (!entry.result) continue;
      ++judged;
      passed += entry.result->verdict == Verdict::match;
      rows.push_back(row_json(*entry.result, entry.is_new));
    }
    object["passed"] = passed;
    object["failed"] = judged - passed;
    object["expected"] = 0;
    object["not_applicable"] = 0;
    object["not_judged"] = entries_.size() - judged;
    object["rows"] = std::move(rows);
    return object;
  }

  Json row_json(const SeedResult& result, bool is_new) const {
    const auto text = [](const std::string& value) { return value.empty() ? Json(nullptr) : Json(value); };
    Json row = {{"seed", result.seed}, {"verdict", verifier::verdict_info(result.verdict).name}};
    row["judged_before"] = !is_new;
    row["ticks_compared"] = result.ticks;
    row["tick"] = result.tick ? Json(*result.tick) : Json(nullptr);
    row["table"] = text(result.table);
    row["column"] = text(result.column);
    row["trace"] = text(result.trace);
    row["second"] = text(result.second);
    row["reason"] = result.reason;
    row["again"] = result.verdict == Verdict::match ? Json(nullptr)
                                                    : Json(campaign::again_command(options_, result, command_.out));
    return row;
  }

  const CampaignCommand& command_;
  campaign::CampaignOptions options_;
  campaign::ResultsFile file_;
  std::uint64_t first_;
  std::vector<Entry> entries_;
  std::string program_;
  std::mutex lock_;  // of all below, and of the entries while jobs run
  std::size_t printed_ = 0;
  std::size_t judged_count_ = 0;
  std::vector<verifier::EscapedChild> escaped_;
  std::optional<Error> problem_;  // the first with the results
};

int run_campaign(const CampaignCommand& command) {
  const Result<TickRange> seeds = parse_seeds(command.seeds);
  if (!seeds) return fail_usage(seeds.error());
  if (!command.junit.empty())
    if (const Status target = verifier::check_writable_target(command.junit, true); !target)
      return fail_usage(target.error());
  auto options = options_of(command);
  if (!options) return fail_usage(options.error());
  const Result<std::string> program = campaign::program_digest(*options);
  if (!program) return fail_usage(program.error());
  auto file = campaign::ResultsFile::open(options->folder, {seeds->first, seeds->last});
  if (!file) return fail_usage(file.error());
  return Campaign(command, *std::move(options), std::move(*file), *seeds, *program).run();
}

}  // namespace

void add_campaign(CLI::App& app, CliContext& context) {
  auto options = std::make_shared<CampaignCommand>();
  CLI::App* command =
      app.add_subcommand("campaign", "Record a program with many seeds, and verify each trace")->group(group_session);
  command
      ->add_option("--command", options->record,
                   "The program that records: {seed} and {trace} stand for the seed and its trace; without {trace}, "
                   "--record TRACE is added")
      ->required()
      ->type_name("WORDS");
  command
      ->add_option("--verify", options->verify,
                   "The program that verifies, as for `verify --command`. Default: each seed is recorded twice, and "
                   "the two traces are compared")
      ->type_name("WORDS");
  command->add_option("--seeds", options->seeds, "The seeds, both included")->required()->type_name("A..B");
  command
      ->add_option(
          "--out", options->out,
          "Folder for results.tsv and the traces of red seeds. Seeds that it has a result of are not run again")
      ->required()
      ->type_name("DIR");
  command->add_flag("--restore", options->restore,
                    "Verify traces with saves also with the words --mode restore behind those of --verify");
  command->add_flag("--keep", options->keep, "Keep the traces of seeds that match, too");
  command->add_flag("--again", options->again, "Run every seed, also those that have a result");
  add_number(*command, "-j,--jobs", options->jobs, "Seeds at once (default: every core)", {1, 1024});
  add_number(*command, "--timeout", options->timeout_s, "Seconds that a run may take (default 600)", {1, 1'000'000});
  command->add_flag("--json", options->json, "One JSON object (schema ticktrue.campaign/1)");
  command->add_option("--junit", options->junit, "Write the results as JUnit XML too, over an older file")
      ->type_name("OUT.xml");
  set_examples(*command,
               "ticktrue campaign --command 'ticktrue record stack?boxes={seed} --ticks 60 -o {trace}' --seeds 1..4 "
               "--out stacks",
               "For a program with a session:\n"
               "  ticktrue campaign --command './mygame --bot {seed} --record {trace}' --verify './mygame --verify "
               "{trace}' \\\n    --seeds 1..1000 --out bots");
  command->callback([options, &context] { context.exit_code = run_campaign(*options); });
}

}  // namespace ticktrue::cli
