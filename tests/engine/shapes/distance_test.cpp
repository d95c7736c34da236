// The distance of shapes: exact, or a lower bound where any distance beyond a limit is enough.
// SPDX-License-Identifier: MIT
#define TICKTRUE_PRECISION f64
#include "engine/narrow_phase/distance.h"

#include <cmath>

#include "base/random.h"
#include "tests/support/catch.h"
#include "tests/support/scenes.h"

namespace ticktrue::test {
namespace {

namespace f64 = engine::f64;

}  // namespace

TEST_CASE("a distance beyond the limit is at least the limit and at most the distance", "[engine][shapes][distance]") {
  Random random(3);
  Scene scene = empty_scene(Precision::f64);
  for (const Shape& shape : {box_shape(0.5, 0.3), polygon_shape({{-1, 0}, {1, -0.2}, {0.2, 0.9}}),
                             capsule_shape({-0.6, 0}, {0.6, 0.1}, 0.2), disc_shape(0.4)})
    scene.bodies.push_back(body_of(shape, {0, 0}));
  const f64::Model model = f64::make_model(scene);
  int early_count = 0, exact_count = 0;
  for (int i = 0; i < 20000; ++i) {
    const f64::ShapeModel& a = model.shapes[random.below(model.shapes.size())];
    const f64::ShapeModel& b = model.shapes[random.below(model.shapes.size())];
    const auto turn = [&] {
      const engine::SinCos q = engine::sin_cos(random.real(-3, 3));
      return f64::Rotation{q.cos, q.sin};
    };
    const f64::Placement pose_a{{0, 0}, turn()}, pose_b{{random.real(-4, 4), random.real(-4, 4)}, turn()};
    const double limit = random.real(0, 2);
    const f64::Distance exact = distance(model, a, pose_a, b, pose_b);
    const f64::Distance bounded = distance(model, a, pose_a, b, pose_b, limit);
    if (bounded.separation > limit && bounded.separation != exact.separation) {
      ++early_count;
      REQUIRE(bounded.separation <= exact.separation + 1e-12);
    } else {
      ++exact_count;
      REQUIRE(bounded.separation == exact.separation);
      REQUIRE(bounded.normal.x == exact.normal.x);
    }
  }
  CHECK(early_count > 1000);
  CHECK(exact_count > 1000);
}

}  // namespace ticktrue::test
