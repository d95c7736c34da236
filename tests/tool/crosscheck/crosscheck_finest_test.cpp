// The cross-check if Box2D has not converged: its finest steps decide.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/crosscheck/crosscheck.h"

namespace ticktrue::test {
namespace {

using tool::Agreement;
using tool::CriterionResult;

/// A row with the means of one seed. `allowed`: the largest difference that agrees.
CriterionResult row_of(std::string_view criterion, double ours, double box2d, double allowed) {
  CriterionResult row;
  row.criterion = criterion;
  row.ours = {ours};
  row.box2d = {box2d};
  row.difference = ours > box2d ? ours - box2d : box2d - ours;
  row.tolerance = allowed;
  row.verdict = row.difference <= allowed ? Agreement::agree : Agreement::differ;
  return row;
}

/// The verdict on the engine's value, given Box2D's values with plain and with finest steps.
Agreement judged(std::string_view criterion, double ours, double plain, double finest, double allowed) {
  std::vector<CriterionResult> rows{row_of(criterion, ours, plain, allowed)};
  tool::judge_by_finest(rows, {row_of(criterion, ours, finest, allowed)}, 16);
  return rows[0].verdict;
}

/// Boxes of 1 kg below a box of `load` kg.
Scene loaded_stack(int count, double load, bool substeps_are_automatic) {
  Scene scene = empty_scene(Precision::f32);
  scene.name = "loaded";
  scene.bodies.push_back(ground());
  for (int i = 0; i <= count; ++i) {
    scene.bodies.push_back(unit_box({0, 0.5 + i}));
    scene.bodies.back().shapes[0].density = i == count ? load : 1;
  }
  if (substeps_are_automatic) scene.settings.auto_substeps.emplace();
  return scene;
}

/// Five boxes, each with five times the mass of the box below. They stand: each rests on the whole of the next.
Scene growing_stack(bool substeps_are_automatic) {
  Scene scene = empty_scene(Precision::f32);
  scene.bodies.push_back(ground());
  double density = 1;
  for (int i = 0; i < 5; ++i, density *= 5) {
    scene.bodies.push_back(unit_box({0, 0.5 + i}));
    scene.bodies.back().shapes[0].density = density;
  }
  if (substeps_are_automatic) scene.settings.auto_substeps.emplace();
  return scene;
}

tool::CrosscheckReport checked(const Scene& scene, std::uint32_t seeds, double seconds) {
  tool::CrosscheckOptions options;
  options.seed_count = seeds;
  options.seconds = seconds;
  const Result<tool::CrosscheckReport> report = tool::crosscheck(scene, options);
  REQUIRE(report.has_value());
  return *report;
}

const CriterionResult& row_named(const tool::CrosscheckReport& report, std::string_view criterion) {
  const auto found = std::find_if(report.rows.begin(), report.rows.end(),
                                  [&](const CriterionResult& row) { return row.criterion == criterion; });
  REQUIRE(found != report.rows.end());
  return *found;
}

}  // namespace

TEST_CASE("where Box2D stands with its finest steps, ours that falls differs", "[verifier][crosscheck][analytic]") {
  const std::string_view stands = tool::stands_criterion;
  CHECK(judged(stands, 0, 0, 1, 0.2) == Agreement::differ);  // both fall, but the finest steps stand
  CHECK(judged(stands, 0, 1, 1, 0.2) == Agreement::differ);
  CHECK(judged(stands, 1, 1, 0, 0.2) == Agreement::differ);    // both stand, but the finest steps fall
  CHECK(judged(stands, 1, 0, 1, 0.2) == Agreement::expected);  // Box2D has not converged
  CHECK(judged(stands, 0, 1, 0, 0.2) == Agreement::expected);
  CHECK(judged(stands, 0.5, 0, 1, 0.2) == Agreement::differ);  // a value between both is not expected here
  CHECK(judged(stands, 1, 1, 1, 0.2) == Agreement::agree);
  CHECK(judged(stands, 0, 0, 0, 0.2) == Agreement::agree);
}

TEST_CASE("a difference that Box2D's finest steps do not remove stays one", "[verifier][crosscheck][analytic]") {
  CHECK(judged("top height", 3, 2, 3, 0.1) == Agreement::expected);
  CHECK(judged("top height", 3, 2, 2, 0.1) == Agreement::differ);
  CHECK(judged("top height", 3, 2, 2.5, 0.1) == Agreement::differ);
  CHECK(judged("top height", 3, 2, 4, 0.1) == Agreement::expected);  // the value is between Box2D's values
  CHECK(judged("top height", 3, 3, 4, 0.1) == Agreement::agree);
  // judge_by_finest does not change the criteria of single bodies.
  CHECK(judged(tool::place_criterion, 3, 2, 3, 0.1) == Agreement::differ);
}

TEST_CASE("a stack under 1,001 kg is judged by what stands, not by who falls alike",
          "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  tool::CrosscheckOptions options;
  options.seed_count = 2;
  options.seconds = 10;
  const auto falls = tool::crosscheck(loaded_stack(4, 1001, false), options);
  REQUIRE(falls.has_value());
  const CriterionResult& fallen = row_named(*falls, tool::stands_criterion);
  CAPTURE(fallen.reason);
  CHECK(tool::mean_of(fallen.ours) == 0);
  REQUIRE(!fallen.box2d_finest.empty());
  CHECK(tool::mean_of(fallen.box2d_finest) == 1);
  CHECK(fallen.verdict == Agreement::differ);
  CHECK(fallen.reason.find("ours with 4 times the substeps") != std::string::npos);

  const auto stood = tool::crosscheck(loaded_stack(4, 1001, true), options);
  REQUIRE(stood.has_value());
  const CriterionResult& standing = row_named(*stood, tool::stands_criterion);
  CAPTURE(standing.reason);
  CHECK(tool::mean_of(standing.ours) == 1);
  CHECK(standing.verdict != Agreement::differ);
}

TEST_CASE("what stands at rest with smaller steps can stand, also where Box2D's finest steps drop it",
          "[verifier][crosscheck][analytic]") {
  const auto verdict = [](double ours, double plain, double finest, bool own_finest_stands, bool own_finest_rests,
                          bool balances = true) {
    tool::CrosscheckRun run;
    run.stood = ours == 1;
    tool::CrosscheckRun fine;
    fine.stood = own_finest_stands;
    fine.balances = balances;
    if (!own_finest_rests) fine.settle_s = std::numeric_limits<double>::infinity();
    std::vector<CriterionResult> rows{row_of(tool::stands_criterion, ours, plain, 0.2)};
    tool::judge_by_finest(rows, {row_of(tool::stands_criterion, ours, finest, 0.2)}, 16);
    tool::judge_by_rest(rows, {run}, {fine}, "4 times the substeps");
    return rows[0].verdict;
  };
  CHECK(verdict(0, 0, 0, true, true) == Agreement::differ);  // both fall, and it can stand
  CHECK(verdict(0, 1, 0, true, true) == Agreement::differ);
  CHECK(verdict(0, 0, 1, true, true) == Agreement::differ);
  CHECK(verdict(1, 1, 0, true, true) == Agreement::expected);
  CHECK(verdict(1, 0, 0, true, true) == Agreement::expected);
  CHECK(verdict(1, 1, 1, true, true) == Agreement::agree);
  CHECK(verdict(0, 0, 0, false, true) == Agreement::agree);  // nobody stands: it falls
  CHECK(verdict(1, 0, 0, false, true) == Agreement::differ);
  CHECK(verdict(0, 0, 0, true, false) == Agreement::agree);  // what still moves is in no equilibrium
  CHECK(verdict(1, 0, 0, true, false) == Agreement::differ);
  CHECK(verdict(0, 0, 0, true, true, false) == Agreement::agree);  // no forces would carry it: ours is at fault
  CHECK(verdict(1, 0, 0, true, true, false) == Agreement::differ);
}

TEST_CASE("a fall that ends elsewhere differs unless smaller steps move its end", "[verifier][crosscheck][analytic]") {
  // Where the fall ends, m: ours and Box2D, then both with smaller steps.
  const auto verdict = [](double ours, double box2d, double ours_finer, double finest,
                          std::string_view criterion = tool::top_criterion) {
    std::vector<CriterionResult> rows{row_of(criterion, ours, box2d, 0.1)};
    tool::judge_collapse(rows, {row_of(criterion, ours_finer, finest, 0.1)}, {row_of(criterion, ours_finer, ours, 0.1)},
                         {row_of(criterion, finest, box2d, 0.1)}, 16);
    return rows[0].verdict;
  };
  CHECK(verdict(1, 2, 1, 2) == Agreement::differ);
  CHECK(verdict(1, 2, 2, 2) == Agreement::expected);
  CHECK(verdict(1, 2, 1, 1) == Agreement::expected);
  CHECK(verdict(1, 2, 1.5, 2) == Agreement::not_applicable);
  CHECK(verdict(1, 2, 1, 2.5) == Agreement::not_applicable);
  CHECK(verdict(1, 1, 3, 2) == Agreement::agree);
  CHECK(verdict(1, 2, 2, 2, tool::joints_criterion) == Agreement::differ);  // judged elsewhere
}

TEST_CASE("boxes of growing mass stand, though Box2D's finest steps drop them", "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  const tool::CrosscheckReport by_default = checked(growing_stack(false), 1, 6);
  const CriterionResult& fallen = row_named(by_default, tool::stands_criterion);
  CAPTURE(fallen.reason);
  CHECK(tool::mean_of(fallen.ours) == 0);
  CHECK(tool::mean_of(fallen.box2d_finest) == 0);
  CHECK(fallen.verdict == Agreement::differ);
  CHECK(fallen.reason.find("raise \"substeps\"") != std::string::npos);

  const tool::CrosscheckReport automatic = checked(growing_stack(true), 1, 6);
  const CriterionResult& standing = row_named(automatic, tool::stands_criterion);
  CAPTURE(standing.reason);
  CHECK(tool::mean_of(standing.ours) == 1);
  CHECK(standing.verdict == Agreement::expected);
  CHECK(automatic.solvers[0].failed == 0);
}

TEST_CASE("smaller gaps of joints than Box2D's are no difference", "[verifier][crosscheck][analytic]") {
  Scene scene = empty_scene(Precision::f32);
  scene.bodies = {ground(), unit_box({0, 3})};
  scene.joints.emplace_back();
  tool::CrosscheckLayout layout = tool::make_layout(scene);
  tool::CrosscheckRun small, large;
  small.places.resize(2);
  large.places.resize(2);
  large.joint_gap = 0.1;
  const auto verdict = [&](const tool::CrosscheckRun& ours, const tool::CrosscheckRun& box2d) {
    for (const CriterionResult& row : tool::compare_runs(layout, {ours}, {box2d}, 0))
      if (row.criterion == tool::joints_criterion) return row.verdict;
    return Agreement::not_applicable;
  };
  CHECK(verdict(small, large) == Agreement::agree);
  CHECK(verdict(large, small) == Agreement::differ);
}

TEST_CASE("ground that slopes in ours carries a part by friction", "[verifier][crosscheck][analytic]") {
  Scene scene = empty_scene(Precision::f32);
  scene.bodies = {ground(), unit_box({0, 0.5})};
  const tool::CrosscheckLayout layout = tool::make_layout(scene);
  tool::CrosscheckRun level;
  level.places.resize(2);
  level.ground_force = 1;
  level.ground_is_flat = true;
  tool::CrosscheckRun leaning = level;
  leaning.ground_force = 0.9;
  const auto verdict = [&] {
    const std::vector<CriterionResult> rows = tool::compare_runs(layout, {leaning}, {level}, 0);
    return std::find_if(rows.begin(), rows.end(),
                        [](const auto& row) { return row.criterion == "weight on the ground"; })
        ->verdict;
  };
  CHECK(verdict() == Agreement::differ);
  leaning.ground_is_flat = false;
  CHECK(verdict() == Agreement::not_applicable);
}

TEST_CASE("a pile that leans over its edge by skins is expected to rest elsewhere",
          "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  // Bricks of 2 m, each farther out by .93 of the largest stable overhang. Their skins tip the pile.
  Scene scene = empty_scene(Precision::f32);
  scene.bodies.push_back(ground());
  const int count = 5;
  double x = 0;
  std::vector<Body> bricks;
  for (int above = 1; above <= count; ++above) {
    bricks.push_back(body_of(box_shape(1, 0.25), {x, 1.25 + 0.5 * (count - above)}));
    x -= 0.93 / above;
  }
  scene.bodies.push_back(body_of(box_shape(1, 0.5), {x, 0.5}));
  scene.bodies.back().type = BodyType::static_body;
  scene.bodies.insert(scene.bodies.end(), bricks.rbegin(), bricks.rend());
  const tool::CrosscheckReport report = checked(scene, 2, 10);
  CHECK(row_named(report, tool::stands_criterion).verdict == Agreement::agree);
  const CriterionResult& place = row_named(report, tool::place_criterion);
  CAPTURE(place.reason, place.difference);
  CHECK(place.difference > place.tolerance);
  CHECK(place.verdict == Agreement::expected);
  CHECK(place.reason.find("--match-skin") != std::string::npos);
}

TEST_CASE("a box that toppled down a slope has toppled, however it lies", "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  // tan(1 rad) = 1.56: a square tips over its edge beyond 1, and the friction of 1.6 keeps it from sliding.
  Scene scene = empty_scene(Precision::f32);
  scene.bodies.push_back(ground());
  scene.bodies.push_back(body_of(box_shape(30, 1), {std::sin(1.0), 6 - std::cos(1.0)}));
  scene.bodies.back().type = BodyType::static_body;
  scene.bodies.back().angle = 1;
  scene.bodies.push_back(unit_box({-0.5 * std::sin(1.0), 6 + 0.5 * std::cos(1.0)}));
  scene.bodies.back().angle = 1;
  for (Body& body : scene.bodies) body.shapes[0].material.friction = 1.6;
  const tool::CrosscheckReport report = checked(scene, 3, 10);
  const CriterionResult& tilt = row_named(report, "largest tilt");
  CHECK(tool::mean_of(tilt.ours) == 45);
  CHECK(tool::mean_of(tilt.box2d) == 45);
}

TEST_CASE("thin boxes are compared with a thinner skin, and the report counts them",
          "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(!tool::box2d_version().empty(), "a build without Box2D");
  Scene scene = empty_scene(Precision::f32);
  scene.bodies.push_back(ground());
  for (int i = 0; i < 3; ++i) scene.bodies.push_back(body_of(box_shape(0.2, 0.01), {0, 0.01 + 0.02 * i}));
  tool::CrosscheckOptions options;
  options.seed_count = 2;
  options.seconds = 2;
  const auto report = tool::crosscheck(scene, options);
  REQUIRE(report.has_value());
  CHECK(report->thin_shape_count == 3);
  CHECK(row_named(*report, tool::stands_criterion).verdict == Agreement::agree);
}

}  // namespace ticktrue::test
