// Scenes of the R.U.B.E. editor: each rule of the format on a small file, and errors with place, found and expected.
// SPDX-License-Identifier: MIT
#include "tool/import/import_rube.h"

#include <cmath>

#include "base/limits.h"
#include "engine/math/trig.h"
#include "tests/support/catch.h"

namespace ticktrue::test {
namespace {

using engine::Body;
using engine::BodyType;
using engine::Joint;
using engine::JointKind;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;
using tool::import_rube;
using tool::RubeImport;

RubeImport imported(const std::string& json) {
  const auto result = import_rube(json, "f.json", "f");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.has_value());
  return *result;
}
Error refused(const std::string& json) {
  const auto result = import_rube(json, "f.json", "f");
  REQUIRE(!result.has_value());
  CHECK(result.error().message.find('\n') == std::string::npos);
  return result.error();
}

const std::string disc = R"("fixture":[{"density":1,"circle":{"center":0,"radius":0.5}}])";

std::string world_of(const std::string& bodies, const std::string& joints = "") {
  return R"({"gravity":{"x":0,"y":-10},"stepsPerSecond":50,"continuousPhysics":true,"body":[)" + bodies +
         R"(],"joint":[)" + joints + "]}";
}
std::string body_with(const std::string& fixture) {
  return world_of(R"({"name":"b","type":0,"awake":true,"fixture":[{)" + fixture + "}]}");
}
Shape shape_with(const std::string& fixture) {
  const RubeImport import = imported(body_with(fixture));
  REQUIRE(import.scene.bodies.at(0).shapes.size() == 1);
  return import.scene.bodies[0].shapes[0];
}
RubeImport joined(const std::string& joint) {
  const std::string two = R"({"name":"ground","type":0,)" + disc +
                          R"(},{"name":"arm","type":2,"awake":true,"angle":1,)" + R"("position":{"x":1,"y":2},)" +
                          disc + "}";
  return imported(world_of(two, R"({"name":"j","bodyA":0,"bodyB":1,)" + joint + "}"));
}
Joint joint_with(const std::string& joint) {
  const RubeImport import = joined(joint);
  REQUIRE(import.scene.joints.size() == 1);
  CHECK(import.scene.joints[0].name == "j");
  CHECK(import.scene.joints[0].body_b == 1);
  return import.scene.joints[0];
}

}  // namespace

TEST_CASE("gravity, steps per second and continuous physics become settings", "[verifier][import_rube]") {
  const RubeImport import = imported(world_of(""));
  CHECK(import.scene.name == "f");
  CHECK(import.scene.gravity == Point{0, -10});
  CHECK(import.scene.settings.dt == 0.02);
  CHECK(import.scene.settings.continuous);
  CHECK(import.notes.empty());
  const RubeImport bare = imported("{}");
  CHECK(bare.scene.gravity == Point{});
  CHECK(bare.scene.settings.dt == 1.0 / 60);
  CHECK_FALSE(bare.scene.settings.continuous);
}

TEST_CASE("polygons are rounded by half the gap that Box2D leaves between them, circles are not",
          "[verifier][import_rube]") {
  // Two skins of 0.01 m that overlap by 0.005 m.
  const Shape square = shape_with(R"("polygon":{"vertices":{"x":[0,1,1,0],"y":[0,0,1,1]}})");
  CHECK(2 * square.radius == Approx(0.015));
  CHECK(shape_with(R"("circle":{"radius":1})").radius == 1);
}

TEST_CASE("a correction factor outside (0, 1] is refused", "[verifier][import_rube]") {
  const std::string two = R"({"name":"ground","type":0,)" + disc + R"(},{"type":2,"awake":true,)" + disc + "}";
  const auto message = [&](const std::string& factor) {
    return refused(world_of(two, R"({"type":"motor","bodyA":0,"bodyB":1,"correctionFactor":)" + factor + "}")).message;
  };
  CHECK(message("0") == "f.json: joint[0].correctionFactor: found 0, expected above 0, at most 1");
  CHECK(message("1.5") == "f.json: joint[0].correctionFactor: found 1.5, expected above 0, at most 1");
}

TEST_CASE("limits the wrong way round are refused, also where one of them is not given", "[verifier][import_rube]") {
  const std::string two = R"({"name":"ground","type":0,)" + disc + R"(},{"type":2,"awake":true,)" + disc + "}";
  const auto message = [&](const std::string& limits) {
    return refused(world_of(two, R"({"type":"revolute","bodyA":0,"bodyB":1,"enableLimit":true,)" + limits + "}"))
        .message;
  };
  CHECK(message(R"("lowerLimit":2,"upperLimit":1)") ==
        "f.json: joint[0].lowerLimit: found 2, expected at most upperLimit: 1");
  CHECK(message(R"("lowerLimit":1)") == "f.json: joint[0].lowerLimit: found 1, expected at most upperLimit: 0");
  CHECK(message(R"("upperLimit":-1)") ==
        "f.json: joint[0].upperLimit: found -1, expected at least 0, since there is no lowerLimit");
}

TEST_CASE("a body keeps its pose, motion and flags", "[verifier][import_rube]") {
  const Body body = imported(world_of(R"({"name":"crate","type":2,"awake":true,"position":{"x":1.5,"y":-2},"angle":0.5,
    "linearVelocity":{"x":3,"y":0},"linearDamping":0.1,"angularDamping":0.2,"gravityScale":0,"fixedRotation":true,
    "bullet":true,"allowSleep":false,)" +
                                      disc + "}"))
                        .scene.bodies.at(0);
  CHECK(body.name == "crate");
  CHECK(body.type == BodyType::dynamic_body);
  CHECK(body.position == Point{1.5, -2});
  CHECK(body.angle == 0.5);
  CHECK(body.velocity == Point{3, 0});
  CHECK(body.linear_damping == 0.1);
  CHECK(body.angular_damping == 0.2);
  CHECK(body.gravity_scale == 0);
  CHECK(body.fixed_rotation);
  CHECK(body.bullet);
  CHECK_FALSE(body.can_sleep);
  const Body bare = imported(world_of("{" + disc + "}")).scene.bodies.at(0);
  CHECK(bare.type == BodyType::static_body);
  CHECK(bare.position == Point{});
  CHECK(bare.gravity_scale == 1);
  CHECK(bare.can_sleep);
  CHECK(bare.name.empty());
}

TEST_CASE("the editor's mass becomes a stated one, its inertia moved to the centre of mass",
          "[verifier][import_rube]") {
  const std::string mass = R"("massData-mass":2,"massData-center":{"x":0.3,"y":0.4},"massData-I":1.5,)";
  const Body body = imported(world_of(R"({"type":2,"awake":true,)" + mass + disc + "}")).scene.bodies.at(0);
  REQUIRE(body.mass.has_value());
  CHECK(body.mass->mass == 2);
  CHECK(body.mass->center == Point{0.3, 0.4});
  REQUIRE(body.mass->inertia.has_value());
  CHECK(*body.mass->inertia == Approx(1.5 - 2 * 0.25));  // I_c = I_o - m |c|^2
  // A body with fixed rotation has no explicit inertia, and a static body has no explicit mass.
  const Body fixed =
      imported(world_of(R"({"type":2,"awake":true,"fixedRotation":true,)" + mass + disc + "}")).scene.bodies.at(0);
  CHECK_FALSE(fixed.mass->inertia.has_value());
  CHECK_FALSE(imported(world_of(R"({"type":0,)" + mass + disc + "}")).scene.bodies.at(0).mass.has_value());
}

TEST_CASE("a spinning body's velocity is moved from its origin to its centre of mass", "[verifier][import_rube]") {
  // v_c = v + w x R c with w = 2, angle pi / 2, c = (1, 0): R c = (0, 1), w x R c = (-2, 0).
  const Body body = imported(world_of(R"({"type":2,"awake":true,"angle":1.5707963267948966,"angularVelocity":2,
    "linearVelocity":{"x":5,"y":1},"massData-mass":1,"massData-I":3,"massData-center":{"x":1,"y":0},)" +
                                      disc + "}"))
                        .scene.bodies.at(0);
  CHECK(body.velocity.x == Approx(3));
  CHECK(body.velocity.y == Approx(1));
}

TEST_CASE("a body that moves and has no mass weighs 1 kg and does not turn", "[verifier][import_rube]") {
  const RubeImport import =
      imported(world_of(R"({"type":2,"awake":true,"fixture":[{"density":0,"circle":{"radius":1}}]})"));
  CHECK(import.scene.bodies.at(0).mass->mass == 1);
  CHECK(import.scene.bodies.at(0).fixed_rotation);
  CHECK(import.notes.size() == 1);
}

TEST_CASE("names are kept and made unique", "[verifier][import_rube]") {
  std::string bodies;
  for (const char* name : {"a", "a", "a#2", "a", "", ""})
    bodies += (bodies.empty() ? "" : ",") + (R"({"name":")" + std::string(name) + R"(",)" + disc + "}");
  const engine::Scene scene = imported(world_of(bodies)).scene;
  std::vector<std::string> names;
  for (const Body& body : scene.bodies) names.push_back(body.name);
  CHECK(names == std::vector<std::string>{"a", "a#3", "a#2", "a#4", "", ""});
}

TEST_CASE("a fixture keeps material, filter and sensor; what is missing has the format's value",
          "[verifier][import_rube]") {
  const Shape shape = shape_with(R"("density":2,"friction":0.3,"restitution":0.4,"sensor":true,"filter-categoryBits":4,
    "filter-maskBits":0,"filter-groupIndex":-3,"circle":{"center":{"x":1,"y":2},"radius":0.25})");
  CHECK(shape.kind == ShapeKind::circle);
  CHECK(shape.center == Point{1, 2});
  CHECK(shape.radius == 0.25);
  CHECK(shape.density == 2);
  CHECK(shape.material.friction == 0.3);
  CHECK(shape.material.restitution == 0.4);
  CHECK(shape.sensor);
  CHECK(shape.filter == engine::Filter{4, 0, -3});
  const Shape bare = shape_with(R"("circle":{"radius":1})");
  CHECK(bare.density > 0);
  CHECK(bare.density < 1e-6);
  CHECK(bare.material.friction == 0);
  CHECK(bare.filter == engine::Filter{});
  CHECK_FALSE(bare.sensor);
  CHECK(shape_with(R"("filter-maskBits":-1,"circle":{"radius":1})").filter == engine::Filter{});
  CHECK(shape_with(R"("filter-maskBits":65534,"circle":{"radius":1})").filter == engine::Filter{1, 65534, 0});
}

TEST_CASE("numbers may be the bits of a 32-bit float in hexadecimal", "[verifier][import_rube]") {
  CHECK(shape_with(R"("circle":{"radius":"3F800000"})").radius == 1);
  CHECK(shape_with(R"("circle":{"radius":1,"center":{"x":"c0490fdb","y":"00000000"}})").center.x ==
        static_cast<double>(-3.14159274F));
  for (const char* text : {"7F800000", "3F80000", "3F80000G", "3F80000000", ""}) {
    CAPTURE(text);
    const Error error = refused(body_with(R"("circle":{"radius":")" + std::string(text) + "\"}"));
    CHECK(error.message == "f.json: body[0].fixture[0].circle.radius: found \"" + std::string(text) +
                               "\", expected a finite number, or 8 hexadecimal digits of a 32-bit float");
  }
}

TEST_CASE("a polygon is kept as it is, or cleaned as Box2D does and told", "[verifier][import_rube]") {
  const Shape square = shape_with(R"("polygon":{"vertices":{"x":[0,1,1,0],"y":[0,0,1,1]}})");
  CHECK(square.kind == ShapeKind::polygon);
  CHECK(square.vertices == std::vector<Point>{{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  // One vertex is on an edge, one almost on another vertex, and one inside.
  const RubeImport import =
      imported(body_with(R"("polygon":{"vertices":{"x":[0,0.5,1,1.0001,1,0,0.4],"y":[0,0,0,0.0001,1,1,0.5]}})"));
  CHECK(import.scene.bodies.at(0).shapes.at(0).vertices.size() == 4);
  REQUIRE(import.notes.size() == 1);
  CHECK(import.notes[0] == "changed: body[0].fixture[0].polygon: 7 vertices, of which 4 are corners");
  const Error flat = refused(body_with(R"("polygon":{"vertices":{"x":[0,1,2],"y":[0,0,0]}})"));
  CHECK(flat.code == ErrorCode::invalid_scene);
  CHECK(flat.message.find("f.json: body[0].fixture[0].polygon: not a convex polygon of area") == 0);
}

TEST_CASE("a chain of two points is a segment, a longer one has both directions", "[verifier][import_rube]") {
  const Shape segment = shape_with(R"("chain":{"vertices":{"x":[-10,10],"y":[0,1]}})");
  CHECK(segment.kind == ShapeKind::segment);
  CHECK(segment.vertices == std::vector<Point>{{-10, 0}, {10, 1}});

  const RubeImport open = imported(body_with(R"("chain":{"vertices":{"x":[0,1,2],"y":[0,1,0]}})"));
  REQUIRE(open.scene.bodies.at(0).shapes.size() == 2);
  const Shape& forth = open.scene.bodies[0].shapes[0];
  const Shape& back = open.scene.bodies[0].shapes[1];
  CHECK(forth.kind == ShapeKind::chain);
  CHECK_FALSE(forth.loop);
  CHECK(forth.vertices == std::vector<Point>{{0, 0}, {1, 1}, {2, 0}});
  CHECK(back.vertices == std::vector<Point>{{2, 0}, {1, 1}, {0, 0}});
  CHECK(open.notes.empty());
}

TEST_CASE("a chain that closes itself is a loop without its repeated point", "[verifier][import_rube]") {
  const std::string loop = R"("chain":{"vertices":{"x":[0,2,2,0,0],"y":[0,0,2,2,0]},"hasNextVertex":true,
    "hasPrevVertex":true,"nextVertex":{"x":2,"y":0},"prevVertex":{"x":0,"y":2}})";
  const RubeImport import = imported(body_with(loop));
  REQUIRE(import.scene.bodies.at(0).shapes.size() == 2);
  for (const Shape& shape : import.scene.bodies[0].shapes) {
    CHECK(shape.loop);
    CHECK(shape.vertices.size() == 4);
  }
  CHECK(import.notes.empty());
  // Neighbour points of an open line are not part of the line. A note names them, and they do not collide.
  const RubeImport open = imported(
      body_with(R"("chain":{"vertices":{"x":[0,1,2],"y":[0,0,0]},"hasPrevVertex":true,"prevVertex":{"x":-1,"y":0}})"));
  CHECK(open.scene.bodies.at(0).shapes.at(0).vertices.size() == 3);
  REQUIRE(open.notes.size() == 1);
  CHECK(open.notes[0].find("prevVertex") != std::string::npos);
}

TEST_CASE("joints of every kind keep limits, motors and springs", "[verifier][import_rube]") {
  const Joint revolute = joint_with(R"("type":"revolute","anchorA":{"x":1,"y":2},"anchorB":0,"refAngle":0.5,
    "enableLimit":true,"lowerLimit":-1,"upperLimit":2,"enableMotor":true,"motorSpeed":3,"maxMotorTorque":4,
    "jointSpeed":9,"collideConnected":true)");
  CHECK(revolute.kind == JointKind::revolute);
  CHECK(revolute.anchor_a == Point{1, 2});
  CHECK(revolute.anchor_b == Point{});
  CHECK(revolute.reference_angle == 0.5);
  CHECK(revolute.limits == engine::Range{-1, 2});
  CHECK(revolute.motor == engine::JointMotor{3, 4});
  CHECK(revolute.collide_connected);
  const Joint free = joint_with(R"("type":"revolute","lowerLimit":-1,"upperLimit":2,"motorSpeed":3)");
  CHECK_FALSE(free.limits.has_value());
  CHECK_FALSE(free.motor.has_value());

  const Joint prismatic = joint_with(R"("type":"prismatic","localAxisA":{"x":0,"y":1},"enableMotor":true,
    "motorSpeed":-1,"maxMotorForce":50,"enableLimit":true,"upperLimit":2)");
  CHECK(prismatic.kind == JointKind::prismatic);
  CHECK(prismatic.axis == Point{0, 1});
  CHECK(prismatic.limits == engine::Range{0, 2});
  CHECK(prismatic.motor == engine::JointMotor{-1, 50});

  const Joint rod = joint_with(R"("type":"distance","length":2,"frequency":0,"dampingRatio":0.7)");
  CHECK(rod.kind == JointKind::distance);
  CHECK(rod.length == 2);
  CHECK_FALSE(rod.spring.has_value());
  const Joint elastic = joint_with(R"("type":"distance","length":2,"frequency":4,"dampingRatio":0.7)");
  CHECK(elastic.spring == engine::JointSpring{false, 4, 0.7, 0, 0});

  const Joint rope = joint_with(R"("type":"rope","maxLength":3)");
  CHECK(rope.kind == JointKind::distance);
  CHECK(rope.limits == engine::Range{0, 3});
  CHECK(rope.spring == engine::JointSpring{true, 0, 0, 0, 0});

  const Joint wheel = joint_with(R"("type":"wheel","localAxisA":{"x":0,"y":1},"springFrequency":5,
    "springDampingRatio":0.8,"enableMotor":true,"motorSpeed":6,"maxMotorTorque":7)");
  CHECK(wheel.kind == JointKind::wheel);
  CHECK(wheel.spring == engine::JointSpring{false, 5, 0.8, 0, 0});
  CHECK(wheel.motor == engine::JointMotor{6, 7});

  const Joint weld = joint_with(R"("type":"weld","refAngle":0.25,"frequency":2,"dampingRatio":0.5)");
  CHECK(weld.kind == JointKind::weld);
  CHECK(weld.reference_angle == 0.25);
  // Box2D's stiffness follows from the inertias alone: I w^2 with w = 2 pi 2 Hz. The inertia of the ground counts as
  // infinite.
  const double mass = engine::pi * 0.25;  // of the disc of 0.5 m
  const double inertia = mass * 0.125;
  const double omega = 4 * engine::pi;
  REQUIRE(weld.spring.has_value());
  CHECK(weld.spring->absolute);
  CHECK(weld.spring->stiffness == Approx(inertia * omega * omega));
  CHECK(weld.spring->damping == Approx(2 * 0.5 * inertia * omega));
  CHECK_FALSE(joint_with(R"("type":"weld")").spring.has_value());

  const Joint motor = joint_with(R"("type":"motor","anchorA":{"x":5,"y":6},"refAngle":1,"maxForce":8,"maxTorque":9)");
  CHECK(motor.kind == JointKind::motor);
  CHECK(motor.offset == Point{5, 6});
  CHECK(motor.anchor_a == Point{});
  CHECK(motor.angle_offset == 1);
  CHECK(motor.force_max == 8);
  CHECK(motor.torque_max == 9);
  // The joint returns at omega / (2 damping_ratio) = correctionFactor / dt. The file has 50 steps per second.
  const auto rate_of = [](const Joint& joint) {
    return engine::pi * joint.spring->hertz / joint.spring->damping_ratio;
  };
  CHECK(rate_of(motor) == Approx(0.3 * 50));  // Box2D's default
  CHECK(rate_of(joint_with(R"("type":"motor","correctionFactor":0.8)")) == Approx(0.8 * 50));
  CHECK(motor.spring->damping_ratio > 1);

  const Joint friction = joint_with(R"("type":"friction","maxForce":8,"maxTorque":9)");
  CHECK(friction.kind == JointKind::friction);
  CHECK(friction.force_max == 8);

  const Joint mouse =
      joint_with(R"("type":"mouse","target":{"x":1,"y":5},"maxForce":8,"frequency":5,"dampingRatio":1)");
  CHECK(mouse.kind == JointKind::target);
  CHECK(mouse.offset == Point{1, 5});
  CHECK(mouse.anchor_b.x == Approx(3 * std::sin(1)));  // (0, 3) from the origin of a body rotated by 1 rad
  CHECK(mouse.anchor_b.y == Approx(3 * std::cos(1)));
  CHECK(mouse.body_a == 0);
  REQUIRE(mouse.spring.has_value());
  CHECK(mouse.spring->stiffness == Approx(mass * 100 * engine::pi * engine::pi));
  CHECK(mouse.spring->damping == Approx(20 * engine::pi * mass));
}

TEST_CASE("a gear couples two joints of the file, in any order", "[verifier][import_rube]") {
  const auto file = [](const std::string& gear, const std::string& second) {
    const std::string bodies = R"({"name":"ground","type":0,)" + disc + R"(},{"name":"a","type":2,"awake":true,)" +
                               disc + R"(},{"name":"b","type":2,"awake":true,)" + disc + "}";
    return imported(world_of(bodies, R"({"name":"g","type":"gear","bodyA":1,"bodyB":2,)" + gear + R"(},)" +
                                         R"({"name":"rope","type":"rope","bodyA":1,"bodyB":2,"maxLength":9},)" +
                                         R"({"name":"p","type":"revolute","bodyA":0,"bodyB":1},)" +
                                         R"({"name":"q","bodyA":0,"bodyB":2,)" + second + "}"));
  };
  const std::string slider = R"("type":"prismatic","localAxisA":{"x":0,"y":1})";
  const RubeImport good = file(R"("joint1":2,"joint2":3,"ratio":-2,"collideConnected":true)", slider);
  CHECK(good.notes.empty());
  REQUIRE(good.scene.joints.size() == 4);
  const Joint& gear = good.scene.joints[3];  // after its joints
  CHECK(gear.kind == JointKind::gear);
  CHECK(gear.name == "g");
  CHECK(good.scene.joints[gear.joint_a].name == "p");
  CHECK(good.scene.joints[gear.joint_b].name == "q");
  CHECK(gear.ratio == -2);
  CHECK(gear.collide_connected);
  CHECK(engine::check_scene(good.scene, "s").has_value());
  CHECK(file(R"("joint1":2,"joint2":3)", slider).scene.joints[3].ratio == 1);

  const auto note_of = [&](const std::string& gear_text, const std::string& second) {
    const RubeImport import = file(gear_text, second);
    CHECK(engine::check_scene(import.scene, "s").has_value());
    return import.notes.empty() ? "" : import.notes[0];
  };
  const std::string begin = "not imported: joint[0] \"g\": gear, ";
  CHECK(note_of(R"("joint1":2,"joint2":1)", slider) == begin + "a joint of which is neither revolute nor prismatic");
  CHECK(note_of(R"("joint1":2,"joint2":0)", slider) == begin + "a joint of which was not imported");
  CHECK(note_of(R"("joint1":2,"joint2":2)", slider) == begin + "both joints of which have the same bodyB");
  CHECK(note_of(R"("joint1":2,"joint2":3,"ratio":0)", slider) == begin + "the ratio of which is 0 or extreme");
  CHECK(note_of(R"("joint1":2)", slider) == begin + "which names no joint2");
}

TEST_CASE("what is not imported is listed by name", "[verifier][import_rube]") {
  CHECK(joined(R"("type":"gear","ratio":2)").notes ==
        std::vector<std::string>{"not imported: joint[0] \"j\": gear, which names no joint1"});
  CHECK(joined(R"("type":"gear","ratio":2)").scene.joints.empty());
  CHECK(joined(R"("type":"motor","correctionSpeed":0.3)").notes ==
        std::vector<std::string>{"not imported: joint key \"correctionSpeed\""});
  const RubeImport import =
      imported(R"({"camera":{},"body":[{"customProperties":[],)" + disc + R"(}],"image":[{"name":"leaf"}]})");
  CHECK(import.notes == std::vector<std::string>{"not imported: image[0] \"leaf\" (no physics)",
                                                 "not imported: body key \"customProperties\"",
                                                 "not imported: world key \"camera\""});
  std::string images;
  for (int i = 0; i < 150; ++i) images += i == 0 ? "{}" : ",{}";
  const RubeImport many = imported(R"({"image":[)" + images + "]}");
  REQUIRE(many.notes.size() == tool::rube_note_count_max);
  CHECK(many.notes.back() == "and 51 more of this kind");
}

TEST_CASE("inactive bodies are left out with their joints, and the others keep theirs", "[verifier][rube]") {
  const std::string body = R"("type":2,"awake":true,)" + disc + "}";
  const RubeImport import = imported(
      world_of(R"({"name":"a",)" + body + R"(,{"name":"ghost","active":false,)" + body + R"(,{"name":"b",)" + body,
               R"({"type":"weld","name":"held","bodyA":0,"bodyB":2},)"
               R"({"type":"weld","name":"lost","bodyA":0,"bodyB":1})"));
  REQUIRE(import.scene.bodies.size() == 2);
  CHECK(import.scene.bodies[1].name == "b");
  REQUIRE(import.scene.joints.size() == 1);
  CHECK(import.scene.joints[0].name == "held");
  CHECK(import.scene.joints[0].body_a == 0);
  CHECK(import.scene.joints[0].body_b == 1);
  CHECK(import.notes == std::vector<std::string>{R"(not imported: body[1] "ghost": is inactive)",
                                                 R"(not imported: joint[1] "lost": one of its bodies is inactive)"});
}

TEST_CASE("broken files are refused with path, found and expected", "[verifier][import_rube]") {
  const std::pair<std::string, std::string> cases[] = {
      {"[]", "f.json: found an array of 0, expected an object with \"body\""},
      {R"({"body":5})", "f.json: body: found 5, expected an array"},
      {R"({"body":[5]})", "f.json: body[0]: found 5, expected an object"},
      {R"({"stepsPerSecond":0})", "f.json: stepsPerSecond: found 0, expected steps per second, at least 1"},
      {R"({"gravity":{"x":1}})", "f.json: gravity: found an object, expected {\"x\": ..., \"y\": ...}, or 0"},
      {world_of(R"({"type":3})"), "f.json: body[0].type: found 3, expected a whole number, 0..2"},
      {world_of(R"({"type":1.5})"), "f.json: body[0].type: found 1.5, expected a whole number, 0..2"},
      {world_of(R"({"awake":1})"), "f.json: body[0].awake: found 1, expected true or false"},
      {world_of(R"({"name":[]})"), "f.json: body[0].name: found an array of 0, expected a text"},
      {world_of(R"({"angle":null})"),
       "f.json: body[0].angle: found null, expected a finite number, or 8 hexadecimal digits of a 32-bit float"},
      {world_of(R"({"active":1})"), "f.json: body[0].active: found 1, expected true or false"},
      {body_with(""),
       "f.json: body[0].fixture[0]: found an object, expected a \"circle\", \"polygon\" or \"chain\" in it"},
      {body_with(R"("circle":{})"), "f.json: body[0].fixture[0].circle: found no radius, expected one above 0"},
      {body_with(R"("polygon":{"vertices":{"x":[0,1,1],"y":[0,0]}})"),
       "f.json: body[0].fixture[0].polygon.vertices.y: found an array of 2, expected as many as x: 3"},
      {body_with(R"("chain":{"vertices":{"x":[1,1],"y":[2,2]}})"),
       "f.json: body[0].fixture[0].chain: found fewer than 2 different points of a chain"},
      {body_with(R"("filter-maskBits":65536,"circle":{"radius":1})"),
       "f.json: body[0].fixture[0].filter-maskBits: found 65536, expected a whole number, -32768..65535"},
      {world_of("{" + disc + "}", R"({"type":"weld","bodyA":0})"), "f.json: joint[0]: found no \"bodyB\""},
      {world_of("{" + disc + "}", R"({"type":"weld","bodyA":0,"bodyB":1})"),
       "f.json: joint[0].bodyB: found 1, expected a whole number, 0..0"},
      {world_of("{" + disc + "}", R"({"type":"weld","bodyA":0,"bodyB":0})"),
       "f.json: joint[0]: found body 0 twice, expected two"},
      {world_of("{" + disc + R"(},{"type":2,"awake":true,)" + disc + "}", R"({"type":"glue","bodyA":0,"bodyB":1})"),
       "f.json: joint[0].type: found \"glue\", expected revolute, prismatic, distance, rope, wheel, weld, motor, "
       "friction, mouse, gear or pulley"},
  };
  for (const auto& [json, message] : cases) {
    CAPTURE(json);
    CHECK(refused(json).message == message);
  }
  CHECK(refused("{\"body\": [").message.find("f.json: broken JSON: parse error at line 1") == 0);
}

TEST_CASE("depth, counts and size are bounded before memory is spent", "[verifier][import_rube]") {
  CHECK(refused(std::string(100'000, '[')).code == ErrorCode::limit);
  CHECK(refused(R"({"name":"[[[[[[[[[[[[[[[[[[[[\"","body":0})").code == ErrorCode::invalid_scene);
  CHECK(refused("[" + std::string(4'000'000, ',') + "]").code == ErrorCode::limit);
  CHECK(refused(std::string(tool::rube_file_size_max + 1, ' ')).code == ErrorCode::limit);
  std::string coordinates = "0";
  for (std::size_t i = 0; i < limits::chain_vertex_count_max + 1; ++i) coordinates += ",0";
  const Error error = refused(body_with(R"("chain":{"vertices":{"x":[)" + coordinates + R"(],"y":[]}})"));
  CHECK(error.code == ErrorCode::limit);
  CHECK(error.message == "f.json: body[0].fixture[0].chain.vertices.x: too many: found 16386, expected at most 16385");
}

TEST_CASE("a file cut anywhere is an error, never a crash", "[verifier][import_rube][corruption]") {
  const std::string whole = world_of(R"({"name":"a","type":2,"awake":true,)" + disc + "},{" + disc + "}",
                                     R"({"type":"weld","bodyA":0,"bodyB":1})");
  REQUIRE(import_rube(whole, "f.json", "f").has_value());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    CAPTURE(size);
    CHECK_FALSE(import_rube(std::string_view(whole).substr(0, size), "f.json", "f").has_value());
  }
}

}  // namespace ticktrue::test
