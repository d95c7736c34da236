// Values of bodies, contacts and joints by name, and their CSV lines.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/joints.h"
#include "tests/support/scenes.h"
#include "tool/expression/csv_columns.h"

namespace ticktrue::test {
namespace {

using tool::CsvColumns;
using tool::find_named_value;
using tool::NamedValues;

double value_of(const engine::Engine& engine, const std::string& name) {
  const auto named = find_named_value(name);
  REQUIRE(named.has_value());
  return NamedValues(engine).of(*named);
}

/// The scene after two seconds.
std::unique_ptr<engine::Engine> settled(const Scene& scene) {
  auto engine = make_engine_or_fail(scene);
  run_ticks(*engine, 120);
  return engine;
}

std::string refusal(const std::string& name) {
  const auto made = CsvColumns::make({name}, stack_scene(2), "--columns");
  REQUIRE_FALSE(made.has_value());
  return made.error().message;
}

}  // namespace

TEST_CASE("forces of a stack at rest are the weights on them", "[verifier][expression][analytic]") {
  for (const auto& precision : engine::precisions) {
    Scene scene = stack_scene(3);
    scene.settings.precision = precision.kind;
    const auto engine = settled(scene);
    CHECK(value_of(*engine, "contacts.0.1.normal_force") == Approx(30).epsilon(0.01));
    CHECK(value_of(*engine, "contacts.1.0.normal_force") == Approx(30).epsilon(0.01));
    CHECK(value_of(*engine, "contacts.2.3.normal_force") == Approx(10).epsilon(0.01));
    CHECK(value_of(*engine, "contacts.0.1.points") == 2);
    CHECK(value_of(*engine, "contacts.0.3.normal_force") == 0);
    CHECK(std::isnan(value_of(*engine, "contacts.0.9.normal_force")));
    CHECK(value_of(*engine, "bodies.3.y") == Approx(2.5).margin(0.02));
    CHECK(std::isnan(value_of(*engine, "bodies.4.y")));
    CHECK(std::isnan(value_of(*engine, "joints.0.force")));
  }
}

TEST_CASE("friction holds a box on a slope with its weight along it", "[verifier][expression][analytic]") {
  Scene scene = empty_scene(Precision::f64);
  const double angle = 0.2;
  scene.gravity = {10 * std::sin(angle), -10 * std::cos(angle)};
  scene.bodies = {ground(), unit_box({0, 0.5})};
  for (Body& body : scene.bodies) body.shapes[0].material.friction = 0.6;
  const auto engine = settled(scene);
  CHECK(std::fabs(value_of(*engine, "contacts.0.1.friction_force")) == Approx(10 * std::sin(angle)).epsilon(0.02));
  CHECK(value_of(*engine, "contacts.0.1.normal_force") == Approx(10 * std::cos(angle)).epsilon(0.02));
}

TEST_CASE("friction above 0 pushes the upper body to +x, whichever has the smaller id",
          "[verifier][expression][analytic]") {
  for (const bool is_ground_first : {true, false})
    for (const double speed : {3.0, -3.0}) {
      CAPTURE(is_ground_first, speed);
      Scene scene = empty_scene(Precision::f64);
      scene.gravity = {0, -10};
      scene.bodies = {unit_box({0, 0.5})};
      scene.bodies[0].velocity = {speed, 0};
      scene.bodies.insert(is_ground_first ? scene.bodies.begin() : scene.bodies.end(), ground());
      for (Body& body : scene.bodies) body.shapes[0].material.friction = 0.5;
      auto engine = make_engine_or_fail(scene);
      run_ticks(*engine, 10);
      const double wanted = speed > 0 ? -5 : 5;  // m mu g, against the motion of the box of 1 kg
      CHECK(value_of(*engine, "contacts.0.1.friction_force") == Approx(wanted).epsilon(0.02));
      CHECK(value_of(*engine, "contacts.1.0.friction_force") == Approx(wanted).epsilon(0.02));
    }
}

TEST_CASE("the force of a joint has no sign: what hangs and what stands on a rod weigh alike",
          "[verifier][expression][analytic]") {
  for (const double gravity : {-10.0, 10.0}) {
    Scene scene = empty_scene(Precision::f64);
    scene.gravity = {0, gravity};
    scene.bodies = {unit_box({0, 0}), body_of(box_shape(0.1, 0.1), {0, 2}, BodyType::static_body)};
    engine::Joint rod;
    rod.kind = engine::JointKind::distance;
    rod.body_a = 1;
    rod.body_b = 0;
    rod.length = 2;
    scene.joints = {rod};
    const auto engine = settled(scene);
    CHECK(value_of(*engine, "joints.0.force") == Approx(10).epsilon(0.02));
  }
}

TEST_CASE("the CSV says which bodies sleep, and in a scene without sleep none does",
          "[verifier][expression][analytic]") {
  for (const bool sleeps : {true, false}) {
    CAPTURE(sleeps);
    Scene scene = stack_scene(2);
    scene.settings.sleep.reset();
    if (sleeps) scene.settings.sleep.emplace();
    auto engine = make_engine_or_fail(scene);
    const auto columns = CsvColumns::make({"asleep", "bodies.*.asleep"}, scene, "--columns");
    REQUIRE(columns.has_value());
    CHECK(columns->head() == "tick,time,asleep,bodies.0.asleep,bodies.1.asleep,bodies.2.asleep\n");
    CHECK(value_of(*engine, "bodies.1.asleep") == 0);
    CHECK(columns->row(*engine, 0) == "0,0,0,0,0,0\n");
    run_ticks(*engine, 300);
    const std::string row = columns->row(*engine, 300);
    CHECK(row.substr(row.size() - 8) == (sleeps ? "2,0,1,1\n" : "0,0,0,0\n"));
    CHECK(std::isnan(value_of(*engine, "bodies.3.asleep")));
  }
}

TEST_CASE("a joint holds what hangs from it", "[verifier][expression][analytic]") {
  Scene scene = empty_scene(Precision::f64);
  scene.bodies = {unit_box({0, 0})};
  engine::Joint joint;
  joint.kind = engine::JointKind::weld;
  joint.body_b = 0;
  scene.bodies.push_back(body_of(box_shape(0.1, 0.1), {0, 1}, BodyType::static_body));
  joint.body_a = 1;
  joint.anchor_a = {0, -0.5};
  joint.anchor_b = {0, 0.5};
  scene.joints = {joint};
  const auto engine = settled(scene);
  CHECK(value_of(*engine, "joints.0.force") == Approx(10).epsilon(0.02));
  CHECK(value_of(*engine, "joints.0.gap") < 0.01);
  CHECK(std::isnan(value_of(*engine, "joints.1.force")));
}

TEST_CASE("names that mean nothing are refused with those that do", "[verifier][expression][hostile]") {
  for (const char* name :
       {"bodies.", "bodies.x", "bodies.3", "bodies.3.", "bodies.3.z", "bodies.3.x.y", "contacts.3.overlap",
        "contacts.3.4", "joints.-1.gap", "joints.99999999999.gap", "bodies.+1.x", "", "energy_start"}) {
    CAPTURE(name);
    CHECK_FALSE(find_named_value(name).has_value());
    CHECK(refusal(name).find("expected the name of a value") != std::string::npos);
  }
}

TEST_CASE("bodies and joints have the names that the scene gives them", "[verifier][expression]") {
  Scene scene = stack_scene(2);
  scene.bodies[0].name = "floor";
  scene.bodies[2].name = "top_2";
  engine::Joint weld = joint_of(engine::JointKind::weld, 1, 2);
  weld.name = "glue";
  weld.anchor_a = {0, 0.5};
  weld.anchor_b = {0, -0.5};
  scene.joints = {weld};
  const auto engine = settled(scene);
  for (const auto& [by_name, by_number] : {std::pair{"bodies.top_2.y", "bodies.2.y"},
                                           {"contacts.floor.1.normal_force", "contacts.0.1.normal_force"},
                                           {"contacts.1.floor.points", "contacts.0.1.points"},
                                           {"joints.glue.force", "joints.0.force"}}) {
    CAPTURE(by_name);
    CHECK(value_of(*engine, by_name) == value_of(*engine, by_number));
    const auto columns = CsvColumns::make({by_name}, scene, "--columns");
    REQUIRE(columns.has_value());
    CHECK(columns->names() == std::vector<std::string>{by_name});
    CHECK(columns->values(*engine)[0] == value_of(*engine, by_number));
  }
  const auto refused = CsvColumns::make({"bodies.top.y"}, scene, "--columns");
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().message == "--columns: bodies.top.y: found no body \"top\"");
  CHECK(refused.error().hint == "names: floor, top_2");
  CHECK(refusal("joints.glue.gap") == "--columns: joints.glue.gap: found no joint \"glue\"");
  CHECK(std::isnan(value_of(*engine, "bodies.top.y")));
}

TEST_CASE("bodies and joints that a scene cannot have are refused with how many it has",
          "[verifier][expression][hostile]") {
  CHECK(refusal("bodies.9.x") == "--columns: bodies.9.x: found no body 9: the scene has 3, expected 0..2");
  CHECK(refusal("contacts.0.3.points").find("found no body 3: the scene has 3") != std::string::npos);
  CHECK(refusal("contacts.4.0.points").find("found no body 4: the scene has 3") != std::string::npos);
  CHECK(refusal("contacts.1.1.points").find("found body 1 twice") != std::string::npos);
  CHECK(refusal("joints.4.force") == "--columns: joints.4.force: found no joint 4: the scene has none");
  const auto takes = [](const Scene& scene, const std::string& name) {
    return CsvColumns::make({name}, scene, "--columns").has_value();
  };
  Scene scene = stack_scene(2);
  scene.prototypes = {unit_box({0, 0})};
  CHECK_FALSE(takes(scene, "bodies.9.x"));
  scene.inputs = {engine::InputKind::spawn};
  CHECK(takes(scene, "bodies.9.x"));
  CHECK(takes(scene, "contacts.0.9.points"));
  CHECK_FALSE(takes(scene, "joints.0.gap"));
  scene.inputs = {engine::InputKind::press};
  scene.pointer.emplace();
  CHECK_FALSE(takes(scene, "bodies.9.x"));
  scene.pointer->spawns = {"ball"};
  CHECK(takes(scene, "bodies.9.x"));
}

TEST_CASE("tick and time are the first two columns once, however often they are named", "[verifier][expression]") {
  const Scene scene = stack_scene(2);
  const auto columns = CsvColumns::make({"tick", "energy", "time", "time"}, scene, "--columns");
  REQUIRE(columns.has_value());
  CHECK(columns->head() == "tick,time,energy\n");
  const auto engine = make_engine_or_fail(scene);
  const std::string row = columns->row(*engine, 5);
  CHECK(std::count(row.begin(), row.end(), ',') == 2);
  CHECK(CsvColumns::make({"time"}, scene, "--columns")->head() == "tick,time\n");
}

TEST_CASE("lines of CSV have a cell for each column, an empty one for what is gone", "[verifier][expression]") {
  Scene scene = stack_scene(2);
  scene.prototypes = {unit_box({0, 0})};
  scene.prototypes[0].name = "crate";
  scene.inputs = {engine::InputKind::spawn};
  const auto columns = CsvColumns::make({"energy", "bodies.*.y", "bodies.7.y", "contacts"}, scene, "--columns");
  REQUIRE(columns.has_value());
  CHECK(columns->head() == "tick,time,energy,bodies.0.y,bodies.1.y,bodies.2.y,bodies.7.y,contacts\n");
  const auto engine = make_engine_or_fail(scene);
  const std::string row = columns->row(*engine, 5);
  CHECK(row.substr(0, 4) == "5,0,");
  CHECK(row.find(",-1,0.5,1.5,,") != std::string::npos);
  const auto all = CsvColumns::make({}, scene, "--columns");
  REQUIRE(all.has_value());
  CHECK(all->head().find(",joint_gap,") != std::string::npos);
}

}  // namespace ticktrue::test
