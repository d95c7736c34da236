// Runs, and what of them is told once for all traces.
// SPDX-License-Identifier: MIT
#include "tool/corpus/run/program_runs.h"

#include <utility>

#include "base/count_text.h"
#include "verifier/runs/escaped.h"

namespace ticktrue::tool {
namespace {

constexpr std::size_t named_file_count_max = 40;

PluginVerification not_verified(const std::string& file, const Error& error) {
  return {verifier::open_error_report(file, error), false};
}

}  // namespace

Result<std::unique_ptr<ProgramRuns>> ProgramRuns::make(const ProgramSubject& subject, std::function<bool()> stops) {
  Result<verifier::RunFolder> folder = verifier::RunFolder::make("ticktrue-corpus", "");
  if (!folder) return folder.error();
  return std::unique_ptr<ProgramRuns>(new ProgramRuns(subject, std::move(stops), *std::move(folder)));
}

ProgramRuns::ProgramRuns(const ProgramSubject& subject, std::function<bool()> stops, verifier::RunFolder folder)
    : subject_(subject), stops_(std::move(stops)), folder_(std::move(folder)) {
  command_.words = subject.choice().words;
  command_.folder = folder_.path();
  command_.time_s = subject.choice().time_s;
}

ProgramRuns::~ProgramRuns() {
  end_escaped(escaped_);
}

PluginVerification ProgramRuns::verify(const std::string& file) {
  const auto stopped = [&] { return not_verified(file, {ErrorCode::io, file + ": stopped", ""}); };
  if (stops()) return stopped();
  if (const Status status = subject_.check_unchanged(); !status) return not_verified(file, status.error());
  verifier::ProgramVerdict verdict = verify_by_program(file, command_, "run-" + std::to_string(run_count_++));
  {
    const std::lock_guard<std::mutex> guard(lock_);
    escaped_.insert(escaped_.end(), verdict.escaped.begin(), verdict.escaped.end());
  }
  if (stops() && !verdict.is_whole) return stopped();
  if (const Status status = subject_.check_unchanged(); !status) return not_verified(file, status.error());
  return {std::move(verdict.report), verdict.is_whole && is_counted(verdict)};
}

bool ProgramRuns::is_counted(const verifier::ProgramVerdict& verdict) {
  if (!verdict.mapped) {
    warn(
        "verdicts are not stored: the session does not tell which libraries its process has; build the program with "
        "the "
        "libticktrue of this tool");
    return false;
  }
  const std::vector<std::string> uncounted = subject_.find_uncounted(*verdict.mapped);
  if (uncounted.empty()) return true;
  std::string options;
  for (std::size_t i = 0; i < uncounted.size() && i < named_file_count_max; ++i)
    options += " --program-file " + verifier::shell_word(uncounted[i]);
  warn("verdicts are not stored: the process of the session ran " + count_text(uncounted.size(), "file") +
       " that no verdict holds for, first " + uncounted.front() +
       "; name each, and all that a script reads as code:" + options);
  return false;
}

void ProgramRuns::warn(const std::string& what) {
  const std::lock_guard<std::mutex> guard(lock_);
  if (!std::exchange(has_warned_, true)) warning_ = what;
}

std::string ProgramRuns::take_warning() {
  const std::lock_guard<std::mutex> guard(lock_);
  return std::exchange(warning_, "");
}

}  // namespace ticktrue::tool
