// What a session must do to count as failing: one object for each option of `ticktrue reduce`.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/experiment/oracle/oracle.h"
#include "tool/experiment/reduce/failure.h"
#include "tool/experiment/soak_case.h"
#include "tool/expression/expression.h"

namespace ticktrue::reduce {

using verifier::soak::EngineMaker;
using verifier::soak::SoakCase;

class Predicate {
 public:
  virtual ~Predicate() = default;
  /// How the session fails; nothing where it does not. The same session gives the same answer. Errors: what keeps the
  /// session from being judged.
  virtual Result<std::optional<Failure>> examine(const SoakCase& session) = 0;
  /// The option that asks the same, as words of a command line.
  virtual std::vector<std::string> words() const = 0;
  /// Whether the answer is about the outcome of the whole run: then start, ticks and gravity of the session stay.
  virtual bool is_of_outcome() const { return false; }
  /// Lines for a shell: one that shows the failure on the trace that stands for `{}`, and one that passes on it once
  /// the failure is mended. Empty: `ticktrue reduce --once` does both.
  virtual std::string show_line() const { return {}; }
  virtual std::string test_line() const { return {}; }
};

/// A value of the state is NaN or infinite at the end of a tick.
std::unique_ptr<Predicate> not_finite(const EngineMaker& make);
/// The expression is 0 or NaN at the end of a tick, and holds before the first one.
std::unique_ptr<Predicate> broken_expectation(verifier::Expression expression, const EngineMaker& make);
/// A tick with cached structures differs from the same tick without.
std::unique_ptr<Predicate> stale_cache(const EngineMaker& make);
/// A check of the soak finds something. `word`: a name, or a variant such as "restore=57"; one seed draws the variants.
/// Errors: usage.
Result<std::unique_ptr<Predicate>> oracle_check(const std::string& word, const verifier::soak::OracleOptions& options);
/// The cross-check with Box2D has a criterion that differs. Inputs count for nothing there.
std::unique_ptr<Predicate> crosscheck_differs();

/// Asks somebody else whether a trace runs as recorded. Errors: what keeps that one from answering.
using TraceJudge = std::function<Result<std::optional<Failure>>(const std::string& trace)>;

/// Another program that verifies traces.
struct OtherProgram {
  TraceJudge judge;
  std::string folder;              // for the traces that it is asked about
  std::vector<std::string> words;  // Predicate::words
  std::string show_line;
  std::string test_line;
};
/// The session is recorded by engines of `make`, and the program finds a difference.
std::unique_ptr<Predicate> differs_elsewhere(const OtherProgram& program, const EngineMaker& make);

}  // namespace ticktrue::reduce
