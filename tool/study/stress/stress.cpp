// Runs and judges the stress cases, and finds stability limits by bisection.
// SPDX-License-Identifier: MIT
#include "tool/study/stress/stress.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "base/parallel/jobs.h"
#include "tool/study/measures.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {

using engine::IntegratorKind;
using engine::Precision;
using engine::SolverKind;

std::vector<StressMethod> contact_methods() {
  return {{"tgs_soft", SolverKind::tgs_soft, IntegratorKind::semi_implicit_euler, false, false},
          {"tgs_soft auto", SolverKind::tgs_soft, IntegratorKind::semi_implicit_euler, true, false},
          {"pgs", SolverKind::pgs, IntegratorKind::semi_implicit_euler, false, true},
          {"impulse", SolverKind::impulse, IntegratorKind::semi_implicit_euler, false, true}};
}

std::vector<StressMethod> load_methods() {
  std::vector<StressMethod> methods = contact_methods();
  methods.pop_back();
  return methods;
}

std::vector<StressMethod> joint_methods() {
  std::vector<StressMethod> methods = load_methods();
  methods.insert(methods.begin() + 2,
                 {"tgs_soft direct", SolverKind::tgs_soft, IntegratorKind::semi_implicit_euler, false, false, true});
  return methods;
}

std::vector<StressMethod> integrator_methods() {
  std::vector<StressMethod> methods;
  for (const engine::IntegratorInfo& info : engine::integrators)
    methods.push_back({std::string(info.name), SolverKind::free_flight, info.kind, false, info.stability_limit == 0});
  return methods;
}

StudyVerdict judge(const StressCase& stress_case, const StressValue& value) {
  if (!value.why_not.empty()) return StudyVerdict::not_applicable;
  const bool passes = value.why_undone.empty() && value.is_finite && value.value >= stress_case.lower &&
                      value.value <= stress_case.upper;
  return passes ? StudyVerdict::pass : StudyVerdict::fail;
}

namespace {

// The reason of a row that fails while `method` keeps the bounds.
std::string passes_with(const StressMethod& method) {
  std::string text = "passes with ";
  if (method.automatic) return text + "automatic substeps";
  if (method.joins_direct) return text + "direct joints";
  return text + "the default's substeps";
}

}  // namespace

void excuse(std::vector<StressRow>& rows, const StressCase& stress_case) {
  const std::vector<StressMethod>& methods = stress_case.methods;
  // A row is excused by a method with other substeps, other loads or direct joints, never by a method with another
  // integrator.
  const auto passing = [&](const StressMethod& missing) -> const StressMethod* {
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (rows[i].verdict == StudyVerdict::pass && !methods[i].is_baseline &&
          methods[i].integrator == missing.integrator)
        return &methods[i];
    return nullptr;
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    StressRow& row = rows[i];
    if (row.verdict != StudyVerdict::fail) continue;
    if (methods[i].is_baseline) {
      row.verdict = StudyVerdict::not_judged;
      row.reason = "a method to compare with";
      continue;
    }
    const auto cure = std::find_if(stress_case.cures.begin(), stress_case.cures.end(),
                                   [&](const StressCure& each) { return each.method == row.method; });
    if (cure != stress_case.cures.end()) {
      row.reason += (row.reason.empty() ? "" : "; ") + cure->place + " names it as the cure";
      continue;
    }
    const auto known =
        std::find_if(stress_case.shortfalls.begin(), stress_case.shortfalls.end(), [&](const StressShortfall& each) {
          return each.method == row.method && (!each.precision || each.precision == row.precision) &&
                 row.value >= each.lower && row.value <= each.upper;
        });
    if (known != stress_case.shortfalls.end()) {
      row.verdict = StudyVerdict::falls_short;
      row.reason = known->reason;
    } else if (const StressMethod* other = stress_case.is_own ? nullptr : passing(methods[i])) {
      row.verdict = StudyVerdict::falls_short;
      row.reason = passes_with(*other);
    }
  }
}

namespace {

// A case with a fixed precision runs once, whatever precisions are requested.
std::vector<Precision> precisions_of(const StressCase& stress_case, const std::vector<Precision>& wanted) {
  if (stress_case.only) return {*stress_case.only};
  return wanted.empty() ? std::vector<Precision>{stress_case.usual} : wanted;
}

}  // namespace

Result<std::vector<StressRow>> run_stress(const StressOptions& options) {
  std::vector<StressCase> cases;
  const auto is_chosen = [&](const std::string& name) {
    if (options.names.empty()) return options.own.empty();
    return std::any_of(options.names.begin(), options.names.end(),
                       [&](const std::string& n) { return name.compare(0, n.size(), n) == 0; });
  };
  for (const std::string& name : options.names) {
    bool found = false;
    for (const StressCase& each : stress_cases()) found = found || each.name.compare(0, name.size(), name) == 0;
    if (!found)
      return Error{ErrorCode::usage,
                   "stress: found case \"" + name + "\", expected one of --list, or how its name begins",
                   "see `ticktrue stress --list`"};
  }
  for (StressCase& each : stress_cases())
    if (is_chosen(each.name) && (!each.is_long || options.with_long)) cases.push_back(std::move(each));

  cases.insert(cases.end(), options.own.begin(), options.own.end());
  for (const StressCase& each : options.own)
    if (each.varies_precision && !options.precisions.empty())
      return Error{ErrorCode::usage, "stress: " + each.name + ": found --precision beside a file that varies it",
                   "leave --precision out"};

  struct Job {
    std::size_t stress_case;
    std::size_t method;
    Precision precision;
  };
  std::vector<Job> jobs;
  for (std::size_t c = 0; c < cases.size(); ++c)
    for (const Precision precision : precisions_of(cases[c], options.precisions))
      for (std::size_t m = 0; m < cases[c].methods.size(); ++m) jobs.push_back({c, m, precision});
  std::vector<StressRow> rows(jobs.size());
  std::mutex mutex;
  std::uint64_t done_count = 0;
  const Status ran = run_jobs(jobs.size(), options.thread_count, [&](std::size_t i) {
    const StressCase& each = cases[jobs[i].stress_case];
    const StressMethod& method = each.methods[jobs[i].method];
    const StressValue value = each.run(method, jobs[i].precision);
    rows[i] = {each.name,          method.name,     value.ran_in.value_or(jobs[i].precision),
               judge(each, value), value.value,     each.lower,
               each.upper,         each.unit,       each.what,
               value.why_not,      each.best_known, each.source};
    if (!value.is_finite) rows[i].reason = "a value is not finite";
    if (!value.why_undone.empty()) rows[i].reason = value.why_undone;
    const std::lock_guard<std::mutex> lock(mutex);
    ++done_count;
    if (options.progress) options.progress(done_count, jobs.size());
  });
  if (!ran) return ran.error();
  std::vector<StressRow> out;
  for (std::size_t i = 0; i < rows.size();) {
    const StressCase& each = cases[jobs[i].stress_case];
    const auto first = rows.begin() + static_cast<std::ptrdiff_t>(i);
    std::vector<StressRow> group(first, first + static_cast<std::ptrdiff_t>(each.methods.size()));
    excuse(group, each);
    out.insert(out.end(), group.begin(), group.end());
    i += each.methods.size();
  }
  return out;
}

namespace {

// Largest distance from rest of an undamped oscillator that takes `step_count` steps of `wh` = w h. The distance is 1
// at the start, and the run stops at 1e5.
Result<double> amplitude_after(IntegratorKind kind, Precision precision, double wh, int step_count) {
  engine::Scene scene = worlds::flight(precision, {1, 0}, {0, 0});
  scene.settings.integrator = kind;
  // A step is at most 1 s long, so w h is set by the stiffness and not by the step.
  scene.settings.dt = 0.5;
  engine::Force spring;
  spring.kind = engine::ForceKind::spring;
  spring.body = 0;
  spring.point = {0, 0};
  spring.rest_length = 0;
  spring.stiffness = wh * wh / (scene.settings.dt * scene.settings.dt);
  scene.forces.push_back(spring);
  Result<Run> run = Run::make(scene);
  if (!run) return run.error();
  double largest = 0;
  for (int i = 0; i < step_count && largest < 1e5; ++i) {
    if (const Status did = run->advance(1); !did) return did.error();
    const double x = std::fabs(run->bodies()[0].center.x);
    largest = std::isfinite(x) ? std::max(largest, x) : 1e5;
  }
  return largest;
}

/// The largest w h that is stable: StabilityRow::found.
Result<double> find_limit(IntegratorKind kind, Precision precision) {
  // If the oscillation grows at all, its amplitude grows by at most sqrt(1 + w^2 h^2 / 2) per step: to 12 after 4000
  // steps of 0.05.
  const Result<double> least = amplitude_after(kind, precision, 0.05, 4000);
  if (!least) return least.error();
  if (*least > 10) return 0.0;
  const Result<double> most = amplitude_after(kind, precision, 1000, 2000);
  if (!most) return most.error();
  if (*most < 2) return double{engine::always_stable};
  double stable = 0.05, unstable = 8;
  while (unstable - stable > 0.001) {
    const double middle = (stable + unstable) / 2;
    const Result<double> amplitude = amplitude_after(kind, precision, middle, 10000);
    if (!amplitude) return amplitude.error();
    (*amplitude < 1000 ? stable : unstable) = middle;
  }
  return stable;
}

}  // namespace

Result<std::vector<StabilityRow>> stability_limits(const std::vector<Precision>& precisions, unsigned thread_count) {
  std::vector<StabilityRow> rows;
  for (const Precision precision : precisions)
    for (const engine::IntegratorInfo& info : engine::integrators)
      rows.push_back({info.kind, precision, 0, info.stability_limit});
  std::vector<Status> done(rows.size());
  const Status ran = run_jobs(rows.size(), thread_count, [&](std::size_t i) {
    const Result<double> found = find_limit(rows[i].integrator, rows[i].precision);
    if (found)
      rows[i].found = *found;
    else
      done[i] = found.error();
  });
  if (!ran) return ran.error();
  for (const Status& status : done)
    if (!status) return status.error();
  return rows;
}

bool stability_holds(const StabilityRow& row) {
  if (std::isinf(row.theory) || row.theory == 0) return row.found == row.theory;
  return std::fabs(row.found - row.theory) <= 0.01 * row.theory;
}

}  // namespace ticktrue::tool
