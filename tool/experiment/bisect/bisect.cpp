// Bisects the history of a repository with git, commit by commit.
// SPDX-License-Identifier: MIT
#include "tool/experiment/bisect/bisect.h"

#include <filesystem>
#include <sstream>
#include <utility>

#include "base/plain_text.h"
#include "tool/output/json_output.h"

namespace ticktrue::bisect {
namespace {

using cli::Json;
using Kind = CommitVerdict::Kind;

constexpr std::size_t short_hash_size = 12;

const char* word_of(Kind kind) {
  if (kind == Kind::good) return "good";
  return kind == Kind::bad ? "bad" : "skip";
}

class Bisection {
 public:
  Bisection(const BisectOptions& options, const verifier::VerdictStore& store)
      : options_(options), judge_(options.judge, store) {}

  Result<BisectReport> run() {
    const Result<Commit> good = find_commit(options_.repository, options_.good);
    if (!good) return good.error();
    const Result<Commit> bad = find_commit(options_.repository, options_.bad);
    if (!bad) return bad.error();
    Result<WorkTree> made = WorkTree::make(options_.repository, options_.work_folder + "/tree", bad->hash);
    if (!made) return made.error();
    const WorkTree tree = *std::move(made);
    for (const auto& [commit, kind] : {std::pair(*good, Kind::good), std::pair(*bad, Kind::bad)})
      if (const Status as_said = check_end(tree, commit, kind); !as_said) return as_said.error();
    if (const auto begun = git(tree.path(), {"bisect", "start", bad->hash, good->hash}); !begun) return begun.error();
    if (const Status asked = find_suspects(tree); !asked) return asked.error();  // git knows it of neighbours
    while (suspects_.empty())
      if (const Status did = judge_next(tree); !did) return did.error();
    return BisectReport{std::move(judged_), std::move(suspects_)};
  }

 private:
  Result<CommitVerdict> judge(const WorkTree& tree, const Commit& commit) {
    Result<CommitVerdict> verdict = judge_.judge(tree.path());
    if (!verdict) return verdict;
    judged_.push_back({commit, *verdict});
    if (options_.progress && !options_.progress(judged_.back()))
      return Error{ErrorCode::unsupported, "bisect: stopped as asked", ""};
    return verdict;
  }

  /// Checks that a given end of the range is good or bad as stated.
  Status check_end(const WorkTree& tree, const Commit& commit, Kind expected) {
    if (const Status out = tree.check_out(commit.hash); !out) return out;
    const Result<CommitVerdict> verdict = judge(tree, commit);
    if (!verdict) return verdict.error();
    if (verdict->kind == expected) return {};
    const std::string why = verdict->kind == Kind::bad ? verdict->failure.what : verdict->why;
    return Error{ErrorCode::usage,
                 "bisect: " + commit.hash.substr(0, short_hash_size) + ": found " + word_of(verdict->kind) +
                     (why.empty() ? "" : " (" + why + ")") + ", expected " + word_of(expected),
                 "GOOD is a commit that runs every trace as recorded, BAD one that does not"};
  }

  Status judge_next(const WorkTree& tree) {
    const Result<Commit> commit = find_commit(tree.path(), "HEAD");
    if (!commit) return commit.error();
    const Result<CommitVerdict> verdict = judge(tree, *commit);
    if (!verdict) return verdict.error();
    // Changes that a build left in the work tree must not stop git from checking out the next commit.
    if (const auto clean = git(tree.path(), {"reset", "--quiet", "--hard"}); !clean) return clean.error();
    const auto told = git(tree.path(), {"bisect", word_of(verdict->kind)});
    if (const Status asked = find_suspects(tree); !asked) return asked;
    if (!told && suspects_.empty()) return told.error();  // git also fails if only skipped commits are left
    return {};
  }

  /// Reads the result from the log of the bisection, if git has found one.
  Status find_suspects(const WorkTree& tree) {
    const auto log = git(tree.path(), {"bisect", "log"});
    if (!log) return log.error();
    std::istringstream lines(*log);
    for (std::string line; std::getline(lines, line);) {
      const bool is_first = line.rfind("# first bad commit: ", 0) == 0;
      if (!is_first && line.rfind("# possible first bad commit: ", 0) != 0) continue;
      const std::size_t begin = line.find('['), end = line.find(']');
      if (begin == std::string::npos || end == std::string::npos) continue;
      const Result<Commit> commit = find_commit(tree.path(), line.substr(begin + 1, end - begin - 1));
      if (!commit) return commit.error();
      suspects_.push_back(*commit);
    }
    return {};
  }

  const BisectOptions& options_;
  CommitJudge judge_;
  std::vector<JudgedCommit> judged_;
  std::vector<Commit> suspects_;
};

std::string commit_text(const Commit& commit) {
  return commit.hash.substr(0, short_hash_size) + "  " + plain_text(commit.subject);
}

const JudgedCommit* find_judged(const BisectReport& report, const Commit& commit) {
  for (const JudgedCommit& judged : report.judged)
    if (judged.commit.hash == commit.hash) return &judged;
  return nullptr;
}

std::string failure_text(const CommitVerdict& verdict) {
  const std::string place = place_text(verdict.failure);
  return verdict.failure.kind + "  " + plain_text(std::filesystem::proximate(verdict.trace).string()) + "  tick " +
         std::to_string(verdict.failure.tick) + (place.empty() ? "" : "  " + place);
}

struct Counts {
  std::size_t built = 0, run = 0, stored = 0, skipped = 0;
};
Counts counts_of(const BisectReport& report) {
  Counts counts;
  for (const JudgedCommit& judged : report.judged) {
    const bool is_skipped = judged.verdict.kind == Kind::skipped;
    counts.built += judged.verdict.was_built;
    counts.run += judged.verdict.was_run;
    counts.skipped += is_skipped;
    counts.stored += !judged.verdict.was_run && !is_skipped;
  }
  return counts;
}

}  // namespace

Result<BisectReport> run_bisect(const BisectOptions& options, const verifier::VerdictStore& store) {
  return Bisection(options, store).run();
}

std::string bisect_text(const BisectReport& report) {
  std::string text;
  if (report.suspects.size() == 1) {
    text = "first bad commit  " + commit_text(report.suspects[0]) + "\n";
    if (const JudgedCommit* judged = find_judged(report, report.suspects[0])) {
      text += "  " + failure_text(judged->verdict) + "\n";
      if (!judged->verdict.failure.what.empty()) text += "  " + plain_text(judged->verdict.failure.what) + "\n";
    }
  } else {
    text = "one of these commits is the first bad one; the others cannot be judged\n";
    for (const Commit& commit : report.suspects) {
      const JudgedCommit* judged = find_judged(report, commit);
      text += "  " + commit_text(commit) + (judged ? "  (" + plain_text(judged->verdict.why) + ")" : "") + "\n";
    }
  }
  const Counts counts = counts_of(report);
  return text + "  judged  " + std::to_string(report.judged.size()) + " commits: " + std::to_string(counts.built) +
         " built, " + std::to_string(counts.run) + " run, " + std::to_string(counts.stored) + " from the store, " +
         std::to_string(counts.skipped) + " skipped\n";
}

std::string bisect_json(const BisectReport& report, const BisectOptions& options) {
  const auto commit_json = [](const Commit& commit) {
    return Json{{"commit", commit.hash}, {"subject", commit.subject}};
  };
  Json object;
  object["schema"] = "ticktrue.bisect/1";
  object["good"] = options.good;
  object["bad"] = options.bad;
  Json suspects = Json::array();
  for (const Commit& commit : report.suspects) suspects.push_back(commit_json(commit));
  object["first_bad"] = report.suspects.size() == 1 ? suspects[0] : Json(nullptr);
  object["suspects"] = std::move(suspects);
  Json judged_list = Json::array();
  for (const JudgedCommit& judged : report.judged) {
    Json one = commit_json(judged.commit);
    const CommitVerdict& verdict = judged.verdict;
    one["verdict"] = word_of(verdict.kind);
    one["built"] = verdict.was_built;
    one["run"] = verdict.was_run;
    if (verdict.kind == Kind::skipped) one["why"] = verdict.why;
    if (verdict.kind == Kind::bad) {
      one["trace"] = verdict.trace;
      one["kind"] = verdict.failure.kind;
      one["tick"] = verdict.failure.tick;
      one["stage"] = verdict.failure.stage;
      one["table"] = verdict.failure.table;
      one["column"] = verdict.failure.column;
      one["what"] = verdict.failure.what;
    }
    judged_list.push_back(std::move(one));
  }
  object["judged"] = std::move(judged_list);
  return object.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ticktrue::bisect
