// Runs of one seed, and what they say.
// SPDX-License-Identifier: MIT
#include "tool/campaign/campaign.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/hash128.h"
#include "replay/trace_reader.h"
#include "verifier/compare/diff.h"
#include "verifier/programs/command_words.h"
#include "verifier/programs/program_run.h"
#include "verifier/programs/verify_program.h"
#include "verifier/report/report_ci.h"
#include "verifier/verify/verify.h"

namespace ticktrue::campaign {
namespace {

namespace fs = std::filesystem;
using verifier::Report;
using verifier::Verdict;

/// The beginning of a reason where there is no whole trace to judge.
constexpr std::string_view recording_failed = "the recording: ";

std::string trace_name(std::uint64_t seed) {
  return "seed-" + std::to_string(seed) + ".ttr";
}
std::string second_name(std::uint64_t seed) {
  return "seed-" + std::to_string(seed) + ".second.ttr";
}

/// The words of a recording.
std::vector<std::string> words_for(const CampaignOptions& options, std::uint64_t seed, const std::string& trace) {
  std::vector<std::string> words = options.record;
  const verifier::CommandMark marks[] = {{"{seed}", std::to_string(seed)}, {"{trace}", trace}, {"{}", trace}};
  const std::vector<bool> found = verifier::replace_marks(words, marks);
  if (!found[1] && !found[2]) words.insert(words.end(), {"--record", trace});
  return words;
}

class SeedJudge {
 public:
  SeedJudge(const CampaignOptions& options, std::uint64_t seed, const std::string& run_folder)
      : options_(options), seed_(seed), run_folder_(run_folder), trace_(options.folder + "/" + trace_name(seed)) {}

  Judged judge() {
    std::optional<Report> failed = record(trace_);
    const Report report = failed ? *std::move(failed) : options_.verify.empty() ? record_twice() : verify();
    judged_.result = result_of(report);
    keep_files();
    return std::move(judged_);
  }

 private:
  std::string second() const { return options_.folder + "/" + second_name(seed_); }

  Report report_of(Verdict verdict, const std::string& reason) const {
    Report report;
    report.file = trace_;
    report.mode = "replay";
    report.verdict = verdict;
    report.reason = reason;
    return report;
  }

  void take_escaped(const std::vector<verifier::EscapedChild>& escaped) {
    judged_.escaped.insert(judged_.escaped.end(), escaped.begin(), escaped.end());
  }

  /// What is wrong with a recording; nothing: it is a trace.
  std::optional<Report> record(const std::string& path) {
    std::error_code failure;
    fs::remove(path, failure);
    const auto run =
        verifier::run_program(words_for(options_, seed_, path), run_folder_, run_name("record"), options_.time_s);
    if (!run) return report_of(Verdict::error, run.error().message);
    take_escaped(run->child.end.escaped);
    const std::string what = std::string(recording_failed) + options_.record.front() + " ";
    if (run->child.end.how == verifier::ChildEnd::How::not_started)
      return report_of(Verdict::error, what + run->failure);
    if (!run->failure.empty()) return report_of(Verdict::incomplete, what + run->failure + position_text(*run));
    const std::string message = verifier::last_line(*run);
    const std::string said = message.empty() ? "" : ": " + message;
    if (run->child.end.exit_status != 0)
      return report_of(Verdict::incomplete, what + "ended with status " + std::to_string(run->child.end.exit_status) +
                                                position_text(*run) + said);
    if (!fs::exists(path, failure)) return report_of(Verdict::incomplete, what + "left no trace" + said);
    return std::nullopt;
  }

  std::string run_name(const std::string& what) const { return what + "-" + std::to_string(seed_); }

  Report record_twice() {
    if (std::optional<Report> failed = record(second())) {
      failed->reason += ", the second time";
      return *std::move(failed);
    }
    auto a = replay::TraceReader::open(trace_);
    auto b = replay::TraceReader::open(second());
    for (const auto* reader : {&a, &b})
      if (!*reader) return verifier::open_error_report(trace_, reader->error());
    const verifier::DiffReport diff = verifier::diff(*a, *b, {});
    return report_of_diff(diff);
  }

  Report report_of_diff(const verifier::DiffReport& diff) const {
    using verifier::DiffVerdict;
    Report report = report_of(Verdict::match, "");
    report.ticks_compared = diff.ticks_compared;
    report.ticks_recorded = diff.a.ticks;
    report.divergence = diff.divergence;
    const bool differ = diff.verdict == DiffVerdict::different || diff.verdict == DiffVerdict::not_comparable;
    if (differ) {
      report.verdict = Verdict::not_reproducible;
      report.reason = "two recordings of the seed differ";
      if (diff.inputs)
        report.reason += ": inputs of tick " + std::to_string(diff.inputs->tick);
      else if (!diff.setup.empty())
        report.reason += ": " + diff.setup.front().what;
      else if (!diff.reason.empty())
        report.reason += ": " + diff.reason;
      return report;
    }
    report.reason = diff.reason;
    if (diff.verdict == DiffVerdict::damaged) report.verdict = Verdict::damaged;
    if (diff.verdict == DiffVerdict::incomplete) report.verdict = Verdict::incomplete;
    if (report.verdict != Verdict::match || diff.ticks_compared > 0) return report;
    report.verdict = Verdict::incomplete;
    report.reason = "the trace has no tick";
    return report;
  }

  Report verify() {
    Report report = verify_with({});
    if (report.verdict != Verdict::match || !options_.restore || !has_saves()) return report;
    Report restored = verify_with({"--mode", "restore"});
    if (restored.verdict == Verdict::match && restored.mode != "restore") {
      restored.verdict = Verdict::incomplete;
      restored.reason = "the session did not take the words --mode restore: it ran in mode " + restored.mode;
    }
    return restored;
  }

  Report verify_with(const std::vector<std::string>& more) {
    verifier::ProgramCommand command{options_.verify, run_folder_, options_.time_s};
    const verifier::CommandMark marks[] = {{"{seed}", std::to_string(seed_)}};
    verifier::replace_marks(command.words, marks);
    command.words.insert(command.words.end(), more.begin(), more.end());
    verifier::ProgramVerdict verdict = verifier::verify_by_program(trace_, command, run_name("verify"));
    take_escaped(verdict.escaped);
    return std::move(verdict.report);
  }

  bool has_saves() const {
    const auto reader = replay::TraceReader::open(trace_);
    return reader && reader->setup().has(replay::Feature::saves);
  }

  SeedResult result_of(const Report& report) const {
    SeedResult result;
    result.seed = seed_;
    result.verdict = report.verdict;
    result.ticks = report.ticks_compared;
    if (report.verdict == Verdict::match) return result;
    result.reason = verifier::report_sentence(report);
    if (!report.divergence) return result;
    result.tick = report.divergence->tick;
    if (!report.divergence->rows.empty()) {
      result.table = report.divergence->rows[0].table;
      result.column = report.divergence->rows[0].column;
    } else if (!report.divergence->tables.empty()) {
      const verifier::TableDifference& first = report.divergence->tables[0];
      result.table = first.table;
      if (!first.columns.empty()) result.column = first.columns[0];
    }
    return result;
  }

  void keep_files() {
    std::error_code failure;
    const bool is_green = judged_.result.verdict == Verdict::match;
    const auto keep = [&](const std::string& path, bool keeps, std::string& name) {
      if (!keeps) fs::remove(path, failure);
      if (fs::exists(path, failure)) name = fs::path(path).filename().string();
    };
    keep(trace_, !is_green || options_.keeps_traces, judged_.result.trace);
    if (options_.verify.empty()) keep(second(), !is_green, judged_.result.second);
  }

  const CampaignOptions& options_;
  std::uint64_t seed_;
  const std::string& run_folder_;
  std::string trace_;
  Judged judged_;
};

/// Where a program is found: as named, or by PATH. Empty: nowhere.
std::string program_path(const std::string& word) {
  std::error_code failure;
  if (word.find('/') != std::string::npos) return fs::is_regular_file(word, failure) ? word : "";
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::string candidate = (folder.empty() ? "." : folder) + "/" + word;
    if (fs::is_regular_file(candidate, failure)) return candidate;
  }
  return "";
}

Status add_file(const std::string& path, Hash128Stream& hash) {
  std::ifstream in(path, std::ios::binary);
  std::array<char, 1u << 16> block{};
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    const auto size = static_cast<std::size_t>(in.gcount());
    hash.add({reinterpret_cast<const std::uint8_t*>(block.data()), size});
  }
  if (in.eof()) return {};
  return Error{ErrorCode::io, path + ": cannot be read", ""};
}

Status add_words(const std::vector<std::string>& words, const std::string& option, Hash128Stream& hash) {
  const auto add = [&](const std::string& text) {  // with its end, so that words do not run together
    hash.add({reinterpret_cast<const std::uint8_t*>(text.c_str()), text.size() + 1});
  };
  for (std::size_t i = 0; i < words.size(); ++i) {
    add(words[i]);
    std::error_code failure;
    const std::string path = i == 0 ? program_path(words[i]) : fs::is_regular_file(words[i], failure) ? words[i] : "";
    if (i == 0 && path.empty())
      return Error{ErrorCode::usage, option + ": " + words[0] + ": found no such program, expected one",
                   "no shell runs the command: its first word is a program"};
    if (path.empty()) continue;
    if (const Status added = add_file(path, hash); !added) return added;
  }
  add("");
  return {};
}

}  // namespace

Result<std::string> program_digest(const CampaignOptions& options) {
  Hash128Stream hash;
  if (const Status added = add_words(options.record, "--command", hash); !added) return added.error();
  if (!options.verify.empty())
    if (const Status added = add_words(options.verify, "--verify", hash); !added) return added.error();
  const std::uint8_t mode = options.restore ? 1 : 0;
  hash.add({&mode, 1});
  return hex128(hash.value());
}

Judged judge_seed(const CampaignOptions& options, std::uint64_t seed, const std::string& run_folder) {
  return SeedJudge(options, seed, run_folder).judge();
}

std::string again_command(const CampaignOptions& options, const SeedResult& result, const std::string& folder) {
  const std::string path = (fs::path(folder) / trace_name(result.seed)).string();
  const std::string trace = verifier::shell_word(path);
  if (!result.second.empty() && result.verdict == Verdict::not_reproducible)
    return "ticktrue diff " + trace + " " + verifier::shell_word((fs::path(folder) / result.second).string());
  if (options.verify.empty() || result.reason.compare(0, recording_failed.size(), recording_failed) == 0)
    return verifier::command_line_of(words_for(options, result.seed, path));
  std::vector<std::string> words = options.verify;
  const verifier::CommandMark marks[] = {{"{seed}", std::to_string(result.seed)}};
  verifier::replace_marks(words, marks);
  if (result.verdict == Verdict::state_incomplete) words.insert(words.end(), {"--mode", "restore"});
  return "ticktrue verify " + trace + " --command " + verifier::shell_word(verifier::command_line_of(words));
}

}  // namespace ticktrue::campaign
