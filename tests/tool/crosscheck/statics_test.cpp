// Statics against answers that can be worked out by hand.
// SPDX-License-Identifier: MIT
#include "tool/crosscheck/statics.h"

#include <cmath>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/scenes.h"
#include "tool/crosscheck/crosscheck.h"

namespace ticktrue::test {
namespace {

using engine::Point;
using tool::can_balance;
using tool::StaticBody;
using tool::StaticContact;

constexpr double statics_friction = 0.6;

struct StaticStructure {
  std::vector<StaticBody> bodies{StaticBody{}};  // the ground first
  std::vector<StaticContact> contacts;

  void add_box(double x, double y, double weight, double size = 1) {
    bodies.push_back({true, {x, y}, {0, -weight}, size});
  }
  /// The last box rests on the body before it, between two points at height `y`.
  void rest_between(double left, double right, double y) {
    const auto upper = static_cast<std::uint32_t>(bodies.size() - 1);
    for (const double x : {left, right}) contacts.push_back({upper - 1, upper, {x, y}, {0, 1}, statics_friction});
  }
  bool balances() const { return can_balance(bodies, contacts); }
};

}  // namespace

TEST_CASE("stacks of any mass ratio balance, and a box beside its support does not", "[crosscheck][analytic]") {
  for (const int count : {1, 5, 40})
    for (const double factor : {0.2, 1.0, 5.0}) {
      if (count == 40 && factor != 1) continue;
      StaticStructure stack;
      double weight = 10;
      for (int i = 0; i < count; ++i, weight *= factor) {
        stack.add_box(0, 0.5 + i, weight);
        stack.rest_between(-0.5, 0.5, i);
      }
      CAPTURE(count, factor);
      CHECK(stack.balances());
      stack.bodies.back().center.x = 0.51;  // its weight acts beyond the edge
      CHECK_FALSE(stack.balances());
    }
}

TEST_CASE("a box on a slope balances if its friction is the tangent at least", "[crosscheck][analytic]") {
  for (const double angle : {0.1, 0.5, 1.0})
    for (const double share : {0.99, 1.01}) {
      const Point normal{-std::sin(angle), std::cos(angle)};
      const Point along{std::cos(angle), std::sin(angle)};
      std::vector<StaticBody> bodies{StaticBody{}, {true, {0, 0}, {0, -3}, 1}};
      std::vector<StaticContact> contacts;
      for (const double half : {-1.0, 1.0})  // so flat that it does not topple
        contacts.push_back({0,
                            1,
                            {half * along.x - 0.1 * normal.x, half * along.y - 0.1 * normal.y},
                            normal,
                            share * std::tan(angle)});
      CAPTURE(angle, share);
      CHECK(can_balance(bodies, contacts) == (share > 1));
    }
}

TEST_CASE("a square topples from a slope steeper than one half right angle", "[crosscheck][analytic]") {
  for (const double slope : {0.98, 1.02}) {
    const double angle = std::atan(slope);
    const Point normal{-std::sin(angle), std::cos(angle)};
    const Point along{std::cos(angle), std::sin(angle)};
    std::vector<StaticBody> bodies{StaticBody{}, {true, {0, 0}, {0, -1}, 1}};
    std::vector<StaticContact> contacts;
    for (const double half : {-0.5, 0.5})
      contacts.push_back({0, 1, {half * along.x - 0.5 * normal.x, half * along.y - 0.5 * normal.y}, normal, 3.0});
    CAPTURE(slope);
    CHECK(can_balance(bodies, contacts) == (slope < 1));
  }
}

TEST_CASE("bricks overhang as far as the harmonic series says", "[crosscheck][analytic]") {
  for (const double share : {0.9, 0.99, 1.01, 1.1}) {
    StaticStructure pile;
    std::vector<double> places{0};  // from the top, bricks of length 2
    for (int above = 1; above <= 6; ++above) places.push_back(places.back() - share / above);
    for (std::size_t i = places.size() - 1; i-- > 0;) {
      const double y = 0.5 * static_cast<double>(places.size() - 1 - i);
      pile.add_box(places[i], y, 7, 0.5);
      pile.rest_between(places[i] - 1, places[i + 1] + 1, y - 0.25);
    }
    CAPTURE(share);
    CHECK(pile.balances() == (share < 1));
  }
}

TEST_CASE("two leaning cards need a friction of half the tangent of their angle", "[crosscheck][analytic]") {
  const double angle = 0.4;  // from the vertical
  for (const double share : {0.98, 1.02}) {
    const double mu = share * 0.5 * std::tan(angle);
    const double x = std::sin(angle);
    const double y = std::cos(angle);
    const std::vector<StaticBody> bodies{
        StaticBody{}, {true, {-x / 2, y / 2}, {0, -1}, 1}, {true, {x / 2, y / 2}, {0, -1}, 1}};
    const std::vector<StaticContact> contacts{
        {0, 1, {-x, 0}, {0, 1}, mu}, {0, 2, {x, 0}, {0, 1}, mu}, {1, 2, {0, y}, {1, 0}, 0}};
    CAPTURE(share);
    CHECK(can_balance(bodies, contacts) == (share > 1));
  }
}

TEST_CASE("what has no weight, no contact or too many contacts is not known to stand", "[crosscheck]") {
  StaticStructure box;
  box.add_box(0, 0.5, 1);
  CHECK_FALSE(box.balances());
  box.rest_between(-0.5, 0.5, 0);
  CHECK(box.balances());
  box.bodies.back().weight = {0, 0};
  CHECK_FALSE(box.balances());
  box.bodies.back().weight = {0, -1};
  while (box.contacts.size() <= tool::statics_point_count_max) box.contacts.push_back(box.contacts.back());
  CHECK_FALSE(box.balances());
}

TEST_CASE("a run balances by the scene's own friction, whatever forces an engine reports", "[crosscheck][analytic]") {
  // A box at rest on a slope, as an engine with any friction would report it.
  const double angle = 0.3;  // tan = 0.309
  const Point normal{-std::sin(angle), std::cos(angle)};
  const Point along{std::cos(angle), std::sin(angle)};
  Scene scene = empty_scene(Precision::f64);
  scene.bodies = {body_of(box_shape(20, 1), {-normal.x, -normal.y}), unit_box({0.5 * normal.x, 0.5 * normal.y})};
  scene.bodies[0].type = BodyType::static_body;
  for (Body& body : scene.bodies) body.angle = angle;
  const auto balances = [&](const Scene& now) {
    const tool::CrosscheckLayout layout = tool::make_layout(now);
    std::vector<engine::BodyReport> bodies(2);
    for (std::uint32_t id = 0; id < 2; ++id) {
      bodies[id].id = id;
      bodies[id].center = now.bodies[id].position;
      bodies[id].angle = now.bodies[id].angle;
    }
    engine::ContactReport contact;
    contact.body_a = 0;
    contact.body_b = 1;
    contact.normal = normal;
    contact.point_count = 2;
    for (int i = 0; i < 2; ++i) {
      const double half = i == 0 ? -0.5 : 0.5;
      contact.point[i] = {half * along.x, half * along.y};
      contact.normal_force[i] = 5;
    }
    tool::CrosscheckMeasure measure(layout, 0, 0);
    const std::vector<engine::ContactReport> contacts{contact};
    for (int tick = 1; tick <= 100; ++tick) measure.add(tick / 60.0, bodies, &contacts);
    const tool::CrosscheckRun run = measure.finish();
    CHECK(run.stood);
    return run.balances;
  };
  const auto with_friction = [&](double of_ground, double of_box, engine::MixRule rule) {
    Scene now = scene;
    now.settings.friction_mix = rule;
    now.bodies[0].shapes[0].material.friction = of_ground;
    now.bodies[1].shapes[0].material.friction = of_box;
    return balances(now);
  };
  using engine::MixRule;
  CHECK(with_friction(0.31, 0.31, MixRule::geometric_mean));
  CHECK_FALSE(with_friction(0.3, 0.3, MixRule::geometric_mean));
  CHECK(with_friction(0.1, 0.31, MixRule::maximum));
  CHECK_FALSE(with_friction(0.3, 1, MixRule::minimum));
  CHECK(with_friction(0.1, 0.53, MixRule::average));
  CHECK_FALSE(with_friction(0.1, 0.53, MixRule::geometric_mean));

  Scene driven = scene;
  for (Body& body : driven.bodies) body.shapes[0].material.friction = 1;
  CHECK(balances(driven));
  driven.bodies[0].shapes[0].material.tangent_speed = 1;
  CHECK_FALSE(balances(driven));
  driven = scene;
  driven.forces.emplace_back();
  CHECK_FALSE(balances(driven));
}

}  // namespace ticktrue::test
