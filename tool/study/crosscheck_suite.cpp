// Towers, walls, arches, slopes, levers and chains, in SI units, on a floor of 40 m.
// SPDX-License-Identifier: MIT
#include "tool/study/crosscheck_suite.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "engine/math/trig.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Body;
using engine::BodyType;
using engine::JointKind;
using engine::Point;
using engine::Scene;
using engine::Shape;

Shape box(double width, double height) {
  return worlds::box(width / 2, height / 2);
}

// Builds a scene. Bodies are dynamic unless a function says otherwise.
struct Builder {
  Scene scene;

  Builder() {
    engine::choose_substeps(scene.settings);
    add_static({0, -1}, box(40, 2));
  }

  Body& add(Point at, Shape shape, double angle = 0) {
    scene.bodies.push_back(worlds::body(std::move(shape), at));
    scene.bodies.back().angle = angle;
    return scene.bodies.back();
  }
  Body& add_static(Point at, Shape shape, double angle = 0) {
    Body& body = add(at, std::move(shape), angle);
    body.type = BodyType::static_body;
    return body;
  }
  void tower(double x, double y, int count, double width, double height, double density = 1) {
    for (int i = 0; i < count; ++i) {
      Shape shape = box(width, height);
      shape.density = density;
      add({x, y + (i + 0.5) * height}, std::move(shape));
    }
  }
  void friction(double value) {
    for (Body& body : scene.bodies)
      for (Shape& shape : body.shapes) shape.material.friction = value;
  }
  // Connects the upper end of a link to the lower end of the link above, or to the peg, by a revolute joint.
  void pin(std::uint32_t a, std::uint32_t b, Point anchor_a, Point anchor_b) {
    scene.joints.push_back(worlds::joint(JointKind::revolute, a, b, anchor_a, anchor_b));
  }
  std::uint32_t last() const { return static_cast<std::uint32_t>(scene.bodies.size() - 1); }
};

template <int count>
Scene tower() {
  Builder built;
  built.tower(0, 0, count, 1, 1);
  return built.scene;
}

Scene slabs() {
  Builder built;
  built.tower(0, 0, 10, 2, 0.4);
  return built.scene;
}

Scene pillar() {
  Builder built;
  built.tower(0, 0, 4, 0.6, 1.2);
  return built.scene;
}

Scene two_towers() {
  Builder built;
  built.tower(-2, 0, 5, 1, 1);
  built.tower(2, 0, 5, 1, 1);
  built.add({0, 5.2}, box(6, 0.4));
  built.tower(-1.5, 5.4, 1, 1, 1);
  built.tower(1.5, 5.4, 1, 1, 1);
  return built.scene;
}

template <int base>
Scene pyramid() {
  Builder built;
  for (int row = 0; row < base; ++row)
    for (int i = 0; i + row < base; ++i) built.add({1.1 * (i + 0.5 * row - 0.5 * (base - 1)), row + 0.5}, box(1, 1));
  return built.scene;
}

// Bricks in running bond: every other course ends in half bricks.
Scene wall() {
  Builder built;
  const int columns = 6;
  for (int row = 0; row < 8; ++row) {
    const double y = 0.5 * row + 0.25;
    if (row % 2 == 0) {
      for (int i = 0; i < columns; ++i) built.add({i - 0.5 * (columns - 1), y}, box(0.98, 0.5));
      continue;
    }
    built.add({-0.5 * columns + 0.25, y}, box(0.48, 0.5));
    for (int i = 0; i + 1 < columns; ++i) built.add({i - 0.5 * (columns - 2), y}, box(0.98, 0.5));
    built.add({0.5 * columns - 0.25, y}, box(0.48, 0.5));
  }
  return built.scene;
}

// Posts and lintels, three floors.
Scene gates() {
  Builder built;
  for (int floor = 0; floor < 3; ++floor) {
    const double y = 2.4 * floor;
    built.add({-1.2, y + 1}, box(0.5, 2));
    built.add({1.2, y + 1}, box(0.5, 2));
    built.add({0, y + 2.2}, box(3.2, 0.4));
  }
  return built.scene;
}

// A half ring of wedge-shaped stones on two fixed feet.
Scene arch() {
  const int stones = 7;
  const double inner = 2, outer = 3;
  Builder built;
  built.add_static({-0.5 * (inner + outer), 0.5}, box(outer - inner, 1));
  built.add_static({0.5 * (inner + outer), 0.5}, box(outer - inner, 1));
  for (int i = 0; i < stones; ++i) {
    const double from = engine::pi * i / stones;
    const double to = engine::pi * (i + 1) / stones;
    const engine::SinCos middle = engine::sin_cos(0.5 * (from + to));
    const double radius = 0.5 * (inner + outer);
    const Point at{radius * middle.cos, 1 + radius * middle.sin};
    std::vector<Point> corners;
    for (const double angle : {from, to})
      for (const double reach : {inner, outer}) {
        const engine::SinCos turn = engine::sin_cos(angle);
        corners.push_back({reach * turn.cos - at.x, 1 + reach * turn.sin - at.y});
      }
    built.add(at, worlds::polygon(std::move(corners)));
  }
  built.friction(0.9);
  return built.scene;
}

// Two cards lean against each other; friction holds their feet.
Scene tent_of(double friction) {
  Builder built;
  const double lean = 0.35;  // rad, from upright
  const engine::SinCos turn = engine::sin_cos(lean);
  const double length = 2, thickness = 0.1;
  const double x = 0.5 * (length * turn.sin + thickness * turn.cos);
  const double y = 0.5 * (length * turn.cos + thickness * turn.sin);
  built.add({-x, y}, box(thickness, length), -lean);
  built.add({x, y}, box(thickness, length), lean);
  built.friction(friction);
  return built.scene;
}
Scene tent_stands() {
  return tent_of(0.8);
}
Scene tent_slips() {
  return tent_of(0.05);  // too little: the feet need a friction of tan(0.35) / 2 = 0.18
}

Scene dominoes_of(double push) {
  Builder built;
  for (int i = 0; i < 10; ++i) built.add({0.6 * i - 2.7, 0.5}, box(0.16, 1));
  Body& first = built.scene.bodies[1];
  first.velocity = {0.5 * push, 0};
  first.angular_velocity = -push;
  return built.scene;
}
Scene dominoes_standing() {
  return dominoes_of(0);
}
Scene dominoes_falling() {
  return dominoes_of(3);
}

Scene top_heavy() {
  Builder built;
  built.add({0, 0.5}, box(1, 1));
  built.add({0, 1.5}, box(1.4, 1));
  built.add({0, 2.5}, box(1.8, 1));
  built.add({0, 3.5}, box(2.2, 1));
  return built.scene;
}

// The upper floor has ten times the density of the lower one.
Scene heavy_on_light() {
  Builder built;
  built.tower(0, 0, 1, 1, 1);
  built.tower(0, 1, 1, 1, 1, 10);
  return built.scene;
}

Scene light_on_heavy() {
  Builder built;
  built.tower(0, 0, 1, 1, 1, 100);
  built.tower(0, 1, 4, 1, 1);
  return built.scene;
}

// Each brick overhangs by `share` of the largest stable overhang, which follows the harmonic series. Below a share of 1
// the bricks stand.
Scene overhang_of(double share) {
  Builder built;
  const int count = 4;
  double x = 0;
  std::vector<double> places(count);
  for (int i = count; i-- > 0;) {
    places[static_cast<std::size_t>(i)] = x;
    x -= share * 1.0 / (count - i);  // half a brick of 2 m, divided by the number of bricks above the joint
  }
  built.add_static({places[0] - share * 0.25, 0.5}, box(2, 1));
  for (int i = 0; i < count; ++i) built.add({places[static_cast<std::size_t>(i)], 1.25 + 0.5 * i}, box(2, 0.5));
  return built.scene;
}
Scene overhang_holds() {
  return overhang_of(0.6);
}
Scene overhang_falls() {
  return overhang_of(1.3);
}

// A tower whose courses are shifted by `step` each. The tower stands while its centre of mass is over its foot.
Scene leaning_of(double step) {
  Builder built;
  for (int i = 0; i < 6; ++i) built.add({step * i, i + 0.5}, box(1, 1));
  return built.scene;
}
Scene leaning_holds() {
  return leaning_of(0.06);
}
Scene leaning_falls() {
  return leaning_of(0.3);
}

// A box lies with an edge down in the groove between two wedges. Friction on the floor holds the wedges together.
Scene wedges_hold() {
  Builder built;
  built.add({-1, 0}, worlds::polygon({{-1, 0}, {1, 0}, {1, 0.2}, {-0.8, 2}, {-1, 2}}));
  built.add({1, 0}, worlds::polygon({{1, 0}, {-1, 0}, {-1, 0.2}, {0.8, 2}, {1, 2}}));
  const double half_diagonal = 0.70710678118654752;
  built.add({0, 0.2 + half_diagonal}, box(1, 1), engine::pi / 4);
  built.friction(0.9);
  return built.scene;
}

Scene mixed_tower() {
  Builder built;
  built.add({0, 0.5}, box(1.6, 1));
  built.add({0, 1 + 0.5 * 0.86602540378443865}, worlds::polygon({{-0.9, -0.43301270189221933},
                                                                 {0.9, -0.43301270189221933},
                                                                 {0.6, 0.43301270189221933},
                                                                 {-0.6, 0.43301270189221933}}));
  built.add({0, 1.86602540378443865 + 0.6 * 0.92387953251128674}, worlds::regular(8, 0.6));
  built.add({0, 1.86602540378443865 + 1.2 * 0.92387953251128674 + 0.25}, box(1, 0.5));
  return built.scene;
}

Scene octagons() {
  Builder built;
  const double apothem = worlds::apothem(8, 0.5);
  for (int i = 0; i < 4; ++i) built.add({0, apothem * (2 * i + 1)}, worlds::regular(8, 0.5));
  return built.scene;
}

// Discs in a tray: each row of discs carries the row above, and the walls keep the rows together.
Scene disc_tray() {
  Builder built;
  built.add_static({-2.6, 0.6}, box(0.2, 1.2));
  built.add_static({2.6, 0.6}, box(0.2, 1.2));
  for (int row = 0; row < 3; ++row)
    for (int i = 0; i + row < 5; ++i)
      built.add({i + 0.5 * row - 2, 0.5 + 0.86602540378443865 * row}, worlds::disc(0.5));
  return built.scene;
}

// A floor inclined by `angle`, with a stack of boxes on the floor.
Scene slope_of(double angle, double friction, int boxes) {
  Builder built;
  const engine::SinCos turn = engine::sin_cos(angle);
  const Point foot{0, 6};
  built.add_static({foot.x + turn.sin, foot.y - turn.cos}, box(20, 2), angle);
  for (int i = 0; i < boxes; ++i) {
    const double up = i + 0.5;
    built.add({foot.x - up * turn.sin, foot.y + up * turn.cos}, box(1, 1), angle);
  }
  built.friction(friction);
  return built.scene;
}
Scene slope_holds() {
  return slope_of(0.35, 0.5, 1);  // tan 0.35 = 0.365
}
Scene slope_slides() {
  Scene scene = slope_of(0.5, 0.4, 1);  // tan 0.5 = 0.546; 10 m in 4 s
  scene.bodies[1].shapes[0].half_size = {30, 1};
  return scene;
}
Scene slope_tower() {
  return slope_of(0.15, 0.5, 3);
}
Scene slope_topples() {
  return slope_of(0.35, 0.9, 4);  // its centre of mass is 0.73 m beside the middle of its foot
}

// A plank on an edge, with equal or different loads at its ends.
Scene lever_of(double right_density) {
  Builder built;
  built.add_static({0, 0.5}, worlds::polygon({{-0.5, -0.5}, {0.5, -0.5}, {0.2, 0.5}, {-0.2, 0.5}}));
  built.add({0, 1.1}, box(6, 0.2));
  built.add({-2.5, 1.7}, box(1, 1));
  Shape right = box(1, 1);
  right.density = right_density;
  built.add({2.5, 1.7}, std::move(right));
  built.friction(0.9);
  if (right_density != 1) {
    built.pin(1, 2, {0, 0.6}, {0, 0});           // the plank turns about its centre,
    built.add_static({2.5, 0.35}, box(1, 0.7));  // and this box stops the plank
    // With friction there, statics would leave open what the stop bears.
    built.scene.bodies.back().shapes[0].material.friction = 0;
  }
  return built.scene;
}
Scene lever_balances() {
  return lever_of(1);
}
Scene lever_tips() {
  return lever_of(3);
}

Scene hanging_chain() {
  Builder built;
  built.add_static({0, 12}, box(0.4, 0.4));
  std::uint32_t above = built.last();
  for (int i = 0; i < 10; ++i) {
    built.add({0, 11.5 - i}, box(0.2, 0.9));
    built.pin(above, built.last(), i == 0 ? Point{0, 0} : Point{0, -0.5}, {0, 0.5});
    above = built.last();
  }
  return built.scene;
}

// Ten planks between two pegs start in the shape of a V. The chain swings until damping stops the swing.
Scene hanging_bridge() {
  Builder built;
  const engine::SinCos half = {2.1794494717703369 / 5, 0.9};  // five planks descend 2.18 m over 4.5 m
  const double angle = engine::arc_tangent(half.sin, half.cos);
  built.add_static({-4.5, 5}, box(0.4, 0.4));
  std::uint32_t before = built.last();
  for (int i = 0; i < 10; ++i) {
    const double along = i < 5 ? i + 0.5 : 9.5 - i;
    const Point at{(i < 5 ? -1 : 1) * (4.5 - along * half.cos), 5 - along * half.sin};
    Body& plank = built.add(at, box(0.9, 0.2), i < 5 ? -angle : angle);
    plank.angular_damping = 2;
    built.pin(before, built.last(), i == 0 ? Point{0, 0} : Point{0.5, 0}, {-0.5, 0});
    before = built.last();
  }
  built.add_static({4.5, 5}, box(0.4, 0.4));
  built.pin(before, built.last(), {0.5, 0}, {0, 0});
  return built.scene;
}

// A heavy box on a vertical slider descends onto the floor. By gears it lifts a light box twice as far and turns a
// disc.
Scene gear_lift() {
  Builder built;
  built.tower(-2, 1, 1, 1, 1, 4);
  built.tower(2, 0, 1, 1, 1);
  built.add({0, 3}, worlds::disc(0.5));
  built.add_static({0, 3}, box(0.2, 0.2));
  engine::Joint slider = worlds::joint(JointKind::prismatic, 0, 1, {-2, 2.5}, {0, 0});
  slider.axis = {0, 1};
  slider.collide_connected = true;
  built.scene.joints.push_back(slider);
  slider.body_b = 2;
  slider.anchor_a = {2, 1.5};
  built.scene.joints.push_back(slider);
  built.pin(4, 3, {0, 0}, {0, 0});
  built.scene.joints.push_back(worlds::gear(0, 1, 0.5));
  built.scene.joints.push_back(worlds::gear(0, 2, 0.5));
  return built.scene;
}

// ---- Scenes that need more than 4 substeps, and more than plain steps in Box2D ----

Scene by_default(Builder built) {
  engine::fix_substeps(built.scene.settings);
  return built.scene;
}

template <int count>
Scene default_tower() {
  Builder built;
  built.tower(0, 0, count, 1, 1);
  return by_default(std::move(built));
}

Scene default_slabs() {
  Builder built;
  built.tower(0, 0, 40, 2, 0.4);
  return by_default(std::move(built));
}

Scene default_pillar() {
  Builder built;
  built.tower(0, 0, 12, 0.6, 1.2);
  return by_default(std::move(built));
}

Scene small_tower() {
  Builder built;
  built.tower(0, 0, 10, 0.1, 0.1);
  return by_default(std::move(built));
}

Scene slow_tower() {
  Builder built;
  built.tower(0, 0, 10, 1, 1);
  built.scene.settings.dt = 1.0 / 20;
  return by_default(std::move(built));
}

// Boxes of 1 kg below one heavier box.
template <int count, int load>
Scene loaded() {
  Builder built;
  built.tower(0, 0, count, 1, 1);
  built.tower(0, count, 1, 1, 1, load);
  return by_default(std::move(built));
}

// Each box has ten times the mass of the box below.
Scene growing() {
  Builder built;
  double density = 1;
  for (int i = 0; i < 4; ++i, density *= 10) built.tower(0, i, 1, 1, 1, density);
  return by_default(std::move(built));
}

Scene lintel() {
  Builder built;
  built.tower(-2, 0, 6, 1, 1);
  built.tower(2, 0, 6, 1, 1);
  built.tower(0, 6, 1, 6, 1, 50);
  return by_default(std::move(built));
}

constexpr std::array<SuiteScene, 46> scenes{{
    {"tower_5", "stands", 10, tower<5>},
    {"tower_10", "stands", 10, tower<10>},
    {"tower_15", "stands", 10, tower<15>},
    {"slabs", "stands", 10, slabs},
    {"pillar", "stands", 10, pillar},
    {"two_towers", "stands, bridged by a plank that carries two boxes", 10, two_towers},
    {"pyramid_5", "stands", 10, pyramid<5>},
    {"pyramid_10", "stands", 10, pyramid<10>},
    {"pyramid_15", "stands", 10, pyramid<15>},
    {"wall", "stands", 10, wall},
    {"gates", "stand", 10, gates},
    {"arch", "stands", 10, arch},
    {"tent_stands", "stands", 10, tent_stands},
    {"tent_slips", "slips apart until it lies flat", 10, tent_slips},
    {"dominoes_standing", "stand", 10, dominoes_standing},
    {"dominoes_falling", "fall, one after the other", 10, dominoes_falling},
    {"top_heavy", "stands", 10, top_heavy},
    {"heavy_on_light", "stands", 10, heavy_on_light},
    {"light_on_heavy", "stands", 10, light_on_heavy},
    {"overhang_holds", "stands", 10, overhang_holds},
    {"overhang_falls", "falls", 8, overhang_falls},
    {"leaning_holds", "stands", 10, leaning_holds},
    {"leaning_falls", "falls", 2, leaning_falls},
    {"wedges_hold", "hold the box", 10, wedges_hold},
    {"mixed_tower", "stands", 10, mixed_tower},
    {"octagons", "stand", 10, octagons},
    {"disc_tray", "stands between its walls", 10, disc_tray},
    {"slope_holds", "holds", 10, slope_holds},
    {"slope_slides", "slides", 4, slope_slides},
    {"slope_tower", "stands", 10, slope_tower},
    {"slope_topples", "topples", 6, slope_topples},
    {"lever_balances", "balances", 10, lever_balances},
    {"lever_tips", "tips to the heavy side", 10, lever_tips},
    {"hanging_chain", "hangs", 10, hanging_chain},
    {"hanging_bridge", "sags into a curve", 10, hanging_bridge},
    {"gear_lift", "lands, and lifts the other box", 10, gear_lift},
    {"default_tower_20", "stands", 10, default_tower<20>, true},
    {"default_tower_30", "stands", 10, default_tower<30>, true},
    {"default_slabs", "stands", 10, default_slabs, true},
    {"default_pillar", "stands", 10, default_pillar, true},
    {"small_tower", "stands", 10, small_tower, true},
    {"slow_tower", "stands, at 20 ticks a second", 10, slow_tower, true},
    {"under_1000", "stands", 10, loaded<4, 1001>, true},
    {"under_100", "stands", 10, loaded<9, 100>, true},
    {"growing", "stands", 10, growing, true},
    {"lintel", "stands", 10, lintel, true},
}};

}  // namespace

std::span<const SuiteScene> crosscheck_suite() {
  return scenes;
}

}  // namespace ticktrue::tool
