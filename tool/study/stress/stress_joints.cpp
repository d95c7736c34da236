// Stress cases of joints: springs from soft to stiff, hanging and swinging chains, bridges, grids, ropes, beams.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/math/trig.h"
#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::Engine;
using engine::Joint;
using engine::JointKind;
using engine::JointMotor;
using engine::JointSpring;
using engine::Point;
using engine::Precision;
using engine::Range;
using engine::Scene;

StressCase joint_case(std::string name, std::string what, std::string unit, double lower, double upper,
                      std::string best_known, std::string source) {
  StressCase out = make_case(std::move(name), std::move(what), std::move(unit), lower, upper, contact_methods());
  out.best_known = std::move(best_known);
  out.source = source.empty() || source == "own" ? std::move(source) : "accuracy study of 2026-11: " + source;
  return out;
}

// 1 kg hangs on a spring joint from a peg. The relaxed spring is 1 m long; the weight starts `start` m below its end.
Scene hanging_weight(double stiffness, double damping, double start) {
  Scene scene = worlds::empty(Precision::f64);
  scene.bodies = {worlds::peg({0, 0}), worlds::weighted(worlds::disc(0.1), {0, -1 - start}, 1, 0.01)};
  scene.joints = {worlds::joint(JointKind::distance, 0, 1)};
  scene.joints[0].spring = JointSpring{true, 0, 0, stiffness, damping};
  return scene;
}

void add_springs(std::vector<StressCase>& cases) {
  for (double stiffness = 1e2; stiffness < 2e9; stiffness *= 10) {
    const double sag = 10 / stiffness;
    StressCase keeps = joint_case("spring_keeps_" + plain_number(stiffness),
                                  "1 kg on " + plain_number(stiffness) +
                                      " N/m without damping, 60 s: amplitude of the last over that of the first 10 s",
                                  "of 1", stiffness < 2e6 ? 0.99 : 0, stiffness < 2e6 ? 1.01 : 1.42,
                                  stiffness < 500 ? "0.02; AVBD 0.0005" : "stable, amplitude lost",
                                  "Box2D HEAD after 10 s, section 6 cases 1, 2");
    keeps.only = Precision::f64;  // the spring stretches by as little as 10 nm, at 1 m from the origin
    keeps.run = [stiffness, sag](const StressMethod& method, Precision) {
      double first = 0, last = 0;
      int tick = 0;
      return run_case(
          with_method(hanging_weight(stiffness, 0, 2 * sag), method), 60,
          [&](const Bodies& bodies) {
            const double off = std::fabs(-1 - sag - bodies[1].center.y);
            if (++tick <= 600) first = std::max(first, off);
            if (tick > 3000) last = std::max(last, off);
            return true;
          },
          [&](const Engine&, const Bodies&, const Bodies&) { return last / first; });
    };
    cases.push_back(std::move(keeps));
    // The bounds of spring_keeps above 2e6 N/m only ask that the amplitude does not grow: the states after the ticks
    // show one phase of an oscillation that lasts four substeps.
    StressCase sags = joint_case(
        "spring_sag_" + plain_number(stiffness),
        "1 kg on " + plain_number(stiffness) + " N/m, critically damped, from twice its sag, 10 s: error of the sag",
        "of 1", 0, 0.01, stiffness < 2e6 ? "0.003; AVBD wrong above 3e4 N/m" : "below what floats resolve",
        "Box2D HEAD, section 6 case 1");
    sags.only = Precision::f64;
    sags.run = [stiffness, sag](const StressMethod& method, Precision) {
      return run_case(with_method(hanging_weight(stiffness, 2 * std::sqrt(stiffness), 2 * sag), method), 10, {},
                      [sag](const Engine&, const Bodies&, const Bodies& end) {
                        return std::fabs((-1 - end[1].center.y) / sag - 1);
                      });
    };
    cases.push_back(std::move(sags));
  }
  for (const double ratio : {0.01, 1.0, 10.0, 1e3, 1e6}) {
    StressCase c =
        joint_case("spring_damping_" + plain_number(ratio),
                   "100 N/m of damping ratio " + plain_number(ratio) +
                       ", let go 0.1 m off, 10 s: how far it goes to the other side, of what the exact solution does",
                   "m", 0, ratio < 1 ? 0.1 : 1e-6, "implicit 1/(1 + h c) form: monotone", "section 6 case 3, derived");
    c.only = Precision::f64;
    c.run = [ratio](const StressMethod& method, Precision) {
      Scene scene = hanging_weight(100, 20 * ratio, 0.1);
      scene.gravity = {0, 0};
      double beyond = 0;
      return run_case(
          with_method(std::move(scene), method), 10,
          [&](const Bodies& bodies) {
            beyond = std::max(beyond, bodies[1].center.y + 1);
            return true;
          },
          [&](const Engine&, const Bodies&, const Bodies&) { return beyond; });
    };
    cases.push_back(std::move(c));
  }
  StressCase ratio = joint_case(
      "spring_ratio",
      "8 bodies of 1 kg on springs of 1e3 and 1e6 N/m in turn, damping ratio 0.1, let go hanging, 10 s: kinetic energy",
      "J", 0, 10, "5.8 J", "AVBD, section 6 case 4");
  ratio.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies.push_back(worlds::peg({0, 0}));
    for (std::uint32_t i = 0; i < 8; ++i) {
      scene.bodies.push_back(worlds::weighted(worlds::disc(0.1), {0, -0.5 * (i + 1)}, 1, 0.01));
      engine::Joint joint = worlds::joint(JointKind::distance, i, i + 1);
      const double stiffness = i % 2 == 0 ? 1e3 : 1e6;
      joint.length = 0.5;
      joint.spring = JointSpring{true, 0, 0, stiffness, 0.2 * std::sqrt(stiffness)};
      scene.joints.push_back(joint);
    }
    return run_case(with_method(std::move(scene), method), 10, {},
                    [](const Engine&, const Bodies&, const Bodies& end) { return kinetic_energy(end); });
  };
  cases.push_back(std::move(ratio));
}

void add_chains(std::vector<StressCase>& cases) {
  for (const int links : {10, 20})
    for (const double end_mass : {1.0, 1e1, 1e2, 1e3, 1e4, 1e6}) {
      StressCase c =
          joint_case("hanging_" + std::to_string(links) + "_r" + plain_number(end_mass),
                     std::to_string(links) + " links of 1 m and 1 kg hang, " + plain_number(end_mass) +
                         " kg at the end, the last 5 of 10 s: widest gap",
                     "of a link", 0, 0.01, "holds to 4.2e4 (AVBD, 160 iterations), 9.6e3 (Box2D HEAD, hertz lifted)",
                     "section 3.4, hanging chains");
      c.run = [links, end_mass](const StressMethod& method, Precision precision) {
        return worst_gap(with_method(worlds::chain(precision, links, {0, -1}, end_mass), method), 10, 5, 1);
      };
      cases.push_back(std::move(c));
    }
  for (const double end_mass : {1.0, 1e1, 1e2, 1e3, 1e4}) {
    StressCase c = joint_case(
        "swinging_10_r" + plain_number(end_mass),
        "10 links of 1 m and 1 kg let go level, " + plain_number(end_mass) + " kg at the end, 10 s: widest gap",
        "of a link", 0, 0.01, "holds to 1.1e3 (AVBD, 40 iterations), 3.5e3 (Box2D HEAD, hertz lifted, 64 sub)",
        "section 6 case 9");
    c.run = [end_mass](const StressMethod& method, Precision precision) {
      return worst_gap(with_method(worlds::chain(precision, 10, {1, 0}, end_mass), method), 10, 0, 1);
    };
    cases.push_back(std::move(c));
    StressCase energy = joint_case("swinging_energy_r" + plain_number(end_mass),
                                   "the same: largest energy over the start's, as a share of the fall's", "of 1", -1,
                                   0.01, "", "section 6 case 9");
    energy.run = [end_mass](const StressMethod& method, Precision precision) {
      const Scene scene = with_method(worlds::chain(precision, 10, {1, 0}, end_mass), method);
      double most = -HUGE_VAL;
      return run_case(
          scene, 10,
          [&](const Bodies& bodies) {
            most = std::max(most, energy_of(scene, bodies));
            return true;
          },
          [&](const Engine&, const Bodies& start, const Bodies&) {
            double fall = 0;
            for (const auto& body : start) fall += 10 * body.mass * body.center.x;
            return (most - energy_of(scene, start)) / fall;
          });
    };
    cases.push_back(std::move(energy));
  }
  StressCase stretched = joint_case(
      "stretched_chain", "40 links of 0.4 m made 1 m apart at every joint, the last quarter of 20 s: widest gap", "m",
      0, 0.04, "0.005 m (TGS_NGS), 0.022 (TGS_Soft); PGS blew up", "Solver2D, Stretched Chain");
  stretched.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies.push_back(worlds::peg({0, 0}));
    for (std::uint32_t i = 0; i < 40; ++i) {
      scene.bodies.push_back(worlds::weighted(worlds::box(0.2, 0.1), {1.4 * (i + 1), 0}, 1));
      scene.joints.push_back(worlds::joint(JointKind::revolute, i, i + 1, i == 0 ? Point{} : Point{0.2, 0}, {-0.2, 0}));
    }
    return worst_gap(with_method(std::move(scene), method), 20, 15, 1);
  };
  cases.push_back(std::move(stretched));
  StressCase bridge =
      joint_case("bridge_160", "160 planks of 1 m pinned between two pegs, the last 5 of 20 s: widest gap",
                 "of a plank", 0, 0.01, "0.037 m (SoftStep), 0.048 (TGS_NGS)", "Solver2D, Bridge");
  bridge.run = [](const StressMethod& method, Precision precision) {
    auto scene = engine::make_builtin_scene("bridge?planks=160");
    if (!scene) return StressValue{0, true, scene.error().message};
    scene->settings.precision = precision;
    return worst_gap(with_method(*scene, method), 20, 15, 1);
  };
  cases.push_back(std::move(bridge));
  for (const int planks : {8, 20}) {
    StressCase straight = joint_case("bridge_straight_" + std::to_string(planks),
                                     std::to_string(planks) +
                                         " planks of 1 m and 1 kg, straight between two pegs, 3 s: largest energy over "
                                         "the start's",
                                     "J", 0, 0.01, "", "own");
    straight.run = [planks](const StressMethod& method, Precision precision) {
      Scene scene = worlds::chain(precision, planks, {1, 0}, 1);
      scene.joints.push_back(worlds::joint(JointKind::revolute, static_cast<std::uint32_t>(planks), 0, {0.5, 0},
                                           {static_cast<double>(planks), 0}));
      scene = with_method(std::move(scene), method);
      double most = -HUGE_VAL;
      return run_case(
          scene, 3,
          [&](const Bodies& bodies) {
            most = std::max(most, energy_of(scene, bodies));
            return true;
          },
          [&](const Engine&, const Bodies& start, const Bodies&) {
            return std::max(0.0, most - energy_of(scene, start));
          });
    };
    cases.push_back(std::move(straight));
  }
  for (const int columns : {25, 100}) {
    StressCase grid =
        joint_case("joint_grid_" + std::to_string(columns),
                   "a square net of " + std::to_string(columns * columns) +
                       " pinned discs, gravity doubled, 20 s: widest gap at the end",
                   "m", 0, 0.1, "100 x 100: none; 4.2-25 m, TGS_NGS not finite", "Solver2D, section 6 case 29");
    grid.is_long = true;
    grid.run = [columns](const StressMethod& method, Precision precision) {
      auto scene = engine::make_builtin_scene("joint_grid?columns=" + std::to_string(columns));
      if (!scene) return StressValue{0, true, scene.error().message};
      scene->settings.precision = precision;
      scene->gravity = {0, -20};
      const Scene set = with_method(*scene, method);
      return run_case(set, 20, {},
                      [&](const Engine&, const Bodies&, const Bodies& end) { return largest(joint_gaps(set, end)); });
    };
    cases.push_back(std::move(grid));
  }
}

// The bound is that of a door under the constant torque .37 N m: a scheme of first order is off by a t h / 2.
constexpr double doors_seconds = 2;

/// A plank of 1 m and 1 kg that turns about one end, and its angle after doors_seconds.
struct Door {
  Joint joint;       // motor, limits, spring
  double spin = 0;   // rad/s, at the start
  double angle = 0;  // rad
};

/// `inertia`: about the hinge, kg m^2.
std::vector<Door> doors_of(double inertia) {
  std::vector<Door> doors;
  for (int i = 0; i < 10; ++i) {
    Door& turned = doors.emplace_back();  // by a strong motor
    const double speed = 0.5 + 0.08 * i;
    turned.joint.motor = JointMotor{speed, 1000};
    turned.angle = speed * doors_seconds;

    Door& pushed = doors.emplace_back();  // by a motor too weak for its speed
    const double torque = 0.1 + 0.03 * i;
    pushed.joint.motor = JointMotor{100, torque};
    pushed.angle = 0.5 * torque / inertia * doors_seconds * doors_seconds;

    Door& stopped = doors.emplace_back();  // by a limit, on either side
    const double stop = (i % 2 == 0 ? 1 : -1) * (0.3 + 0.05 * i);
    stopped.joint.limits = Range{std::min(stop, 0.0) - 0.01, std::max(stop, 0.0) + 0.01};
    stopped.joint.motor = JointMotor{stop > 0 ? 2.0 : -2.0, 1};
    stopped.angle = stop > 0 ? stopped.joint.limits->upper : stopped.joint.limits->lower;

    Door& sprung = doors.emplace_back();
    const double stiffness = 1 + 0.2 * i;
    const double frequency = std::sqrt(stiffness / inertia);
    sprung.joint.spring = JointSpring{true, 0, 0, stiffness, 0};
    sprung.spin = 0.5;
    sprung.angle = sprung.spin / frequency * engine::sin_cos(frequency * doors_seconds).sin;
  }
  return doors;
}

void add_doors(std::vector<StressCase>& cases) {
  StressCase out = make_case("doors",
                             "40 planks of 1 kg and 1 m on hinges, turned by motors, stopped by limits, swung by "
                             "springs, 2 s: largest error of an angle, or gap",
                             "rad or m", 0, 0.005, joint_methods());
  out.source = "own";
  out.run = [](const StressMethod& method, Precision precision) {
    const double inertia = 1.0 / 3;
    const std::vector<Door> doors = doors_of(inertia);
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    for (const Door& door : doors) {
      const auto first = static_cast<std::uint32_t>(scene.bodies.size());
      const double x = 1.5 * first;
      scene.bodies.push_back(worlds::peg({x, 0}));
      engine::Body& plank =
          scene.bodies.emplace_back(worlds::weighted(worlds::box(0.5, 0.1), {x + 0.5, 0}, 1, inertia - 0.25));
      plank.velocity = {0, 0.5 * door.spin};
      plank.angular_velocity = door.spin;
      Joint& joint = scene.joints.emplace_back(door.joint);
      joint.body_a = first;
      joint.body_b = first + 1;
      joint.anchor_b = {-0.5, 0};
    }
    const Scene set = with_method(std::move(scene), method);
    return run_case(set, doors_seconds, {}, [&](const Engine&, const Bodies&, const Bodies& end) {
      double worst = largest(joint_gaps(set, end));
      for (std::size_t i = 0; i < doors.size(); ++i)
        worst = std::max(worst, std::fabs(end[2 * i + 1].angle - doors[i].angle));
      return worst;
    });
  };
  cases.push_back(std::move(out));
}

constexpr double geared_seconds = 2;
constexpr double gear_ratio = 2;

// Two heavy discs on hinges with a gear between them. A motor turns the first with 20 N m: it is too weak for its
// speed.
Scene geared_discs(Precision precision, double first_inertia, double second_inertia) {
  Scene scene = worlds::empty(precision);
  scene.gravity = {0, 0};
  scene.bodies = {worlds::peg({0, 0}), worlds::weighted(worlds::disc(1), {0, 0}, 100, first_inertia),
                  worlds::peg({3, 0}), worlds::weighted(worlds::disc(1), {3, 0}, 400, second_inertia)};
  scene.joints = {worlds::joint(JointKind::revolute, 0, 1), worlds::joint(JointKind::revolute, 2, 3)};
  scene.joints[0].motor = JointMotor{100, 20};
  scene.joints.push_back(worlds::gear(0, 1, gear_ratio));
  return scene;
}

void add_geared(std::vector<StressCase>& cases) {
  constexpr double first = 50, second = 200;  // kg m^2
  constexpr double turned = 0.5 * 20 / (first + second / (gear_ratio * gear_ratio)) * geared_seconds * geared_seconds;
  StressCase turns =
      make_case("geared_turn", "two heavy discs and a gear, 20 N m on the first, 2 s: error of its angle", "rad", 0,
                0.001, joint_methods());
  turns.source = "own";
  turns.run = [](const StressMethod& method, Precision precision) {
    return run_case(with_method(geared_discs(precision, first, second), method), geared_seconds, {},
                    [](const Engine&, const Bodies&, const Bodies& end) { return std::fabs(end[1].angle - turned); });
  };
  StressCase slip = make_case("geared_slip", "the same: how far the angle of the second is from its share", "rad", 0,
                              4e-6, joint_methods());
  slip.source = "own";
  slip.run = [](const StressMethod& method, Precision precision) {
    return run_case(with_method(geared_discs(precision, first, second), method), geared_seconds, {},
                    [](const Engine&, const Bodies&, const Bodies& end) {
                      return std::fabs(end[1].angle + gear_ratio * end[3].angle);
                    });
  };
  cases.push_back(std::move(turns));
  cases.push_back(std::move(slip));
}

void add_others(std::vector<StressCase>& cases) {
  StressCase beam = joint_case(
      "cantilever_10", "10 planks of 1 m and 1 kg welded into a beam from a wall, 10 s: how far its end hangs down",
      "of its length", 0, 0.01, "", "own");
  beam.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies.push_back(worlds::peg({0, 0}));
    for (std::uint32_t i = 0; i < 10; ++i) {
      scene.bodies.push_back(worlds::weighted(worlds::box(0.5, 0.1), {i + 0.5, 0}, 1));
      scene.joints.push_back(worlds::joint(JointKind::weld, i, i + 1, i == 0 ? Point{0, 0} : Point{0.5, 0}, {-0.5, 0}));
    }
    return run_case(with_method(std::move(scene), method), 10, {}, [](const Engine&, const Bodies&, const Bodies& end) {
      return std::fabs(end.back().center.y) / 10;
    });
  };
  cases.push_back(std::move(beam));
  StressCase rope = joint_case(
      "rope_catch", "100 kg falls 5 m into a rope between 1 kg rings, 5 m long, 5 s: longest over its length", "of 1",
      0, 1.01, "", "own");
  rope.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::peg({0, 0}), worlds::weighted(worlds::disc(0.2), {0.5, 0}, 100)};
    scene.joints = {worlds::joint(JointKind::distance, 0, 1)};
    scene.joints[0].length = 5;
    scene.joints[0].limits = Range{0, 5};
    scene.joints[0].spring = JointSpring{true, 0, 0, 0, 0};
    double most = 0;
    return run_case(
        with_method(std::move(scene), method), 5,
        [&](const Bodies& bodies) {
          most = std::max(most, std::hypot(bodies[1].center.x, bodies[1].center.y) / 5);
          return true;
        },
        [&](const Engine&, const Bodies&, const Bodies&) { return most; });
  };
  rope.what = "100 kg falls into a rope of 5 m, 5 s: its greatest length over that";
  cases.push_back(std::move(rope));
  StressCase whirl =
      joint_case("whirl", "100 kg on an arm of 1 kg and 1 m whirls at 30 rad/s, no gravity, 5 s: widest gap", "m", 0,
                 0.01, "", "own");
  whirl.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::chain(precision, 2, {1, 0}, 100);
    scene.gravity = {0, 0};
    for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
      scene.bodies[i].angular_velocity = 30;
      scene.bodies[i].velocity = {0, 30 * scene.bodies[i].position.x};
    }
    return worst_gap(with_method(std::move(scene), method), 5, 0, 1);
  };
  cases.push_back(std::move(whirl));
  StressCase pendulum = joint_case(
      "pendulum_energy", "1 kg on a rod of 1 m from 60 degrees: energy of the last period of 60 s over the start's",
      "of 1", 0.99, 1.01, "0.983 (4 sub), 0.9993 with hertz lifted (8 sub); AVBD 0", "Box2D HEAD, section 2.3");
  pendulum.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::peg({0, 0}),
                    worlds::weighted(worlds::disc(0.1), {std::sin(engine::pi / 3), -0.5}, 1, 0.01)};
    scene.joints = {worlds::joint(JointKind::distance, 0, 1)};
    double sum = 0;
    int tick = 0;
    return run_case(
        with_method(std::move(scene), method), 60,
        [&](const Bodies& bodies) {
          const double v = speed_of(bodies[1]);
          if (++tick > 3600 - 128) sum += (0.5 * v * v + 10 * (bodies[1].center.y + 1)) / 5 / 128;
          return true;
        },
        [&](const Engine&, const Bodies&, const Bodies&) { return sum; });
  };
  cases.push_back(std::move(pendulum));
}

}  // namespace

void add_joint_cases(std::vector<StressCase>& cases) {
  add_springs(cases);
  add_chains(cases);
  add_doors(cases);
  add_geared(cases);
  add_others(cases);
}

}  // namespace ticktrue::tool
