// Error against run time: every verification problem over a sweep of methods and steps, with slopes and floors.
// SPDX-License-Identifier: MIT
// Source: Hairer, Wanner, "Solving Ordinary Differential Equations II", 1996, IV.10 (work-precision diagrams);
// Macklin et al., "Small Steps in Physics Simulation", 2019 (substeps against iterations).
//
// Verified: the error of each point; the slope of the finest four points above ten times the rounding floor.
// The hash of the last state checks that every repeat gives the same bits.
// Not verified: run times, which depend on the machine.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "tool/study/measures.h"
#include "tool/study/problems.h"
#include "tool/study/verdict.h"

namespace ticktrue::tool {

/// One method, which gives one curve of a diagram.
struct Method {
  std::string name;
  engine::SolverKind solver = engine::SolverKind::tgs_soft;
  engine::IntegratorKind integrator = engine::IntegratorKind::semi_implicit_euler;
  bool automatic = false;                       // target_error is swept
  bool locates = true;                          // impacts are located, if the scene asks for it
  std::optional<engine::ClockKind> clock = {};  // the clock that turns frames of a host into ticks
  std::string host = {};                        // the host model of the clock
};

/// One setting of a method in a sweep. A field that the method does not vary has the value of the scene.
struct Setting {
  double dt = 1.0 / 60;  // s
  int substeps = 1;
  double target = 0;      // automatic substeps: relative target error; adaptive clock: tolerance, m
  std::string host = {};  // the host model, for a clock
  double h() const { return dt / substeps; }
};

enum class PointState : std::uint8_t { ok, not_finite, not_repeatable };

struct AccuracyPoint {
  Setting setting;
  double error = 0;          // root mean square over samples, relative to the problem's scale
  double error_max = 0;      // relative
  double floor = 0;          // rounding error: relative, root mean square
  double energy = 0;         // J, end minus start: kinetic energy plus potential energy of gravity
  double momentum = 0;       // kg m/s, end minus start of its magnitude
  double overlap_max = 0;    // m, at samples
  double joint_gap_max = 0;  // m, at samples
  std::uint64_t tick_count = 0;
  int substeps_most = 0;   // the largest count chosen by automatic substeps
  SampleSpread time_ms;    // per simulated second
  std::uint64_t hash = 0;  // of the last state
  PointState state = PointState::ok;
  /// With AccuracyOptions::keep_samples, else empty: times in s, and what Problem::observe returned then.
  std::vector<double> times;
  std::vector<std::vector<double>> samples;
};

struct Judgement {
  StudyVerdict verdict = StudyVerdict::not_judged;
  std::optional<double> slope;     // observed
  std::optional<double> expected;  // by theory
  std::string reason;              // empty: the verdict is pass
};

struct AccuracyCurve {
  std::string problem;
  ProblemClass kind = ProblemClass::smooth;
  int corner_count = -1;
  engine::Precision precision = engine::Precision::f64;
  Method method;
  std::vector<AccuracyPoint> points;  // from coarse to fine
  Judgement judgement;
};

inline constexpr double slope_tolerance = 0.15;
inline constexpr double error_coarse = 0.1;  // relative: a larger error shows no order

/// Least-squares slope of log error over log h. Uses the finest `count` points with an error above ten times their
/// floor and below error_coarse. Absent if fewer than three points are left.
std::optional<double> fitted_slope(const std::vector<double>& steps, const std::vector<double>& errors,
                                   const std::vector<double>& floors, std::size_t count = 4);

/// The theoretical result of a method on a problem: a slope, an exact result, or the reason why no slope is expected.
struct Expectation {
  std::optional<double> slope;
  bool is_exact = false;
  std::string reason;
};
Expectation expectation_of(const Problem& problem, const Method& method);

/// Whether a point can show an order: its error is above ten floors and below error_coarse.
bool shows_order(double error, double floor);

/// Whether the user's file claims anything: a slope or a bar. False for built-in problems.
bool claims_of_own(const Problem& problem);

/// The verdict on one curve. `steps` descend; errors and floors belong to the steps.
Judgement judge(const Expectation& expectation, const std::vector<double>& steps, const std::vector<double>& errors,
                const std::vector<double>& floors);

/// Judges the points of a curve by the bars of the problem. A curve that misses a bar fails, or falls short if the miss
/// is documented. A curve without an expected order passes if the problem has bars and the curve keeps them.
void judge_bars(const Problem& problem, AccuracyCurve& curve);

/// Error of observed values against the problem's exact ones.
struct SampleError {
  double rms = 0;
  double max = 0;
};
/// The error of `samples[i]`, observed at `times[i]`, relative to the scale of the problem.
SampleError sample_error(const Problem& problem, const std::vector<double>& times,
                         const std::vector<std::vector<double>>& samples);

/// The methods to run a problem with.
std::vector<Method> methods_of(const Problem& problem);
/// The sweep of a method, from coarse to fine.
std::vector<Setting> settings_of(const Problem& problem, const Method& method);

struct AccuracyOptions {
  std::vector<engine::Precision> precisions{engine::Precision::f64, engine::Precision::f32};
  int repeat_max = 7;      // timed runs of a point, after one untimed run
  double repeat_s = 0.02;  // no further run once the timed runs have taken this long in total
  unsigned thread_count = 1;
  bool keep_samples = false;
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;  // curves; called by one thread at a time
};

/// All curves of the problems, in the order of the problems and then of the precisions. A method that a scene refuses
/// is not_applicable, with the reason. Errors: check_float_behaviour.
Result<std::vector<AccuracyCurve>> run_accuracy(const std::vector<Problem>& problems, const AccuracyOptions& options);

/// The fastest point of a curve with at most this error; null if there is none.
const AccuracyPoint* cheapest(const AccuracyCurve& curve, double error);
/// The coarsest point with at most this error.
const AccuracyPoint* coarsest(const AccuracyCurve& curve, double error);

/// The text of a setting: "1/240" (s), "8 sub", "tol 1e-3".
std::string setting_text(const Method& method, const Setting& setting);

}  // namespace ticktrue::tool
