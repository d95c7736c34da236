// Notes on scenes: restitution 1 that loses energy, and places where f32 rounds too coarsely.
// SPDX-License-Identifier: MIT
#include "tool/output/scene_notes.h"

#include <string>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/engine.h"
#include "engine/math/trig.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tests/support/text.h"

namespace ticktrue::test {
namespace {

using tool::scene_notes;

// A ball above the ground, with these restitutions.
Scene ball(double of_ball, double of_ground) {
  Scene scene = empty_scene(Precision::f32);
  scene.bodies = {ground(), body_of(disc_shape(0.5), {0, 5})};
  scene.bodies[0].shapes[0].material.restitution = of_ground;
  scene.bodies[1].shapes[0].material.restitution = of_ball;
  return scene;
}

bool tells(const Scene& scene, const std::string& part) {
  for (const std::string& note : scene_notes(scene))
    if (contains(note, part)) return true;
  return false;
}

}  // namespace

TEST_CASE("restitution 1 is told where it loses energy", "[verifier][session][notes]") {
  Scene scene = ball(1, 0);
  CHECK(tells(scene, "restitution 1"));
  CHECK(tells(scene, "\"locate_impacts\": \"auto\""));
  scene.settings.integrator = engine::IntegratorKind::velocity_verlet;  // this integrator locates no impacts
  CHECK(tells(scene, "restitution 1"));
  CHECK_FALSE(tells(scene, "locate_impacts"));
  scene = ball(1, 0);
  scene.settings.locate_impacts = true;
  CHECK(scene_notes(scene).empty());
}

TEST_CASE("restitution 1 is told only if a pair has it", "[verifier][session][notes]") {
  CHECK(scene_notes(ball(0.99, 0.99)).empty());
  Scene scene = ball(0, 1);
  CHECK(tells(scene, "restitution 1"));
  scene.settings.restitution_mix = engine::MixRule::minimum;
  CHECK(scene_notes(scene).empty());
  CHECK(scene_notes(ball(1, 1)).size() == 1);
  scene = ball(0, 1);
  scene.bodies[0].shapes[0].sensor = true;
  CHECK(scene_notes(scene).empty());
  // Two static bodies never collide, and a single ball has no partner.
  scene = ball(0, 0);
  scene.bodies.push_back(scene.bodies[0]);
  scene.settings.restitution_mix = engine::MixRule::geometric_mean;
  for (const std::size_t i : {0, 2}) scene.bodies[i].shapes[0].material.restitution = 1;
  CHECK(scene_notes(scene).empty());
}

TEST_CASE("two of one prototype may meet", "[verifier][session][notes]") {
  Scene scene = empty_scene(Precision::f32);
  scene.settings.restitution_mix = engine::MixRule::minimum;
  scene.bodies = {ground()};
  scene.prototypes = {body_of(disc_shape(0.5), {})};
  scene.prototypes[0].name = "ball";
  scene.prototypes[0].shapes[0].material.restitution = 1;
  scene.inputs = {engine::InputKind::spawn};
  CHECK(tells(scene, "restitution 1"));
}

TEST_CASE("a note names a joint that turns its bodies, and the angle that leaves them", "[verifier][session][notes]") {
  Scene scene = empty_scene(Precision::f32);
  for (const double x : {0.0, 1.0, 2.0}) scene.bodies.push_back(body_of(box_shape(0.5, 0.1), {x, 0}));
  scene.bodies[1].angle = 1.25;
  scene.bodies[2].angle = -3.1;
  engine::Joint weld;
  weld.kind = engine::JointKind::weld;
  weld.body_a = 0;
  weld.body_b = 1;
  scene.joints = {weld};
  CHECK(tells(scene, "joints[0] (weld) turns its bodies by 1.25 rad in the first ticks"));
  CHECK(tells(scene, "\"reference_angle\": 1.25"));
  scene.joints[0].reference_angle = 1.2;
  CHECK(scene_notes(scene).empty());
  scene.joints[0].kind = engine::JointKind::revolute;  // it holds no angle
  scene.joints[0].reference_angle = 0;
  CHECK(scene_notes(scene).empty());
  scene.joints = {weld, weld};
  scene.joints[1].kind = engine::JointKind::prismatic;
  CHECK(tells(scene, ", as 1 more;"));
  scene.joints = {weld};
  scene.joints[0].body_b = 2;
  scene.joints[0].reference_angle = engine::pi;  // angles that differ by whole turns are one
  CHECK(scene_notes(scene).empty());
  scene.joints = {weld};
  scene.joints[0].spring = engine::JointSpring{true, 0, 0, 10, 1};
  CHECK(scene_notes(scene).empty());
}

TEST_CASE("f32 far from the origin is told beyond 2^17 sizes of the smallest moving shape",
          "[verifier][session][notes]") {
  Scene scene = ball(0, 0);  // the disc is 1 m wide
  scene.bodies[1].position.x = 0x1p17;
  CHECK(scene_notes(scene).empty());
  scene.bodies[1].position.x = -0x1p17 * 1.001;
  CHECK(tells(scene, "\"precision\": \"f64\""));
  CHECK(tells(scene, "0.016 m"));  // 2^(17 - 23)
  scene.settings.precision = Precision::f64;
  CHECK(scene_notes(scene).empty());
  // The thickness of a thin box counts as its size.
  scene.settings.precision = Precision::f32;
  scene.bodies[1].position.x = 2000;
  CHECK(scene_notes(scene).empty());
  scene.bodies[1].shapes[0] = box_shape(1, 0.005);
  CHECK(tells(scene, "f64"));
}

TEST_CASE("f32 is refused beyond 2^20 sizes of the smallest moving shape", "[verifier][session][notes]") {
  Scene scene = ball(0, 0);  // the disc is 1 m wide
  scene.bodies[1].position.x = 0x1p20;
  CHECK(tool::check_f32_reach(scene, "far.json"));
  CHECK(tells(scene, "\"precision\": \"f64\""));
  scene.bodies[1].position = {0, -0x1p20 * 1.001};
  const Status refused = tool::check_f32_reach(scene, "far.json");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::incompatible);
  CHECK(contains(refused.error().message, "far.json: settings.precision: f32 is too coarse"));
  CHECK(contains(refused.error().hint, "\"precision\": \"f64\""));
  // A trace of such a scene still runs: neither the rules of scenes nor the engine refuse it.
  CHECK(engine::check_scene(scene, "far"));
  CHECK(engine::make_engine(scene).has_value());
  scene.settings.precision = Precision::f64;
  CHECK(tool::check_f32_reach(scene, "far.json"));
  // What does not move may be anywhere.
  scene.settings.precision = Precision::f32;
  scene.bodies[1].position = {0, 5};
  scene.bodies[0].position.x = 0x1p22;
  CHECK(tool::check_f32_reach(scene, "far.json"));
}

TEST_CASE("no built-in scene is far out, and only elastic ones lose energy", "[verifier][session][notes]") {
  for (const engine::BuiltinScene& builtin : engine::builtin_scenes()) {
    const auto scene = engine::make_builtin_scene(builtin.name);
    REQUIRE(scene.has_value());
    CAPTURE(builtin.name);
    const bool is_elastic = builtin.name == "billiards" || builtin.name == "gas" || builtin.name == "resting";
    CHECK(scene_notes(*scene).empty() != is_elastic);
  }
}

}  // namespace ticktrue::test
