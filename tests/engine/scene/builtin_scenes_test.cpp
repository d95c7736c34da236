// The built-in scenes: each is valid for all values of its parameters, and matches its description.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/builtin_scenes.h"

#include <set>

#include "base/hash.h"
#include "engine/json/number_text.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "engine/scene/scene_binary.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;
using Catch::Matchers::Contains;

namespace {

Scene made(const std::string& text) {
  auto scene = make_builtin_scene(text);
  if (!scene) FAIL(scene.error().message);
  return *std::move(scene);
}

std::string refusal(const std::string& text) {
  const auto scene = make_builtin_scene(text);
  if (scene) return "accepted";
  return scene.error().message;
}

std::size_t dynamic_count(const Scene& scene) {
  std::size_t count = 0;
  for (const Body& body : scene.bodies) count += body.type == BodyType::dynamic_body ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("every built-in scene is valid, and at both ends of each parameter", "[engine][builtin_scenes][analytic]") {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const std::string name(builtin.name);
    CAPTURE(name);
    CHECK(refusal(name) == "accepted");
    CHECK_FALSE(builtin.summary.empty());
    for (const SceneParameter& parameter : builtin.parameters) {
      CAPTURE(parameter.name);
      for (const double value : {parameter.min, parameter.max, parameter.value})
        CHECK(refusal(name + "?" + std::string(parameter.name) + "=" + number_text(value)) == "accepted");
      CHECK_THAT(refusal(name + "?" + std::string(parameter.name) + "=" + number_text(parameter.max * 1.5 + 1)),
                 Contains(": out of range: found ") && Contains(std::string(parameter.name)));
      CHECK_THAT(refusal(name + "?" + std::string(parameter.name) + "=nan"), Contains("not a number"));
      if (parameter.whole)
        CHECK_THAT(refusal(name + "?" + std::string(parameter.name) + "=0.5"),
                   Contains("out of range: found 0.5, expected a whole number"));
    }
  }
}

TEST_CASE("every built-in scene takes the settings by name", "[engine][builtin_scenes][analytic]") {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const std::string name(builtin.name);
    CAPTURE(name);
    for (const auto& row : precisions)
      CHECK(made(name + "?precision=" + std::string(row.name)).settings.precision == row.kind);
    for (const auto& row : broad_phases)
      CHECK(made(name + "?broad_phase=" + std::string(row.name)).settings.broad_phase == row.kind);
    for (const auto& row : integrators)
      if (row.carries_constraints)
        CHECK(made(name + "?integrator=" + std::string(row.name)).settings.integrator == row.kind);
    CHECK(made(name + "?dt=1/120").settings.dt == 1.0 / 120);
    CHECK(made(name + "?dt=0.01").settings.dt == 0.01);
    CHECK(made(name + "?substeps=7").settings.substeps == 7);
    CHECK(made(name + "?locate_impacts=1").settings.locate_impacts);
    CHECK_FALSE(made(name + "?continuous=0").settings.continuous);
    CHECK_FALSE(made(name + "?sleep=0").settings.sleep);
    CHECK(made(name + "?gravity=3.5").gravity == Point{0, -3.5});
    CHECK(made(name + "?solver=tgs_soft&substeps=2").settings.substeps == 2);
    if (!made(name).joints.empty() || name == "shapes" || name == "sensors") {
      CHECK_THAT(refusal(name + "?solver=impulse"), Contains(": impulse "));
      continue;
    }
    CHECK(made(name + "?solver=impulse").settings.substeps == 1);
    CHECK_THAT(refusal(name + "?solver=impulse&substeps=4"), Contains("impulse does not substep: found 4, expected 1"));
  }
  CHECK(made("stack?substeps=auto").settings.auto_substeps == AutoSubsteps{});
  CHECK(made("stack?sleep=1").settings.sleep == SleepSettings{});
  CHECK_FALSE(made("stack?sleep=0").settings.sleep);
  CHECK_THAT(refusal("stack?sleep=yes"), Contains("sleep: not a number: found \"yes\", expected a whole number 0..1"));
  CHECK(bits_of(made("slide?gravity=0").gravity.y) == 0);
}

TEST_CASE("what is not a built-in scene or a parameter of it is refused with what there is",
          "[engine][builtin_scenes][analytic]") {
  CHECK_THAT(refusal("piramid"),
             Contains("no built-in scene has this name: found \"piramid\", expected thesis, stack, "));
  CHECK_THAT(refusal(""), Contains("no built-in scene has this name"));
  CHECK_THAT(refusal("stack?box=3"),
             Contains("unknown parameter: found \"box\", expected boxes, size, jitter, seed, precision"));
  CHECK_THAT(refusal("stack?boxes"), Contains("parameter without value: found \"boxes\""));
  CHECK_THAT(refusal("stack?boxes=3&boxes=4"), Contains("parameter given twice: found \"boxes\""));
  CHECK_THAT(refusal("stack?boxes=3x"), Contains("boxes: not a number: found \"3x\", expected a whole number 1..1000"));
  CHECK_THAT(refusal("stack?boxes="), Contains("not a number"));
  CHECK_THAT(refusal("stack?boxes=0x10"), Contains("not a number"));
  CHECK_THAT(refusal("stack?boxes=1e300"), Contains("out of range"));
  CHECK_THAT(refusal("stack?dt=1/0"), Contains("not a number"));
  CHECK_THAT(refusal("stack?dt=0"), Contains("dt: out of range: found 0"));
  CHECK_THAT(refusal("stack?precision=f16"), Contains("precision: unknown: found \"f16\", expected f32 or f64"));
  CHECK_THAT(refusal("stack?solver=free_flight"), Contains("free_flight solves no contacts"));
  CHECK_THAT(refusal("stack?boxes=5&" + std::string(300, 'x')), Contains("name too long"));
  CHECK(refusal("stack?") == "accepted");
  CHECK(make_builtin_scene("x").error().code == ErrorCode::usage);
}

TEST_CASE("large_pyramid is the benchmark's: 5,050 touching boxes centred over the floor",
          "[engine][builtin_scenes][analytic]") {
  const Scene scene = made("large_pyramid");
  REQUIRE(scene.bodies.size() == 5051);
  CHECK(scene.bodies[0].shapes[0].half_size == Point{100, 1});
  CHECK(scene.bodies[0].position == Point{0, -1});
  CHECK(scene.bodies[1].position == Point{-49.5, 0.5});
  CHECK(scene.bodies[100].position == Point{49.5, 0.5});
  CHECK(scene.bodies[101].position == Point{-49, 1.5});
  CHECK(scene.bodies[5050].position == Point{0, 99.5});
  Scene same = made("pyramid?base=100");
  same.name = scene.name;
  CHECK(same == scene);
  CHECK(dynamic_count(made("pyramid")) == 210);
}

TEST_CASE("many_pyramids is the benchmark's: 22,000 boxes on 20 floors", "[engine][builtin_scenes][analytic]") {
  const Scene scene = made("many_pyramids");
  REQUIRE(dynamic_count(scene) == 22000);
  REQUIRE(scene.bodies.size() == 22001);
  REQUIRE(scene.bodies[0].shapes.size() == 20);
  for (std::size_t row = 0; row < 20; ++row) {
    const Shape& floor = scene.bodies[0].shapes[row];
    CHECK(floor.center.y + floor.half_size.y == 11.0 * static_cast<double>(row));
    CHECK(floor.half_size.x == 110);
  }
  CHECK(scene.bodies[1].position == Point{-109, 0.5});
  CHECK(scene.bodies[55].position == Point{-104.5, 9.5});
  CHECK(scene.bodies[56].position == Point{-98, 0.5});
  CHECK(scene.bodies[55 * 20 + 1].position == Point{-109, 11.5});
}

TEST_CASE("the thesis scene has the thesis' measures", "[engine][builtin_scenes][analytic]") {
  const Scene scene = made("thesis");
  REQUIRE(scene.bodies.size() == 5);
  CHECK(dynamic_count(scene) == 0);
  CHECK(scene.gravity == Point{0, -9.81});
  CHECK(scene.settings.dt == 0.0167);
  CHECK(scene.settings.friction_mix == MixRule::minimum);
  CHECK(scene.settings.restitution_mix == MixRule::minimum);
  CHECK(scene.settings.solver == SolverKind::tgs_soft);
  CHECK(made("thesis?solver=impulse").settings.restitution_threshold == 0);
  CHECK(scene.bodies[0].position == Point{8, 12});
  CHECK(scene.bodies[0].shapes[0].radius == 2);
  CHECK(scene.bodies[0].shapes[0].material == Material{0.5, 1});
  CHECK(scene.bodies[2].position.y + scene.bodies[2].shapes[0].half_size.y == Approx(1.8));
  REQUIRE(scene.prototypes.size() == 3);
  for (const Body& prototype : scene.prototypes) CHECK(body_mass(prototype).mass == 1);
  CHECK(scene.prototypes[0].shapes[0].radius == 0.6);
  CHECK(scene.prototypes[1].shapes[0].half_size == Point{1, 1});
  REQUIRE(scene.prototypes[2].shapes[0].vertices.size() == 6);
  for (const Point& p : scene.prototypes[2].shapes[0].vertices) {
    const double radius = __builtin_sqrt(p.x * p.x + p.y * p.y);
    CHECK(radius >= 0.8);
    CHECK(radius <= 2.0);
  }
  CHECK(scene.spawned_max == 150u);
  CHECK(scene.pointer->spawns == std::vector<std::string>{"circle", "box", "polygon"});
  CHECK(scene.pointer->window == Bounds{{0, 0}, {32, 24}});
}

TEST_CASE("circles has nothing but circles, projectile nothing to hit, slide its friction",
          "[engine][builtin_scenes][analytic]") {
  for (const Body& body : made("circles").bodies)
    for (const Shape& shape : body.shapes) CHECK(shape.kind == ShapeKind::circle);
  CHECK(dynamic_count(made("circles?columns=7&rows=3")) == 21);
  const Scene projectile = made("projectile");
  CHECK_FALSE(can_collide(projectile));
  CHECK(projectile.settings.solver == SolverKind::free_flight);
  CHECK(projectile.bodies[0].velocity == Point{3, 7});
  const Scene slide = made("slide");
  CHECK(slide.bodies[1].velocity == Point{10, 0});
  CHECK(slide.bodies[0].shapes[0].material.friction == 0.5);
  CHECK(slide.bodies[1].shapes[0].material.friction == 0.5);
  const Scene billiards = made("billiards");
  CHECK(dynamic_count(billiards) == 16);
  CHECK(billiards.bodies.size() == 16);
  CHECK(made("billiards?walls=1").bodies.size() == 20);
  CHECK(billiards.gravity == Point{0, 0});
}

TEST_CASE("no two bodies of mixed_pile or circles overlap at the start", "[engine][builtin_scenes][analytic]") {
  for (const char* text :
       {"mixed_pile?bodies=300&seed=9", "circles?columns=12&rows=12&jitter=0.1", "billiards?gap=0"}) {
    const Scene scene = made(text);
    const auto reach = [](const Body& body) {
      double r = 0;
      for (const Shape& shape : body.shapes) {
        const double s =
            shape.kind == ShapeKind::circle ? shape.radius
            : shape.kind == ShapeKind::box
                ? __builtin_sqrt(shape.half_size.x * shape.half_size.x + shape.half_size.y * shape.half_size.y)
                : 0.6 * (1 + 1e-12);
        r = s > r ? s : r;
      }
      return r;
    };
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
      for (std::size_t j = i + 1; j < scene.bodies.size(); ++j) {
        const Body &a = scene.bodies[i], &b = scene.bodies[j];
        if (a.type != BodyType::dynamic_body || b.type != BodyType::dynamic_body) continue;
        const double x = a.position.x - b.position.x, y = a.position.y - b.position.y;
        const double distance = __builtin_sqrt(x * x + y * y);
        if (distance < (reach(a) + reach(b)) * (1 - 1e-12)) FAIL(text << ": bodies " << i << " and " << j);
      }
  }
}

TEST_CASE("anchors of built-in joints meet at the start", "[engine][builtin_scenes][joints][analytic]") {
  for (const char* text : {"chain", "chain?links=7&angle=1.2", "bridge", "joint_grid", "joint_grid?columns=20",
                           "tumbler", "spinner", "rain"}) {
    const Scene scene = made(text);
    CAPTURE(text);
    double worst = 0;
    for (const Joint& joint : scene.joints) {
      const auto place = [&](std::uint32_t index, Point anchor) {
        const Body& body = scene.bodies[index];
        const double c = sin_cos(body.angle).cos, s = sin_cos(body.angle).sin;
        return Point{body.position.x + c * anchor.x - s * anchor.y, body.position.y + s * anchor.x + c * anchor.y};
      };
      const Point a = place(joint.body_a, joint.anchor_a), b = place(joint.body_b, joint.anchor_b);
      const double gap = (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
      worst = gap > worst ? gap : worst;
    }
    CHECK(worst < 1e-24);
  }
  const Scene grid = made("joint_grid");
  CHECK(grid.joints.size() == 19800 - 6);  // no joint between two pegs
  CHECK(dynamic_count(grid) == 10000 - 7);
  CHECK(grid.bodies[4700].type == BodyType::static_body);
  CHECK(grid.bodies[5300].type == BodyType::static_body);
}

TEST_CASE("the timed scenes have the measures of Box2D's benchmarks", "[engine][builtin_scenes][analytic]") {
  const Scene tumbler = made("tumbler");
  CHECK(dynamic_count(tumbler) == 2026);
  CHECK(tumbler.bodies[1].shapes.size() == 4);
  CHECK(tumbler.bodies[2].position == Point{-9, 1});
  CHECK(tumbler.bodies[3].position.x - tumbler.bodies[2].position.x == Approx(0.4));
  CHECK(tumbler.joints[0].motor->speed == Approx(25 * pi / 180));
  const Scene smash = made("smash");
  CHECK(dynamic_count(smash) == 9601);
  CHECK(smash.bodies[1].position == Point{30, -16});
  CHECK(smash.bodies[9600].position.x == Approx(30 + 119 * 0.4));
  CHECK(smash.bodies[9600].position.y == Approx(-16 + 79 * 0.4));
  CHECK(smash.gravity == Point{0, 0});
  const Scene spinner = made("spinner");
  CHECK(dynamic_count(spinner) == 6077);
  CHECK(spinner.bodies[0].shapes[0].vertices.size() == 360);
  CHECK(spinner.bodies[2].position == Point{-23, 2});
  CHECK(spinner.bodies[2 + 92].position == Point{-23, 2.5});
  const Scene rain = made("rain");
  CHECK(dynamic_count(rain) == 11000);
  CHECK(rain.joints.size() == 10000);
  std::size_t floor_count = 0;
  for (const Body& body : rain.bodies) floor_count += body.type == BodyType::static_body ? body.shapes.size() : 0;
  CHECK(floor_count == 5 * 501);
  CHECK(rain.bodies[5].position == Point{-125 + 250.0 / 80, 40.95});
  CHECK(dynamic_count(made("thesis_mix?bodies=1000")) == 1000);
  for (const Body& body : made("gas").bodies) CHECK(body.shapes[0].material.friction == 0);
}

TEST_CASE("a seed gives the same world every time, another seed another world",
          "[engine][builtin_scenes][determinism]") {
  CHECK(made("mixed_pile?seed=5") == made("mixed_pile?seed=5"));
  Scene other = made("mixed_pile?seed=6");
  other.name = "mixed_pile?seed=5";
  CHECK_FALSE(other == made("mixed_pile?seed=5"));
  CHECK(made("stack?jitter=0.1&seed=3").bodies[4].position.x != made("stack?jitter=0.1&seed=4").bodies[4].position.x);
}

TEST_CASE("automatic substeps are the default where a scene says so, and a number of substeps replaces them",
          "[engine][builtin_scenes]") {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const std::string name(builtin.name);
    CAPTURE(name);
    const Settings chosen = made(name).settings;
    CHECK(chosen.auto_substeps.has_value() == (builtin.automatic_budget > 0));
    CHECK(chosen.substep_budget == builtin.automatic_budget);
    Settings automatic = made(name + "?substeps=auto").settings;
    if (info_of(solvers, automatic.solver).substeps) CHECK(automatic.substep_budget == default_substep_budget);
    automatic.substep_budget = builtin.automatic_budget;
    if (builtin.automatic_budget > 0) CHECK(automatic == chosen);
    const Settings fixed = made(name + "?substeps=4").settings;
    CHECK(fixed.substeps == 4);
    CHECK_FALSE(fixed.auto_substeps.has_value());
    CHECK(fixed.joints == JointSolverKind::iterative);
    CHECK(fixed.substep_budget == 0);
    const auto without = make_builtin_scene(name + "?solver=pgs");
    if (without.has_value()) CHECK(without->settings.substeps == 1);
    if (without.has_value()) CHECK_FALSE(without->settings.auto_substeps.has_value());
  }
}

TEST_CASE("built-in scenes have the pinned bits that every platform must build", "[engine][builtin_scenes][golden]") {
  std::string got;
  for (const BuiltinScene& builtin : builtin_scenes())
    got += std::string(builtin.name) + " " + hex64(hash64(encode_scene(made(std::string(builtin.name))))) + "\n";
  CHECK(got == R"(thesis cd76ec308f0d9557
stack b74021181fb155c2
pyramid ead4ced9f38d743b
large_pyramid cfda595a2fd461a9
many_pyramids e417c9bdb9fd1d3e
circles 137be1c652260ae9
mixed_pile ef9f001e2c39ae5c
projectile d996cab508eb6dae
billiards 72719fd2433a72c0
slide ac744a9847f58ae8
shapes d0a6cd41e83d6e5f
sensors 8010a8b1af5c5721
pendulum 5f2596054040750a
chain 97fe9389ef9dc975
bridge f852f6ccf9426651
joint_grid 7ea07c04b37d811d
card_house 42e5d290efba3714
thesis_mix 213bcd66bc7064fa
tumbler b67c377d635fc6dc
smash 09fe9583ac4a69ad
spinner 72da70a024886f0f
rain 87ef82f0f0d35bdf
gas e78f8a2a374b2f7a
loose 6d7f4ebe227c8635
resting 3f4d4172d8b88137
)");
}
