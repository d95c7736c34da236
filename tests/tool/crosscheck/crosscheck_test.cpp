// The cross-check: criteria on hand-made runs, the Box2D peer, and both engines end to end.
// SPDX-License-Identifier: MIT
#include "tool/crosscheck/crosscheck.h"

#include <cmath>
#include <limits>

#include "tests/support/box2d.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tool/study/worlds.h"

using namespace ticktrue;
using namespace ticktrue::test;
using tool::Agreement;
using tool::CriterionResult;
using tool::CrosscheckLayout;
using tool::CrosscheckMeasure;
using tool::CrosscheckRun;

namespace {

engine::BodyReport report_of(const Scene& scene, std::uint32_t id) {
  engine::BodyReport report;
  report.id = id;
  report.type = scene.bodies[id].type;
  report.center = report.origin = scene.bodies[id].position;
  report.angle = scene.bodies[id].angle;
  report.mass = report.type == BodyType::dynamic_body ? 1 : 0;
  report.inertia = report.type == BodyType::dynamic_body ? 1.0 / 6 : 0;
  return report;
}

std::vector<engine::BodyReport> reports_of(const Scene& scene) {
  std::vector<engine::BodyReport> reports;
  for (std::uint32_t id = 0; id < scene.bodies.size(); ++id) reports.push_back(report_of(scene, id));
  return reports;
}

// Contacts of a stack at rest: box i lies on box i - 1, box 1 on the ground, `gap` apart.
std::vector<engine::ContactReport> stack_contacts(int count, double gap) {
  std::vector<engine::ContactReport> contacts;
  for (int i = 1; i <= count; ++i) {
    engine::ContactReport contact;
    contact.body_a = static_cast<std::uint32_t>(i - 1);
    contact.body_b = static_cast<std::uint32_t>(i);
    contact.normal = {0, 1};
    contact.point_count = 2;
    for (int p = 0; p < 2; ++p) {
      contact.point[p] = {p == 0 ? -0.5 : 0.5, i - 1.0};
      contact.separation[p] = gap;
      contact.normal_force[p] = 10.0 * (count - i + 1) / 2;
    }
    contacts.push_back(contact);
  }
  return contacts;
}

// A run whose bodies stay at rest at the given places.
CrosscheckRun run_of(const CrosscheckLayout& layout, const std::vector<engine::BodyReport>& bodies,
                     const std::vector<engine::ContactReport>& contacts, double contact_hertz = 0) {
  CrosscheckMeasure measure(layout, contact_hertz, 0.02);
  measure.add(0.1, bodies, nullptr);
  measure.add(20, bodies, &contacts);
  return measure.finish();
}

// A stack of `count` boxes with the same gap below each.
CrosscheckRun stack_run(const CrosscheckLayout& layout, int count, double gap, double contact_hertz = 0) {
  Scene scene = stack_scene(count);
  for (int i = 1; i <= count; ++i) scene.bodies[static_cast<std::size_t>(i)].position.y += gap * i;
  return run_of(layout, reports_of(scene), stack_contacts(count, gap), contact_hertz);
}

const CriterionResult& row_of(const std::vector<CriterionResult>& rows, const std::string& criterion) {
  for (const CriterionResult& row : rows)
    if (row.criterion == criterion) return row;
  FAIL("no criterion " << criterion);
  return rows.front();
}

Agreement verdict_of(const std::vector<CriterionResult>& rows, const std::string& criterion) {
  return row_of(rows, criterion).verdict;
}

constexpr double skin = 0.02;

}  // namespace

TEST_CASE("the layout of a stack is one column of placed boxes, each upon the one before",
          "[verifier][crosscheck][analytic]") {
  const CrosscheckLayout layout = tool::make_layout(stack_scene(5, 0.1));
  CHECK(layout.placed_count == 5);
  CHECK(layout.is_structure);
  CHECK(layout.is_column);
  CHECK(layout.bodies[5].supports == std::vector<std::uint32_t>{4});
  CHECK(layout.bodies[5].drop == Approx(0.5));  // five gaps close
  CHECK(layout.height == Approx(4.5));
}

TEST_CASE("the layout of a pyramid has each box on two and a row for each level", "[verifier][crosscheck][analytic]") {
  const CrosscheckLayout layout = tool::make_layout(pyramid_scene(4));
  CHECK(layout.placed_count == 10);
  CHECK_FALSE(layout.is_column);
  CHECK(layout.body_rows.size() == 3);  // the top box has no neighbour
  CHECK(layout.bodies[10].supports.size() == 2);
}

TEST_CASE("boxes in the air or moving are no structure", "[verifier][crosscheck][analytic]") {
  Scene falling = stack_scene(1);
  falling.bodies[1].position.y = 3;
  CHECK_FALSE(tool::make_layout(falling).is_structure);
  CHECK_FALSE(tool::make_layout(slide_scene(10, 0.5)).is_structure);
  Scene hanging = stack_scene(3, 0.1);  // the lower bodies lie on nothing themselves
  hanging.bodies[0].position.y -= 3;
  CHECK(tool::make_layout(hanging).placed_count == 0);
}

TEST_CASE("a box on a slope is placed, and up is against gravity whichever way that is",
          "[verifier][crosscheck][analytic]") {
  Scene slope = stack_scene(1);
  for (Body& body : slope.bodies) {
    const engine::SinCos turn = engine::sin_cos(0.3);
    body.position = {turn.cos * body.position.x - turn.sin * body.position.y,
                     turn.sin * body.position.x + turn.cos * body.position.y};
    body.angle = 0.3;
  }
  const CrosscheckLayout tilted = tool::make_layout(slope);
  CHECK(tilted.placed_count == 1);
  CHECK(tilted.bodies[1].drop == Approx(0).margin(1e-9));

  Scene ceiling = stack_scene(3);
  for (Body& body : ceiling.bodies) body.position.y = -body.position.y;
  ceiling.gravity = {0, 10};
  CHECK(tool::make_layout(ceiling).is_column);
}

TEST_CASE("a tower that leans within the limits stands, one that fell does not", "[verifier][crosscheck][analytic]") {
  const Scene scene = stack_scene(3);
  const CrosscheckLayout layout = tool::make_layout(scene);
  std::vector<engine::BodyReport> leaning = reports_of(scene);
  for (int i = 1; i <= 3; ++i) {
    leaning[static_cast<std::size_t>(i)].center.x += 0.1 * i;
    leaning[static_cast<std::size_t>(i)].angle = -0.1;
  }
  const CrosscheckRun lean = run_of(layout, leaning, stack_contacts(3, 0));
  CHECK(lean.standing_count == 3);
  CHECK(lean.stood);
  CHECK(lean.tilt_deg == Approx(5.73).margin(0.01));

  std::vector<engine::BodyReport> fallen = reports_of(scene);
  fallen[3].center = {2, 0.5};
  fallen[3].angle = 1.57;
  const CrosscheckRun fall = run_of(layout, fallen, {});
  CHECK(fall.standing_count == 2);
  CHECK_FALSE(fall.stood);
  CHECK(fall.order == Approx(0.5));
  CHECK(fall.tilt_deg == 45);
}

TEST_CASE("a body that has left the world does not stand", "[verifier][crosscheck][analytic]") {
  const Scene scene = stack_scene(2);
  const CrosscheckLayout layout = tool::make_layout(scene);
  std::vector<engine::BodyReport> bodies = reports_of(scene);
  bodies.pop_back();
  const CrosscheckRun run = run_of(layout, bodies, {});
  CHECK(run.standing_count == 1);
  CHECK(run.tilt_deg == 45);
  CHECK(run.order == 0);
}

TEST_CASE("equal runs agree on every criterion that applies", "[verifier][crosscheck][equivalence]") {
  const CrosscheckLayout layout = tool::make_layout(stack_scene(10));
  const std::vector<CrosscheckRun> runs(5, stack_run(layout, 10, 0));
  const std::vector<CriterionResult> rows = tool::compare_runs(layout, runs, runs, skin);
  CHECK(rows.size() == 12);
  for (const CriterionResult& row : rows) {
    CAPTURE(row.criterion);
    const bool applies = row.criterion != tool::distance_criterion;  // all bodies rest
    CHECK(row.verdict == (applies ? Agreement::agree : Agreement::not_applicable));
  }
}

TEST_CASE("a top that is higher by Box2D's skin is expected, one that is higher by more differs",
          "[verifier][crosscheck][analytic]") {
  const CrosscheckLayout layout = tool::make_layout(stack_scene(10));
  const std::vector<CrosscheckRun> ours(2, stack_run(layout, 10, -0.003));
  const std::vector<CrosscheckRun> skinned(2, stack_run(layout, 10, 0.015));
  const std::vector<CriterionResult> rows = tool::compare_runs(layout, ours, skinned, skin);
  CHECK(verdict_of(rows, "top height") == Agreement::expected);
  CHECK(row_of(rows, "top height").reason.find("skin") != std::string::npos);

  const std::vector<CrosscheckRun> floating(2, stack_run(layout, 10, 0.03));  // thicker than any skin
  CHECK(verdict_of(tool::compare_runs(layout, ours, floating, skin), "top height") == Agreement::differ);

  std::vector<CrosscheckRun> lifted = skinned;
  for (CrosscheckRun& run : lifted) run.top += 0.2;  // more than its gaps explain
  CHECK(verdict_of(tool::compare_runs(layout, ours, lifted, skin), "top height") == Agreement::differ);
}

TEST_CASE("a deep overlap is expected only as far as soft contacts give under their load",
          "[verifier][crosscheck][analytic]") {
  const CrosscheckLayout layout = tool::make_layout(stack_scene(10));
  const std::vector<CrosscheckRun> box2d(2, stack_run(layout, 10, 0.015));
  // Force / (w^2 * effective mass) for 90 N between two boxes: 45 N per point, 0.2 kg.
  const double hertz = 13;
  const double stiffness = std::pow(2 * engine::pi * hertz, 2) * 0.2;
  REQUIRE(45 / stiffness > 0.03);
  std::vector<engine::ContactReport> contacts = stack_contacts(10, 0);
  for (engine::ContactReport& contact : contacts)
    for (int i = 0; i < 2; ++i) contact.separation[i] = -contact.normal_force[i] / stiffness;
  contacts.erase(contacts.begin());  // contacts with the ground are stiffer
  const std::vector<engine::BodyReport> bodies = reports_of(stack_scene(10));
  const std::vector<CrosscheckRun> soft(2, run_of(layout, bodies, contacts, hertz));
  CHECK(verdict_of(tool::compare_runs(layout, soft, box2d, skin), "deepest overlap") == Agreement::expected);
  const std::vector<CrosscheckRun> hard(2, run_of(layout, bodies, contacts, 0));
  CHECK(verdict_of(tool::compare_runs(layout, hard, box2d, skin), "deepest overlap") == Agreement::differ);
}

TEST_CASE("joints that gape differ from joints that hold", "[verifier][crosscheck][analytic]") {
  Scene scene = worlds::chain(engine::Precision::f32, 4, {1, 0}, 1);
  const CrosscheckLayout layout = tool::make_layout(scene);
  const std::vector<CrosscheckRun> hold(2, run_of(layout, reports_of(scene), {}));
  CHECK(verdict_of(tool::compare_runs(layout, hold, hold, skin), "joints hold") == Agreement::agree);
  scene.bodies.back().position.x += 0.1 * layout.size;
  const std::vector<CrosscheckRun> gape(2, run_of(layout, reports_of(scene), {}));
  const CriterionResult row = row_of(tool::compare_runs(layout, gape, hold, skin), "joints hold");
  CHECK(row.verdict == Agreement::differ);
  CHECK(row.ours.front() == Approx(10));
  CHECK(row.box2d.front() == Approx(0).margin(1e-9));
  const CrosscheckLayout stack = tool::make_layout(stack_scene(2));
  const std::vector<CrosscheckRun> stands(2, stack_run(stack, 2, 0));
  for (const CriterionResult& each : tool::compare_runs(stack, stands, stands, skin))
    CHECK(each.criterion != "joints hold");
}

TEST_CASE("a stack that fell differs from one that stands on what a person would see",
          "[verifier][crosscheck][analytic]") {
  const Scene scene = stack_scene(10);
  const CrosscheckLayout layout = tool::make_layout(scene);
  std::vector<engine::BodyReport> fallen = reports_of(scene);
  for (std::size_t i = 1; i < fallen.size(); ++i) {
    fallen[i].center = {1.2 * static_cast<double>(i), 0.5};
    fallen[i].angle = 1.57;
  }
  const std::vector<CrosscheckRun> ours(5, run_of(layout, fallen, {}));
  const std::vector<CrosscheckRun> box2d(5, stack_run(layout, 10, 0.015));
  const std::vector<CriterionResult> rows = tool::compare_runs(layout, ours, box2d, skin);
  for (const char* criterion : {"stands or falls", "standing bodies", "top height", "order upwards", "largest tilt",
                                "slides or holds", "weights in the stack", "weight on the ground"}) {
    CAPTURE(criterion);
    CHECK(verdict_of(rows, criterion) == Agreement::differ);
  }
}

TEST_CASE("one seed of five may go the other way, two may not", "[verifier][crosscheck][analytic]") {
  const CrosscheckLayout layout = tool::make_layout(stack_scene(3));
  const std::vector<CrosscheckRun> box2d(5, stack_run(layout, 3, 0));
  std::vector<CrosscheckRun> ours = box2d;
  ours[0].stood = false;
  CHECK(verdict_of(tool::compare_runs(layout, ours, box2d, skin), "stands or falls") == Agreement::agree);
  ours[1].stood = false;
  CHECK(verdict_of(tool::compare_runs(layout, ours, box2d, skin), "stands or falls") == Agreement::differ);
}

TEST_CASE("what never comes to rest differs from what does", "[verifier][crosscheck][analytic]") {
  const Scene scene = stack_scene(1);
  const CrosscheckLayout layout = tool::make_layout(scene);
  std::vector<engine::BodyReport> bodies = reports_of(scene);
  const CrosscheckRun resting = run_of(layout, bodies, stack_contacts(1, 0));
  CHECK(resting.settle_s == 0);
  bodies[1].velocity.x = 1;
  const CrosscheckRun moving = run_of(layout, bodies, stack_contacts(1, 0));
  CHECK(std::isinf(moving.settle_s));
  CHECK(verdict_of(tool::compare_runs(layout, {moving}, {resting}, skin), "comes to rest") == Agreement::differ);
  CHECK(verdict_of(tool::compare_runs(layout, {moving}, {moving}, skin), "comes to rest") == Agreement::agree);
}

TEST_CASE("a slide is compared by its distance, box by box in order", "[verifier][crosscheck][analytic]") {
  Scene scene = slide_scene(10, 0.5);
  const CrosscheckLayout layout = tool::make_layout(scene);
  const auto slid = [&](double distance) {
    std::vector<engine::BodyReport> bodies = reports_of(scene);
    bodies[1].center.x += distance;
    return std::vector<CrosscheckRun>(3, run_of(layout, bodies, stack_contacts(1, 0)));
  };
  CHECK(verdict_of(tool::compare_runs(layout, slid(9.98), slid(9.92), skin), "slides or holds") == Agreement::agree);
  CHECK(verdict_of(tool::compare_runs(layout, slid(9.5), slid(9.92), skin), "slides or holds") == Agreement::differ);
}

TEST_CASE("rows that Box2D's skin pushed apart are expected, a pyramid that spreads is not",
          "[verifier][crosscheck][analytic]") {
  const Scene scene = pyramid_scene(12);
  const CrosscheckLayout layout = tool::make_layout(scene);
  const auto spread = [&](double gap) {
    std::vector<engine::BodyReport> bodies = reports_of(scene);
    for (const std::vector<std::uint32_t>& row : layout.body_rows)
      for (std::size_t i = 0; i < row.size(); ++i)
        bodies[row[i]].center.x += gap * (static_cast<double>(i) - 0.5 * static_cast<double>(row.size() - 1));
    return std::vector<CrosscheckRun>(2, run_of(layout, bodies, stack_contacts(0, 0)));
  };
  const std::vector<CrosscheckRun> ours = spread(0);
  CHECK(verdict_of(tool::compare_runs(layout, ours, spread(0.02), skin), "slides or holds") == Agreement::agree);
  const std::vector<CriterionResult> rows = tool::compare_runs(layout, spread(0.1), ours, skin);
  CHECK(verdict_of(rows, "slides or holds") == Agreement::differ);
}

TEST_CASE("a non-finite state differs, whatever else it does", "[verifier][crosscheck][analytic]") {
  const Scene scene = stack_scene(2);
  const CrosscheckLayout layout = tool::make_layout(scene);
  std::vector<engine::BodyReport> bodies = reports_of(scene);
  const CrosscheckRun good = run_of(layout, bodies, stack_contacts(2, 0));
  bodies[2].velocity.y = std::numeric_limits<double>::quiet_NaN();
  const CrosscheckRun bad = run_of(layout, bodies, stack_contacts(2, 0));
  const std::vector<CriterionResult> rows = tool::compare_runs(layout, {bad}, {good}, skin);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].verdict == Agreement::differ);
}

TEST_CASE("jitter shifts bodies by at most a millimetre per metre, seed 0 by nothing",
          "[verifier][crosscheck][analytic]") {
  const Scene scene = stack_scene(10);
  const CrosscheckLayout layout = tool::make_layout(scene);
  CHECK(tool::jittered_scene(scene, layout, 0) == scene);
  const Scene jittered = tool::jittered_scene(scene, layout, 1);
  CHECK_FALSE(jittered == tool::jittered_scene(scene, layout, 2));
  CHECK(jittered.bodies[0] == scene.bodies[0]);
  double largest = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    largest = std::max(largest, std::fabs(jittered.bodies[i].position.x - scene.bodies[i].position.x));
    CHECK(jittered.bodies[i].position.y == scene.bodies[i].position.y);
  }
  CHECK(largest <= 0.001);
  CHECK(largest > 0.0003);
}

TEST_CASE("tgs_soft agrees with Box2D on a three-box stack", "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  tool::CrosscheckOptions options;
  options.seconds = 3;
  options.seed_count = 3;
  const auto report = tool::crosscheck(stack_scene(3, 0, Precision::f32), options);
  REQUIRE(report);
  REQUIRE(report->solvers.size() == 1);
  CAPTURE(report->solvers[0].summary);
  CHECK(report->solvers[0].failed == 0);
  CHECK(report->solvers[0].passed >= 8);
  CHECK(report->solvers[0].stood == 3);
  CHECK(report->box2d_stood == 3);
}

TEST_CASE("tgs_soft agrees with Box2D on a ten-box stack, the thesis' impulse solver does not: its stack falls",
          "[verifier][crosscheck][equivalence]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  tool::CrosscheckOptions options;
  options.solvers = {SolverKind::tgs_soft, SolverKind::impulse};
  const auto report = tool::crosscheck(stack_scene(10, 0, Precision::f32), options);
  REQUIRE(report);
  REQUIRE(report->solvers.size() == 2);
  CAPTURE(report->solvers[0].summary, report->solvers[1].summary);
  CHECK(report->solvers[0].failed == 0);
  CHECK(report->solvers[0].stood == 5);
  CHECK(report->solvers[1].failed > 5);
  CHECK(report->solvers[1].stood == 0);
}

TEST_CASE("the report does not depend on the number of threads", "[verifier][crosscheck][determinism]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  tool::CrosscheckOptions options;
  options.seconds = 1;
  options.seed_count = 3;
  const Scene scene = stack_scene(4, 0.05, Precision::f32);
  const auto one = tool::crosscheck(scene, options);
  options.thread_count = 3;
  const auto three = tool::crosscheck(scene, options);
  REQUIRE(one);
  REQUIRE(three);
  REQUIRE(one->rows.size() == three->rows.size());
  for (std::size_t i = 0; i < one->rows.size(); ++i) {
    CHECK(one->rows[i].ours == three->rows[i].ours);
    CHECK(one->rows[i].box2d == three->rows[i].box2d);
    CHECK(one->rows[i].verdict == three->rows[i].verdict);
  }
}

TEST_CASE("what Box2D cannot do is not applicable, with the reason", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  tool::CrosscheckOptions options;
  options.seconds = 1;
  Scene nonagon = stack_scene(0);
  nonagon.bodies.push_back(body_of(polygon_shape(regular_polygon(9, 1)), {0, 2}));
  Scene fast = stack_scene(1);
  fast.bodies[1].velocity.x = 200;
  for (const Scene& scene : {nonagon, fast, stack_scene(0)}) {
    const auto report = tool::crosscheck(scene, options);
    REQUIRE(report);
    REQUIRE(report->rows.size() == 1);
    CHECK(report->rows[0].verdict == Agreement::not_applicable);
    CHECK_FALSE(report->rows[0].reason.empty());
    CHECK(report->solvers[0].failed == 0);
  }
}

TEST_CASE("seeds and seconds out of range are refused", "[verifier][crosscheck][analytic]") {
  SKIP_UNLESS(has_box2d(), "a build without Box2D");
  tool::CrosscheckOptions options;
  options.seed_count = 0;
  CHECK_FALSE(tool::crosscheck(stack_scene(1), options));
  options.seed_count = 1;
  options.seconds = 0;
  CHECK_FALSE(tool::crosscheck(stack_scene(1), options));
}

// ---- Single bodies ----

namespace {

// Two boxes on the ground. Box 1 ends `off` from its start. Box 2 ends with a speed, `way` from its start.
std::vector<CrosscheckRun> ended(const CrosscheckLayout& layout, const Scene& scene, std::vector<double> offs,
                                 double way = 0) {
  std::vector<CrosscheckRun> runs;
  for (const double off : offs) {
    std::vector<engine::BodyReport> bodies = reports_of(scene);
    bodies[1].center.x += off;
    bodies[2].center.x += way;
    bodies[2].velocity.x = way > 0 ? 3 : 0;
    runs.push_back(run_of(layout, bodies, {}));
  }
  return runs;
}

Scene two_boxes() {
  Scene scene = stack_scene(1);
  scene.bodies.push_back(unit_box({20, 0.5}));
  return scene;
}

}  // namespace

TEST_CASE("what rests in both rests within 2 cm or differs, unless Box2D's seeds scatter or smaller steps move it",
          "[verifier][crosscheck][analytic]") {
  const Scene scene = two_boxes();
  const CrosscheckLayout layout = tool::make_layout(scene);
  const auto runs = [&](std::vector<double> offs) { return ended(layout, scene, std::move(offs)); };
  const auto place = [&](const auto& ours, const auto& box2d, const std::vector<std::vector<CrosscheckRun>>& finer,
                         const std::vector<std::vector<CrosscheckRun>>& own_finer) {
    return tool::compare_bodies(layout, ours, box2d, finer, own_finer, skin)[0];
  };
  CHECK(place(runs({0, 0}), runs({0.019, 0.019}), {}, {}).verdict == Agreement::agree);
  CHECK(place(runs({0, 0}), runs({0.021, 0.021}), {}, {}).verdict == Agreement::differ);
  CHECK(place(runs({0, 0}), runs({0.021, 0.021}), {}, {}).unit == "m, 2 of 2");
  // Box2D's own seeds are 3 cm apart. Box 1 has no certain place, so only box 2 is judged.
  CHECK(place(runs({0, 0}), runs({0.1, 0.13}), {}, {}).verdict == Agreement::agree);
  CHECK(place(runs({0, 0}), runs({0.1, 0.13}), {}, {}).unit == "m, 1 of 2");
  // The spread of the engine's own runs does not widen the tolerance.
  CHECK(place(runs({0, 0.1}), runs({0, 0}), {}, {}).verdict == Agreement::differ);
  CHECK(place(runs({0, 0}), runs({0.1, 0.1}), {runs({0.01, 0.01})}, {}).verdict == Agreement::expected);
  CHECK(place(runs({0, 0}), runs({0.1, 0.1}), {runs({0.2, 0.2})}, {}).unit == "m, 1 of 2");
  CHECK(place(runs({0, 0}), runs({0.1, 0.1}), {runs({0.1, 0.1})}, {runs({0, 0})}).verdict == Agreement::differ);
  CHECK(place(runs({0, 0}), runs({0.1, 0.1}), {runs({0.1, 0.1})}, {runs({0.05, 0.05})}).unit == "m, 1 of 2");
}

TEST_CASE("what still moves has come as far within 10 % or 1 m", "[verifier][crosscheck][analytic]") {
  const Scene scene = two_boxes();
  const CrosscheckLayout layout = tool::make_layout(scene);
  const auto way = [&](double own, double theirs) {
    return tool::compare_bodies(layout, ended(layout, scene, {0, 0}, own), ended(layout, scene, {0, 0}, theirs), {}, {},
                                skin)[1];
  };
  CHECK(way(30, 32.9).verdict == Agreement::agree);
  CHECK(way(30, 34).verdict == Agreement::differ);
  CHECK(way(1, 1.9).verdict == Agreement::agree);
  CHECK(way(1, 2.1).verdict == Agreement::differ);
  CHECK(way(0, 0).verdict == Agreement::not_applicable);
}

// ---- Joints of the peer ----
