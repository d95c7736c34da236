// Error against run time: runs every verification problem over a sweep of methods and steps.
// SPDX-License-Identifier: MIT
#include "tool/study/accuracy.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>

#include "base/hash.h"
#include "base/parallel/jobs.h"
#include "engine/math/trig.h"
#include "replay/recorder.h"
#include "tool/session/clocked_inputs.h"
#include "tool/study/table.h"

namespace ticktrue::tool {

using engine::ClockKind;
using engine::IntegratorKind;
using engine::Precision;
using engine::SolverKind;

namespace {

// The observations of one run with one setting.
struct Observed {
  std::vector<double> times;
  std::vector<std::vector<double>> samples;
  AccuracyPoint point;
  double step_time_s = 0;
};

engine::Scene scene_of(const Problem& problem, const Method& method, const Setting& setting, Precision precision) {
  engine::Scene scene = problem.scene(precision);
  engine::Settings& settings = scene.settings;
  settings.solver = method.solver;
  settings.integrator = method.integrator;
  settings.dt = setting.dt;
  engine::use_fixed_substeps(settings, setting.substeps);
  if (method.automatic) {
    engine::choose_substeps(settings);
    settings.auto_substeps->target_error = setting.target;
  }
  if (!method.locates) settings.locate_impacts = false;
  if (method.clock) {
    settings.clock.kind = *method.clock;
    if (*method.clock == ClockKind::adaptive) settings.clock.tolerance = setting.target;
  }
  return scene;
}

void add_sample(const Problem& problem, const engine::Engine& engine, Observed& observed) {
  observed.times.push_back(engine.time_s());
  observed.samples.push_back(problem.observe(engine));
  if (problem.kind == ProblemClass::smooth) return;
  const Bodies bodies = engine.bodies();
  observed.point.overlap_max = std::max(observed.point.overlap_max, deepest_overlap(engine.contacts()));
  observed.point.joint_gap_max = std::max(observed.point.joint_gap_max, largest(joint_gaps(engine.scene(), bodies)));
}

Status run_on_ticks(const Problem& problem, Run& run, Observed& observed) {
  const double ticks = problem.duration / run.engine().scene().settings.dt / problem.sample_count;
  for (int sample = 0; sample < problem.sample_count; ++sample) {
    if (Status did = run.advance(static_cast<std::uint64_t>(std::lround(ticks))); !did) return did;
    add_sample(problem, run.engine(), observed);
    // time_s() is not used here: as a sum of tick lengths, time_s() has a rounding error of its own.
    observed.times.back() = problem.duration * (sample + 1) / problem.sample_count;
  }
  observed.step_time_s = run.step_time_s();
  return {};
}

// The ticks of a clock do not end at the common times. Every tick is therefore a sample.
Status run_on_frames(const Problem& problem, const Method& method, const Setting& setting, Run& run,
                     Observed& observed) {
  auto frames = open_host(setting.host.empty() ? method.host : setting.host, 1);
  if (!frames) return frames.error();
  ClockedInputs inputs(run.engine(), std::make_unique<replay::NoInputs>(setting.dt), std::move(*frames));
  for (std::uint64_t tick = 0; run.engine().time_s() < problem.duration; ++tick) {
    const double start = computed_s();
    const auto input = inputs.next(tick);
    if (!input) return input.error();
    if (!*input) break;
    if (Status did = run.engine().step(**input, nullptr); !did) return did;
    observed.step_time_s += computed_s() - start;
    add_sample(problem, run.engine(), observed);
  }
  return {};
}

Result<Observed> observe(const Problem& problem, const Method& method, const Setting& setting, Precision precision) {
  Result<Run> made = Run::make(scene_of(problem, method, setting, precision));
  if (!made) return made.error();
  Run& run = *made;
  Observed observed;
  const Bodies before = run.bodies();
  const Status ran =
      method.clock ? run_on_frames(problem, method, setting, run, observed) : run_on_ticks(problem, run, observed);
  if (!ran) return ran.error();
  const engine::Engine& engine = run.engine();
  const Bodies after = run.bodies();
  AccuracyPoint& point = observed.point;
  point.setting = setting;
  const engine::Point p = momentum_of(before), q = momentum_of(after);
  point.energy = energy_of(engine.scene(), after) - energy_of(engine.scene(), before);
  point.momentum = std::hypot(q.x, q.y) - std::hypot(p.x, p.y);
  point.tick_count = engine.tick();
  point.substeps_most = substeps_most(engine);
  point.hash = root_hash(engine.state());
  if (!all_finite(after)) point.state = PointState::not_finite;
  return observed;
}

double apart(const Problem& problem, double a, double b) {
  const double d = problem.is_angle ? std::remainder(a - b, 2 * engine::pi) : a - b;
  return std::isfinite(d) ? d : HUGE_VAL;
}

// Estimates the rounding error of a run. In f32 the estimate is the distance between the run and the same run in f64.
// In f64 it is 2^-29 of that distance, but at least a random walk with one rounding per tick.
double rounding_floor(const Problem& problem, const Method& method, const Observed& f64, const Observed& f32,
                      Precision precision) {
  if (f64.samples.size() != f32.samples.size() || f64.samples.empty()) return 0;
  double sum = 0;
  for (std::size_t i = 0; i < f64.samples.size(); ++i)
    for (std::size_t k = 0; k < f64.samples[i].size(); ++k) {
      const double d = apart(problem, f64.samples[i][k], f32.samples[i][k]);
      sum += d * d;
    }
  const double floor = std::sqrt(sum / static_cast<double>(f64.samples.size())) / problem.scale;
  if (precision == Precision::f32) return floor;
  const auto tick_count = static_cast<double>(f64.point.tick_count);
  // Sample times of a clock are sums of equal tick lengths. The rounding errors of these sums all have the same sign.
  return std::max(floor * 0x1p-29, 0x1p-53 * (method.clock ? tick_count : std::sqrt(tick_count)));
}

Result<AccuracyPoint> timed_point(const Problem& problem, const Method& method, const Setting& setting,
                                  Precision precision, const AccuracyOptions& options, Observed& kept) {
  Result<Observed> first = observe(problem, method, setting, precision);
  if (!first) return first.error();
  kept = std::move(*first);
  AccuracyPoint point = kept.point;
  const SampleError error = sample_error(problem, kept.times, kept.samples);
  point.error = error.rms;
  point.error_max = error.max;
  std::vector<double> times;
  const double simulated_s = kept.times.empty() ? problem.duration : kept.times.back();
  double sum_s = 0;
  while (static_cast<int>(times.size()) < options.repeat_max && (times.size() < 3 || sum_s < options.repeat_s)) {
    if (!times.empty() && kept.step_time_s > 0.1) break;  // a long run is timed once
    const Result<Observed> again = observe(problem, method, setting, precision);
    if (!again) return again.error();
    if (again->point.hash != point.hash) point.state = PointState::not_repeatable;
    times.push_back(again->step_time_s * 1e3 / simulated_s);
    sum_s += again->step_time_s;
  }
  point.time_ms = spread_of(std::move(times));
  if (options.keep_samples) {
    point.times = kept.times;
    point.samples = kept.samples;
  }
  return point;
}

AccuracyCurve empty_curve(const Problem& problem, const Method& method, Precision precision) {
  AccuracyCurve curve;
  curve.problem = problem.name;
  curve.kind = problem.kind;
  curve.corner_count = problem.corner_count;
  curve.precision = precision;
  curve.method = method;
  return curve;
}

/// A curve of a user's problem whose values are not finite, or that cannot show the slope that the file claims, fails.
void judge_own(const Problem& problem, AccuracyCurve& curve) {
  if (!problem.is_own || curve.points.empty()) return;
  for (const AccuracyPoint& point : curve.points)
    if (point.state == PointState::not_finite || !std::isfinite(point.error)) {
      curve.judgement.verdict = StudyVerdict::fail;
      curve.judgement.reason = "a value is not finite at " + setting_text(curve.method, point.setting);
      return;
    }
  const AccuracyPoint& finest = curve.points.back();
  if (curve.judgement.verdict != StudyVerdict::not_judged || !curve.judgement.expected || finest.error < error_coarse)
    return;
  curve.judgement.verdict = StudyVerdict::fail;
  curve.judgement.reason = "the error is " + short_number(finest.error) + " at the finest setting, " +
                           setting_text(curve.method, finest.setting) + ": a slope shows below 0.1";
}

/// Both with as few digits, but at least four, as tell them apart.
std::pair<std::string, std::string> distinct_numbers(double a, double b) {
  const auto text = [](double value, int digits) {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
    return std::string(buffer);
  };
  int digits = 4;
  while (digits < 17 && text(a, digits) == text(b, digits)) ++digits;
  return {text(a, digits), text(b, digits)};
}

/// The value farthest from its exact one, as text: "bodies.1.x at 0.5 s: found 3.1, exact 3".
std::string farthest_text(const Problem& problem, const Observed& observed) {
  double most = 0;
  std::string text;
  for (std::size_t i = 0; i < observed.samples.size(); ++i) {
    const std::vector<double> exact = problem.exact(observed.times[i]);
    for (std::size_t k = 0; k < exact.size(); ++k) {
      const double distance = std::fabs(apart(problem, observed.samples[i][k], exact[k]));
      if (!(distance > most)) continue;
      most = distance;
      const double scale = k < problem.value_scales.size() ? problem.value_scales[k] : 1;
      const auto [found, wanted] = distinct_numbers(observed.samples[i][k] * scale, exact[k] * scale);
      text = problem.value_names[k] + " at " + short_number(observed.times[i]) + " s: found " + found + ", exact " +
             wanted;
    }
  }
  return text;
}

/// Adds to the reason of a failure of a user's problem where the finest run is farthest off, and whether finer settings
/// help at all. `finest`: the samples of the finest setting.
void explain_own(const Problem& problem, const Observed& finest, AccuracyCurve& curve) {
  if (!problem.is_own || curve.judgement.verdict != StudyVerdict::fail || curve.points.size() < 3) return;
  if (curve.judgement.reason.rfind("energy changes", 0) == 0) return;
  const std::string farthest = farthest_text(problem, finest);
  if (farthest.empty()) return;
  curve.judgement.reason += "; farthest at the finest setting: " + farthest;
  constexpr double hardly = 2;  // the error of the coarsest setting over that of the finest
  const bool steps_differ = curve.points.front().substeps_most != curve.points.back().substeps_most;
  if ((!curve.method.automatic || steps_differ) && curve.points.front().error < hardly * curve.points.back().error)
    curve.judgement.reason += "; finer settings hardly help, so what it is compared with may be off";
}

void judge_curve(const Problem& problem, AccuracyCurve& curve) {
  std::vector<double> steps, errors, floors;
  for (const AccuracyPoint& point : curve.points) {
    steps.push_back(point.setting.h());
    errors.push_back(point.error);
    floors.push_back(point.floor);
  }
  for (const AccuracyPoint& point : curve.points)
    if (point.state == PointState::not_repeatable) {
      curve.judgement = {StudyVerdict::fail, {}, {}, "two runs gave different bits"};
      return;
    }
  if (curve.method.automatic && problem.size > 0) {
    const auto broken = std::find_if(curve.points.begin(), curve.points.end(), [&](const AccuracyPoint& point) {
      return point.error * problem.scale > point.setting.target * problem.size;
    });
    curve.judgement = {};
    if (broken == curve.points.end())
      curve.judgement.verdict = StudyVerdict::pass;
    else
      curve.judgement.reason = "target_error bounds how far contacts and joints give way, not the order of time steps";
    const bool promises_target = problem.is_own || (problem.slope && *problem.slope == 2);
    if (broken != curve.points.end() && promises_target)
      curve.judgement = {StudyVerdict::fail,
                         {},
                         {},
                         problem.is_own ? "target_error is not kept; leave size out where bodies move freely, since it "
                                          "bounds no errors of time"
                                        : "target_error is not kept"};
    return;
  }
  curve.judgement = judge(expectation_of(problem, curve.method), steps, errors, floors);
}

// The rounding floor of f32 may leave only coarse steps, where no curve shows its order yet. A curve is excused if f64
// has the same slope over the same steps, and the theoretical slope over finer steps.
void explain_by_f64(const Problem& problem, const std::vector<double>& f64_errors,
                    const std::vector<double>& f64_floors, AccuracyCurve& curve) {
  Judgement& judgement = curve.judgement;
  if (curve.precision != Precision::f32 || judgement.verdict != StudyVerdict::fail || !judgement.slope) return;
  std::vector<double> steps, left_out;
  for (const AccuracyPoint& point : curve.points) {
    steps.push_back(point.setting.h());
    left_out.push_back(shows_order(point.error, point.floor) ? 0 : HUGE_VAL);
  }
  const std::optional<double> same_steps = fitted_slope(steps, f64_errors, left_out);
  const Judgement f64 = judge(expectation_of(problem, curve.method), steps, f64_errors, f64_floors);
  if (f64.verdict != StudyVerdict::pass || !same_steps) return;
  if (std::fabs(*same_steps - *judgement.slope) > slope_tolerance) return;
  judgement.verdict = StudyVerdict::not_judged;
  judgement.reason = "rounding leaves coarse steps alone: f64 has this slope over them, and theory's over finer ones";
}

// A tick that fails is a failure of the method. A scene that is refused makes the method not applicable.
StudyVerdict verdict_of(const Error& error) {
  const bool is_undone = error.code == ErrorCode::limit || error.code == ErrorCode::inconsistent;
  return is_undone ? StudyVerdict::fail : StudyVerdict::not_applicable;
}

// Runs one method in the requested precisions. Both precisions always run, because their difference is the rounding
// floor.
std::vector<AccuracyCurve> run_method(const Problem& problem, const Method& method, const AccuracyOptions& options) {
  std::vector<AccuracyCurve> curves;
  for (const Precision precision : options.precisions) curves.push_back(empty_curve(problem, method, precision));
  std::vector<double> f64_errors, f64_floors;
  Observed finest[2];
  for (const Setting& setting : settings_of(problem, method)) {
    Observed kept[2];
    AccuracyPoint points[2];
    bool wanted[2]{};
    for (const Precision precision : {Precision::f32, Precision::f64}) {
      const std::size_t at = static_cast<std::size_t>(precision);
      wanted[at] =
          std::find(options.precisions.begin(), options.precisions.end(), precision) != options.precisions.end();
      Status ran;
      if (wanted[at]) {
        const Result<AccuracyPoint> point = timed_point(problem, method, setting, precision, options, kept[at]);
        if (point)
          points[at] = *point;
        else
          ran = point.error();
      } else {
        Result<Observed> other = observe(problem, method, setting, precision);
        if (other)
          kept[at] = *std::move(other);
        else
          ran = other.error();
      }
      if (ran) continue;
      for (AccuracyCurve& curve : curves) curve.judgement = {verdict_of(ran.error()), {}, {}, ran.error().message};
      return curves;
    }
    f64_errors.push_back(sample_error(problem, kept[1].times, kept[1].samples).rms);
    f64_floors.push_back(rounding_floor(problem, method, kept[1], kept[0], Precision::f64));
    for (AccuracyCurve& curve : curves) {
      AccuracyPoint point = points[static_cast<std::size_t>(curve.precision)];
      point.floor = rounding_floor(problem, method, kept[1], kept[0], curve.precision);
      curve.points.push_back(point);
    }
    finest[0] = std::move(kept[0]);
    finest[1] = std::move(kept[1]);
  }
  for (AccuracyCurve& curve : curves) {
    judge_curve(problem, curve);
    explain_by_f64(problem, f64_errors, f64_floors, curve);
    judge_own(problem, curve);
    judge_bars(problem, curve);
    explain_own(problem, finest[static_cast<std::size_t>(curve.precision)], curve);
  }
  return curves;
}

}  // namespace

SampleError sample_error(const Problem& problem, const std::vector<double>& times,
                         const std::vector<std::vector<double>>& samples) {
  SampleError error;
  double sum = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::vector<double> exact = problem.exact(times[i]);
    double squares = 0;
    for (std::size_t k = 0; k < samples[i].size(); ++k) {
      const double d = apart(problem, samples[i][k], exact[k]);
      squares += d * d;
    }
    sum += squares;
    error.max = std::max(error.max, std::sqrt(squares) / problem.scale);
  }
  error.rms = samples.empty() ? HUGE_VAL : std::sqrt(sum / static_cast<double>(samples.size())) / problem.scale;
  return error;
}

void judge_bars(const Problem& problem, AccuracyCurve& curve) {
  Judgement& judgement = curve.judgement;
  if (judgement.verdict == StudyVerdict::fail || judgement.verdict == StudyVerdict::not_applicable) return;
  const auto known = std::find_if(problem.shortfalls.begin(), problem.shortfalls.end(),
                                  [&](const Shortfall& each) { return each.method == curve.method.name; });
  bool is_known = known != problem.shortfalls.end();
  bool has_bars = false;
  std::string missed;
  for (const Bar& bar : problem.bars) {
    if (bar.method != curve.method.name) continue;
    for (const AccuracyPoint& point : curve.points) {
      const std::string setting = setting_text(curve.method, point.setting);
      if (!bar.setting.empty() && bar.setting != setting) continue;
      has_bars = true;
      std::string miss;
      if (bar.error > 0 && !(point.error <= bar.error)) {
        miss = "error " + short_number(point.error) + " at " + setting + ", bar " + short_number(bar.error);
        is_known = is_known && point.error <= known->error;
      }
      if (bar.energy > 0 && !(std::fabs(point.energy) <= bar.energy)) {
        if (miss.empty())
          miss = "energy changes by " + short_number(point.energy) + " J at " + setting + ", bar " +
                 short_number(bar.energy) + " J";
        is_known = is_known && std::fabs(point.energy) <= known->energy;
      }
      if (missed.empty()) missed = miss;
    }
  }
  if (!has_bars) return;
  if (missed.empty()) {
    if (judgement.verdict != StudyVerdict::not_judged) return;
    judgement.verdict = StudyVerdict::pass;
    if (problem.is_own && judgement.expected)
      judgement.reason = "by its bars alone: " + judgement.reason;
    else
      judgement = {StudyVerdict::pass, judgement.slope, {}, ""};
    return;
  }
  judgement.verdict = is_known ? StudyVerdict::falls_short : StudyVerdict::fail;
  judgement.reason = is_known ? missed + ": " + known->reason : missed;
}

bool shows_order(double error, double floor) {
  return error > 10 * floor && error > 0 && error < error_coarse;
}

std::optional<double> fitted_slope(const std::vector<double>& steps, const std::vector<double>& errors,
                                   const std::vector<double>& floors, std::size_t count) {
  std::vector<double> x, y;
  for (std::size_t i = steps.size(); i-- > 0 && x.size() < count;) {
    if (!shows_order(errors[i], floors[i])) continue;
    x.push_back(std::log2(steps[i]));
    y.push_back(std::log2(errors[i]));
  }
  if (x.size() < 3) return {};
  double mx = 0, my = 0, xx = 0, xy = 0;
  const auto n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    mx += x[i] / n;
    my += y[i] / n;
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mx) * (x[i] - mx);
    xy += (x[i] - mx) * (y[i] - my);
  }
  if (xx == 0) return {};
  return xy / xx;
}

bool claims_of_own(const Problem& problem) {
  return problem.is_own && (problem.slope || !problem.slopes.empty() || !problem.bars.empty());
}

Expectation expectation_of(const Problem& problem, const Method& method) {
  Expectation out;
  if (!problem.slopes.empty()) {
    for (const auto& [name, slope] : problem.slopes)
      if (name == method.name) out.slope = slope;
    if (!out.slope) out.reason = "the file states no slope for this method";
    return out;
  }
  if (problem.is_exact) {
    // If impacts are not located, all impacts of a tick happen together at the end of the tick.
    out.is_exact = problem.kind != ProblemClass::impact || method.locates || problem.is_pair;
    if (!out.is_exact) out.reason = "impacts are not located: those of one tick happen at once";
    return out;
  }
  const auto& integrator = engine::info_of(engine::integrators, method.integrator);
  if (problem.kind == ProblemClass::smooth) {
    if (method.clock && *method.clock == ClockKind::adaptive) {
      out.reason = "the step follows the tolerance";
      return out;
    }
    out.is_exact = problem.is_exact_from_order_2 && integrator.order >= 2;
    if (out.is_exact) return out;
    out.slope = problem.slope ? *problem.slope : integrator.order;
    if (integrator.order >= 2 && problem.slope_of_higher) out.slope = problem.slope_of_higher;
    return out;
  }
  if (method.solver != SolverKind::tgs_soft) {
    out.reason = "a baseline: no order is claimed";
    return out;
  }
  if (method.automatic) {
    out.reason = "the substeps follow the target";
    return out;
  }
  // The solver meets constraints at the ends of steps. A higher-order integrator therefore raises the order only where
  // constraint forces are constant.
  const bool bounces = problem.kind == ProblemClass::impact || problem.kind == ProblemClass::bounce;
  if (method.locates || !bounces) {
    out.slope = integrator.order >= 2 && problem.slope_of_higher ? problem.slope_of_higher : problem.slope;
    out.reason = problem.why_no_slope;
    return out;
  }
  out.reason = "the impact is met at the end of its tick: each shifts all that follows";
  return out;
}

Judgement judge(const Expectation& expectation, const std::vector<double>& steps, const std::vector<double>& errors,
                const std::vector<double>& floors) {
  Judgement out;
  out.slope = fitted_slope(steps, errors, floors);
  out.expected = expectation.slope;
  out.reason = expectation.reason;
  if (expectation.is_exact) {
    // Rounding alone explains an error of at most ten floors, or of a thousand times the rounding error of 1.
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (!(errors[i] <= std::max(10 * floors[i], 1000 * 0x1p-53))) {
        out.verdict = StudyVerdict::fail;
        out.reason = "an exact scheme has an error beyond rounding";
        return out;
      }
    out.verdict = StudyVerdict::pass;
    return out;
  }
  if (!expectation.slope) return out;
  if (!out.slope) {
    int coarse_count = 0, rounded_count = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      coarse_count += !(errors[i] < error_coarse) ? 1 : 0;
      rounded_count += errors[i] < error_coarse && !shows_order(errors[i], floors[i]) ? 1 : 0;
    }
    out.reason = coarse_count > rounded_count
                     ? "too coarse for an order: fewer than three points have an error below 10 %"
                     : "rounding hides the order: fewer than three points are above ten times its floor";
    return out;
  }
  out.verdict = std::fabs(*out.slope - *expectation.slope) <= slope_tolerance ? StudyVerdict::pass : StudyVerdict::fail;
  out.reason = out.verdict == StudyVerdict::pass ? "" : "the slope is not the theory's";
  return out;
}

namespace {

std::vector<Method> all_methods_of(const Problem& problem) {
  std::vector<Method> methods;
  if (problem.kind == ProblemClass::smooth) {
    for (const engine::IntegratorInfo& info : engine::integrators)
      methods.push_back({std::string(info.name), SolverKind::free_flight, info.kind});
    if (!problem.has_clocks) return methods;
    for (const IntegratorKind kind :
         {IntegratorKind::semi_implicit_euler, IntegratorKind::velocity_verlet, IntegratorKind::rk4}) {
      const std::string name(engine::info_of(engine::integrators, kind).name);
      const std::string brief = kind == IntegratorKind::semi_implicit_euler ? "semi_implicit" : name;
      methods.push_back({brief + " fixed", SolverKind::free_flight, kind, false, true, ClockKind::fixed, "jitter_60"});
      methods.push_back({brief + " variable", SolverKind::free_flight, kind, false, true, ClockKind::variable, ""});
      methods.push_back(
          {brief + " adaptive", SolverKind::free_flight, kind, false, true, ClockKind::adaptive, "jitter_60"});
    }
    methods.push_back({"semi_implicit semi_fixed", SolverKind::free_flight, IntegratorKind::semi_implicit_euler, false,
                       true, ClockKind::semi_fixed, "stutter"});
    return methods;
  }
  const bool locates = problem.scene(Precision::f64).settings.locate_impacts;
  methods.push_back({"tgs_soft", SolverKind::tgs_soft, IntegratorKind::semi_implicit_euler});
  if (locates) {
    methods.push_back({"tgs_soft unlocated", SolverKind::tgs_soft, IntegratorKind::semi_implicit_euler, false, false});
  }
  if (problem.corner_count < 0) {
    methods.push_back({"tgs_soft verlet", SolverKind::tgs_soft, IntegratorKind::velocity_verlet, false, !locates});
    methods.push_back({"tgs_soft rk4", SolverKind::tgs_soft, IntegratorKind::rk4, false, !locates});
  }
  methods.push_back({"tgs_soft auto", SolverKind::tgs_soft, IntegratorKind::semi_implicit_euler, true});
  methods.push_back({"pgs", SolverKind::pgs, IntegratorKind::semi_implicit_euler, false, false});
  methods.push_back({"impulse", SolverKind::impulse, IntegratorKind::semi_implicit_euler, false, false});
  return methods;
}

}  // namespace

std::vector<Method> methods_of(const Problem& problem) {
  std::vector<Method> methods = all_methods_of(problem);
  const std::vector<std::string>& names = problem.method_names;
  if (names.empty()) return methods;
  const auto is_left_out = [&](const Method& method) {
    return std::find(names.begin(), names.end(), method.name) == names.end();
  };
  methods.erase(std::remove_if(methods.begin(), methods.end(), is_left_out), methods.end());
  return methods;
}

std::vector<Setting> settings_of(const Problem& problem, const Method& method) {
  std::vector<Setting> settings;
  if (method.clock) {
    switch (*method.clock) {
      case ClockKind::fixed:
      case ClockKind::semi_fixed:
        for (int i = 0; i < 6; ++i) settings.push_back({1.0 / (60 << i), 1, 0, {}});
        break;
      case ClockKind::variable:
        settings.push_back({1.0 / 30, 1, 0, "steady_30"});
        settings.push_back({1.0 / 60, 1, 0, "steady_60"});
        settings.push_back({1.0 / 144, 1, 0, "steady_144"});
        break;
      case ClockKind::adaptive:
        for (const double tolerance : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) settings.push_back({1.0 / 60, 1, tolerance, {}});
        break;
    }
    return settings;
  }
  if (problem.kind == ProblemClass::smooth) {
    for (int i = 0; i < 7; ++i) settings.push_back({problem.duration / (problem.step_count << i), 1, 0, {}});
    return settings;
  }
  if (method.automatic) {
    for (const double target : {0.05, 0.02, 0.01, 0.005, 0.002, 0.001}) settings.push_back({problem.dt, 4, target, {}});
    return settings;
  }
  const bool substeps = method.solver == SolverKind::tgs_soft;
  if (!substeps || !method.locates)
    for (int i = 0; i < 6; ++i) settings.push_back({problem.dt / (1 << i), substeps ? 4 : 1, 0, {}});
  else if (problem.substep_counts.empty())
    for (int count = 1; count <= problem.substeps_max; count *= 2) settings.push_back({problem.dt, count, 0, {}});
  else
    for (const int count : problem.substep_counts) settings.push_back({problem.dt, count, 0, {}});
  return settings;
}

Result<std::vector<AccuracyCurve>> run_accuracy(const std::vector<Problem>& problems, const AccuracyOptions& options) {
  struct Job {
    const Problem* problem;
    Method method;
  };
  std::vector<Job> jobs;
  for (const Problem& problem : problems)
    for (Method& method : methods_of(problem)) jobs.push_back({&problem, std::move(method)});
  std::vector<std::vector<AccuracyCurve>> done(jobs.size());
  std::mutex mutex;
  std::uint64_t done_count = 0;
  const Status ran = run_jobs(jobs.size(), options.thread_count, [&](std::size_t i) {
    done[i] = run_method(*jobs[i].problem, jobs[i].method, options);
    const std::lock_guard<std::mutex> lock(mutex);
    ++done_count;
    if (options.progress) options.progress(done_count, jobs.size());
  });
  if (!ran) return ran.error();
  std::vector<AccuracyCurve> curves;
  for (const Problem& problem : problems)
    for (std::size_t precision = 0; precision < options.precisions.size(); ++precision)
      for (std::size_t i = 0; i < jobs.size(); ++i)
        if (jobs[i].problem == &problem) curves.push_back(std::move(done[i][precision]));
  return curves;
}

const AccuracyPoint* cheapest(const AccuracyCurve& curve, double error) {
  const AccuracyPoint* best = nullptr;
  for (const AccuracyPoint& point : curve.points)
    if (point.state == PointState::ok && point.error <= error && (!best || point.time_ms.min < best->time_ms.min))
      best = &point;
  return best;
}

const AccuracyPoint* coarsest(const AccuracyCurve& curve, double error) {
  const auto found = std::find_if(curve.points.begin(), curve.points.end(), [error](const AccuracyPoint& point) {
    return point.state == PointState::ok && point.error <= error;
  });
  return found == curve.points.end() ? nullptr : &*found;
}

std::string setting_text(const Method& method, const Setting& setting) {
  const auto number = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return std::string(text);
  };
  if (!setting.host.empty()) return setting.host;
  if (method.automatic) return "target " + number(setting.target);
  if (method.clock && *method.clock == ClockKind::adaptive) return "tol " + number(setting.target);
  if (method.solver == SolverKind::tgs_soft && method.locates) return std::to_string(setting.substeps) + " sub";
  char text[32];
  std::snprintf(text, sizeof text, "1/%.*g", 1 / setting.dt < 1000 ? 4 : 6,
                1 / setting.dt < 1000 ? 1 / setting.dt : std::round(1 / setting.dt));
  return text;
}

}  // namespace ticktrue::tool
