// Stiff and extreme cases: a number and a verdict for each, next to known results of other engines.
// SPDX-License-Identifier: MIT
//
// Verified: the stated number of each case against its stated bound, and that every value stays finite. Not verified:
// that a case which passes looks right otherwise. Cases that have no meaning in two dimensions (spinning tops,
// gyroscopic terms) do not exist here.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "engine/scene/scene.h"
#include "tool/study/verdict.h"

namespace ticktrue::verifier {

/// The settings of the engine for a case.
struct StressMethod {
  std::string name;
  engine::SolverKind solver = engine::SolverKind::tgs_soft;
  engine::IntegratorKind integrator = engine::IntegratorKind::semi_implicit_euler;
  bool automatic = false;    // substeps
  bool is_baseline = false;  // for comparison: its failures are expected
};
/// Default, automatic substeps, pgs, impulse.
std::vector<StressMethod> contact_methods();
/// Every integrator, without constraints; those that theory lets grow or decay are baselines.
std::vector<StressMethod> integrator_methods();

/// What came of a run.
struct StressValue {
  double value = 0;
  bool is_finite = true;
  std::string why_not;          // not empty: not applicable, and why
  std::string why_undone = {};  // not empty: a tick could not be done, and why
};

struct StressCase {
  std::string name;
  std::string what;  // the case, and what its number is
  std::string unit;
  double lower = 0;  // the number must lie between these
  double upper = 0;
  std::string best_known;  // of other engines
  std::string source;      // of that
  bool is_long = false;    // minutes: only when asked for
  std::vector<StressMethod> methods;
  std::function<StressValue(const StressMethod&, engine::Precision)> run;
};

/// All cases, in the order in which they are shown.
std::vector<StressCase> stress_cases();

struct StressRow {
  std::string name;
  std::string method;
  engine::Precision precision = engine::Precision::f32;
  StudyVerdict verdict = StudyVerdict::not_applicable;
  double value = 0;
  double lower = 0;
  double upper = 0;
  std::string unit;
  std::string what;
  std::string reason;
  std::string best_known;
  std::string source;
};

/// The verdict on a number, and for baselines and for the default where automatic substeps pass, why it is expected.
StudyVerdict judge(const StressCase& stress_case, const StressValue& value);
/// Failures of baselines are not judged. Those of the default in a case that automatic substeps pass, or the other way
/// round, fall short: a case fails where neither passes. `rows` are all rows of one case
/// and precision, `methods` in the same order.
void excuse(std::vector<StressRow>& rows, const std::vector<StressMethod>& methods);

struct StressOptions {
  std::vector<std::string> names;  // of cases, or their beginnings; empty: all, unless there are own ones
  std::vector<StressCase> own;     // run besides
  std::vector<engine::Precision> precisions{engine::Precision::f32};
  bool with_long = false;
  unsigned thread_count = 1;
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;  // runs; from one thread at a time
};
/// Errors: usage (no case has that name).
Result<std::vector<StressRow>> run_stress(const StressOptions& options);

/// Largest w h at which an undamped oscillation does not grow, by bisection to 0.001.
struct StabilityRow {
  engine::IntegratorKind integrator;
  engine::Precision precision;
  double found = 0;  // 0: grows at w h = 0.05 already; infinity: does not grow at 1000
  double theory = 0;
};
/// Errors: those of Simulation::step, and of run_jobs.
Result<std::vector<StabilityRow>> stability_limits(const std::vector<engine::Precision>& precisions,
                                                   unsigned thread_count);
bool stability_holds(const StabilityRow& row);

}  // namespace ticktrue::verifier
