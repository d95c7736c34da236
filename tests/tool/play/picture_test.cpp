// Bodies are drawn at their places in the state, shapes cover their geometric area, and pictures are complete PNG
// files.
// SPDX-License-Identifier: MIT
#include <cmath>
#include <set>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"
#include "tests/support/engine_runs.h"
#include "tests/support/scenes.h"
#include "tool/output/compression.h"
#include "tool/play/picture/canvas.h"
#include "tool/play/picture/font.h"
#include "tool/play/picture/png.h"
#include "tool/play/picture/theme.h"
#include "tool/play/picture/view.h"
#include "tool/play/picture/world_picture.h"

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_ONLY_PNG
#include <stb/stb_image.h>

namespace ticktrue {
namespace {

using play::Canvas;
using play::Color;
using play::Pixel;

constexpr Color black{0, 0, 0};
constexpr Color white{255, 255, 255};

/// Sum and first moments of the whiteness of a picture.
struct Ink {
  double area = 0;
  Pixel middle;
};
Ink ink_of(const Canvas& canvas) {
  Ink ink;
  for (int y = 0; y < canvas.height(); ++y)
    for (int x = 0; x < canvas.width(); ++x) {
      const double share = canvas.at(x, y).green / 255.0;
      ink.area += share;
      ink.middle.x += share * (x + 0.5);
      ink.middle.y += share * (y + 0.5);
    }
  ink.middle.x /= ink.area;
  ink.middle.y /= ink.area;
  return ink;
}

TEST_CASE("a circle covers pi r^2 around its centre, also between pixels", "[play][canvas]") {
  for (const double radius : {3.0, 10.3, 41.7}) {
    for (const double shift : {0.0, 0.3, 0.5}) {
      Canvas canvas(100, 100);
      canvas.clear(black);
      canvas.circle({50 + shift, 49.2}, radius, {white, white, 2});
      const Ink ink = ink_of(canvas);
      CAPTURE(radius, shift);
      CHECK(ink.area == Approx(3.14159265 * radius * radius).epsilon(0.02));
      CHECK(ink.middle.x == Approx(50 + shift).margin(0.02));
      CHECK(ink.middle.y == Approx(49.2).margin(0.02));
    }
  }
}

TEST_CASE("a convex area covers its own area, whichever way round its corners go", "[play][canvas]") {
  std::vector<Pixel> corners{{10.2, 20.7}, {60.5, 12.1}, {80.9, 50.3}, {40.4, 77.7}};
  double area = 0;
  for (std::size_t i = 0; i < 4; ++i)
    area += (corners[i].x * corners[(i + 1) % 4].y - corners[i].y * corners[(i + 1) % 4].x) / 2;
  for (const bool turned : {false, true}) {
    if (turned) std::reverse(corners.begin(), corners.end());
    Canvas canvas(100, 100);
    canvas.clear(black);
    canvas.convex(corners, {white, white, 1.5});
    CHECK(ink_of(canvas).area == Approx(std::abs(area)).epsilon(0.01));
  }
}

TEST_CASE("what lies outside, is huge, or is not finite is drawn without harm", "[play][canvas]") {
  Canvas canvas(64, 48);
  canvas.clear(black);
  const double infinite = std::numeric_limits<double>::infinity();
  for (const double far : {-1e6, 1e12, 1e300, infinite, std::nan("")}) {
    canvas.circle({far, 10}, 5, {white, white, 1});
    canvas.circle({10, 10}, std::abs(far) > 1e6 ? 2 : 1, {black, black, 1});
    canvas.line({far, far}, {far, 10}, 1, white);
    canvas.line({-1e9, 1e9 + 100}, {-2e9, 5}, 1, white);
    canvas.rectangle({far, 0}, {far, 40}, {white, white, 1});
  }
  canvas.rectangle({-1e9, -1e9}, {1e9, 1e9}, {white, white, 1});
  CHECK(ink_of(canvas).area == Approx(64 * 48));
}

TEST_CASE("every letter has ink of its own", "[play][font]") {
  const play::Font font(10);
  std::set<std::vector<std::uint32_t>> seen;
  for (char letter = '!'; letter <= '~'; ++letter) {
    Canvas canvas(20, 24);
    canvas.clear(black);
    font.draw(canvas, 4, 4, std::string(1, letter), white);
    CAPTURE(letter);
    CHECK(ink_of(canvas).area > 1);
    CHECK(seen.insert(canvas.pixels()).second);
  }
}

/// A scene with one body. The picture shows only this body.
engine::Scene scene_with(const engine::Shape& shape) {
  engine::Scene scene;
  engine::Body body;
  body.name = "it";
  body.position = {1.25, -0.6};
  body.angle = 0.7;
  body.shapes.push_back(shape);
  scene.bodies.push_back(body);
  return scene;
}

TEST_CASE("the pixels of a body have their middle where its centre of mass projects to", "[play][picture]") {
  const engine::Shape shapes[] = {test::disc_shape(0.5), test::box_shape(0.7, 0.3),
                                  test::polygon_shape({{0, 0}, {1, 0}, {0.4, 0.9}}),
                                  test::capsule_shape({-0.5, 0}, {0.6, 0.2}, 0.25)};
  for (engine::Shape shape : shapes) {
    for (const double rounding : {0.0, 0.15}) {
      if (shape.kind == engine::ShapeKind::box || shape.kind == engine::ShapeKind::polygon) shape.radius = rounding;
      const auto engine = test::make_engine_or_fail(scene_with(shape));
      play::View view;
      view.width = 200;
      view.height = 160;
      view.center = {1, -0.5};
      view.scale = 50;
      Canvas with(view.width, view.height), without(view.width, view.height);
      play::WorldPicture picture(*engine);
      picture.draw(with, view, {});
      play::draw_ground(without, view);
      // Counts every pixel that differs from the empty background: edge and fill.
      Canvas difference(view.width, view.height);
      difference.clear(black);
      double area = 0;
      for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x)
          if (!(with.at(x, y) == without.at(x, y))) {
            difference.rectangle({double(x), double(y)}, {x + 1.0, y + 1.0}, {white, white, 0});
            ++area;
          }
      const engine::BodyReport body = engine->bodies()[0];
      const Pixel expected = view.to_pixel(body.center);
      const Ink ink = ink_of(difference);
      CAPTURE(static_cast<int>(shape.kind), rounding);
      // Half a pixel around the outline also changes. The change is even, so the centre of an asymmetric shape moves by
      // less than 2 px.
      CHECK(ink.middle.x == Approx(expected.x).margin(2));
      CHECK(ink.middle.y == Approx(expected.y).margin(2));
      const double whole = body.mass / 1.0 * view.scale * view.scale;  // density 1: the mass is the area
      CHECK(area > whole);
      CHECK(area < whole * 1.15);
    }
  }
}

TEST_CASE("each body that can be seen is drawn at its projected centre, in a moving pile", "[play][picture]") {
  auto scene = engine::make_builtin_scene("shapes?bodies=60");
  REQUIRE(scene);
  const auto engine = test::make_engine_or_fail(*scene);
  const play::View view = play::first_view(*engine, 900, 700);
  play::WorldPicture picture(*engine);
  Canvas canvas(view.width, view.height), ground(view.width, view.height);
  play::draw_ground(ground, view);
  for (int tick = 0; tick < 200; ++tick) {
    REQUIRE(engine->step({scene->settings.dt, {}}, nullptr));
    if (tick % 50 != 49) continue;
    const std::uint64_t before = root_hash(engine->state());
    picture.draw(canvas, view, {});
    CHECK(root_hash(engine->state()) == before);
    int seen = 0;
    for (const engine::BodyReport& body : engine->bodies()) {
      if (body.type != engine::BodyType::dynamic_body) continue;
      const Pixel at = view.to_pixel(body.center);
      if (!(at.x >= 1 && at.y >= 1 && at.x < view.width - 1 && at.y < view.height - 1)) continue;
      ++seen;
      CAPTURE(tick, body.name, at.x, at.y);
      CHECK_FALSE(canvas.at(static_cast<int>(at.x), static_cast<int>(at.y)) ==
                  ground.at(static_cast<int>(at.x), static_cast<int>(at.y)));
    }
    CHECK(seen > 50);
  }
}

// Discs in a row, 2 m apart, without gravity. Those with an index in `spinning` rotate in place.
engine::Scene row_of_discs(int count, const std::set<int>& spinning) {
  engine::Scene scene;
  scene.gravity = {0, 0};
  for (int i = 0; i < count; ++i) {
    engine::Body body;
    body.position = {2.0 * i, 0};
    body.angular_velocity = spinning.count(i) == 1 ? 1 : 0;
    body.shapes.push_back(test::disc_shape(0.5));
    scene.bodies.push_back(body);
  }
  return scene;
}

play::View view_of_row() {
  play::View view;
  view.width = 400;
  view.height = 100;
  view.center = {4, 0};
  view.scale = 40;
  return view;
}

TEST_CASE("bodies that sleep are dim, and no others", "[play][picture]") {
  const std::set<int> spinning{0, 3};
  engine::Scene scene = row_of_discs(5, spinning);
  scene.settings.sleep.emplace();
  scene.settings.sleep->after_s = 0.1;
  const auto engine = test::make_engine_or_fail(scene);
  const play::View view = view_of_row();
  play::WorldPicture picture(*engine);
  Canvas awake(view.width, view.height), later(view.width, view.height);
  picture.draw(awake, view, {});
  test::run_ticks(*engine, 20);
  picture.draw(later, view, {});
  for (int i = 0; i < 5; ++i) {
    const Pixel at = view.to_pixel({2.0 * i, -0.25});  // beside the line that shows the angle
    CAPTURE(i);
    const bool is_same = awake.at(static_cast<int>(at.x), static_cast<int>(at.y)) ==
                         later.at(static_cast<int>(at.x), static_cast<int>(at.y));
    CHECK(is_same == (spinning.count(i) == 1));
  }
}

TEST_CASE("a pull is drawn from its body to the pointer", "[play][picture]") {
  engine::Scene scene = row_of_discs(5, {});
  scene.inputs = {engine::InputKind::press, engine::InputKind::drag, engine::InputKind::release};
  scene.pointer.emplace();
  const auto engine = test::make_engine_or_fail(scene);
  engine::Input press;
  press.kind = engine::InputKind::press;
  press.values[0] = 4.1;
  press.values[1] = 0.2;
  Bytes inputs;
  engine::encode_inputs({press}, inputs);
  REQUIRE(engine->step({scene.settings.dt, inputs}, nullptr));
  const play::View view = view_of_row();
  play::WorldPicture picture(*engine);
  Canvas canvas(view.width, view.height);
  picture.draw(canvas, view, {});
  const Pixel at = view.to_pixel({4.1, 0.2});
  CHECK(canvas.at(static_cast<int>(at.x), static_cast<int>(at.y)) == play::theme::pull);
  int count = 0;
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) count += canvas.at(x, y) == play::theme::pull ? 1 : 0;
  CHECK(count > 10);
  CHECK(count < 150);  // a disc of 3 px, and a ring of 5 px around the pointer at the same place
}

TEST_CASE("the layers show what there is: contacts, joints, boxes, pairs", "[play][picture]") {
  const std::pair<const char*, play::Layer> rows[] = {
      {"stack?boxes=5", play::Layer::contacts}, {"stack?boxes=5", play::Layer::normals},
      {"bridge?planks=6", play::Layer::joints}, {"stack?boxes=5", play::Layer::islands},
      {"stack?boxes=5", play::Layer::boxes},    {"stack?boxes=5", play::Layer::pairs}};
  for (const auto& [name, layer] : rows) {
    auto scene = engine::make_builtin_scene(name);
    REQUIRE(scene);
    const auto engine = test::make_engine_or_fail(*scene);
    for (int tick = 0; tick < 20; ++tick) REQUIRE(engine->step({scene->settings.dt, {}}, nullptr));
    const play::View view = play::first_view(*engine, 400, 300);
    play::WorldPicture picture(*engine);
    Canvas plain(400, 300), layered(400, 300);
    picture.draw(plain, view, {});
    play::LayerSet set;
    set.toggle(layer);
    picture.draw(layered, view, set);
    CAPTURE(name, static_cast<int>(layer));
    CHECK(plain.pixels() != layered.pixels());
  }
}

TEST_CASE("every broad phase hands on at least the pairs that touch", "[play][broad_phase]") {
  for (const auto& info : engine::broad_phases) {
    auto scene = engine::make_builtin_scene("mixed_pile?bodies=40&broad_phase=" + std::string(info.name));
    REQUIRE(scene);
    const auto engine = test::make_engine_or_fail(*scene);
    for (int tick = 0; tick < 120; ++tick) REQUIRE(engine->step({scene->settings.dt, {}}, nullptr));
    const engine::BroadPhaseReport report = engine->broad_phase();
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const auto& pair : report.pairs) {
      const std::uint32_t a = report.boxes[pair.first].body, b = report.boxes[pair.second].body;
      pairs.insert({std::min(a, b), std::max(a, b)});
    }
    CAPTURE(info.name);
    const std::vector<engine::ContactReport> contacts = engine->contacts();
    REQUIRE(contacts.size() > 20);
    for (const engine::ContactReport& contact : contacts) {
      CHECK(pairs.count({std::min(contact.body_a, contact.body_b), std::max(contact.body_a, contact.body_b)}) == 1);
    }
  }
}

// --- PNG ------------------------------------------------------------------------------------------------------------

TEST_CASE("a picture written as PNG holds the pixels it was made of", "[play][png]") {
  auto scene = engine::make_builtin_scene("mixed_pile?bodies=60");
  REQUIRE(scene);
  const auto engine = test::make_engine_or_fail(*scene);
  const play::View view = play::first_view(*engine, 320, 240);
  play::WorldPicture picture(*engine);
  Canvas canvas(320, 240);
  picture.draw(canvas, view, {});
  const Bytes png = play::png_of(canvas);
  CHECK(png.size() < 320 * 240 * 3 / 4);  // it compresses
  int width = 0, height = 0, channels = 0;
  unsigned char* rgb = stbi_load_from_memory(png.data(), static_cast<int>(png.size()), &width, &height, &channels, 3);
  REQUIRE(rgb != nullptr);
  REQUIRE(width == 320);
  REQUIRE(height == 240);
  CHECK(channels == 3);
  bool same = true;
  const unsigned char* at = rgb;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x, at += 3) {
      const Color color = canvas.at(x, y);
      same = same && at[0] == color.red && at[1] == color.green && at[2] == color.blue;
    }
  stbi_image_free(rgb);
  CHECK(same);
}

TEST_CASE("a zlib stream holds the bytes it was made of", "[play][png]") {
  for (const std::size_t size : {1u, 1000u, 300000u}) {
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i % 7 == 0 ? i * i >> 5 : 0);
    const Bytes stream = zlib_of(bytes);
    int found_size = 0;
    char* found = stbi_zlib_decode_malloc(reinterpret_cast<const char*>(stream.data()), static_cast<int>(stream.size()),
                                          &found_size);
    REQUIRE(found != nullptr);
    CHECK(Bytes(found, found + found_size) == bytes);
    CHECK(stream.size() < size / 2 + 20);
    stbi_image_free(found);
  }
  CHECK(zlib_of({}) == Bytes{0x78, 0x01, 0x03, 0x00, 0x00, 0x00, 0x00, 0x01});  // readable by Python's zlib.decompress
}

}  // namespace
}  // namespace ticktrue
