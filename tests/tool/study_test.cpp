// The studies: slopes and verdicts on invented errors, references against published digits, small cases of each study.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/build_info.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/math/trig.h"
#include "tests/support/catch.h"
#include "tests/support/source_tree.h"
#include "tests/support/text.h"
#include "tool/session/scene_key.h"
#include "tool/study/accuracy.h"
#include "tool/study/closed_forms.h"
#include "tool/study/compare.h"
#include "tool/study/peer_curves.h"
#include "tool/study/reference_numbers.h"
#include "tool/study/stress/stress.h"
#include "tool/study/table.h"

using namespace ticktrue;
using namespace ticktrue::tool;
using engine::Point;
using engine::Precision;

namespace {

std::vector<tool::Problem> smooth_problems() {
  std::vector<tool::Problem> out;
  for (tool::Problem& problem : tool::verification_problems())
    if (problem.kind == tool::ProblemClass::smooth) out.push_back(std::move(problem));
  return out;
}

tool::Problem problem_named(const std::string& name) {
  for (tool::Problem& problem : tool::verification_problems())
    if (problem.name == name) return problem;
  FAIL("no problem " << name);
  return {};
}

struct Flow {
  Point x;
  Point v;
};

// The classical scheme with custom weights (1, 2, 2, 1 are correct), in place of the engine's integrator.
Flow stepped(const tool::Problem& problem, const Flow& s, double h, const std::array<double, 4>& weights) {
  const auto rate = [&](const Flow& at) { return Flow{at.v, problem.acceleration(at.x, at.v)}; };
  const auto moved = [](const Flow& a, const Flow& k, double t) {
    return Flow{{a.x.x + t * k.x.x, a.x.y + t * k.x.y}, {a.v.x + t * k.v.x, a.v.y + t * k.v.y}};
  };
  const Flow k1 = rate(s);
  const Flow k2 = rate(moved(s, k1, h / 2));
  const Flow k3 = rate(moved(s, k2, h / 2));
  const Flow k4 = rate(moved(s, k3, h));
  Flow out = moved(s, k1, h / 6 * weights[0]);
  out = moved(out, k2, h / 6 * weights[1]);
  out = moved(out, k3, h / 6 * weights[2]);
  return moved(out, k4, h / 6 * weights[3]);
}

// The judgement of `ticktrue accuracy` on the stand-in, with the same problem and steps.
tool::Judgement judgement_of(const tool::Problem& problem, const std::array<double, 4>& weights) {
  const tool::Method rk4{"rk4", engine::SolverKind::free_flight, engine::IntegratorKind::rk4};
  std::vector<double> steps, errors, floors;
  for (const tool::Setting& setting : settings_of(problem, rk4)) {
    const int count = static_cast<int>(std::lround(problem.duration / setting.dt));
    Flow flow{problem.start, problem.start_velocity};
    std::vector<double> times;
    std::vector<std::vector<double>> samples;
    for (int i = 1; i <= count; ++i) {
      flow = stepped(problem, flow, setting.dt, weights);
      if (i % (count / problem.sample_count) != 0) continue;
      times.push_back(problem.duration * i / count);
      samples.push_back(problem.is_angle ? std::vector<double>{flow.x.x} : std::vector<double>{flow.x.x, flow.x.y});
    }
    steps.push_back(setting.dt);
    errors.push_back(sample_error(problem, times, samples).rms);
    floors.push_back(0x1p-53 * std::sqrt(count));
  }
  return judge(expectation_of(problem, rk4), steps, errors, floors);
}

}  // namespace

TEST_CASE("a fitted slope is that of the power law, without what rounding and coarse steps add", "[verifier][study]") {
  std::vector<double> steps, errors, floors;
  for (int i = 0; i < 8; ++i) {
    steps.push_back(std::ldexp(0.5, -i));
    errors.push_back(std::pow(steps.back(), 3) + (i < 2 ? 5 : 0) + (i > 5 ? 1e-3 : 0));
    floors.push_back(i > 5 ? 1e-3 : 0);
  }
  const auto slope = tool::fitted_slope(steps, errors, floors);
  REQUIRE(slope.has_value());
  CHECK(*slope == Approx(3).epsilon(1e-9));
  CHECK_FALSE(tool::fitted_slope({1, 0.5, 0.25}, {1e-3, 1e-4, 1e-5}, {1, 1, 1}).has_value());
}

TEST_CASE("a curve is judged by its slope, by rounding where it is exact, and not at all without theory",
          "[verifier][study]") {
  const std::vector<double> steps{0.1, 0.05, 0.025, 0.0125}, none(4, 0.0);
  const std::vector<double> second{1e-2, 2.5e-3, 6.25e-4, 1.5625e-4};
  tool::Expectation order;
  order.slope = 2;
  CHECK(judge(order, steps, second, none).verdict == tool::StudyVerdict::pass);
  order.slope = 1;
  CHECK(judge(order, steps, second, none).verdict == tool::StudyVerdict::fail);
  tool::Expectation exact;
  exact.is_exact = true;
  CHECK(judge(exact, steps, second, none).verdict == tool::StudyVerdict::fail);
  CHECK(judge(exact, steps, {1e-15, 1e-15, 1e-15, 1e-15}, none).verdict == tool::StudyVerdict::pass);
  tool::Expectation unknown;
  unknown.reason = "why";
  CHECK(judge(unknown, steps, second, none).verdict == tool::StudyVerdict::not_judged);
  CHECK(judge(unknown, steps, second, none).reason == "why");
}

TEST_CASE("a missed bar makes a curve fail, or fall short where that is documented", "[verifier][study]") {
  tool::Problem problem;
  problem.bars = {{"m", "4 sub", 0.01, 0}, {"m", "", 0, 2}};
  tool::AccuracyCurve curve;
  curve.method = {"m", engine::SolverKind::tgs_soft, engine::IntegratorKind::semi_implicit_euler};
  for (const int substeps : {1, 4}) {
    curve.points.emplace_back();
    curve.points.back().setting.substeps = substeps;
    curve.points.back().error = 0.009;
  }
  const auto judged = [&](tool::StudyVerdict before) {
    tool::AccuracyCurve copy = curve;
    copy.judgement.verdict = before;
    judge_bars(problem, copy);
    return copy.judgement;
  };
  CHECK(judged(tool::StudyVerdict::not_judged).verdict == tool::StudyVerdict::pass);
  CHECK(judged(tool::StudyVerdict::fail).verdict == tool::StudyVerdict::fail);
  curve.points[0].error = 1;  // at "1 sub", which has no bar for errors
  CHECK(judged(tool::StudyVerdict::pass).verdict == tool::StudyVerdict::pass);
  curve.points[1].error = std::nan("");
  CHECK(judged(tool::StudyVerdict::pass).verdict == tool::StudyVerdict::fail);
  curve.points[1].error = 0.011;
  CHECK(judged(tool::StudyVerdict::pass).verdict == tool::StudyVerdict::fail);
  CHECK(judged(tool::StudyVerdict::pass).reason == "error 0.011 at 4 sub, bar 0.01");
  problem.shortfalls = {{"m", "why", 0.0105, 3}};
  CHECK(judged(tool::StudyVerdict::pass).verdict == tool::StudyVerdict::fail);  // larger than the documented miss
  problem.shortfalls[0].error = 0.012;
  CHECK(judged(tool::StudyVerdict::pass).verdict == tool::StudyVerdict::falls_short);
  CHECK(judged(tool::StudyVerdict::pass).reason == "error 0.011 at 4 sub, bar 0.01: why");
  CHECK(judged(tool::StudyVerdict::not_applicable).verdict == tool::StudyVerdict::not_applicable);
  curve.points[1].error = 0;
  curve.points[0].energy = -2.5;
  CHECK(judged(tool::StudyVerdict::pass).reason == "energy changes by -2.5 J at 1 sub, bar 2 J: why");
  curve.points[0].energy = -3.5;
  CHECK(judged(tool::StudyVerdict::pass).verdict == tool::StudyVerdict::fail);
  curve.method.name = "other";
  CHECK(judged(tool::StudyVerdict::not_judged).verdict == tool::StudyVerdict::not_judged);
}

TEST_CASE("documented shortfalls of joint problems are real, and nothing else fails", "[verifier][study]") {
  std::vector<tool::Problem> problems{problem_named("pendulum_rod"), problem_named("double_pendulum"),
                                      problem_named("spring_joint"), problem_named("cantilever")};
  for (tool::Problem& problem : problems) problem.method_names = {"tgs_soft", "tgs_soft verlet", "tgs_soft rk4"};
  tool::AccuracyOptions options;
  options.precisions = {Precision::f64};
  options.repeat_max = 1;
  const auto curves = run_accuracy(problems, options);
  REQUIRE(curves.has_value());
  REQUIRE(curves->size() == 12);
  const std::string study_page = source_tree::read_text(std::filesystem::path(TICKTRUE_SOURCE_DIR) / "docs/study.md");
  for (const tool::AccuracyCurve& curve : *curves) {
    CAPTURE(curve.problem, curve.method.name, curve.judgement.reason);
    const tool::Problem problem = problem_named(curve.problem);
    for (const tool::Shortfall& each : problem.shortfalls) CHECK(source_tree::contains(study_page, each.reason));
    const bool is_known = std::any_of(problem.shortfalls.begin(), problem.shortfalls.end(),
                                      [&](const tool::Shortfall& each) { return each.method == curve.method.name; });
    CHECK(curve.judgement.verdict == (is_known ? tool::StudyVerdict::falls_short : tool::StudyVerdict::pass));
  }
}

TEST_CASE("rk4 with two stage weights swapped fails on every smooth problem that is not exact", "[verifier][study]") {
  int judged = 0;
  for (const tool::Problem& problem : smooth_problems()) {
    CAPTURE(problem.name);
    const tool::Judgement right = judgement_of(problem, {1, 2, 2, 1});
    CAPTURE(right.reason, right.slope.value_or(0));
    if (problem.name == "spin") continue;  // without forces, all weights with sum 1 are correct
    CHECK(right.verdict == tool::StudyVerdict::pass);
    const tool::Judgement swapped = judgement_of(problem, {2, 1, 2, 1});
    CAPTURE(swapped.reason, swapped.slope.value_or(0));
    CHECK(swapped.verdict == tool::StudyVerdict::fail);
    if (!swapped.expected) continue;  // exact: the reason names an error beyond rounding instead
    REQUIRE(swapped.slope.has_value());
    CHECK(*swapped.slope == Approx(1).margin(0.15));
    ++judged;
  }
  CHECK(judged >= 7);
}

TEST_CASE("references agree with published digits", "[verifier][study]") {
  // Accuracy anchors 4.2, problems 5, 7a, 7b: computed independently to 15 digits.
  CHECK(tool::double_pendulum_90[18] == Approx(-0.6629799257481).epsilon(1e-12));
  CHECK(tool::double_pendulum_90[19] == Approx(-1.04638763323205).epsilon(1e-12));
  CHECK(tool::double_pendulum_90[38] == Approx(-0.424982716481034).epsilon(1e-12));
  CHECK(tool::double_pendulum_120[18] == Approx(-0.343685660491346).epsilon(1e-12));
  CHECK(tool::double_pendulum_120[39] == Approx(-1.89489882956367).epsilon(1e-12));
  const double period = 2.13232427506;
  CHECK(tool::pendulum_angle(engine::pi / 3, std::sqrt(10.0), period) == Approx(engine::pi / 3).epsilon(1e-10));
  CHECK(std::fabs(tool::pendulum_angle(engine::pi / 3, std::sqrt(10.0), period / 4)) < 1e-10);
  // The first apex after one bounce with 0.8 from 1 m: 0.64 m.
  const double apex_s = std::sqrt(0.2) * (1 + 0.8);
  CHECK(tool::bouncing_height(1, 0.8, apex_s) == Approx(0.64).epsilon(1e-12));
  // A polygon with many corners rolls almost like a disc. A triangle stops on its next side or on the first.
  CHECK(tool::rolled_angle[13][19] < tool::rolling_spin * 2);
  CHECK(std::fabs(std::remainder(tool::rolled_angle[0][19], 2 * engine::pi / 3)) < 0.05);
}

TEST_CASE("the integrators keep their order on the oscillator, and errors repeat to the last bit",
          "[verifier][study]") {
  tool::AccuracyOptions options;
  options.precisions = {Precision::f64};
  options.repeat_max = 1;
  const auto curves = run_accuracy({problem_named("damped")}, options);
  REQUIRE(curves.has_value());
  REQUIRE(curves->size() == engine::integrators.size());
  for (const tool::AccuracyCurve& curve : *curves) {
    CAPTURE(curve.method.name, curve.judgement.reason, curve.judgement.slope.value_or(0));
    CHECK(curve.judgement.verdict == tool::StudyVerdict::pass);
  }
  const auto again = run_accuracy({problem_named("damped")}, options);
  REQUIRE(again.has_value());
  for (std::size_t i = 0; i < curves->size(); ++i)
    for (std::size_t k = 0; k < (*curves)[i].points.size(); ++k) {
      CHECK((*again)[i].points[k].error == (*curves)[i].points[k].error);
      CHECK((*again)[i].points[k].hash == (*curves)[i].points[k].hash);
    }
}

TEST_CASE("the cheapest point is the quickest that keeps the error", "[verifier][study]") {
  tool::AccuracyCurve curve;
  for (const auto& [error, ms] : {std::pair{0.1, 1.0}, {0.009, 2.0}, {0.005, 1.5}, {0.0001, 8.0}}) {
    tool::AccuracyPoint point;
    point.error = error;
    point.time_ms.min = ms;
    curve.points.push_back(point);
  }
  CHECK(cheapest(curve, 0.01)->error == 0.005);
  CHECK(cheapest(curve, 0.001)->error == 0.0001);
  CHECK(cheapest(curve, 1e-6) == nullptr);
  CHECK(coarsest(curve, 0.01)->error == 0.009);
  CHECK(coarsest(curve, 1e-6) == nullptr);
  curve.points[2].state = tool::PointState::not_finite;
  CHECK(cheapest(curve, 0.01)->error == 0.009);
}

TEST_CASE("beside a peer, half its best error at no more time holds, more does not", "[verifier][study]") {
  tool::PeerCurves curves;
  const auto point = [](double error, double ms) {
    tool::PeerPoint out;
    out.error = error;
    out.time_ms.min = ms;
    return out;
  };
  curves.ours = {point(0.1, 1), point(0.04, 2), point(0.001, 50)};
  curves.box2d = {point(0.5, 1), point(0.1, 3)};
  conclude(curves);
  CHECK(curves.ratio == Approx(0.4));
  CHECK(curves.holds);
  curves.box2d[1].error = 0.06;
  conclude(curves);
  CHECK_FALSE(curves.holds);
  curves.box2d[1] = point(0.06, 0.5);  // faster than any of our settings
  conclude(curves);
  CHECK_FALSE(curves.holds);
}

TEST_CASE("beside a peer, common settings have bars of their own", "[verifier][study]") {
  tool::PeerCurves curves;
  const auto point = [](double error, double ms, const char* setting) {
    tool::PeerPoint out;
    out.error = error;
    out.time_ms.min = ms;
    out.setting = setting;
    return out;
  };
  curves.ours = {point(0.06, 1, "1 sub"), point(0.001, 5, "8 sub")};
  curves.box2d = {point(0.5, 2, "8/3 it"), point(0.4, 3, "12/5 it"), point(0.01, 6, "64/24 it")};
  conclude(curves);
  CHECK(curves.ratio == Approx(0.1));
  CHECK_FALSE(curves.holds);  // 0.12 at 8/3
  CHECK(curves.conclusion.find("At 8/3 it 0.12 of its error (fail: at most 0.1)") != std::string::npos);
  curves.box2d[0].error = 0.7;
  conclude(curves);
  CHECK(curves.holds);  // 12/5 has no bar
  REQUIRE(curves.bars.size() == 1);
  CHECK(curves.bars[0].ratio == Approx(0.06 / 0.7));
  curves.box2d[0].time_ms.min = 0.5;
  conclude(curves);
  CHECK_FALSE(curves.holds);
  CHECK(curves.conclusion.find("At 8/3 it none of ours is as quick (fail: at most 0.1)") != std::string::npos);
  curves.peer = tool::PeerKind::box2d3;
  curves.box2d = {point(0.1, 2, "4 sub"), point(0.01, 6, "32 sub")};
  conclude(curves);
  CHECK_FALSE(curves.holds);  // 0.6 at 4 sub
  curves.box2d[0].error = 0.13;
  conclude(curves);
  CHECK(curves.holds);
}

TEST_CASE("a stress number is judged by its bounds, and baselines are excused", "[verifier][study]") {
  tool::StressCase c;
  c.lower = 0;
  c.upper = 1;
  CHECK(judge(c, {0.5, true, ""}) == tool::StudyVerdict::pass);
  CHECK(judge(c, {1.5, true, ""}) == tool::StudyVerdict::fail);
  CHECK(judge(c, {0.5, false, ""}) == tool::StudyVerdict::fail);
  CHECK(judge(c, {0.5, true, "because"}) == tool::StudyVerdict::not_applicable);

  c.methods = tool::contact_methods();
  std::vector<tool::StressRow> rows(4);
  for (tool::StressRow& row : rows) row.verdict = tool::StudyVerdict::fail;
  excuse(rows, c);
  CHECK(rows[0].verdict == tool::StudyVerdict::fail);
  CHECK(rows[1].verdict == tool::StudyVerdict::fail);
  CHECK(rows[2].verdict == tool::StudyVerdict::not_judged);
  for (tool::StressRow& row : rows) row.verdict = tool::StudyVerdict::fail;
  rows[1].verdict = tool::StudyVerdict::pass;
  excuse(rows, c);
  CHECK(rows[0].verdict == tool::StudyVerdict::falls_short);
}

TEST_CASE("every stress case says what it measures, and what is chosen runs", "[verifier][study]") {
  std::vector<std::string> names;
  for (const tool::StressCase& c : tool::stress_cases()) {
    CAPTURE(c.name);
    CHECK_FALSE(c.what.empty());
    CHECK_FALSE(c.methods.empty());
    CHECK(c.lower <= c.upper);
    CHECK(std::find(names.begin(), names.end(), c.name) == names.end());
    names.push_back(c.name);
  }
  tool::StressOptions options;
  options.names = {"bad_input", "slope_hold"};
  const auto rows = run_stress(options);
  REQUIRE(rows.has_value());
  CHECK(rows->size() == 5);
  for (const tool::StressRow& row : *rows) {
    CAPTURE(row.name, row.method, row.value);
    CHECK(row.verdict != tool::StudyVerdict::fail);
  }
  options.names = {"nothing_like_this"};
  CHECK_FALSE(run_stress(options).has_value());
}

TEST_CASE("bisection finds the stability limits of theory", "[verifier][study]") {
  const auto rows = tool::stability_limits({Precision::f64}, 1);
  REQUIRE(rows.has_value());
  REQUIRE(rows->size() == engine::integrators.size());
  for (const tool::StabilityRow& row : *rows) {
    CAPTURE(engine::info_of(engine::integrators, row.integrator).name, row.found, row.theory);
    CHECK(stability_holds(row));
  }
  CHECK_FALSE(tool::stability_holds({engine::IntegratorKind::rk4, Precision::f64, 2.7, 2.8284}));
}

TEST_CASE("growth is the rate of an exponential, and drift is one's own only beyond the twins'", "[verifier][study]") {
  std::vector<tool::CompareSample> samples;
  for (int i = 1; i <= 100; ++i) {
    tool::CompareSample sample;
    sample.time_s = 0.1 * i;
    sample.position_rms = std::min(1.0, 1e-8 * std::exp(2.5 * sample.time_s));
    sample.twin_rms = sample.position_rms / 2;
    samples.push_back(sample);
  }
  REQUIRE(growth_rate(samples).has_value());
  CHECK(*growth_rate(samples) == Approx(2.5).epsilon(1e-6));
  CHECK_FALSE(first_beyond(samples).has_value());
  samples[40].position_rms = 5 * samples[40].twin_rms;
  REQUIRE(first_beyond(samples).has_value());
  CHECK(*first_beyond(samples) == Approx(4.1));
}

TEST_CASE("a twin is shifted by one unit in the last place", "[verifier][study]") {
  auto scene = engine::make_builtin_scene("stack?boxes=3&precision=f32");
  REQUIRE(scene);
  const engine::Scene twin = tool::twin_of(*scene, 1);
  for (std::size_t i = 0; i < scene->bodies.size(); ++i) {
    const double shift = std::fabs(twin.bodies[i].position.x - scene->bodies[i].position.x);
    if (scene->bodies[i].type != engine::BodyType::dynamic_body)
      CHECK(shift == 0);
    else
      CHECK(shift == 0x1p-24);  // of half a metre
  }
}

TEST_CASE("compare calls a broad phase equal in bits, an integrator drift, and a refused one not applicable",
          "[verifier][study]") {
  auto scene = engine::make_builtin_scene("stack?boxes=4&precision=f64");
  REQUIRE(scene);
  tool::CompareSession session;
  session.scene = *scene;
  session.seconds = 1;
  tool::CompareAxes axes;
  axes.broad_phases = {engine::BroadPhaseKind::brute_force};
  std::vector<tool::Variant> variants = product_of(axes);
  axes = {};
  axes.substeps = {1};
  axes.integrators = {engine::IntegratorKind::semi_implicit_euler, engine::IntegratorKind::yoshida4};
  for (const tool::Variant& variant : product_of(axes)) variants.push_back(variant);
  REQUIRE(variants.size() == 3);
  const auto report = compare_variants(session, variants, {});
  REQUIRE(report.has_value());
  CHECK(report->twins.size() == 3);
  CHECK(report->rows[0].verdict == tool::CompareVerdict::same_bits);
  CHECK(report->rows[0].position_max == 0);
  CHECK(report->rows[1].verdict == tool::CompareVerdict::drift);
  CHECK(report->rows[1].first_different.has_value());
  CHECK(report->rows[1].position_max > 1e-4);  // 16 times the yield
  CHECK(report->rows[2].verdict == tool::CompareVerdict::not_applicable);
  CHECK_FALSE(report->rows[2].reason.empty());
}

TEST_CASE("compare finds every column equal whatever the threads of a tick, and not under another solver",
          "[verifier][study][threads]") {
  auto scene = engine::make_builtin_scene("pyramid?base=30");  // large enough to use threads
  REQUIRE(scene);
  tool::CompareSession session;
  session.scene = *scene;
  session.seconds = 0.1;
  tool::CompareAxes axes;
  axes.threads = {1, 2, 3};
  std::vector<tool::Variant> variants = product_of(axes);
  REQUIRE(variants.size() == 3);
  CHECK(variants[2].name == "3 threads");
  axes.solvers = {engine::SolverKind::pgs};
  axes.substeps = {1};
  axes.threads = {2};
  for (const tool::Variant& variant : product_of(axes)) variants.push_back(variant);
  tool::CompareOptions options;
  options.wall_clock = true;
  options.twin_count = 1;
  options.sample_count = 2;
  const auto report = compare_variants(session, variants, options);
  REQUIRE(report.has_value());
  for (std::size_t i = 0; i < 3; ++i) {
    const tool::CompareRow& row = report->rows[i];
    CAPTURE(row.variant.name, row.reason);
    if (i > 0 && !build_info().has_threads) {
      CHECK(row.verdict == tool::CompareVerdict::not_applicable);
      continue;
    }
    CHECK(row.whole_state);
    CHECK(row.verdict == tool::CompareVerdict::same_bits);
    CHECK(row.root_hash == report->base.root_hash);
    CHECK(row.ms_per_s > 0);
  }
  CHECK_FALSE(report->rows[3].whole_state);
  CHECK(report->rows[3].root_hash != report->base.root_hash);
}

TEST_CASE("a variant with other ticks is compared at equal times", "[verifier][study]") {
  // With velocity Verlet, a projectile is exact at every dt, so all differences are rounding.
  auto scene = engine::make_builtin_scene("projectile?precision=f64&integrator=velocity_verlet");
  REQUIRE(scene);
  tool::CompareSession session;
  session.scene = *scene;
  session.seconds = 1;
  tool::CompareAxes axes;
  axes.dts = {1.0 / 47, 1.0 / 240};
  tool::CompareOptions options;
  options.sample_count = 30;
  const auto report = compare_variants(session, product_of(axes), options);
  REQUIRE(report.has_value());
  for (const tool::CompareRow& row : report->rows) {
    CHECK_FALSE(row.same_ticks);
    CHECK(row.position_max < 1e-12);
  }
}

TEST_CASE("a key of the scene is varied, and its effect is the law's", "[verifier][study]") {
  const auto scene = engine::make_builtin_scene("slide?speed=4&precision=f64");
  REQUIRE(scene);
  tool::CompareSession session;
  session.scene = *scene;
  session.seconds = 3;
  const auto varied = tool::parse_varied("bodies.1.shapes.0.friction=0.25:1:4", "--vary");
  REQUIRE(varied.has_value());
  CHECK(varied->values == std::vector<std::string>{"0.25", "0.5", "0.75", "1"});
  const auto variants = with_varied({}, session.scene, *varied, "--vary");
  REQUIRE(variants.has_value());
  REQUIRE(variants->size() == 4);
  CHECK((*variants)[1].name == "friction 0.5");
  tool::CompareOptions options;
  options.measure = [](const engine::Engine& engine) {
    return std::vector<double>{engine.bodies()[1].center.x, engine.bodies()[1].velocity.x};
  };
  const auto report = compare_variants(session, *variants, options);
  REQUIRE(report.has_value());
  const std::vector<double>& base_end = report->base.samples.back().values;
  REQUIRE(base_end.size() == 2);
  for (std::size_t i = 0; i < 4; ++i) {
    // The friction is the root of the product of both materials. All bodies stop, in the base after v^2 / (2 mu g).
    const tool::CompareRow& row = report->rows[i];
    CAPTURE(row.variant.name, row.reason);
    const auto way = [](double friction) { return 16 / (2 * std::sqrt(friction * 0.5) * 10); };
    const double base_way = way(0.5);
    CHECK(row.position_rms == Approx(std::fabs(way(0.25 * static_cast<double>(i + 1)) - base_way)).margin(0.03));
    REQUIRE(row.samples.size() == 120);
    CHECK(row.samples.back().energy < row.samples.front().energy - 1);
    CHECK(row.samples.back().momentum < 1e-3);
    const std::vector<double>& end = row.samples.back().values;
    REQUIRE(end.size() == 2);
    CHECK(end[0] - base_end[0] == Approx(way(0.25 * static_cast<double>(i + 1)) - base_way).margin(0.03));
    CHECK(std::fabs(end[1]) < 1e-3);
    CHECK(row.samples.front().values[1] > 1);  // each sample has the values of its time
  }
  CHECK(report->rows[1].verdict == tool::CompareVerdict::same_bits);  // this friction equals that of the scene
  const auto product = with_varied(*variants, session.scene, {"gravity.1", {"-5", "-20"}}, "--vary");
  REQUIRE(product.has_value());
  REQUIRE(product->size() == 8);
  CHECK(product->back().scene->gravity.y == -20);
  CHECK(product->back().scene->bodies[1].shapes[0].material.friction == 1);
}

TEST_CASE("keys are called by the shortest end that tells them apart", "[verifier][study]") {
  const auto labels_of = [](const std::vector<std::string>& names) {
    std::vector<tool::VariedKey> keys;
    for (const std::string& name : names) keys.push_back({name, {"1"}});
    label_keys(keys);
    std::vector<std::string> labels;
    for (const tool::VariedKey& key : keys) labels.push_back(key.label);
    return labels;
  };
  using Names = std::vector<std::string>;
  CHECK(labels_of({"bodies.1.shapes.0.friction", "gravity.1"}) == Names{"friction", "gravity.1"});
  CHECK(labels_of({"bodies.1.mass", "bodies.2.mass"}) == Names{"1.mass", "2.mass"});
  CHECK(labels_of({"bodies.1.mass", "mass"}) == Names{"1.mass", "mass"});
  CHECK(labels_of({"a.mass", "a.mass"}) == Names{"a.mass", "a.mass"});
  CHECK(labels_of({"x.mass", "x.bigmass"}) == Names{"mass", "bigmass"});

  const auto scene = engine::make_builtin_scene("slide");
  REQUIRE(scene);
  std::vector<tool::VariedKey> keys{{"bodies.0.shapes.0.friction", {"0.5"}}, {"bodies.1.shapes.0.friction", {"0.250"}}};
  label_keys(keys);
  auto variants = with_varied({}, *scene, keys[0], "--vary");
  REQUIRE(variants);
  variants = with_varied(*variants, *scene, keys[1], "--vary");
  REQUIRE(variants);
  CHECK((*variants)[0].name == "0.shapes.0.friction 0.5, 1.shapes.0.friction 0.25");
  CHECK((*variants)[0].varied_values == Names{"0.5", "0.25"});
}

TEST_CASE("a key that a scene cannot have is refused with its name", "[verifier][study]") {
  const auto scene = engine::make_builtin_scene("slide");
  REQUIRE(scene);
  REQUIRE(scene->settings.auto_substeps);  // and what only automatic substeps have is left out with them
  const auto refusal = [&](const std::string& key, const std::string& value) {
    const auto changed = tool::scene_with(*scene, key, value, "--vary x");
    return changed ? std::string() : changed.error().message;
  };
  CHECK(refusal("settings.substeps", "8").empty());
  engine::Scene stated = *scene;  // what a scene states itself stays with "auto" and with an object
  stated.settings.substep_budget = 77;
  for (const char* value : {"auto", R"({"least": 4, "target_error": 0.01})"}) {
    const auto kept = tool::scene_with(stated, "settings.substeps", value, "--vary x");
    REQUIRE(kept);
    CHECK(kept->settings.auto_substeps);
    CHECK(kept->settings.substep_budget == 77);
  }
  const auto fixed = tool::scene_with(stated, "settings.substeps", "8", "--vary x");
  REQUIRE(fixed);
  CHECK(fixed->settings.substeps == 8);
  CHECK_FALSE(fixed->settings.auto_substeps);
  CHECK(refusal("settings.solver", "pgs").find("substeps") != std::string::npos);
  CHECK(refusal("bodies.2.position.0", "1") ==
        "--vary x: found bodies.2, expected an index below 2 or a name: floor, box");
  CHECK(refusal("bodies.x.position", "1").find("expected an index below 2") != std::string::npos);
  engine::Scene named = *scene;
  named.bodies[1].name = "slider";
  CHECK(tool::scene_with(named, "bodies.slider.position.0", "1.5", "--vary x")->bodies[1].position.x == 1.5);
  const auto misnamed = tool::scene_with(named, "bodies.slide.position.0", "1", "--vary x");
  REQUIRE_FALSE(misnamed);
  CHECK(misnamed.error().message == "--vary x: found bodies.slide, expected an index below 2 or a name: floor, slider");
  CHECK(refusal("gravity.1.2", "1").find("a value that has no keys") != std::string::npos);
  CHECK(refusal("settings.substebs", "8").find("unknown key: found \"substebs\"") != std::string::npos);
  CHECK(refusal("bodies.1.mass", "heavy").find("bodies[1].mass") != std::string::npos);
  for (const char* text : {"", "a", "a=", "=1", "a=1:2", "a=1:2:1", "a=1:2:1001", "a=1,,2", "a=1:x:3"}) {
    CAPTURE(text);
    CHECK_FALSE(tool::parse_varied(text, "--vary").has_value());
  }
  CHECK(tool::parse_varied("a=1,2,b", "--vary")->values == std::vector<std::string>{"1", "2", "b"});
  CHECK(tool::parse_varied("a={\"x\": [1, 2]}", "--vary")->values.size() == 1);
  using Texts = std::vector<std::string>;
  CHECK(tool::parse_varied("a=[0,-10],[0, -2]", "--vary")->values == Texts{"[0,-10]", "[0, -2]"});
  CHECK(tool::parse_varied(R"(a=auto,{"least": 4, "most": 8})", "--vary")->values ==
        Texts{"auto", R"({"least": 4, "most": 8})"});
  CHECK(tool::parse_varied(R"(a="x,[","y\",")", "--vary")->values == Texts{R"("x,[")", R"("y\",")"});
  const auto vectors =
      with_varied({}, *scene, *tool::parse_varied("bodies.1.velocity=[1,0],[2,0]", "--vary"), "--vary");
  REQUIRE(vectors);
  REQUIRE(vectors->size() == 2);
  CHECK((*vectors)[1].scene->bodies[1].velocity.x == 2);
}

TEST_CASE("a table wider than its lines goes on below, and no cell of it is cut", "[verifier][study]") {
  std::vector<std::string> head{"method", "setting"};
  for (int i = 0; i < 12; ++i) head.push_back("column " + std::to_string(i));
  tool::TextTable table(head, 2);
  for (int row = 0; row < 3; ++row) {
    std::vector<std::string> cells{"m" + std::to_string(row), "s"};
    for (int i = 0; i < 12; ++i) cells.push_back(std::to_string(1'000'000'000 + 100 * row + i));
    table.add(cells);
  }
  std::istringstream in(table.text());
  std::size_t line_count = 0, empty_count = 0;
  std::set<std::string> words;
  for (std::string line; std::getline(in, line); ++line_count) {
    CHECK(line.size() <= tool::table_width_max);
    if (line.empty()) ++empty_count;
    // Each line begins with the name of its row.
    if (!line.empty()) CHECK((line.compare(0, 3, "  m") == 0));
    std::istringstream cells(line);
    for (std::string word; cells >> word;) words.insert(word);
  }
  CHECK(empty_count == 1);
  CHECK(line_count == 2 * 4 + 1);
  for (int row = 0; row < 3; ++row)
    for (int i = 0; i < 12; ++i) CHECK(words.count(std::to_string(1'000'000'000 + 100 * row + i)) == 1);
}

TEST_CASE("a cell wider than a line is shown whole", "[verifier][study]") {
  tool::TextTable table({"name", "value", "more"});
  table.add({"long", std::string(200, 'x'), "7"});
  CHECK(test::contains(table.text(), std::string(200, 'x')));
  CHECK(test::contains(table.text(), "7"));
}

TEST_CASE("cells of CSV keep to their commas", "[verifier][study]") {
  CHECK(tool::csv_line({"a,b", "say \"so\"", "c"}) == "\"a,b\",\"say \"\"so\"\"\",c\n");
  CHECK(tool::full_number(0.1) == "0.1");
  CHECK(std::stod(tool::full_number(1.0 / 3)) == 1.0 / 3);
}
