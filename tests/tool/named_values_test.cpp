// Values of bodies, contacts and joints by name, and their CSV lines.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <string>

#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"
#include "tool/expression/csv_columns.h"

namespace ticktrue::test {
namespace {

using verifier::CsvColumns;
using verifier::find_named_value;
using verifier::NamedValues;

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

TEST_CASE("lines of CSV have a cell for each column, an empty one for what is gone", "[verifier][expression]") {
  Scene scene = stack_scene(2);
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
