// The definitions of a failing session: one class for each option of `ticktrue reduce`.
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

using soak::EngineMaker;
using soak::SoakCase;

class Predicate {
 public:
  virtual ~Predicate() = default;
  /// The failure of the session; absent if the session does not fail. Equal sessions give equal answers. Errors: a
  /// reason why the session cannot be judged.
  virtual Result<std::optional<Failure>> examine(const SoakCase& session) = 0;
  /// The option for this predicate, as words of a command line.
  virtual std::vector<std::string> words() const = 0;
  /// Whether the answer depends on the outcome of the whole run. If so, start, ticks and gravity of the session are
  /// kept.
  virtual bool is_of_outcome() const { return false; }
  /// Lines for a shell, in which `{}` is replaced by the trace. show_line shows the failure; test_line passes once the
  /// failure is fixed. Empty: `ticktrue reduce --once` does both.
  virtual std::string show_line() const { return {}; }
  virtual std::string test_line() const { return {}; }
};

/// A value of the state is NaN or infinite at the end of a tick.
std::unique_ptr<Predicate> not_finite(const EngineMaker& make);
/// The expression is 0 or NaN at the end of a tick, but holds before the first tick.
std::unique_ptr<Predicate> broken_expectation(tool::Expression expression, const EngineMaker& make);
/// A tick with caches differs from the same tick without caches.
std::unique_ptr<Predicate> stale_cache(const EngineMaker& make);
/// A check of the soak has a finding. `word`: a name, or a variant such as "restore=57". A fixed seed draws the
/// variants. Errors: usage.
Result<std::unique_ptr<Predicate>> oracle_check(const std::string& word, const soak::OracleOptions& options);
/// The cross-check with Box2D has a criterion that differs. Inputs have no effect here.
std::unique_ptr<Predicate> crosscheck_differs();

/// Asks another program whether a trace runs as recorded. Errors: a reason why the program cannot answer.
using TraceJudge = std::function<Result<std::optional<Failure>>(const std::string& trace)>;

/// Another program that verifies traces.
struct OtherProgram {
  TraceJudge judge;
  std::string folder;              // folder for the traces passed to `judge`
  std::vector<std::string> words;  // Predicate::words
  std::string show_line;
  std::string test_line;
};
/// Engines of `make` record the session, and the program finds a difference.
std::unique_ptr<Predicate> differs_elsewhere(const OtherProgram& program, const EngineMaker& make);

}  // namespace ticktrue::reduce
