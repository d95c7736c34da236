// Builds commits, runs their programs on traces, and stores their verdicts.
// SPDX-License-Identifier: MIT
#include "tool/experiment/bisect/commit_judge.h"

#include <filesystem>
#include <system_error>

#include "base/hash128.h"
#include "replay/trace_reader.h"
#include "tool/experiment/bisect/repository.h"
#include "tool/experiment/reduce/program_judge.h"
#include "tool/output/cli.h"
#include "verifier/runs/child.h"

namespace ticktrue::bisect {
namespace {

using reduce::Failure;

constexpr std::size_t trace_size_max = std::size_t{1} << 32;

Hash128 hash_of(const std::string& text) {
  return hash128(ByteView(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

verifier::ChildResult run_in(const std::string& folder, const std::string& command, double time_s) {
  verifier::ChildCommand child;
  child.argv = {"sh", "-c", command};
  child.cwd = folder;
  child.limits.time_s = time_s;
  return verifier::run_child(child);
}

/// Converts a failure to a report that the store can hold.
verifier::Report report_of(const std::string& trace, const std::optional<Failure>& found) {
  verifier::Report report;
  report.file = trace;
  report.mode = "program";
  report.verdict = verifier::Verdict::match;
  if (!found) return report;
  report.verdict = verifier::Verdict::diverged;
  report.reason = found->kind;
  report.hint = found->what;
  verifier::Divergence& divergence = report.divergence.emplace();
  divergence.tick = found->tick;
  if (!found->stage.empty()) divergence.stage = found->stage;
  if (!found->table.empty()) divergence.tables.push_back({found->table, {found->column}});
  return report;
}

Failure failure_of(const verifier::Report& report) {
  Failure failure;
  failure.kind = report.reason;
  failure.what = report.hint;
  if (!report.divergence) return failure;
  failure.tick = report.divergence->tick;
  failure.stage = report.divergence->stage.value_or("");
  if (report.divergence->tables.empty()) return failure;
  failure.table = report.divergence->tables.front().table;
  failure.column = report.divergence->tables.front().columns.front();
  return failure;
}

}  // namespace

Result<CommitVerdict> CommitJudge::judge(const std::string& work_tree) {
  const Result<std::string> identity = identity_of_tree(work_tree);
  if (!identity) return identity.error();
  const auto stored = from_store(*identity);
  if (!stored) return stored.error();
  if (*stored) return **stored;
  return build_and_run(work_tree, *identity);
}

/// The git hashes of the files that the verdict depends on.
Result<std::string> CommitJudge::identity_of_tree(const std::string& work_tree) const {
  if (options_.paths.empty()) return git(work_tree, {"rev-parse", "HEAD^{tree}"});
  std::vector<std::string> words{"ls-tree", "HEAD", "--"};
  words.insert(words.end(), options_.paths.begin(), options_.paths.end());
  return git(work_tree, words);
}

Result<std::string> CommitJudge::key_of(const std::string& identity, const std::string& trace) const {
  const Result<std::string> bytes = cli::read_text_file(trace, trace_size_max);
  if (!bytes) return bytes.error();
  verifier::VerdictSubject subject;
  subject.trace = hash_of(*bytes);
  subject.size = bytes->size();
  subject.engine = hash_of(identity);
  subject.options = "bisect " + options_.build + "\n" + options_.program;
  return verifier::verdict_key(subject);
}

/// The stored verdict, if the store has a failing verdict for one trace or a verdict for every trace.
Result<std::optional<CommitVerdict>> CommitJudge::from_store(const std::string& identity) const {
  bool knows_all = true;
  for (const std::string& trace : options_.traces) {
    const Result<std::string> key = key_of(identity, trace);
    if (!key) return key.error();
    const auto found = store_.find(*key);
    if (!found) return found.error();
    if (!found->report) {
      knows_all = false;
      continue;
    }
    if (found->report->verdict == verifier::Verdict::match) continue;
    CommitVerdict verdict;
    verdict.kind = CommitVerdict::Kind::bad;
    verdict.failure = failure_of(*found->report);
    verdict.trace = trace;
    return std::optional(verdict);
  }
  if (!knows_all) return std::optional<CommitVerdict>();
  return std::optional(CommitVerdict());
}

Status CommitJudge::add_to_store(const std::string& identity, const std::string& trace,
                                 const std::optional<Failure>& found) {
  const Result<std::string> key = key_of(identity, trace);
  if (!key) return key.error();
  const auto added = store_.add(*key, report_of(trace, found));
  if (!added) return added.error();
  return {};
}

Result<CommitVerdict> CommitJudge::build_and_run(const std::string& work_tree, const std::string& tree_identity) {
  CommitVerdict verdict;
  if (!options_.build.empty()) {
    verdict.was_built = true;
    const verifier::ChildResult built = run_in(work_tree, options_.build, options_.build_time_s);
    if (built.end.how != verifier::ChildEnd::How::exited || built.end.exit_status != 0) {
      verdict.kind = CommitVerdict::Kind::skipped;
      verdict.why = "it does not build";
      return verdict;
    }
  }
  std::vector<std::string> identities{tree_identity};
  if (options_.identity) {
    const verifier::ChildResult named = run_in(work_tree, *options_.identity, options_.verify_time_s);
    if (named.end.how == verifier::ChildEnd::How::exited && named.end.exit_status == 0 && !named.output.empty()) {
      identities.push_back("program " + named.output);
      const auto stored = from_store(identities.back());
      if (!stored) return stored.error();
      if (*stored) {
        CommitVerdict known = **stored;
        known.was_built = verdict.was_built;
        return known;
      }
    }
  }
  return run_traces(work_tree, identities, verdict);
}

Result<CommitVerdict> CommitJudge::run_traces(const std::string& work_tree, const std::vector<std::string>& identities,
                                              CommitVerdict verdict) {
  const reduce::TraceJudge ask =
      reduce::program_judge({"sh", "-c", "cd " + verifier::shell_word(work_tree) + " && " + options_.program},
                            options_.folder, options_.verify_time_s);
  verdict.was_run = true;
  for (const std::string& trace : options_.traces) {
    const auto found = ask(trace);
    if (!found) {
      verdict.kind = CommitVerdict::Kind::skipped;
      verdict.why = found.error().message;
      return verdict;
    }
    for (const std::string& identity : identities)
      if (const Status added = add_to_store(identity, trace, *found); !added) return added.error();
    if (!*found) continue;
    verdict.kind = CommitVerdict::Kind::bad;
    verdict.failure = **found;
    verdict.trace = trace;
    return verdict;
  }
  return verdict;
}

}  // namespace ticktrue::bisect
