// Hulls: accepted input, order of corners, refusals with reasons, and masses against closed forms.
// SPDX-License-Identifier: MIT
#include "engine/scene/hull.h"

#include <cmath>
#include <cstdint>

#include "base/random.h"
#include "engine/math/trig.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;

namespace {

std::vector<Point> regular(int count, double radius, Point center = {}, double turn = 0) {
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const SinCos s = sin_cos(turn + 2 * pi * i / count);
    points.push_back({center.x + radius * s.cos, center.y + radius * s.sin});
  }
  return points;
}

Shape polygon(std::vector<Point> vertices, double density = 1) {
  Shape shape;
  shape.kind = ShapeKind::polygon;
  shape.vertices = std::move(vertices);
  shape.density = density;
  return shape;
}

Shape box(double hx, double hy, Point center = {}, double density = 1) {
  Shape shape;
  shape.kind = ShapeKind::box;
  shape.half_size = {hx, hy};
  shape.center = center;
  shape.density = density;
  return shape;
}

Shape circle(double radius, Point center = {}, double density = 1) {
  Shape shape;
  shape.radius = radius;
  shape.center = center;
  shape.density = density;
  return shape;
}

Body body_with(std::vector<Shape> shapes) {
  Body body;
  body.shapes = std::move(shapes);
  return body;
}

std::string hull_refusal(const std::vector<Point>& points) {
  const auto hull = build_hull(points);
  if (hull) return "accepted";
  CHECK(hull.error().code == ErrorCode::invalid_scene);
  return hull.error().message;
}

bool is_counter_clockwise_from_lowest(const std::vector<Point>& hull) {
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Point &a = hull[i], &b = hull[(i + 1) % hull.size()], &c = hull[(i + 2) % hull.size()];
    if ((b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x) <= 0) return false;
    if (hull[i].y < hull[0].y || (hull[i].y == hull[0].y && hull[i].x < hull[0].x)) return false;
  }
  return true;
}

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

}  // namespace

TEST_CASE("a hull is the same for every order of its points", "[engine][hull][equivalence]") {
  const std::vector<Point> square = *build_hull({{1, 1}, {-1, -1}, {1, -1}, {-1, 1}});
  CHECK(square == std::vector<Point>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}});

  Random random(7);
  for (int trial = 0; trial < 300; ++trial) {
    const int count = 3 + static_cast<int>(random.below(14));
    std::vector<Point> points;
    // Points of an ellipse at distinct angles, which are always strictly convex.
    for (int i = 0; i < count; ++i) {
      const SinCos s = sin_cos(2 * pi * (i + random.real(-0.35, 0.35)) / count);
      points.push_back({500 + 3 * s.cos, -70 + 1.3 * s.sin});
    }
    const auto expected = build_hull(points);
    REQUIRE(expected);
    REQUIRE(expected->size() == points.size());
    REQUIRE(is_counter_clockwise_from_lowest(*expected));
    for (int shuffle = 0; shuffle < 5; ++shuffle) {
      for (std::size_t i = points.size() - 1; i > 0; --i) std::swap(points[i], points[random.below(i + 1)]);
      const auto got = build_hull(points);
      REQUIRE(got);
      REQUIRE(*got == *expected);
    }
  }
}

TEST_CASE("a hull needs 3 to 16 vertices", "[engine][hull][analytic]") {
  CHECK_THAT(hull_refusal({}), Contains("found 0, expected 3..16"));
  CHECK_THAT(hull_refusal({{0, 0}, {1, 0}}), Contains("found 2, expected 3..16"));
  CHECK(hull_refusal(regular(3, 1)) == "accepted");
  CHECK(hull_refusal(regular(16, 1)) == "accepted");
  CHECK_THAT(hull_refusal(regular(17, 1)), Contains("found 17, expected 3..16"));
}

TEST_CASE("degenerate hulls are refused with the vertex and the reason", "[engine][hull][analytic]") {
  CHECK_THAT(hull_refusal({{0, 0}, {2, 0}, {2, 2}, {0, 0}}), StartsWith("vertices 0 and 3 coincide"));
  CHECK_THAT(hull_refusal({{0, 0}, {2, 0}, {2, 2}, {2, 2.0001}}), StartsWith("vertices 2 and 3 coincide"));
  CHECK_THAT(hull_refusal({{3, 3}, {3, 3}, {3, 3}}), StartsWith("vertices 0 and 1 coincide"));
  CHECK_THAT(hull_refusal({{0, 0}, {1, 1}, {2, 2}, {3, 3}}), Contains("one line"));
  CHECK_THAT(hull_refusal({{0, 0}, {1, 0.1}, {2, 0.2}}), Contains("one line") || Contains("on the line"));
  CHECK_THAT(hull_refusal({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {0, 2}}), StartsWith("vertex 1 lies on the line"));
  CHECK_THAT(hull_refusal({{0, 0}, {1, -1e-7}, {2, 0}, {2, 2}, {0, 2}}), StartsWith("vertex 1 lies on the line"));
  CHECK_THAT(hull_refusal({{0, 0}, {1, 1e-7}, {2, 0}, {2, 2}, {0, 2}}), StartsWith("vertex 1 lies on the line"));
  CHECK_THAT(hull_refusal({{0, 0}, {2, 0}, {1, 0.5}, {1, 2}}), StartsWith("concave: found vertex 2 (1, 0.5)"));
  CHECK_THAT(hull_refusal({{0, 0}, {std::nan(""), 0}, {1, 2}}), Contains("must be finite"));
  CHECK_THAT(hull_refusal({{0, 0}, {1, 0}, {1, INFINITY}}), Contains("must be finite"));
}

TEST_CASE("thin but real polygons are accepted", "[engine][hull][analytic]") {
  CHECK(hull_refusal({{-1, -0.0005}, {1, -0.0005}, {1, 0.0005}, {-1, 0.0005}}) == "accepted");
  CHECK(hull_refusal({{0, 0}, {1, 0}, {1, 1.745e-4}}) == "accepted");  // an angle of 0.01 degrees
  CHECK(hull_refusal({{1e5, 1e5}, {1e5 + 1, 1e5}, {1e5 + 1, 1e5 + 1}}) == "accepted");
  CHECK(hull_refusal({{0, 0}, {1e-5, 0}, {0, 1e-5}}) == "accepted");
}

TEST_CASE("masses of circle, box, triangle and regular polygons are those of the closed forms",
          "[engine][mass][analytic]") {
  const MassProperties disc = shape_mass(circle(0.5, {3, -2}, 7));
  CHECK(disc.mass == Approx(7 * pi * 0.25).epsilon(1e-14));
  CHECK(disc.inertia == Approx(disc.mass * 0.125).epsilon(1e-14));
  CHECK(disc.center == Point{3, -2});

  const MassProperties plank = shape_mass(box(2, 0.25, {1, 1}, 3));
  CHECK(plank.mass == Approx(3 * 4 * 0.5).epsilon(1e-14));
  CHECK(plank.inertia == Approx(plank.mass * (16 + 0.25) / 12).epsilon(1e-14));

  // A right triangle with legs a and b: I = m (a^2 + b^2) / 18 about its centroid (a/3, b/3).
  const MassProperties wedge = shape_mass(polygon({{0, 0}, {3, 0}, {0, 1.5}}, 2));
  CHECK(wedge.mass == Approx(2 * 2.25).epsilon(1e-14));
  CHECK(wedge.center.x == Approx(1).epsilon(1e-14));
  CHECK(wedge.center.y == Approx(0.5).epsilon(1e-14));
  CHECK(wedge.inertia == Approx(wedge.mass * (9 + 2.25) / 18).epsilon(1e-13));

  for (int n = 3; n <= 16; ++n) {
    // A = n r^2 sin(2 pi / n) / 2, I = m r^2 (2 + cos(2 pi / n)) / 6.
    CAPTURE(n);
    const double r = 0.7;
    const MassProperties got = shape_mass(polygon(regular(n, r, {10, -4}, 0.3), 5));
    const double mass = 5 * n * r * r * std::sin(2 * pi / n) / 2;
    CHECK(got.mass == Approx(mass).epsilon(1e-12));
    CHECK(got.inertia == Approx(mass * r * r * (2 + std::cos(2 * pi / n)) / 6).epsilon(1e-12));
    CHECK(got.center.x == Approx(10).epsilon(1e-13));
    CHECK(got.center.y == Approx(-4).epsilon(1e-13));
  }
}

TEST_CASE("a box has the mass of the polygon with its corners", "[engine][mass][equivalence]") {
  const MassProperties a = shape_mass(box(2, 0.1, {1e4, 3}));
  const MassProperties b = shape_mass(polygon({{1e4 - 2, 2.9}, {1e4 + 2, 2.9}, {1e4 + 2, 3.1}, {1e4 - 2, 3.1}}));
  CHECK(b.mass == Approx(a.mass).epsilon(1e-12));
  CHECK(b.inertia == Approx(a.inertia).epsilon(1e-9));
  CHECK(b.center.x == Approx(1e4).epsilon(1e-14));
}

TEST_CASE("masses of capsules and rounded hulls are those of a fine numerical sum", "[engine][mass][analytic]") {
  const auto capsule = [](Point a, Point b, double radius) {
    Shape shape;
    shape.kind = ShapeKind::capsule;
    shape.vertices = {a, b};
    shape.radius = radius;
    shape.density = 3;
    return shape;
  };
  Shape wedge = polygon({{5, 5}, {8, 5.5}, {5.5, 7}}, 3);
  wedge.radius = 0.6;
  Shape plank = box(1.5, 0.2, {-4, 1}, 3);
  plank.angle = 0.7;
  plank.radius = 0.3;
  for (const Shape& shape : {capsule({-1, 2}, {2, 3}, 0.5), capsule({0, 0}, {0.1, 0}, 2), wedge, plank}) {
    // Thin strips of thickness t, each with its exact length. The error falls as t^1.5 at round ends.
    std::vector<Point> core = core_of(shape);
    Point lower = core[0], upper = core[0];
    for (const Point& p : core) {
      lower = {std::fmin(lower.x, p.x), std::fmin(lower.y, p.y)};
      upper = {std::fmax(upper.x, p.x), std::fmax(upper.y, p.y)};
    }
    const double r = shape.radius;
    const int count = 20000;
    const double t = (upper.y - lower.y + 2 * r) / count;
    double area = 0, first_x = 0, first_y = 0, second = 0;
    for (int i = 0; i < count; ++i) {
      const double y = lower.y - r + (i + 0.5) * t;
      // The strip is the union of the circles of all core points, so the outermost circles determine its ends.
      double left = 1e300, right = -1e300;
      const auto look = [&](double x, double core_y) {
        const double reach = r * r - (y - core_y) * (y - core_y);
        if (reach < 0) return;
        left = std::fmin(left, x - std::sqrt(reach));
        right = std::fmax(right, x + std::sqrt(reach));
      };
      for (std::size_t k = 0; k < core.size(); ++k) {
        const Point &a = core[k], &b = core[(k + 1) % core.size()];
        look(a.x, a.y);
        const double size = std::hypot(b.x - a.x, b.y - a.y);
        const double nx = (b.y - a.y) / size, ny = (a.x - b.x) / size;
        for (const double side : {1.0, -1.0}) {  // the edge moved outwards by r, where it crosses the strip
          const double ay = a.y + side * ny * r, by = b.y + side * ny * r;
          if (ay == by || (y - ay) * (y - by) > 0) continue;
          const double x = a.x + side * nx * r + (y - ay) / (by - ay) * (b.x - a.x);
          left = std::fmin(left, x);
          right = std::fmax(right, x);
        }
      }
      if (left > right) continue;
      const double width = right - left, middle = (left + right) / 2;
      area += t * width;
      first_x += t * width * middle;
      first_y += t * width * y;
      second += t * width * (width * width / 12 + middle * middle + y * y + t * t / 12);
    }
    const Point center{first_x / area, first_y / area};
    const MassProperties got = shape_mass(shape);
    CAPTURE(shape.kind, shape.radius);
    CHECK(got.mass == Approx(3 * area).epsilon(2e-6));
    CHECK(got.center.x == Approx(center.x).margin(2e-6));
    CHECK(got.center.y == Approx(center.y).margin(2e-6));
    const double inertia = 3 * (second - area * (center.x * center.x + center.y * center.y));
    CHECK(got.inertia == Approx(inertia).epsilon(1e-5));
  }
  // Closed form: a rectangle and two half discs.
  const MassProperties pill = shape_mass(capsule({-1, 0}, {1, 0}, 0.5));
  const double disc = pi * 0.25, strip = 2;
  CHECK(pill.mass == Approx(3 * (disc + strip)).epsilon(1e-14));
  CHECK(pill.center == Point{0, 0});
  CHECK(pill.inertia ==
        Approx(3 * (strip * (4 + 1) / 12 + disc * (0.125 + 1 + 2 * 4 * 0.5 / (3 * pi)))).epsilon(1e-13));
}

TEST_CASE("lines have no mass, and a body of them takes what it states", "[engine][mass][analytic]") {
  Shape segment;
  segment.kind = ShapeKind::segment;
  segment.vertices = {{1, 2}, {3, 4}};
  Body body = body_with({segment});
  CHECK(body_mass(body).mass == 0);
  CHECK(body_mass(body).center == Point{0, 0});
  body.shapes.push_back(segment);
  body.mass = ExplicitMass{4, 2.0, {}};
  CHECK(body_mass(body).mass == 4);
  CHECK(body_mass(body).inertia == 2);
  CHECK(body_mass(body).center == Point{0, 0});
  body.mass->inertia.reset();
  CHECK(body_mass(body).inertia == 0);
  body.shapes = {box(1, 1, {2, 0}), segment};
  body.mass.reset();
  CHECK(body_mass(body).mass == 4);
  CHECK(body_mass(body).center == Point{2, 0});
}

TEST_CASE("several shapes add up by the parallel axis theorem", "[engine][mass][analytic]") {
  // Two half boxes are the whole box.
  const MassProperties whole = body_mass(body_with({box(2, 1)}));
  const MassProperties halves = body_mass(body_with({box(1, 1, {-1, 0}), box(1, 1, {1, 0})}));
  CHECK(halves.mass == Approx(whole.mass));
  CHECK(halves.inertia == Approx(whole.inertia).epsilon(1e-14));
  CHECK(halves.center == Point{0, 0});

  // A dumbbell: I = 2 (m r^2 / 2 + m d^2).
  const MassProperties bell = body_mass(body_with({circle(0.5, {-3, 5}), circle(0.5, {3, 5})}));
  const double m = pi / 4;
  CHECK(bell.mass == Approx(2 * m));
  CHECK(bell.center.y == Approx(5));
  CHECK(bell.inertia == Approx(2 * (m * 0.125 + m * 9)).epsilon(1e-13));
}

TEST_CASE("a stated mass scales the inertia, and what is stated counts", "[engine][mass][analytic]") {
  Body body = body_with({box(1, 0.5, {2, 0})});
  body.mass = ExplicitMass{8, {}, {}};
  CHECK(body_mass(body).mass == 8);
  CHECK(body_mass(body).inertia == Approx(8 * (4 + 1) / 12.0));
  CHECK(body_mass(body).center == Point{2, 0});
  body.mass = ExplicitMass{8, 3.0, Point{1, 1}};
  CHECK(body_mass(body).inertia == 3);
  CHECK(body_mass(body).center == Point{1, 1});
  body.fixed_rotation = true;
  CHECK(body_mass(body).inertia == 0);
  CHECK(body_mass(body).mass == 8);
  body = body_with({box(1, 0.5, {2, 0})});
  body.type = BodyType::static_body;
  CHECK(body_mass(body).mass == 0);
  CHECK(body_mass(body).inertia == 0);
  CHECK(body_mass(body).center == Point{2, 0});
}
