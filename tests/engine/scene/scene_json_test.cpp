// Scenes and inputs as JSON: exact round trips, and errors with place, found value and allowed values.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_json.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "base/limits.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/scene_binary.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tests/support/schema_keys.h"

using namespace ticktrue;
using namespace ticktrue::engine;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using nlohmann::json;
using test::keys_of;
using test::reader_keys;

namespace {

std::string file_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

const std::filesystem::path scenes_folder = std::filesystem::path(TICKTRUE_SOURCE_DIR) / "scenes";

std::string json_refusal(const std::string& text) {
  const auto scene = parse_scene(text, "s.json");
  if (scene) return "accepted";
  return scene.error().message + (scene.error().hint.empty() ? "" : "\n" + scene.error().hint);
}

/// The refusal of a scene with one body, given as JSON.
std::string body_refusal(const std::string& body) {
  return json_refusal("{\"bodies\": [" + body + "]}");
}
std::string shape_refusal(const std::string& shape) {
  return body_refusal("{\"shapes\": [" + shape + "]}");
}

/// A scene of two dynamic bodies, "a" at (1, 2) turned by 0.5 rad and one without name, and a list of one element.
std::string with_two_bodies(const std::string& list, const std::string& element) {
  const std::string disc = "\"shapes\":[{\"type\":\"circle\",\"radius\":1}]}";
  return "{\"" + list + "\":[" + element + "],\"bodies\":[{\"name\":\"a\",\"position\":[1,2],\"angle\":0.5," + disc +
         ",{" + disc + "]}";
}
std::string joint_refusal(const std::string& joint) {
  return json_refusal(with_two_bodies("joints", joint));
}
std::string force_refusal(const std::string& force) {
  return json_refusal(with_two_bodies("forces", force));
}

std::string input_refusal(const std::string& line) {
  static const Scene scene = *make_builtin_scene("thesis");
  const auto input = parse_input(scene, line, "f.jsonl:7");
  if (input) return "accepted";
  return input.error().message;
}

}  // namespace

TEST_CASE("every built-in scene comes back from its JSON with the same bits", "[engine][scene_json][equivalence]") {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    const std::string name(builtin.name);
    CAPTURE(name);
    const Scene scene = *make_builtin_scene(name);
    const auto back = parse_scene(print_scene(scene), "s.json");
    if (!back) FAIL(back.error().message);
    CHECK(*back == scene);
    CHECK(encode_scene(*back) == encode_scene(scene));
  }
}

TEST_CASE("a scene with everything in it comes back from its JSON with the same bits",
          "[engine][scene_json][equivalence]") {
  const Scene scene = test::everything_scene();
  const auto back = parse_scene(print_scene(scene), "s.json");
  if (!back) FAIL(back.error().message);
  CHECK(*back == scene);
  CHECK(encode_scene(*back) == encode_scene(scene));
  // Without names, indices refer to bodies.
  Scene nameless = scene;
  for (Body& body : nameless.bodies) body.name = "";
  const auto again = parse_scene(print_scene(nameless), "s.json");
  if (!again) FAIL(again.error().message);
  CHECK(encode_scene(*again) == encode_scene(nameless));
}

TEST_CASE("joints and forces refer to bodies by index or name, wherever these stand in the text",
          "[engine][scene_json][analytic]") {
  const auto scene = parse_scene(
      with_two_bodies("joints", R"({"type":"friction","body_a":1,"body_b":"a","force_max":1,"torque_max":0})"), "s");
  if (!scene) FAIL(scene.error().message);
  CHECK(scene->joints[0].body_a == 1);
  CHECK(scene->joints[0].body_b == 0);
  const auto spring =
      parse_scene(with_two_bodies("forces", R"({"type":"spring","body":1,"other":"a","stiffness":3})"), "s");
  if (!spring) FAIL(spring.error().message);
  CHECK(spring->forces[0].body == 1u);
  CHECK(spring->forces[0].other == 0u);

  CHECK(joint_refusal(R"({"type":"revolute","body_a":"b","body_b":1})") ==
        "s.json: joints[0].body_a: no body of the scene has this name: found \"b\", expected a");
  CHECK(joint_refusal(R"({"type":"revolute","body_a":0,"body_b":""})") ==
        "s.json: joints[0].body_b: no body of the scene has this name: found \"\", expected a");
  CHECK(force_refusal(R"({"type":"spring","body":0,"other":"b","stiffness":3})") ==
        "s.json: forces[0].other: no body of the scene has this name: found \"b\", expected a");
  CHECK(joint_refusal(R"({"type":"revolute","body_a":true,"body_b":1})") ==
        "s.json: joints[0].body_a: wrong type: found true, expected the index or the name of a body");
  CHECK(joint_refusal(R"({"type":"revolute","body_a":0,"body_b":2})") ==
        "s.json: joints[0].body_b: no body has this index: found 2, expected 0..1");
  CHECK_THAT(joint_refusal(R"({"type":"revolute","body_a":-1,"body_b":2})"),
             StartsWith("s.json: joints[0].body_a: must be a whole number in range: found -1"));
}

TEST_CASE("gears refer to joints by index or name", "[engine][scene_json][analytic]") {
  const auto joints = [](const std::string& a, const std::string& b) {
    return with_two_bodies("joints", R"({"type":"revolute","name":"pin","body_a":0,"body_b":1},)"
                                     R"({"type":"prismatic","body_a":1,"body_b":0,"axis":[1,0]},)"
                                     R"({"type":"gear","joint_a":)" +
                                         a + R"(,"joint_b":)" + b + R"(,"ratio":-2})");
  };
  const auto scene = parse_scene(joints("\"pin\"", "1"), "s");
  if (!scene) FAIL(scene.error().message);
  CHECK(scene->joints[2].joint_a == 0);
  CHECK(scene->joints[2].joint_b == 1);
  CHECK_THAT(print_scene(*scene), Contains(R"("joint_a": "pin", "joint_b": 1, "ratio": -2)"));
  CHECK(json_refusal(joints("0", "\"axle\"")) ==
        "s.json: joints[2].joint_b: no joint of the scene has this name: found \"axle\", expected pin");
  CHECK(json_refusal(joints("true", "0")) ==
        "s.json: joints[2].joint_a: wrong type: found true, expected the index or the name of a joint");
}

TEST_CASE("an anchor in world coordinates becomes one in each body's frame", "[engine][scene_json][analytic]") {
  // Body a is at (1, 2) with an angle of 0.5 rad. The point (2, 2) is 1 m away, rotated back into the body's frame.
  const auto scene =
      parse_scene(with_two_bodies("joints", R"({"type":"revolute","body_a":"a","body_b":1,"anchor":[2,2]})"), "s");
  if (!scene) FAIL(scene.error().message);
  const Joint& joint = scene->joints[0];
  CHECK(joint.anchor_a.x == Approx(std::cos(0.5)).epsilon(1e-14));
  CHECK(joint.anchor_a.y == Approx(-std::sin(0.5)).epsilon(1e-14));
  CHECK(joint.anchor_b == Point{2, 2});
  const auto pull = parse_scene(
      with_two_bodies("joints", R"({"type":"target","body_b":"a","anchor":[1,2],"point":[5,6],"force_max":9})"), "s");
  if (!pull) FAIL(pull.error().message);
  CHECK(pull->joints[0].anchor_a == Point{});
  CHECK(pull->joints[0].anchor_b == Point{});
  CHECK(pull->joints[0].offset == Point{5, 6});
  CHECK_THAT(
      joint_refusal(R"({"type":"weld","body_a":0,"body_b":1,"anchor":[2,2],"anchor_b":[0,0]})"),
      StartsWith("s.json: joints[0].anchor: replaces the anchors in the bodies' frames: found anchor_b as well"));
  CHECK_THAT(joint_refusal(R"({"type":"distance","body_a":0,"body_b":1,"length":1,"anchor":[2,2]})"),
             StartsWith("s.json: joints[0]: unknown key: found \"anchor\""));
}

TEST_CASE("springs, limits and motors are refused where their form is wrong", "[engine][scene_json][corruption]") {
  const auto revolute = [](const std::string& keys) {
    return joint_refusal(R"({"type":"revolute","body_a":0,"body_b":1,)" + keys + "}");
  };
  CHECK(revolute(R"("spring":{"hertz":2})") == "accepted");
  CHECK(revolute(R"("spring":{"damping":2})") == "accepted");
  CHECK(revolute(R"("spring":{})") ==
        "s.json: joints[0].spring: must be one of two forms: found no key, expected hertz and damping_ratio, or "
        "stiffness and damping");
  CHECK_THAT(revolute(R"("spring":{"hertz":2,"damping":1})"),
             StartsWith("s.json: joints[0].spring: must be one of two forms: found keys of both"));
  CHECK(revolute(R"("limits":[1])") ==
        "s.json: joints[0].limits: wrong type: found an array of 1, expected [lower, upper]");
  CHECK(revolute(R"("limits":[1,"x"])") == "s.json: joints[0].limits[1]: wrong type: found \"x\", expected a number");
  CHECK_THAT(revolute(R"("motor":{"speed":1})"), StartsWith("s.json: joints[0].motor.force_max: missing"));
  CHECK_THAT(revolute(R"("axis":[1,0])"), StartsWith("s.json: joints[0]: unknown key: found \"axis\""));
  CHECK_THAT(joint_refusal("{\"type\":\"hinge\"}"),
             StartsWith("s.json: joints[0].type: unknown: found \"hinge\", expected revolute, prismatic, "));
  CHECK_THAT(force_refusal("{}"), StartsWith("s.json: forces[0].type: missing"));
  CHECK(force_refusal("3") == "s.json: forces[0]: wrong type: found 3, expected an object");
  CHECK(json_refusal("{\"joints\":3}") == "s.json: joints: wrong type: found 3, expected an array");
}

TEST_CASE("substeps, sleep and clock have a short and a long form", "[engine][scene_json][analytic]") {
  const auto settings = [](const std::string& keys) {
    const auto scene = parse_scene(
        "{\"settings\":{" + keys + "},\"bodies\":[{\"shapes\":[{\"type\":\"circle\",\"radius\":1}]}]}", "s");
    if (!scene) FAIL(scene.error().message);
    return scene->settings;
  };
  CHECK(settings(R"("substeps":"auto")").auto_substeps == AutoSubsteps{});
  CHECK(settings(R"("substeps":"auto")").substeps == 4);
  CHECK(settings(R"("substeps":{"least":2,"target_error":0.01,"most":64})").auto_substeps == AutoSubsteps{0.01, 64});
  CHECK(settings(R"("substeps":{"least":2})").substeps == 2);
  CHECK(settings(R"("sleep":true)").sleep == SleepSettings{});
  CHECK_FALSE(settings(R"("sleep":false)").sleep);
  CHECK(settings(R"("sleep":{"after":2})").sleep == SleepSettings{2, 0.05});
  CHECK(settings(R"("clock":"adaptive")").clock.kind == ClockKind::adaptive);
  CHECK(settings(R"("clock":{"type":"variable","dt_max":0.5})").clock.dt_max == 0.5);
  CHECK(
      json_refusal(R"({"settings":{"substeps":true}})") ==
      R"(s.json: settings.substeps: wrong type: found true, expected a number, "auto" or {"least", "target_error", "most"})");
  CHECK(json_refusal(R"({"settings":{"sleep":1}})") ==
        R"(s.json: settings.sleep: wrong type: found 1, expected true, false or {"after", "speed_max"})");
  CHECK_THAT(json_refusal(R"({"settings":{"clock":"fast"}})"),
             StartsWith("s.json: settings.clock: unknown: found \"fast\", expected fixed, semi_fixed, "));
  CHECK_THAT(json_refusal(R"({"settings":{"clock":{"type":"fixed","dt_max":1}}})"),
             StartsWith("s.json: settings.clock: unknown key: found \"dt_max\", expected type"));
}

TEST_CASE("dt may be a quotient, divided once", "[engine][scene_json][analytic]") {
  const auto dt_of = [](const std::string& dt) {
    const auto scene = parse_scene(
        "{\"settings\":{\"dt\":" + dt + "},\"bodies\":[{\"shapes\":[{\"type\":\"circle\",\"radius\":1}]}]}", "s");
    if (!scene) FAIL(scene.error().message);
    return scene->settings.dt;
  };
  CHECK(dt_of("\"1/60\"") == 1.0 / 60);
  CHECK(dt_of("\"1001/60000\"") == 1001.0 / 60000);
  CHECK(dt_of("0.0167") == 0.0167);
  for (const char* bad : {"\"1/\"", "\"/60\"", "\"1/0\"", "\"1/-60\"", "\"one\"", "\"1/60/2\"", "\"1/nan\"", "\"\""})
    CHECK_THAT(json_refusal("{\"settings\":{\"dt\":" + std::string(bad) + "}}"),
               StartsWith("s.json: settings.dt: not a quotient: found "));
}

TEST_CASE("a solver without substeps has one by default", "[engine][scene_json][analytic]") {
  const std::string bodies = ",\"bodies\":[{\"shapes\":[{\"type\":\"circle\",\"radius\":1}]}]}";
  CHECK(parse_scene("{\"settings\":{\"solver\":\"impulse\"}" + bodies, "s")->settings.substeps == 1);
  CHECK(parse_scene("{\"settings\":{}" + bodies, "s")->settings.substeps == 4);
  CHECK_THAT(json_refusal("{\"settings\":{\"substeps\":4,\"solver\":\"impulse\"}" + bodies),
             Contains("impulse does not substep"));
}

TEST_CASE("broken JSON is refused with line and column", "[engine][scene_json][corruption]") {
  CHECK_THAT(json_refusal(""), StartsWith("s.json:1:0: broken JSON: ") || StartsWith("s.json:1:1: broken JSON: "));
  CHECK_THAT(json_refusal("{\n  \"name\": \"x\",\n  \"gravity\": [0, -10,]\n}"),
             StartsWith("s.json:3:22: broken JSON: syntax error"));
  CHECK_THAT(json_refusal("{\"gravity\": [0, NaN]}"),
             StartsWith("s.json:1:17: broken JSON: ") && Contains("JSON has no NaN, no Infinity"));
  CHECK_THAT(json_refusal("{\"gravity\": [0, -Infinity]}"), StartsWith("s.json:1:18: broken JSON: "));
  CHECK_THAT(json_refusal("{\"gravity\": [0, 1e999]}"), StartsWith("s.json:1:21: broken JSON: number overflow"));
  CHECK_THAT(json_refusal("{'name': 1}"), StartsWith("s.json:1:2: broken JSON: "));
  CHECK_THAT(json_refusal("{} {}"), StartsWith("s.json:1:4: broken JSON: "));
  CHECK_THAT(json_refusal("{\"name\": \"\xff\"}"), StartsWith("s.json:1:11: broken JSON: "));
  CHECK_THAT(json_refusal("// comment\n{}"), Contains("no comments"));
  CHECK_THAT(json_refusal("{\"name\": \"" + std::string(100'000, 'x')),
             StartsWith("s.json:1:") && Contains("broken JSON"));
  CHECK(json_refusal("{\"name\": \"" + std::string(100'000, 'x')).size() < 300);
}

TEST_CASE("a scene cut anywhere is refused, never a crash", "[engine][scene_json][corruption]") {
  std::string whole = print_scene(*make_builtin_scene("thesis"));
  while (whole.back() != '}') whole.pop_back();
  for (std::size_t size = 0; size < whole.size(); ++size) REQUIRE(json_refusal(whole.substr(0, size)) != "accepted");
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x15);
    const auto scene = parse_scene(changed, "s.json");
    if (scene) REQUIRE(check_scene(*scene, "s.json"));
  }
}

TEST_CASE("unknown keys are refused with those that are known and the nearest of them",
          "[engine][scene_json][corruption]") {
  CHECK(json_refusal("{\"gravty\": [0, 1]}") ==
        "s.json: unknown key: found \"gravty\", expected $schema, name, gravity, settings, bodies, joints, forces, "
        "prototypes, inputs, pointer, bounds or spawned_max\ndid you mean gravity?");
  CHECK_THAT(body_refusal("{\"shape\": []}"),
             StartsWith("s.json: bodies[0]: unknown key: found \"shape\"") && Contains("did you mean shapes?"));
  CHECK_THAT(
      shape_refusal("{\"type\":\"box\",\"half_size\":[1,1],\"points\":2}"),
      StartsWith(
          "s.json: bodies[0].shapes[0]: unknown key: found \"points\", expected type, half_size, center, angle"));
  CHECK_THAT(json_refusal("{\"settings\":{\"sub_steps\":2}}"), Contains("did you mean substeps?"));
  CHECK_THAT(json_refusal("{\"completely_different\":2}"), !Contains("did you mean"));
}

TEST_CASE("a key that is given twice is refused", "[engine][scene_json][corruption]") {
  CHECK_THAT(json_refusal("{\"name\":\"a\",\"name\":\"b\"}"),
             StartsWith("s.json: key given twice: found \"name\" again"));
  CHECK_THAT(body_refusal("{\"angle\":1,\"angle\":1,\"shapes\":[]}"),
             StartsWith("s.json: bodies[0]: key given twice: found \"angle\""));
  CHECK_THAT(shape_refusal("{\"type\":\"circle\",\"radius\":1,\"radius\":2}"),
             StartsWith("s.json: bodies[0].shapes[0]: key given twice: found \"radius\""));
  CHECK_THAT(json_refusal("{\"bodies\":[],\"bodies\":[]}"), StartsWith("s.json: key given twice"));
}

TEST_CASE("wrong types and missing keys are refused with their place", "[engine][scene_json][corruption]") {
  CHECK(json_refusal("[]") == "s.json: wrong type: found an array of 0, expected an object");
  CHECK(json_refusal("3") == "s.json: wrong type: found 3, expected an object");
  CHECK(json_refusal("{\"bodies\": 3}") == "s.json: bodies: wrong type: found 3, expected an array");
  CHECK(json_refusal("{\"bodies\": [3]}") == "s.json: bodies[0]: wrong type: found 3, expected an object");
  CHECK(json_refusal("{\"gravity\": 9.81}") == "s.json: gravity: wrong type: found 9.81, expected [x, y]");
  CHECK(json_refusal("{\"gravity\": [0, 1, 2]}") ==
        "s.json: gravity: wrong type: found an array of 3, expected [x, y]");
  CHECK(json_refusal("{\"gravity\": [0, \"down\"]}") ==
        "s.json: gravity[1]: wrong type: found \"down\", expected a number");
  CHECK(json_refusal("{\"name\": null}") == "s.json: name: wrong type: found null, expected a string");
  CHECK_THAT(json_refusal("{\"settings\":{\"substeps\":2.5}}"),
             StartsWith("s.json: settings.substeps: must be a whole number in range: found 2.5, expected 1..256"));
  CHECK_THAT(
      json_refusal("{\"settings\":{\"solver\":\"tgs\"}}"),
      StartsWith("s.json: settings.solver: unknown: found \"tgs\", expected free_flight, impulse, tgs_soft or pgs"));
  CHECK_THAT(json_refusal("{\"settings\":{\"solver\":\"tgs_sofd\"}}"), Contains("did you mean tgs_soft?"));
  CHECK_THAT(json_refusal("{\"inputs\":[\"jump\"]}"),
             StartsWith("s.json: inputs[0]: unknown: found \"jump\", expected spawn, remove, "));
  CHECK_THAT(json_refusal("{\"bounds\":{\"lower\":[0,0]}}"), StartsWith("s.json: bounds.upper: missing"));
  CHECK_THAT(json_refusal("{\"spawned_max\":-1}"),
             StartsWith("s.json: spawned_max: must be a whole number in range: found -1"));
  CHECK(body_refusal("{\"fixed_rotation\":1}") ==
        "s.json: bodies[0].fixed_rotation: wrong type: found 1, expected true or false");
  CHECK_THAT(body_refusal("{}"), StartsWith("s.json: bodies[0].shapes: a body needs a shape: found none"));
  CHECK_THAT(body_refusal("{\"inertia\":1,\"shapes\":[]}"),
             StartsWith("s.json: bodies[0].inertia: needs a stated mass"));
  CHECK_THAT(body_refusal("{\"center_of_mass\":[0,1],\"shapes\":[]}"),
             StartsWith("s.json: bodies[0].center_of_mass: needs a stated mass"));
  CHECK_THAT(shape_refusal("{\"radius\":1}"),
             StartsWith("s.json: bodies[0].shapes[0].type: missing: found no such key, expected circle, box, polygon, "
                        "capsule, segment or chain"));
  CHECK_THAT(shape_refusal("{\"type\":\"ball\",\"radius\":1}"),
             StartsWith("s.json: bodies[0].shapes[0].type: unknown: found \"ball\""));
  CHECK_THAT(shape_refusal("{\"type\":\"circle\"}"), StartsWith("s.json: bodies[0].shapes[0].radius: missing"));
  CHECK_THAT(shape_refusal("{\"type\":\"box\"}"), StartsWith("s.json: bodies[0].shapes[0].half_size: missing"));
  CHECK_THAT(shape_refusal("{\"type\":\"polygon\"}"), StartsWith("s.json: bodies[0].shapes[0].vertices: missing"));
  CHECK_THAT(shape_refusal("{\"type\":\"circle\",\"radius\":-1}"),
             StartsWith("s.json: bodies[0].shapes[0].radius: must be > 0: found -1, expected 1e-06..1e+06"));
}

TEST_CASE("a million bodies, deep nesting and huge objects are refused in bounded memory",
          "[engine][scene_json][corruption]") {
  std::string text = "{\"bodies\":[";
  for (std::size_t i = 0; i < limits::body_count_max + 1; ++i)
    text += std::string(i == 0 ? "" : ",") + "{\"shapes\":[{\"type\":\"circle\",\"radius\":1}]}";
  text += "]}";
  const auto scene = parse_scene(text, "s.json");
  REQUIRE_FALSE(scene);
  CHECK(scene.error().code == ErrorCode::limit);
  CHECK_THAT(scene.error().message, StartsWith("s.json: bodies: too many: found more than 200000"));

  text = "{\"forces\":[";
  for (std::size_t i = 0; i < limits::force_count_max + 1; ++i)
    text += std::string(i == 0 ? "" : ",") + "{\"type\":\"linear_drag\",\"coefficient\":1}";
  CHECK_THAT(json_refusal(text + "]}"), StartsWith("s.json: forces: too many: found more than 4096"));

  CHECK_THAT(json_refusal("{\"gravity\":" + std::string(100'000, '[')), Contains("nested too deeply"));
  std::string numbers = "{\"gravity\":[0";
  for (int i = 0; i < 300'000; ++i) numbers += ",0";
  CHECK_THAT(json_refusal(numbers + "]}"), Contains("too many"));
  std::string keys = "{";
  for (int i = 0; i < 100; ++i) keys += "\"k" + std::to_string(i) + "\":[],";
  CHECK_THAT(json_refusal(keys + "\"z\":0}"), Contains("too many keys"));
}

TEST_CASE("an input comes back from its line", "[engine][scene_json][equivalence]") {
  Scene scene = *make_builtin_scene("thesis");
  scene.inputs.clear();
  for (const InputInfo& info : input_kinds) scene.inputs.push_back(info.kind);
  scene.joints.resize(2);
  for (Joint& joint : scene.joints) joint.motor.emplace();
  for (const InputInfo& info : input_kinds) {
    Input input;
    input.kind = info.kind;
    input.tick = 123456789012;
    input.player = 255;
    if (info.has_body) input.body = 4'000'000'000u;
    if (info.has_prototype) input.prototype = 1;
    if (info.has_joint) input.joint = 1;
    for (std::size_t i = 0; i < info.value_count; ++i)
      input.values[i] = i == 0 ? -0.0 : 1.0 / (3.0 + static_cast<double>(i));
    const std::string line = print_input(scene, input);
    CAPTURE(line);
    const auto back = parse_input(scene, line, "f.jsonl:1");
    if (!back) FAIL(back.error().message);
    CHECK(*back == input);
    CHECK(print_input(scene, *back) == line);
  }
  Input spawn;
  spawn.kind = InputKind::spawn;
  spawn.tick = 5;
  spawn.values = {1, 2.5, 0, 0, 0, 0};
  CHECK(print_input(scene, spawn) ==
        R"({"tick":5,"kind":"spawn","prototype":"circle","x":1,"y":2.5,"angle":0,"vx":0,"vy":0,"angular_velocity":0})");
  Input set_motor;
  set_motor.kind = InputKind::set_motor;
  set_motor.joint = 1;
  set_motor.values = {-3, 10, 0, 0, 0, 0};
  CHECK(print_input(scene, set_motor) == R"({"tick":0,"kind":"set_motor","joint":1,"speed":-3,"force_max":10})");
  scene.joints[1].name = "axle";
  CHECK(print_input(scene, set_motor) == R"({"tick":0,"kind":"set_motor","joint":"axle","speed":-3,"force_max":10})");
  CHECK(*parse_input(scene, print_input(scene, set_motor), "f:1") == set_motor);
  CHECK(parse_input(scene, R"({"kind":"set_motor","tick":5,"joint":"axel"})", "f:1").error().message ==
        "f:1: joint: no joint of the scene has this name: found \"axel\", expected axle");
  CHECK(parse_input(scene, R"({"kind":"set_motor","tick":5,"joint":true})", "f:1").error().message ==
        "f:1: joint: wrong type: found true, expected the index or the name of a joint");
  // Zeros may be left out.
  CHECK(*parse_input(scene, R"({"kind":"spawn","tick":5,"prototype":"circle","x":1,"y":2.5})", "f:1") == spawn);
}

TEST_CASE("bad input lines are refused with file, line and reason", "[engine][scene_json][corruption]") {
  CHECK(input_refusal(R"({"tick":1,"kind":"press","x":1,"y":2})") == "accepted");
  CHECK_THAT(input_refusal("{"), StartsWith("f.jsonl:7:1:1: broken JSON") || StartsWith("f.jsonl:7:1:2: broken JSON"));
  CHECK_THAT(input_refusal("[]"), StartsWith("f.jsonl:7: wrong type: found an array of 0"));
  CHECK_THAT(input_refusal(R"({"tick":1})"), StartsWith("f.jsonl:7: kind: missing"));
  CHECK_THAT(input_refusal(R"({"kind":"press"})"), StartsWith("f.jsonl:7: tick: missing"));
  CHECK_THAT(input_refusal(R"({"tick":-1,"kind":"press"})"),
             StartsWith("f.jsonl:7: tick: must be a whole number in range: found -1"));
  CHECK_THAT(input_refusal(R"({"tick":1.5,"kind":"press"})"), StartsWith("f.jsonl:7: tick: must be a whole number"));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"pres"})"), StartsWith("f.jsonl:7: kind: unknown: found \"pres\""));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"press","player":256})"), StartsWith("f.jsonl:7: player: "));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"press","z":1})"),
             StartsWith("f.jsonl:7: unknown key: found \"z\", expected tick, player, kind, x or y"));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"spawn","prototype":"cirle"})"),
             StartsWith("f.jsonl:7: prototype: no prototype of the scene has this name: found \"cirle\", expected "
                        "circle, box or polygon"));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"spawn"})"), StartsWith("f.jsonl:7: prototype: missing"));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"remove"})"), StartsWith("f.jsonl:7: body: missing"));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"remove","body":4294967295})"), StartsWith("f.jsonl:7: body: "));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"press","x":1e8})"),
             StartsWith("f.jsonl:7: x: out of range: found 1e+08"));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"torque","body":1})"), StartsWith("f.jsonl:7: kind: not declared"));
  CHECK_THAT(input_refusal(R"({"tick":1,"kind":"press","x":NaN})"), Contains("broken JSON"));
  CHECK_THAT(input_refusal("{\"tick\":1,\"kind\":\"" + std::string(70'000, 'x') + "\"}"),
             StartsWith("f.jsonl:7: line too long"));
}

TEST_CASE("impacts are located automatically where a pair has restitution 1", "[engine][scene_json][analytic]") {
  // A ball above a floor. The settings come before the bodies in the text.
  const auto text_of = [](const std::string& settings, const std::string& ball, const std::string& floor) {
    return "{\"settings\":{" + settings +
           "},\"bodies\":[{\"position\":[0,5],\"shapes\":[{\"type\":\"circle\",\"radius\":1" + ball +
           "}]},{\"type\":\"static\",\"shapes\":[{\"type\":\"box\",\"half_size\":[9,1]" + floor + "}]}]}";
  };
  const auto scene_of = [&](const std::string& settings, const std::string& ball, const std::string& floor) {
    const auto scene = parse_scene(text_of(settings, ball, floor), "s.json");
    if (!scene) FAIL(scene.error().message);
    return *scene;
  };
  const std::string automatic = R"("locate_impacts":"auto")", full = R"(,"restitution":1)",
                    less = R"(,"restitution":0.99)";
  CHECK(scene_of(automatic, full, "").settings.locate_impacts);
  CHECK(scene_of(automatic, "", full).settings.locate_impacts);
  CHECK_FALSE(scene_of(automatic, less, less).settings.locate_impacts);
  CHECK_FALSE(scene_of(automatic + R"(,"restitution_mix":"min")", full, less).settings.locate_impacts);
  CHECK_FALSE(scene_of("", full, full).settings.locate_impacts);
  CHECK_FALSE(scene_of(R"("locate_impacts":false)", full, full).settings.locate_impacts);
  // Other integrators locate no impacts: true is refused there, and auto is off.
  const std::string verlet = R"(,"integrator":"velocity_verlet")";
  CHECK_FALSE(scene_of(automatic + verlet, full, full).settings.locate_impacts);
  CHECK_THAT(json_refusal(text_of(R"("locate_impacts":true)" + verlet, full, full)),
             Contains("settings.locate_impacts"));
  CHECK(json_refusal(R"({"settings":{"locate_impacts":"always"}})") ==
        R"(s.json: settings.locate_impacts: wrong type: found "always", expected true, false or "auto")");
  // A scene that was read has the choice itself, in print and in a setup.
  const Scene chosen = scene_of(automatic, full, "");
  CHECK_THAT(print_scene(chosen), Contains(R"("locate_impacts": true)"));
  CHECK(encode_scene(chosen) == encode_scene(scene_of(R"("locate_impacts":true)", full, "")));
}

TEST_CASE("the JSON Schema and the parser know the same keys and names", "[engine][scene_json][equivalence]") {
  const json schema = json::parse(file_text(scenes_folder / "scene.schema.json"));
  const json& defs = schema["$defs"];
  CHECK(reader_keys(json_refusal("{\"?\":0}")) == keys_of(schema["properties"]));
  CHECK(reader_keys(json_refusal("{\"settings\":{\"?\":0}}")) == keys_of(defs["settings"]["properties"]));
  CHECK(reader_keys(json_refusal("{\"pointer\":{\"?\":0}}")) == keys_of(defs["pointer"]["properties"]));
  CHECK(reader_keys(json_refusal("{\"bounds\":{\"?\":0}}")) == keys_of(defs["bounds"]["properties"]));
  CHECK(reader_keys(body_refusal("{\"?\":0}")) == keys_of(defs["body"]["properties"]));
  CHECK(reader_keys(json_refusal("{\"settings\":{\"substeps\":{\"?\":0}}}")) ==
        keys_of(defs["auto_substeps"]["properties"]));
  CHECK(reader_keys(json_refusal("{\"settings\":{\"sleep\":{\"?\":0}}}")) == keys_of(defs["sleep"]["properties"]));
  CHECK(reader_keys(shape_refusal("{\"type\":\"circle\",\"filter\":{\"?\":0}}")) ==
        keys_of(defs["filter"]["properties"]));
  // A valid value for each key that some kind requires.
  const std::map<std::string, std::string> samples{{"radius", "1"},
                                                   {"half_size", "[1,1]"},
                                                   {"vertices", "[[0,0],[1,0],[0,1]]"},
                                                   {"points", "[[0,0],[1,0]]"},
                                                   {"body_a", "0"},
                                                   {"body_b", "1"},
                                                   {"joint_a", "0"},
                                                   {"joint_b", "1"},
                                                   {"axis", "[1,0]"},
                                                   {"length", "1"},
                                                   {"ground_anchor_a", "[0,1]"},
                                                   {"ground_anchor_b", "[1,1]"},
                                                   {"force_max", "1"},
                                                   {"torque_max", "1"},
                                                   {"point", "[0,0]"},
                                                   {"body", "0"},
                                                   {"stiffness", "1"},
                                                   {"velocity", "[0,0]"},
                                                   {"coefficient", "1"}};
  // If one of the required keys is missing, an object is refused for this key.
  const auto check_required = [&](const json& rule, const std::string& kind, const std::string& place,
                                  const std::function<std::string(std::string)>& refusal_of) {
    for (const json& missing : rule["required"]) {
      std::string text = "{";
      for (const json& key : rule["required"]) {
        const std::string value = key == "type" ? "\"" + kind + "\"" : samples.at(key);
        if (key != missing) text += std::string(text.size() > 1 ? "," : "") + "\"" + std::string(key) + "\":" + value;
      }
      CHECK_THAT(refusal_of(text + "}"), Contains(place + std::string(missing) + ": missing"));
    }
  };
  const auto options_of = [&](const char* definition) {
    std::set<std::string> options;
    for (const json& option : defs[definition]["oneOf"])
      options.insert(std::string(option["$ref"]).substr(std::string("#/$defs/").size()));
    return options;
  };
  const auto same_kinds = [&](const char* definition, const char* suffix, const auto& table,
                              const std::function<std::string(std::string)>& refusal_of) {
    std::set<std::string> kinds;
    for (const auto& row : table) {
      const std::string kind(row.name);
      const std::string key = kind + suffix;
      CAPTURE(key);
      kinds.insert(key);
      CHECK(defs[key]["properties"]["type"]["const"] == kind);
      CHECK(reader_keys(refusal_of("{\"type\":\"" + kind + "\",\"?\":0}")) == keys_of(defs[key]["properties"]));
      if (defs[key].contains("required")) check_required(defs[key], kind, "[0].", refusal_of);
    }
    CHECK(kinds == options_of(definition));
  };
  same_kinds("joint", "_joint", joint_kinds, joint_refusal);
  same_kinds("force", "_force", force_kinds, force_refusal);
  same_kinds("clock", "_clock", clock_kinds,
             [](const std::string& clock) { return json_refusal("{\"settings\":{\"clock\":" + clock + "}}"); });
  CHECK(reader_keys(joint_refusal("{\"type\":\"revolute\",\"motor\":{\"?\":0}}")) ==
        keys_of(defs["motor"]["properties"]));
  std::set<std::string> spring = keys_of(defs["relative_spring"]["properties"]);
  spring.merge(keys_of(defs["absolute_spring"]["properties"]));
  CHECK(reader_keys(joint_refusal("{\"type\":\"revolute\",\"spring\":{\"?\":0}}")) == spring);
  const std::set<std::string> shapes_in_schema = options_of("shape");
  std::set<std::string> shapes;
  for (const auto& row : shape_kinds) {
    const std::string name(row.name);
    shapes.insert(name);
    CHECK(defs[name]["properties"]["type"]["const"] == name);
    CHECK(reader_keys(shape_refusal("{\"type\":\"" + name + "\",\"?\":0}")) == keys_of(defs[name]["properties"]));
    check_required(defs[name], name, "shapes[0].", shape_refusal);
  }
  CHECK(shapes == shapes_in_schema);

  const auto same_names = [&](const char* definition, const auto& table) {
    std::vector<std::string> names;
    for (const auto& row : table) names.emplace_back(row.name);
    CHECK(defs[definition]["enum"] == json(names));
  };
  same_names("precision", precisions);
  same_names("solver", solvers);
  same_names("integrator", integrators);
  same_names("broad_phase", broad_phases);
  same_names("mix_rule", mix_rules);
  same_names("joint_solver", joint_solvers);
  same_names("substep_loads", substep_loads);
  same_names("body_type", body_types);
  same_names("clock_kind", clock_kinds);
  same_names("input_kind", input_kinds);
}

TEST_CASE("the JSON Schema states the limits that hold", "[engine][scene_json][equivalence]") {
  const json schema = json::parse(file_text(scenes_folder / "scene.schema.json"));
  const json& defs = schema["$defs"];
  // A number at a limit of the schema is accepted; a number just beyond the limit is refused.
  const auto scene_with = [](const std::string& body_keys, const std::string& shape_keys, const std::string& keys) {
    return "{\"bodies\":[{" + body_keys + "\"shapes\":[{\"type\":\"circle\"," + shape_keys + "}]}]" + keys + "}";
  };
  const auto check_limits = [](const json& rule, const std::string& key,
                               const std::function<std::string(std::string)>& text) {
    CAPTURE(key);
    for (const char* side : {"minimum", "maximum"}) {
      if (!rule.contains(side)) continue;
      const double limit = rule[side];
      CHECK_THAT(json_refusal(text(json(limit).dump())), !Contains(key + ": "));
      const double step = limit == 0 ? 0.1 : (limit > 0 ? limit : -limit) * 0.01;
      const double beyond = side == std::string("minimum") ? limit - step : limit + step;
      CHECK_THAT(json_refusal(text(json(beyond).dump())), Contains(key + ": "));
    }
  };
  for (const auto& item : defs["settings"]["properties"].items()) {
    const std::string& key = item.key();
    if (key == "substeps" || key == "iterations" || key == "substep_budget") continue;  // integers
    check_limits(item.value(), item.key(), [&](const std::string& v) {
      return scene_with("", "\"radius\":1", ",\"settings\":{\"" + item.key() + "\":" + v + "}");
    });
  }
  for (const auto& item : defs["body"]["properties"].items())
    check_limits(item.value(), item.key(), [&](const std::string& v) {
      return scene_with((item.key() == "inertia" ? "\"mass\":1," : "") + ("\"" + item.key() + "\":" + v + ","),
                        "\"radius\":1", "");
    });
  for (const char* key : {"density", "friction", "restitution"})
    check_limits(defs[key], key, [&](const std::string& v) {
      return scene_with("\"mass\":1,", "\"radius\":1,\"" + std::string(key) + "\":" + v, "");
    });
  check_limits(defs["size"], "radius",
               [&](const std::string& v) { return scene_with("\"mass\":1,", "\"radius\":" + v, ""); });
  for (const auto& item : defs["pointer"]["properties"].items())
    check_limits(item.value(), item.key(), [&](const std::string& v) {
      return scene_with("", "\"radius\":1",
                        ",\"inputs\":[\"press\",\"drag\",\"release\"],\"pointer\":{\"" + item.key() + "\":" + v + "}");
    });

  CHECK(defs["polygon"]["properties"]["vertices"]["minItems"] == limits::polygon_vertex_count_min);
  CHECK(defs["polygon"]["properties"]["vertices"]["maxItems"] == limits::polygon_vertex_count_max);
}

TEST_CASE("every example scene is valid, and so are its inputs", "[engine][scene_json][analytic]") {
  std::size_t scene_count = 0, session_count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scenes_folder)) {
    const std::string name = entry.path().filename().string();
    CAPTURE(name);
    if (entry.path().extension() == ".json" && name.find(".schema.") == std::string::npos) {
      ++scene_count;
      const auto scene = parse_scene(file_text(entry.path()), name);
      if (!scene) FAIL(scene.error().message);
    }
    if (entry.path().extension() != ".jsonl") continue;
    ++session_count;
    // x.jsonl belongs to x.json, x_session.jsonl to the built-in scene x.
    std::filesystem::path scene_path = entry.path();
    scene_path.replace_extension(".json");
    const std::string stem = entry.path().stem().string();
    const auto scene = std::filesystem::exists(scene_path) ? parse_scene(file_text(scene_path), name)
                                                           : make_builtin_scene(stem.substr(0, stem.find("_session")));
    if (!scene) FAIL(scene.error().message);
    std::istringstream in(file_text(entry.path()));
    std::uint64_t tick = 0;
    int line_number = 0;
    for (std::string line; std::getline(in, line);) {
      const auto input = parse_input(*scene, line, name + ":" + std::to_string(++line_number));
      if (!input) FAIL(input.error().message);
      REQUIRE(input->tick >= tick);
      tick = input->tick;
    }
    CHECK(line_number > 0);
  }
  CHECK(scene_count >= 6);
  CHECK(session_count >= 2);
}
