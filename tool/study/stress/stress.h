// Stiff and extreme cases: a number and a verdict for each, beside known results of other engines.
// SPDX-License-Identifier: MIT
//
// Verified: the number of each case against its bounds, and that every value stays finite.
// Not verified: that a case which passes also looks right. Cases without a meaning in two dimensions (spinning tops,
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

namespace ticktrue::tool {

/// The settings of the engine for a case.
struct StressMethod {
  std::string name;
  engine::SolverKind solver = engine::SolverKind::tgs_soft;
  engine::IntegratorKind integrator = engine::IntegratorKind::semi_implicit_euler;
  bool automatic = false;     // substeps
  bool is_baseline = false;   // only for comparison: failures are expected
  bool joins_direct = false;  // joints are solved directly
};
/// The default, automatic substeps, pgs, impulse.
std::vector<StressMethod> contact_methods();
/// The default, automatic substeps, pgs.
std::vector<StressMethod> load_methods();
/// The methods of load_methods, and direct joints.
std::vector<StressMethod> joint_methods();
/// Every integrator, without constraints. An integrator that grows or decays in theory is a baseline.
std::vector<StressMethod> integrator_methods();

/// The result of a run.
struct StressValue {
  double value = 0;
  bool is_finite = true;
  std::string why_not;                           // not empty: the case is not applicable, for this reason
  std::string why_undone = {};                   // not empty: a tick failed, for this reason
  std::optional<engine::Precision> ran_in = {};  // absent: the case did not run
};

/// A document says that this method keeps the bounds of a case. A miss by this method always fails.
struct StressCure {
  std::string method;
  std::string place;  // "README.md"
};

/// A method that misses the bounds of a case, the reason (also in docs/study.md), and the range of the accepted misses.
struct StressShortfall {
  std::string method;
  std::string reason;
  double lower = 0;
  double upper = 0;
  std::optional<engine::Precision> precision = {};  // absent: both precisions
};

struct StressCase {
  std::string name;
  std::string what;  // the case, and the meaning of its number
  std::string unit;
  double lower = 0;  // lower and upper bound of the number
  double upper = 0;
  std::string best_known;  // of other engines
  std::string source;      // source of best_known
  bool is_long = false;    // takes minutes: runs only on request
  std::vector<StressMethod> methods;
  bool is_own = false;                               // of a user's file: a method that is no baseline is never excused
  std::optional<engine::Precision> only = {};        // the only precision of the case, whatever is requested
  engine::Precision usual = engine::Precision::f32;  // the precision of the case if none is requested
  bool varies_precision = false;                     // refuses a requested precision
  std::vector<StressCure> cures = {};
  std::vector<StressShortfall> shortfalls = {};
  std::function<StressValue(const StressMethod&, engine::Precision)> run;
};

/// All cases, in the printed order.
std::vector<StressCase> stress_cases();

struct StressRow {
  std::string name;
  std::string method;
  engine::Precision precision = engine::Precision::f32;  // precision of the run
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

/// Whether a value is within its bounds, before any excuse.
StudyVerdict judge(const StressCase& stress_case, const StressValue& value);
/// Excuses failed rows. A failed baseline is not judged. Any other failed method falls short if docs/study.md says so,
/// or if another method passes, unless the case is a user's. A method that a document names as the cure is never
/// excused. `rows` are all rows of the case in one precision, in the order of its methods.
void excuse(std::vector<StressRow>& rows, const StressCase& stress_case);

struct StressOptions {
  std::vector<std::string> names;  // names of cases, or their beginnings; empty: all, unless `own` is not empty
  std::vector<StressCase> own;     // the user's cases, which run as well
  std::vector<engine::Precision> precisions;  // empty: the usual precision of each case
  bool with_long = false;
  unsigned thread_count = 1;
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;  // counts runs; called by one thread at a time
};
/// Errors: usage (no case has this name).
Result<std::vector<StressRow>> run_stress(const StressOptions& options);

/// The largest w h at which an undamped oscillation does not grow, found by bisection to 0.001.
struct StabilityRow {
  engine::IntegratorKind integrator;
  engine::Precision precision;
  double found = 0;  // 0: grows at w h = 0.05 already; infinity: does not grow at w h = 1000
  double theory = 0;
};
/// Errors: those of Simulation::step and of run_jobs.
Result<std::vector<StabilityRow>> stability_limits(const std::vector<engine::Precision>& precisions,
                                                   unsigned thread_count);
bool stability_holds(const StabilityRow& row);

}  // namespace ticktrue::tool
