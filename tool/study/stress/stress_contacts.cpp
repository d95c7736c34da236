// Stress cases of contacts: towers, mass ratios, sizes, speed, overlap, distance, thin shapes, bounces.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/math/trig.h"
#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {

using engine::BodyType;
using engine::Engine;
using engine::Point;
using engine::Precision;
using engine::Scene;

namespace {

constexpr std::string_view measured_here = "accuracy study of 2026-11: ";

StressCase contact_case(std::string name, std::string what, std::string unit, double lower, double upper,
                        std::string best_known, std::string source) {
  StressCase out = make_case(std::move(name), std::move(what), std::move(unit), lower, upper, contact_methods());
  out.best_known = std::move(best_known);
  out.source = source.empty() ? std::string() : source == "own" ? source : std::string(measured_here) + source;
  return out;
}

// ---- Stacks ----

void add_towers(std::vector<StressCase>& cases) {
  for (const int count : {10, 20, 40, 80, 200})
    for (const double jitter : {0.0, 0.01}) {
      StressCase c = contact_case(
          "tower_" + std::to_string(count) + (jitter > 0 ? "_jitter" : ""),
          std::to_string(count) + " boxes" + (jitter > 0 ? ", shifted by 1 cm" : "") +
              ", 20 s: way across over 5 cm or down over 1 % of the height, the larger",
          "of 1", 0, 1,
          count <= 40 ? "Box2D HEAD stands" : "80 leans 0.2-0.6 m, 200 falls; hertz lifted, 16 sub: stands",
          "Box2D HEAD, section 6 case 10");
      c.run = [count, jitter](const StressMethod& method, Precision precision) {
        return run_case(with_method(worlds::stack(precision, count, 1, jitter), method), 20, {},
                        [count](const Engine&, const Bodies& start, const Bodies& end) {
                          return moved_share(start, end, 0.05, 0.01 * count);
                        });
      };
      cases.push_back(std::move(c));
    }
}

void add_mass_ratios(std::vector<StressCase>& cases) {
  for (const int count : {2, 10})
    for (const double ratio : {1e1, 1e2, 1e3, 1e4, 1e6}) {
      StressCase c =
          contact_case("top_heavy_" + std::to_string(count) + "_r" + plain_number(ratio),
                       std::to_string(count) + " boxes, the top one " + plain_number(ratio) +
                           " kg, 10 s: way down over a hundredth, across over a tenth of a box",
                       "of 1", 0, 1, "holds to 1.7e4 (AVBD, 160 iterations), 3.5e3 (Box2D HEAD, hertz lifted, 64 sub)",
                       "section 6 case 5, stack of 10");
      c.run = [count, ratio](const StressMethod& method, Precision precision) {
        Scene scene = worlds::stack(precision, count);
        scene.bodies.back().mass = engine::ExplicitMass{ratio, {}, {}};
        return run_case(
            with_method(std::move(scene), method), 10, {},
            [](const Engine&, const Bodies& start, const Bodies& end) { return moved_share(start, end, 0.1, 0.01); });
      };
      cases.push_back(std::move(c));
    }
  // Stacks that hopped for ever while their substeps fell by half.
  for (const auto& [count, ratio] : {std::pair{2, 1e4}, {8, 1e3}, {10, 2e2}, {20, 3e2}}) {
    StressCase c = contact_case("top_heavy_rest_" + std::to_string(count) + "_r" + plain_number(ratio),
                                std::to_string(count) + " boxes, the top one " + plain_number(ratio) +
                                    " kg, the last 5 of 15 s: largest speed of the top one",
                                "m/s", 0, 0.01, "", "own");
    c.run = [count = count, ratio = ratio](const StressMethod& method, Precision precision) {
      Scene scene = worlds::stack(precision, count);
      scene.bodies.back().mass = engine::ExplicitMass{ratio, {}, {}};
      const double dt = scene.settings.dt;
      int tick = 0;
      double most = 0;
      return run_case(
          with_method(std::move(scene), method), 15,
          [&](const Bodies& bodies) {
            const Point v = bodies.back().velocity;
            if (++tick * dt > 10) most = std::max(most, std::hypot(v.x, v.y));
            return true;
          },
          [&](const Engine&, const Bodies&, const Bodies&) { return most; });
    };
    cases.push_back(std::move(c));
  }
  StressCase wide = contact_case(
      "heavy_on_light", "a box of 20 m and 400 kg on two of 1 m and 1 kg, 10 s: way down over 1 %", "of 1", 0, 1,
      "lands and stands, top 8.8 cm low of 11 m (SoftStep, TGS_Soft)", "Solver2D, High Mass Ratio 2");
  wide.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::weighted(worlds::box(0.5, 0.5), {-9.5, 0.5}, 1),
                    worlds::weighted(worlds::box(0.5, 0.5), {9.5, 0.5}, 1),
                    worlds::weighted(worlds::box(10, 10), {0, 11}, 400)};
    return run_case(
        with_method(std::move(scene), method), 10, {},
        [](const Engine&, const Bodies& start, const Bodies& end) { return moved_share(start, end, 0.1, 0.01); });
  };
  cases.push_back(std::move(wide));
  StressCase pinched =
      contact_case("pinched_disc", "1000 kg on a disc of 1 kg in a notch, 10 s: deepest overlap over its size", "of 1",
                   0, 0.01, "", "own");
  pinched.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::weighted(worlds::disc(0.5), {0, 0.5}, 1),
                    worlds::weighted(worlds::box(0.5, 0.5), {0, 1.5}, 1000)};
    scene.bodies[2].fixed_rotation = true;
    return run_case(
        with_method(std::move(scene), method), 10, {},
        [](const Engine& engine, const Bodies&, const Bodies&) { return deepest_overlap(engine.contacts()); });
  };
  cases.push_back(std::move(pinched));
}

void add_structures(std::vector<StressCase>& cases) {
  StressCase house =
      contact_case("card_house", "forty cards of 2 mm by 0.4 m, 20 s: height of the top card", "m", 1.60, 1.70,
                   "1.64, stands (Box2D HEAD); AVBD with 10 iterations: falls", "section 6 case 12");
  house.run = [](const StressMethod& method, Precision precision) {
    auto scene = engine::make_builtin_scene("card_house?substeps=4");
    if (!scene) return StressValue{0, true, scene.error().message};
    scene->settings.precision = precision;
    return run_case(with_method(*scene, method), 20, {},
                    [](const Engine&, const Bodies&, const Bodies& end) { return end.back().center.y; });
  };
  cases.push_back(std::move(house));
  StressCase pyramid = contact_case("pyramid_rest", "210 boxes at rest, the last 9 of 10 s: largest way of one", "m", 0,
                                    1e-3, "1.2 mm without sleep", "Box2D HEAD, problem 26");
  pyramid.run = [](const StressMethod& method, Precision precision) {
    auto scene = engine::make_builtin_scene("pyramid?base=20&substeps=4");
    if (!scene) return StressValue{0, true, scene.error().message};
    scene->settings.precision = precision;
    Bodies settled;
    int tick = 0;
    return run_case(
        with_method(*scene, method), 10,
        [&](const Bodies& bodies) {
          if (++tick == 60) settled = bodies;
          return true;
        },
        [&](const Engine&, const Bodies&, const Bodies& end) { return moved_share(settled, end, 1, 1); });
  };
  cases.push_back(std::move(pyramid));
  StressCase soak = contact_case("soak", "a stack of 10 for 1e5 ticks, the last 99 %: largest way of a box", "m", 0,
                                 2e-3, "1.38 mm across", "Box2D HEAD, section 6 case 26");
  soak.run = [](const StressMethod& method, Precision precision) {
    Bodies settled;
    const Scene scene = with_method(worlds::stack(precision, 10), method);
    StressValue out;
    out.ran_in = precision;
    Result<Run> run = Run::make(scene);
    if (!run) return StressValue{0, true, run.error().message};
    Status did = run->advance(1000);
    settled = run->bodies();
    if (did) did = run->advance(99000);
    if (!did) return StressValue{0, true, {}, did.error().message, precision};
    out.value = moved_share(settled, run->bodies(), 1, 1);
    out.is_finite = all_finite(run->bodies());
    return out;
  };
  cases.push_back(std::move(soak));
}

void add_sizes(std::vector<StressCase>& cases) {
  for (const double size : {0.01, 0.1, 1.0, 10.0, 100.0, 1000.0}) {
    StressCase c = contact_case(
        "size_" + plain_number(size),
        "ten boxes of " + plain_number(size) + " m, 10 s: way down over 1 % of the height, across over a tenth", "of 1",
        0, 1,
        size == 0.01  ? "falls (absolute slop)"
        : size == 0.1 ? "6.3 % of a box low"
                      : "0.63 % of a box low at 1 m; 1 km stands",
        "Box2D HEAD, section 6 case 13");
    c.run = [size](const StressMethod& method, Precision precision) {
      return run_case(with_method(worlds::stack(precision, 10, size), method), 10, {},
                      [size](const Engine&, const Bodies& start, const Bodies& end) {
                        return moved_share(start, end, 0.1 * size, 0.1 * size);
                      });
    };
    cases.push_back(std::move(c));
  }
  for (const double mass : {1e-6, 1e6}) {
    StressCase c = contact_case("mass_" + plain_number(mass),
                                "ten boxes of " + plain_number(mass) +
                                    " kg, 10 s: way down over 1 % of the height, across over a tenth of a box",
                                "of 1", 0, 1, "", "own");
    c.run = [mass](const StressMethod& method, Precision precision) {
      Scene scene = worlds::stack(precision, 10);
      for (std::size_t i = 1; i < scene.bodies.size(); ++i) scene.bodies[i].mass = engine::ExplicitMass{mass, {}, {}};
      return run_case(
          with_method(std::move(scene), method), 10, {},
          [](const Engine&, const Bodies& start, const Bodies& end) { return moved_share(start, end, 0.1, 0.1); });
    };
    cases.push_back(std::move(c));
  }
  for (const double rate : {10.0, 20.0, 1000.0}) {
    StressCase c =
        contact_case("dt_" + plain_number(rate) + "_hz",
                     "ten boxes at " + plain_number(rate) +
                         " ticks a second, 10 s: way down over 1 % of the height, across over a tenth of a box",
                     "of 1", 0, 1, "", "own");
    c.run = [rate](const StressMethod& method, Precision precision) {
      Scene scene = worlds::stack(precision, 10);
      scene.settings.dt = 1 / rate;
      return run_case(
          with_method(std::move(scene), method), 10, {},
          [](const Engine&, const Bodies& start, const Bodies& end) { return moved_share(start, end, 0.1, 0.1); });
    };
    cases.push_back(std::move(c));
  }
  for (const double thickness : {0.01, 0.001}) {
    StressCase c = contact_case(
        "sliver_" + plain_number(thickness),
        "five plates of 2 m by " + plain_number(thickness) + " m, 10 s: height of the top one over what it should be",
        "of 1", 0.99, 1.01, thickness > 0.005 ? "0.73" : "0.24, collapsed into slop", "Box2D HEAD, section 6 case 25");
    c.run = [thickness](const StressMethod& method, Precision precision) {
      Scene scene = worlds::empty(precision);
      scene.bodies.push_back(worlds::ground());
      for (int i = 0; i < 5; ++i)
        scene.bodies.push_back(worlds::body(worlds::box(1, thickness / 2), {0, thickness * (i + 0.5)}));
      return run_case(with_method(std::move(scene), method), 10, {},
                      [thickness](const Engine&, const Bodies&, const Bodies& end) {
                        return end.back().center.y / (4.5 * thickness);
                      });
    };
    cases.push_back(std::move(c));
  }
}

// ---- Overlap and speed ----

void add_overlaps(std::vector<StressCase>& cases) {
  for (const int percent : {10, 25, 50, 90}) {
    StressCase c = contact_case(
        "overlap_" + std::to_string(percent),
        "five boxes " + std::to_string(percent) + " % inside each other, 10 s: speed at the end, 9 if they stay merged",
        "m/s", 0, 1e-3, "recovers, kinetic energy up to 4-58 J; AVBD stays merged at 90 %",
        "Box2D HEAD, section 6 case 17");
    c.run = [percent](const StressMethod& method, Precision precision) {
      Scene scene = worlds::empty(precision);
      scene.bodies.push_back(worlds::ground());
      for (int i = 0; i < 5; ++i)
        scene.bodies.push_back(worlds::body(worlds::box(0.5, 0.5), {0, 0.5 + i * (1 - percent / 100.0)}));
      return run_case(with_method(std::move(scene), method), 10, {},
                      [](const Engine& engine, const Bodies&, const Bodies& end) {
                        return deepest_overlap(engine.contacts()) > 0.05 ? 9 : fastest(end);
                      });
    };
    cases.push_back(std::move(c));
  }
  for (const int count : {200, 5000}) {
    StressCase c = contact_case(
        "coincident_" + std::to_string(count), std::to_string(count) + " unit boxes at one place, 5 s: largest speed",
        "m/s", 0, 50, "10 m/s (AVBD, 200); Box2D HEAD: pair buffer exceeded, thrown to 556 m", "section 6 case 18");
    c.is_long = count > 1000;
    c.run = [count](const StressMethod& method, Precision precision) {
      Scene scene = worlds::empty(precision);
      scene.bodies.push_back(worlds::ground());
      for (int i = 0; i < count; ++i) scene.bodies.push_back(worlds::body(worlds::box(0.5, 0.5), {0, 5}));
      double most = 0;
      return run_case(
          with_method(std::move(scene), method), 5,
          [&](const Bodies& bodies) {
            most = std::max(most, fastest(bodies));
            return true;
          },
          [&](const Engine&, const Bodies&, const Bodies&) { return most; });
    };
    cases.push_back(std::move(c));
  }
}

void add_bullets(std::vector<StressCase>& cases) {
  for (const double speed : {100.0, 1000.0, 1e5})
    for (const bool free : {false, true}) {
      StressCase c =
          contact_case(std::string("bullet_") + (free ? "plate_" : "wall_") + plain_number(speed),
                       "a disc of 5 cm at " + plain_number(speed) + " m/s against " +
                           (free ? "a free plate 1 cm thick" : "a wall 1 cm thick") + ": how far past it, 1 s",
                       "m", -HUGE_VAL, 0, free ? "only as a bullet; else passes at 400 m/s already" : "stopped",
                       "Box2D HEAD, section 6 cases 14, 15");
      c.run = [speed, free](const StressMethod& method, Precision precision) {
        Scene scene = worlds::empty(precision);
        scene.gravity = {0, 0};
        engine::Body plate =
            worlds::body(worlds::box(0.005, 50), {0, 0}, free ? BodyType::dynamic_body : BodyType::static_body);
        plate.shapes[0].density = 1000;
        engine::Body bullet = worlds::body(worlds::disc(0.05), {-3.3, 0.1});
        bullet.velocity = {speed, 0};
        bullet.bullet = free;
        scene.bodies = {plate, bullet};
        double past = -HUGE_VAL;
        return run_case(
            with_method(std::move(scene), method), 1,
            [&](const Bodies& bodies) {
              past = std::max(past, bodies[1].center.x - bodies[0].center.x);
              return true;
            },
            [&](const Engine&, const Bodies&, const Bodies&) { return past; });
      };
      cases.push_back(std::move(c));
    }
}

// ---- Bounces ----

void add_bounces(std::vector<StressCase>& cases) {
  StressCase gas =
      contact_case("elastic_gas", "100 discs, restitution 1, no friction, no gravity, 60 s: kinetic energy left",
                   "of 1", 0.9, 1.01, "0.08; with threshold 0: 0.51", "Box2D HEAD, section 6 case 22");
  gas.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.gravity = {0, 0};
    for (int i = 0; i < 4; ++i) {
      const bool level = i % 2 == 0;
      const double side = i < 2 ? -10.5 : 10.5;
      scene.bodies.push_back(worlds::body(level ? worlds::box(11, 0.5) : worlds::box(0.5, 11),
                                          level ? Point{0, side} : Point{side, 0}, BodyType::static_body));
    }
    for (int i = 0; i < 100; ++i) {
      const int row = i / 10;
      engine::Body disc = worlds::weighted(worlds::disc(0.4), {-9 + 2.0 * (i % 10), -9 + 2.0 * row}, 1);
      disc.velocity = {3 * std::cos(i * 2.39996), 3 * std::sin(i * 2.39996)};
      scene.bodies.push_back(disc);
    }
    worlds::set_bounces(scene, 1);
    return run_case(with_method(std::move(scene), method), 60, {},
                    [](const Engine&, const Bodies& start, const Bodies& end) {
                      return kinetic_energy(end) / kinetic_energy(start);
                    });
  };
  cases.push_back(std::move(gas));
  StressCase drop =
      contact_case("elastic_drop", "restitution 1 from 10 m, 60 s: the apex farthest from 10 m", "m", 9.9, 10.0005,
                   "9.98 at 16 substeps, 10.02 with hertz lifted (gains)", "Box2D HEAD, section 6 case 23");
  drop.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    scene.bodies = {worlds::ground(), worlds::body(worlds::disc(0.5), {0, 10.5})};
    worlds::set_bounces(scene, 1);
    double highest = 0, worst = 10;
    bool rose = false;
    return run_case(
        with_method(std::move(scene), method), 60,
        [&](const Bodies& bodies) {
          const bool rises = bodies[1].velocity.y > 0;
          if (rises && !rose) highest = 0;
          highest = std::max(highest, bodies[1].center.y - 0.5);
          if (rose && !rises && std::fabs(highest - 10) > std::fabs(worst - 10)) worst = highest;
          rose = rises;
          return true;
        },
        // A ball that no longer bounces has no apex.
        [&](const Engine&, const Bodies&, const Bodies&) { return highest < 1 ? highest : worst; });
  };
  cases.push_back(std::move(drop));
}

// ---- Friction ----

Scene box_on_ground(Precision precision, double friction) {
  Scene scene = worlds::empty(precision);
  scene.bodies = {worlds::ground(), worlds::body(worlds::box(0.5, 0.5), {0, 0.5})};
  worlds::set_material(scene, friction, 0);
  return scene;
}

void add_frictions(std::vector<StressCase>& cases) {
  StressCase none = contact_case("friction_0", "a box at 10 m/s without friction, 5 s: relative change of its speed",
                                 "of 1", 0, 1e-9, "", "");
  none.run = [](const StressMethod& method, Precision precision) {
    Scene scene = box_on_ground(precision, 0);
    scene.bodies[1].velocity = {10, 0};
    return run_case(with_method(std::move(scene), method), 5, {}, [](const Engine&, const Bodies&, const Bodies& end) {
      return std::fabs(end[1].velocity.x - 10) / 10;
    });
  };
  cases.push_back(std::move(none));
  StressCase most =
      contact_case("friction_1e6", "a box at 10 m/s with friction 1e6, 5 s: largest energy over the start's", "of 1", 0,
                   1.001, "tumbles and rests", "Box2D HEAD, section 6 case 24");
  most.run = [](const StressMethod& method, Precision precision) {
    Scene scene = box_on_ground(precision, 1e6);
    scene.bodies[1].velocity = {10, 0};
    double energy = 0, first = 0;
    return run_case(
        with_method(scene, method), 5,
        [&](const Bodies& bodies) {
          energy = std::max(energy, energy_of(scene, bodies));
          return true;
        },
        [&](const Engine&, const Bodies& start, const Bodies&) {
          first = energy_of(scene, start);
          return std::max(energy, first) / first;
        });
  };
  cases.push_back(std::move(most));
  StressCase hold = contact_case("slope_hold", "friction 1.05 tan 20 on a slope of 20 degrees, 10 s: creep", "m", 0,
                                 1e-3, "0.43 mm; AVBD 277 mm", "Box2D HEAD, section 2.3");
  hold.run = [](const StressMethod& method, Precision precision) {
    Scene scene = box_on_ground(precision, 1.05 * std::tan(20 * engine::pi / 180));
    worlds::lean(scene, 20);
    return run_case(with_method(std::move(scene), method), 10, {},
                    [](const Engine&, const Bodies& start, const Bodies& end) {
                      return std::fabs(end[1].center.x - start[1].center.x);
                    });
  };
  cases.push_back(std::move(hold));
  for (const double degrees : {26.0, 27.1}) {
    StressCase c = contact_case("topple_" + plain_number(degrees),
                                "a box twice as high as wide on a slope of " + plain_number(degrees) +
                                    " degrees (limit 26.565), 6 s: how far it turned",
                                "deg", degrees < 26.5 ? 0 : 45, degrees < 26.5 ? 1 : 360, "", "");
    c.run = [degrees](const StressMethod& method, Precision precision) {
      Scene scene = worlds::empty(precision);
      scene.bodies = {worlds::ground(), worlds::body(worlds::box(0.5, 1), {0, 1})};
      worlds::set_material(scene, 2, 0);
      worlds::lean(scene, degrees);
      double most_turned = 0;
      return run_case(
          with_method(std::move(scene), method), 6,
          [&](const Bodies& bodies) {
            most_turned = std::max(most_turned, std::fabs(bodies[1].angle) * 180 / engine::pi);
            return true;
          },
          [&](const Engine&, const Bodies&, const Bodies&) { return most_turned; });
    };
    cases.push_back(std::move(c));
  }
  StressCase rod = contact_case(
      "painleve",
      "a rod slides at 10 m/s on its end, friction 2, leaning 10 to 80 degrees, 2 s: largest energy over the start's",
      "of 1", 0, 1.001, "no unique answer exists: finite, no energy gained", "problem 25");
  rod.run = [](const StressMethod& method, Precision precision) {
    StressValue worst;
    worst.ran_in = precision;
    for (int degrees = 10; degrees <= 80; degrees += 10) {
      Scene scene = worlds::empty(precision);
      const double lean = degrees * engine::pi / 180;
      engine::Body body = worlds::weighted(worlds::box(1, 0.02), {0, std::sin(lean) + 0.02 * std::cos(lean)}, 1);
      body.angle = lean;
      body.velocity = {10, 0};
      scene.bodies = {worlds::ground(), body};
      worlds::set_material(scene, 2, 0);
      double energy = 0;
      const StressValue value = run_case(
          with_method(scene, method), 2,
          [&](const Bodies& bodies) {
            energy = std::max(energy, energy_of(scene, bodies));
            return true;
          },
          [&](const Engine&, const Bodies& start, const Bodies&) { return energy / energy_of(scene, start); });
      if (!value.why_not.empty() || !value.is_finite) return value;
      worst.value = std::max(worst.value, value.value);
    }
    return worst;
  };
  cases.push_back(std::move(rod));
  StressCase wedge = contact_case(
      "wedge", "1000 kg dropped from 2 m into a wedge of 20 degrees, 10 s: speed at the end, 9 if it is through", "m/s",
      0, 0.05, "", "own");
  wedge.run = [](const StressMethod& method, Precision precision) {
    Scene scene = worlds::empty(precision);
    engine::Body left = worlds::body(worlds::box(5, 0.5), {-1.5, 4}, BodyType::static_body);
    engine::Body right = worlds::body(worlds::box(5, 0.5), {1.5, 4}, BodyType::static_body);
    left.angle = -80 * engine::pi / 180;
    right.angle = 80 * engine::pi / 180;
    scene.bodies = {left, right, worlds::weighted(worlds::disc(0.5), {0, 10}, 1000)};
    return run_case(with_method(std::move(scene), method), 10, {}, [](const Engine&, const Bodies&, const Bodies& end) {
      return end[2].center.y < -2 ? 9 : fastest(end);
    });
  };
  cases.push_back(std::move(wedge));
  StressCase press = contact_case(
      "press", "a kinematic plate presses a box into the ground at 1 m/s for 2 s: largest speed of the box", "m/s", 0,
      20, "", "own");
  press.run = [](const StressMethod& method, Precision precision) {
    Scene scene = box_on_ground(precision, 0.6);
    scene.bodies.push_back(worlds::body(worlds::box(2, 0.5), {0, 2}, BodyType::kinematic_body));
    scene.bodies[2].velocity = {0, -1};
    double most_speed = 0;
    return run_case(
        with_method(std::move(scene), method), 2,
        [&](const Bodies& bodies) {
          most_speed = std::max(most_speed, speed_of(bodies[1]));
          return true;
        },
        [&](const Engine&, const Bodies&, const Bodies&) { return most_speed; });
  };
  cases.push_back(std::move(press));
}

}  // namespace

void add_contact_cases(std::vector<StressCase>& cases) {
  add_towers(cases);
  add_mass_ratios(cases);
  add_structures(cases);
  add_sizes(cases);
  add_overlaps(cases);
  add_bullets(cases);
  add_bounces(cases);
  add_frictions(cases);
}

}  // namespace ticktrue::tool
