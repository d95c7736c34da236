// Runs of a program that verifies its own traces, for a corpus: which of its verdicts may be stored.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/corpus/program_subject.h"
#include "tool/corpus/verify_trace.h"
#include "verifier/programs/verify_program.h"
#include "verifier/runs/run_folder.h"

namespace ticktrue::tool {

class ProgramRuns {
 public:
  /// `stops`: asked around each run; may be empty. The subject outlives this. Errors: io.
  static Result<std::unique_ptr<ProgramRuns>> make(const ProgramSubject& subject, std::function<bool()> stops);
  ProgramRuns(const ProgramRuns&) = delete;
  ProgramRuns& operator=(const ProgramRuns&) = delete;
  ~ProgramRuns();  // ends what programs left running

  /// Any thread. No verdict (`is_verdict`): the program did not end by itself, or its process had a file mapped that
  /// the subject does not count. A program that changed meanwhile is an error of the report.
  PluginVerification verify(const std::string& file);

  /// Why verdicts are not stored, for people; once. Empty: nothing to say.
  std::string take_warning();

 private:
  ProgramRuns(const ProgramSubject& subject, std::function<bool()> stops, verifier::RunFolder folder);
  bool stops() const { return stops_ && stops_(); }
  /// Whether all that the process had mapped counts; else says so.
  bool is_counted(const verifier::ProgramVerdict& verdict);
  void warn(const std::string& what);

  const ProgramSubject& subject_;
  std::function<bool()> stops_;
  verifier::RunFolder folder_;
  verifier::ProgramCommand command_;
  std::atomic<std::size_t> run_count_{0};
  std::mutex lock_;
  std::vector<verifier::EscapedChild> escaped_;
  bool has_warned_ = false;
  std::string warning_;
};

}  // namespace ticktrue::tool
