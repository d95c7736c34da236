// The drawn bodies of a state equal the bodies that the engine reports.
// SPDX-License-Identifier: MIT
#include "tool/drawing/drawing.h"

#include <cmath>
#include <cstring>

#include "engine/engine.h"
#include "tests/support/catch.h"
#include "tests/support/joints.h"
#include "tests/support/scenes.h"
#include "tool/drawing/joint_geometry.h"

namespace ticktrue::test {
namespace {

using tool::Drawing;
using tool::DrawnBody;

/// Every kind of shape, some off the body's origin, moving and rotating.
Scene all_shapes(Precision precision) {
  Scene scene = empty_scene(precision);
  scene.bodies.push_back(ground());
  Shape rounded = box_shape(0.5, 0.25);
  rounded.radius = 0.1;
  rounded.center = {0.3, 0.2};
  rounded.angle = 0.5;
  Shape sensor = disc_shape(2);
  sensor.sensor = true;
  for (const Shape& shape : {disc_shape(0.5), box_shape(0.5, 0.3), rounded, capsule_shape({-1, 0}, {1, 0.5}, 0.25),
                             polygon_shape({{1, 1}, {0, 0}, {1, 0}, {0, 1.5}}), sensor}) {
    Body body = body_of(shape, {3.0 * static_cast<double>(scene.bodies.size()), 5});
    body.name = "thrown_" + std::to_string(scene.bodies.size());
    body.velocity = {1, 4};
    body.angular_velocity = 2;
    body.angle = 0.25;
    body.shapes.push_back(disc_shape(0.125));
    scene.bodies.push_back(body);
  }
  scene.bodies.push_back(body_of(chain_shape({{60, 0}, {30, 1}, {-60, 0}}), {0, 0}, BodyType::static_body));
  scene.bodies.push_back(body_of(segment_shape({0, 0}, {0, 9}), {-40, 0}, BodyType::static_body));
  return scene;
}

TEST_CASE("drawing: bodies stand where the engine says, in both precisions", "[verifier][drawing][equivalence]") {
  for (const Precision precision : {Precision::f32, Precision::f64}) {
    const Scene scene = all_shapes(precision);
    const auto engine = engine::make_engine(scene);
    REQUIRE(engine.has_value());
    const Drawing drawing(scene, *(*engine)->state().schema);
    std::vector<DrawnBody> drawn;
    for (int tick = 0; tick < 40; ++tick) {
      drawing.read((*engine)->state(), drawn);
      const auto bodies = (*engine)->bodies();
      REQUIRE(drawn.size() == bodies.size());
      for (std::size_t i = 0; i < drawn.size(); ++i) {
        const tool::Figure& figure = drawing.figures()[drawn[i].figure];
        // Centres of mass are rounded to the engine's precision. All other values have equal bits.
        const double off = precision == Precision::f32 ? 1e-5 : 1e-12;
        const Point origin = to_world(drawn[i], figure, {0, 0});
        CHECK(drawn[i].id == bodies[i].id);
        CHECK(drawing.name(drawn[i]) == bodies[i].name);
        CHECK(drawn[i].center == bodies[i].center);
        CHECK(drawn[i].velocity == bodies[i].velocity);
        CHECK(drawn[i].angular_velocity == bodies[i].angular_velocity);
        CHECK(std::hypot(origin.x - bodies[i].origin.x, origin.y - bodies[i].origin.y) < off);
        CHECK(std::fabs(drawn[i].cos - std::cos(bodies[i].angle)) < off);
        CHECK(std::fabs(drawn[i].sin - std::sin(bodies[i].angle)) < off);
        CHECK(figure.type == bodies[i].type);
      }
      REQUIRE((*engine)->step({scene.settings.dt, {}}, nullptr));
    }
    CHECK(drawing.gravity((*engine)->state()) == scene.gravity);
  }
}

TEST_CASE("drawing: an outline says what a shape is", "[verifier][drawing][analytic]") {
  const auto disc = tool::outline_of(disc_shape(0.5));
  CHECK((disc.points.size() == 1 && disc.radius == 0.5 && !disc.is_line));
  const auto capsule = tool::outline_of(capsule_shape({-1, 0}, {1, 0}, 0.25));
  CHECK((capsule.points.size() == 2 && capsule.radius == 0.25 && !capsule.is_line));
  const auto segment = tool::outline_of(segment_shape({0, 0}, {1, 0}));
  CHECK((segment.points.size() == 2 && segment.is_line && !segment.is_closed));
  Shape loop = chain_shape({{0, 0}, {1, 0}, {1, 1}});
  loop.loop = true;
  CHECK(tool::outline_of(loop).is_closed);
  const auto polygon = tool::outline_of(polygon_shape({{1, 1}, {0, 0}, {1, 0}, {0, 1}}));
  REQUIRE(polygon.points.size() == 4);
  double area = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point &a = polygon.points[i], &b = polygon.points[(i + 1) % 4];
    area += (a.x * b.y - b.x * a.y) / 2;
  }
  CHECK(area == 1);  // ordered, counter-clockwise
}

TEST_CASE("drawing: a body that is not finite is marked, spawned ones have their prototype's name",
          "[verifier][drawing][regression]") {
  Scene scene = empty_scene(Precision::f64);
  scene.bodies.push_back(unit_box({0, 1}));
  scene.prototypes.push_back(body_of(disc_shape(0.5), {0, 0}));
  scene.prototypes[0].name = "ball";
  scene.inputs = {engine::InputKind::spawn};
  const auto engine = engine::make_engine(scene);
  REQUIRE(engine.has_value());
  const StateView& state = (*engine)->state();
  const Drawing drawing(scene, *state.schema);
  std::vector<DrawnBody> drawn;
  drawing.read(state, drawn);
  REQUIRE(drawn.size() == 1);
  CHECK(drawn[0].is_finite);
  CHECK(drawing.name(drawn[0]) == "body#0");
  const auto table = state.schema->find_table("bodies");
  REQUIRE(table.has_value());
  std::vector<std::uint8_t> rows(state.tables[*table].data,
                                 state.tables[*table].data + state.schema->tables[*table].row_size);
  const double bad = std::nan("");
  for (const Column& column : state.schema->tables[*table].columns) {
    if (column.name == "source") rows[column.offset] = 1;
    if (column.name == "position") std::memcpy(rows.data() + column.offset, &bad, sizeof bad);
  }
  StateView broken = state;
  broken.tables[*table].data = rows.data();
  drawing.read(broken, drawn);
  REQUIRE(drawn.size() == 1);
  CHECK_FALSE(drawn[0].is_finite);
  CHECK(drawing.name(drawn[0]) == "ball#0");
}

TEST_CASE("a joint is drawn from anchor to anchor, a pulley over its ground anchors", "[verifier][drawing][analytic]") {
  const tool::JointPlaces places{{0, 0}, {3, 4}, {1, 0}};
  for (const auto& info : engine::joint_kinds) {
    CAPTURE(info.name);
    Joint joint = joint_of(info.kind, 0, 1);
    joint.ground_anchor_a = {0, 6};
    joint.ground_anchor_b = {3, 6};
    const tool::JointLines shown = tool::joint_lines(joint, places);
    const bool over = info.kind == JointKind::pulley;
    REQUIRE(shown.count == (over ? 3 : 1));
    CHECK(shown.lines[0] ==
          (over ? std::array<Point, 2>{Point{0, 6}, Point{0, 0}} : std::array{Point{0, 0}, Point{3, 4}}));
    if (over) CHECK(shown.lines[2] == std::array{Point{0, 6}, Point{3, 6}});
  }
}

TEST_CASE("a gear is shown between the anchors of its two turning bodies", "[verifier][drawing][analytic]") {
  Scene scene = empty_scene();
  scene.bodies = {peg({0, 0}), bob({1, 0}), bob({3, 0})};
  scene.joints = {joint_of(JointKind::revolute, 0, 1), joint_of(JointKind::prismatic, 0, 2),
                  joint_of(JointKind::gear, 0, 0)};
  scene.joints[0].anchor_b = {-1, 2};
  scene.joints[1].anchor_b = {4, 5};
  scene.joints[2].joint_b = 1;
  const Joint shown = tool::shown_joint(scene, scene.joints[2]);
  CHECK(shown.body_a == 1);
  CHECK(shown.anchor_a == Point{-1, 2});
  CHECK(shown.body_b == 2);
  CHECK(shown.anchor_b == Point{4, 5});
  CHECK(tool::shown_joint(scene, scene.joints[1]) == scene.joints[1]);
}

TEST_CASE("the gap of a joint is what its rigid rows hold", "[verifier][drawing][analytic]") {
  const tool::JointPlaces places{{0, 0}, {3, 4}, {2, 0}};
  const auto gap = [&](JointKind kind, auto change) {
    Joint joint = joint_of(kind, 0, 1);
    change(joint);
    return joint_gap(joint, places);
  };
  const auto as_it_is = [](Joint&) {};
  CHECK(gap(JointKind::revolute, as_it_is) == Approx(5));
  CHECK(gap(JointKind::prismatic, as_it_is) == Approx(4));
  CHECK(gap(JointKind::wheel, as_it_is) == Approx(4));
  CHECK(gap(JointKind::weld, as_it_is) == Approx(5));
  CHECK(gap(JointKind::weld, [](Joint& j) { j.linear_spring = absolute_spring(1); }) == 0);
  CHECK(gap(JointKind::distance, [](Joint& j) { j.length = 4; }) == Approx(1));
  CHECK(gap(JointKind::distance, [](Joint& j) { j.limits = engine::Range{0, 1}; }) == 0);
  for (const JointKind kind : {JointKind::motor, JointKind::friction, JointKind::target, JointKind::gear})
    CHECK(gap(kind, as_it_is) == 0);
  const auto rope = [](Joint& j) {
    j.ground_anchor_a = {0, 6};
    j.ground_anchor_b = {3, 6};
    j.ratio = 3;
    j.length = 11.5;
  };
  CHECK(gap(JointKind::pulley, rope) == Approx(0.5));  // 6 + 3 * 2 - 11.5
}

}  // namespace
}  // namespace ticktrue::test
