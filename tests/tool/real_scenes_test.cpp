// Scenes with joints, including scenes that others drew for Box2D: they run, hold together and end as in Box2D.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "engine/scene/scene_json.h"
#include "tests/support/catch.h"
#include "tests/support/joint_gaps.h"
#include "tests/support/joints.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/crosscheck/crosscheck.h"
#include "tool/import/import_rube.h"

namespace ticktrue::test {
namespace {

constexpr double run_s = 60;
constexpr double start_s = 2;           // files are drawn by hand: joints may start with a gap
constexpr double gap_share_max = 0.01;  // of the smaller body's size

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

Scene scene_of(const std::string& name) {
  const auto scene = engine::parse_scene(text_of(std::string(TICKTRUE_SOURCE_DIR) + "/scenes/" + name), name);
  REQUIRE(scene.has_value());
  return *scene;
}

bool is_finite(const engine::BodyReport& body) {
  return std::isfinite(body.center.x + body.center.y + body.angle + body.velocity.x + body.velocity.y +
                       body.angular_velocity);
}

/// Runs a scene. Checks that the scene stays finite, and that joint gaps stay within 1 % of the smaller body or within
/// the gaps at the start.
void check_holds_together(const Scene& scene) {
  CAPTURE(scene.name);
  const auto made = engine::make_engine(scene);
  INFO((made ? "" : made.error().message));
  REQUIRE(made.has_value());
  engine::Engine& engine = **made;
  const std::vector<JointGap> first = joint_gaps(scene, engine.bodies());
  std::vector<JointGap> most = first;
  for (JointGap& gap : most) gap.gap = gap.beyond = 0;
  bool finite = true;
  const int tick_count = static_cast<int>(std::lround(run_s / scene.settings.dt));
  for (int tick = 1; tick <= tick_count; ++tick) {
    REQUIRE(engine.step({scene.settings.dt, {}}, nullptr));
    const auto bodies = engine.bodies();
    for (const engine::BodyReport& body : bodies) finite &= is_finite(body);
    if (tick * scene.settings.dt < start_s) continue;
    const std::vector<JointGap> gaps = joint_gaps(scene, bodies);
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      most[i].gap = std::fmax(most[i].gap, gaps[i].gap);
      most[i].beyond = std::fmax(most[i].beyond, gaps[i].beyond);
    }
  }
  CHECK(finite);
  for (std::size_t i = 0; i < most.size(); ++i) {
    CAPTURE(i, scene.joints[i].name, most[i].size);
    CHECK(most[i].gap <= std::fmax(gap_share_max * most[i].size, first[i].gap));
    CHECK(most[i].beyond <= std::fmax(gap_share_max * most[i].size, first[i].beyond));
  }
}

/// Two legs under a chassis, each with a thigh and a shin. Cranks with motors move the thighs.
Scene walker_scene(double motor_speed) {
  Scene scene = empty_scene(Precision::f32);
  scene.name = "walker";
  scene.bodies.push_back(ground());
  scene.bodies.push_back(body_of(box_shape(1, 0.2), {0, 2}));  // 1: chassis
  const auto add = [&](Body body) {
    body.shapes[0].filter = {2, 1, 0};
    body.shapes[0].density = 20;
    scene.bodies.push_back(std::move(body));
    return static_cast<std::uint32_t>(scene.bodies.size() - 1);
  };
  const auto pin = [&](std::uint32_t a, std::uint32_t b, Point at) -> Joint& {
    Joint& joint = scene.joints.emplace_back(joint_of(JointKind::revolute, a, b));
    joint.anchor_a = {at.x - scene.bodies[a].position.x, at.y - scene.bodies[a].position.y};
    joint.anchor_b = {at.x - scene.bodies[b].position.x, at.y - scene.bodies[b].position.y};
    return joint;
  };
  for (const double side : {-0.8, 0.8}) {
    const std::uint32_t crank = add(body_of(box_shape(0.15, 0.05), {side, 2}));
    const std::uint32_t thigh = add(body_of(box_shape(0.06, 0.5), {side, 1.4}));
    const std::uint32_t shin = add(body_of(box_shape(0.06, 0.4), {side, 0.45}));
    pin(1, crank, {side, 2}).motor = engine::JointMotor{motor_speed, 30};
    pin(crank, thigh, {side + 0.1, 2});
    pin(thigh, shin, {side, 0.9}).limits = engine::Range{-0.5, 0.5};
    Joint& rod = scene.joints.emplace_back(joint_of(JointKind::distance, 1, thigh));
    rod.anchor_a = {0, -0.2};
    rod.length = std::hypot(side, 0.4);
    Joint& foot =
        scene.joints.emplace_back(joint_of(JointKind::prismatic, shin, add(body_of(box_shape(0.2, 0.1), {side, 0.1}))));
    foot.anchor_a = {0, -0.35};
    foot.axis = {0, 1};
    foot.limits = engine::Range{-0.1, 0.1};
    foot.spring = engine::JointSpring{false, 8, 1, 0, 0};
  }
  return scene;
}

const std::vector<std::string> rube_names{"bike",   "bodyTypes",  "car",       "gettingStarted",
                                          "images", "jointTypes", "mariotest", "walker"};

// TICKTRUE_RUBE names the folder of the scenes. The repository does not contain them.
const char* rube_folder() {
  const char* folder = std::getenv("TICKTRUE_RUBE");
  if (folder == nullptr) WARN("TICKTRUE_RUBE is not set: nothing was checked");
  return folder;
}

Scene rube_scene(const std::string& folder, const std::string& name) {
  const auto import = tool::import_rube(text_of(folder + "/" + name + ".json"), name, name);
  INFO((import ? "" : import.error().message));
  REQUIRE(import.has_value());
  return import->scene;
}

}  // namespace

TEST_CASE("the bridge and the car of the repository hold together for a minute", "[verifier][real_scenes][analytic]") {
  check_holds_together(scene_of("bridge.json"));
  Scene car = scene_of("car.json");
  check_holds_together(car);
  for (Joint& joint : car.joints)
    if (joint.motor) joint.motor->speed = -10;
  check_holds_together(car);
}

TEST_CASE("a walker on cranks, rods and sprung feet holds together, at rest and driven",
          "[verifier][real_scenes][analytic]") {
  check_holds_together(walker_scene(0));
  check_holds_together(walker_scene(2));
}

TEST_CASE("joint gaps are what the anchors, axes and angles of the poses say", "[verifier][real_scenes][analytic]") {
  Scene scene = empty_scene();
  scene.bodies = {peg({0, 0}), bob({3, 4})};
  const auto gap = [&](auto change) {
    scene.joints = {joint_of(JointKind::revolute, 0, 1)};
    change(scene.joints[0]);
    const auto made = engine::make_engine(scene);
    REQUIRE(made.has_value());
    return joint_gaps(scene, (*made)->bodies()).at(0);
  };
  CHECK(gap([](Joint&) {}).gap == Approx(5));
  CHECK(gap([](Joint&) {}).size == Approx(0.2));
  CHECK(gap([](Joint& j) { j.anchor_b = {-3, -4}; }).gap == Approx(0).margin(1e-12));
  CHECK(gap([](Joint& j) { j.kind = JointKind::wheel; }).gap == Approx(4));
  CHECK(gap([](Joint& j) { j.kind = JointKind::prismatic, j.axis = {3, 4}; }).gap == Approx(0).margin(1e-12));
  CHECK(gap([](Joint& j) { j.kind = JointKind::prismatic, j.limits = engine::Range{0, 2}; }).beyond == Approx(1));
  CHECK(gap([](Joint& j) { j.kind = JointKind::distance, j.length = 4; }).gap == Approx(1));
  CHECK(gap([](Joint& j) { j.kind = JointKind::distance, j.limits = engine::Range{0, 3}; }).beyond == Approx(2));
}

TEST_CASE("the scenes of the editor run for a minute, finite and with their joints together",
          "[verifier][real_scenes][.rube]") {
  const char* folder = rube_folder();
  SKIP_UNLESS(folder != nullptr, "no folder of real scenes is named");
  for (const std::string& name : rube_names) check_holds_together(rube_scene(folder, name));
}

TEST_CASE("recordings of the editor's scenes verify by replay and by restore", "[verifier][real_scenes][.rube]") {
  const char* folder = rube_folder();
  SKIP_UNLESS(folder != nullptr, "no folder of real scenes is named");
  const std::filesystem::path place = std::filesystem::temp_directory_path() / "ticktrue_real_scenes";
  std::filesystem::create_directories(place);
  const std::string tool = TICKTRUE_TOOL;
  for (const std::string& name : rube_names) {
    CAPTURE(name);
    const std::string scene = (place / (name + ".json")).string();
    const std::string trace = (place / (name + ".ttr")).string();
    std::ofstream(scene, std::ios::binary) << engine::print_scene(rube_scene(folder, name));
    const auto run = [&](const std::string& arguments) {
      return std::system((tool + " " + arguments + " > /dev/null 2>&1").c_str());
    };
    CHECK(run("record " + scene + " --ticks 3600 --checkpoint-interval 300 --force -o " + trace) == 0);
    CHECK(run("verify " + trace) == 0);
    CHECK(run("verify " + trace + " --mode restore") == 0);
  }
  std::filesystem::remove_all(place);
}

TEST_CASE("the editor's scenes end in Box2D as they do here, at rest and driven", "[verifier][real_scenes][.rube]") {
  const char* folder = rube_folder();
  SKIP_UNLESS(folder != nullptr && !tool::box2d_version().empty(), "no folder of real scenes, or no Box2D");
  tool::CrosscheckOptions options;
  options.seconds = 10;
  options.thread_count = 2;
  for (const std::string& name : rube_names)
    for (const double speed : {0.0, -8.0}) {
      Scene scene = rube_scene(folder, name);
      bool has_motor = false;
      for (Joint& joint : scene.joints) {
        if (!joint.motor || joint.motor->speed != 0) continue;
        joint.motor->speed = speed;
        has_motor = true;
      }
      if (speed != 0 && !has_motor) continue;
      CAPTURE(name, speed);
      const auto report = tool::crosscheck(scene, options);
      REQUIRE(report.has_value());
      for (const tool::CriterionResult& row : report->rows) {
        CAPTURE(row.criterion, row.difference, row.tolerance, row.unit, row.reason);
        // A known shortfall, not an expected difference (docs/crosscheck.md). The bike begins 3.6 cm inside the ground,
        // and the walker yields with 4 substeps. Both rest up to 4.5 cm from Box2D's places. The limit of 5 cm keeps
        // the shortfall from growing.
        const bool falls_short = name == "bike" || name == "walker";
        if (row.criterion == tool::place_criterion && falls_short && row.verdict == tool::Agreement::differ)
          CHECK(row.difference < 0.05);
        else if (row.criterion == tool::place_criterion || row.criterion == tool::distance_criterion)
          CHECK(row.verdict != tool::Agreement::differ);
        CHECK(row.criterion != "scene");  // the row of a scene that Box2D does not support
      }
    }
}

}  // namespace ticktrue::test
