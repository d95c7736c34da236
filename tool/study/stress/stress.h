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
#include <optional>
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
  bool automatic = false;     // substeps
  bool is_baseline = false;   // for comparison: its failures are expected
  bool is_measured = false;   // automatic substeps follow from measured loads
  bool joins_direct = false;  // joints are solved directly
};
/// Default, automatic substeps, pgs, impulse.
std::vector<StressMethod> contact_methods();
/// Default, automatic substeps, those from measured loads, pgs.
std::vector<StressMethod> load_methods();
/// The same and direct joints.
std::vector<StressMethod> joint_methods();
/// Every integrator, without constraints; those that theory lets grow or decay are baselines.
std::vector<StressMethod> integrator_methods();

/// What came of a run.
struct StressValue {
  double value = 0;
  bool is_finite = true;
  std::string why_not;                           // not empty: not applicable, and why
  std::string why_undone = {};                   // not empty: a tick could not be done, and why
  std::optional<engine::Precision> ran_in = {};  // absent: nothing ran
};

/// A document says that this method keeps the bounds of a case. A miss of it always fails.
struct StressCure {
  std::string method;
  std::string place;  // "README.md"
};

/// A method that misses the bounds of a case, the reason (docs/study.md has it, too), and between which numbers it
/// does.
struct StressShortfall {
  std::string method;
  std::string reason;
  double lower = 0;
  double upper = 0;
  std::optional<engine::Precision> precision = {};  // absent: both
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
  std::optional<engine::Precision> only = {};  // the one that it is run in, whatever is asked for
  std::vector<StressCure> cures = {};
  std::vector<StressShortfall> shortfalls = {};
  std::function<StressValue(const StressMethod&, engine::Precision)> run;
};

/// All cases, in the order in which they are shown.
std::vector<StressCase> stress_cases();

struct StressRow {
  std::string name;
  std::string method;
  engine::Precision precision = engine::Precision::f32;  // that the engine ran with
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

/// Within the bounds or not, before anything is excused.
StudyVerdict judge(const StressCase& stress_case, const StressValue& value);
/// Failures of baselines are not judged. Others fall short where docs/study.md says so, or where another method passes.
/// What a document names as the cure is never excused. `rows` are all rows of the case in one precision, in the order
/// of its methods.
void excuse(std::vector<StressRow>& rows, const StressCase& stress_case);

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
