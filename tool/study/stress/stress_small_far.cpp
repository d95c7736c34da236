// Stress cases of small bodies and of places far from the origin: stacks and heaps of bodies from 1 mm to 1 m, up to
// 1e6 m away.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "tool/study/stress/stress_parts.h"
#include "tool/study/worlds.h"

namespace ticktrue::tool {
namespace {

using engine::BodyType;
using engine::Engine;
using engine::Point;
using engine::Precision;
using engine::Scene;

void move_all(Scene& scene, Point way) {
  for (engine::Body& body : scene.bodies) body.position = {body.position.x + way.x, body.position.y + way.y};
}

// A stack far from the origin against the same stack at the origin.
void add_far_stacks(std::vector<StressCase>& cases) {
  for (const double far : {1e3, 1e4, 1e5, 1e6}) {
    StressCase c =
        make_case("far_" + plain_number(far),
                  "a stack of 10 at (" + plain_number(far) + ", -0.87 of it), 10 s: top against the same at the origin",
                  "m", 0, 1e-3, contact_methods());
    c.best_known = "identical to 4 digits at 1e7 with double positions; floats: wrong at 1e7, jitter 0.11 m/s at 1e5";
    c.source = "accuracy study of 2026-11: Box2D HEAD, section 6 case 20";
    c.run = [far](const StressMethod& method, Precision precision) {
      double near_top = 0;
      const StressValue at_origin =
          run_case(with_method(worlds::stack(precision, 10), method), 10, {},
                   [&](const Engine&, const Bodies&, const Bodies& end) { return near_top = end.back().center.y; });
      if (!at_origin.why_not.empty() || !at_origin.is_finite) return at_origin;
      Scene scene = worlds::stack(precision, 10);
      move_all(scene, {far, -0.87 * far});
      return run_case(with_method(std::move(scene), method), 10, {},
                      [far, near_top](const Engine&, const Bodies&, const Bodies& end) {
                        return std::fabs(end.back().center.y + 0.87 * far - near_top);
                      });
    };
    cases.push_back(std::move(c));
  }
}

// Twenty-four boxes of `size` m fall crosswise into a tub. The whole scene is displaced by `way`.
Scene heap(Precision precision, double size, Point way) {
  Scene scene = worlds::empty(precision);
  scene.name = "heap";
  const double wall = 10 * size;
  scene.bodies = {worlds::body(worlds::box(6 * size, size), {0, -size}, BodyType::static_body),
                  worlds::body(worlds::box(size, wall), {-5 * size, wall}, BodyType::static_body),
                  worlds::body(worlds::box(size, wall), {5 * size, wall}, BodyType::static_body)};
  for (int row = 0; row < 6; ++row)
    for (int i = 0; i < 4; ++i) {
      engine::Body box = worlds::body(worlds::box(size / 2, size / 2),
                                      {size * (1.5 * (i - 1.5) + 0.1 * (row % 3)), size * (1 + 1.5 * row)});
      box.angle = 0.3 * (i + row);
      scene.bodies.push_back(std::move(box));
    }
  move_all(scene, way);
  return scene;
}

void add_heaps(std::vector<StressCase>& cases) {
  struct Place {
    double size;
    double far;
  };
  for (const Place place :
       {Place{1, 0}, Place{0.01, 0}, Place{0.001, 0}, Place{1, 1e3}, Place{1, 1e5}, Place{0.01, 1e3}}) {
    const std::string where = place.far > 0 ? "_far_" + plain_number(place.far) : "";
    const std::string what = "24 boxes of " + plain_number(place.size) + " m fall into a tub" +
                             (place.far > 0 ? " at (" + plain_number(place.far) + ", 0) m" : "") + ", 5 s: ";
    StressCase overlap =
        make_case("heap_" + plain_number(place.size) + where,
                  what + "deepest overlap at the end over the size of a box", "of 1", 0, 0.02, contact_methods());
    overlap.run = [place](const StressMethod& method, Precision precision) {
      return run_case(with_method(heap(precision, place.size, {place.far, 0}), method), 5, {},
                      [place](const Engine& engine, const Bodies&, const Bodies&) {
                        return deepest_overlap(engine.contacts()) / place.size;
                      });
    };
    cases.push_back(std::move(overlap));
    // A body faster than speed_max never sleeps.
    StressCase rest =
        make_case("heap_rest_" + plain_number(place.size) + where, what + "fastest body in the last of them", "m/s", 0,
                  engine::SleepSettings().speed_max, contact_methods());
    rest.run = [place](const StressMethod& method, Precision precision) {
      double most = 0;
      int tick = 0;
      return run_case(
          with_method(heap(precision, place.size, {place.far, 0}), method), 5,
          [&](const Bodies& bodies) {
            if (++tick > 240) most = std::max(most, fastest(bodies));
            return true;
          },
          [&](const Engine&, const Bodies&, const Bodies&) { return most; });
    };
    cases.push_back(std::move(rest));
  }
}

}  // namespace

void add_small_and_far_cases(std::vector<StressCase>& cases) {
  add_far_stacks(cases);
  add_heaps(cases);
}

}  // namespace ticktrue::tool
