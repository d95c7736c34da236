// The actions of a person become the inputs of a recording, independently of the display.
// SPDX-License-Identifier: MIT
#include "tool/play/session.h"

#include <cmath>

#include "replay/trace_reader.h"
#include "tests/support/catch.h"
#include "tests/tool/play/playing.h"
#include "tool/play/picture/world_picture.h"
#include "tool/session/playback.h"
#include "tool/session/simulations.h"
#include "verifier/verify/verify.h"

namespace ticktrue {
namespace {

using test::play_script;
using test::PlayedSession;

std::string event(double t, const std::string& rest) {
  return "{\"t\":" + std::to_string(t) + ",\"event\":" + rest + "}\n";
}
std::string mouse(double t, const char* what, const char* button, double x, double y, bool ctrl = false) {
  return event(t, std::string("\"") + what + "\",\"button\":\"" + button + "\",\"x\":" + std::to_string(x) +
                      ",\"y\":" + std::to_string(y) + (ctrl ? ",\"ctrl\":true" : ""));
}
std::string move(double t, double x, double y) {
  return event(t, "\"move\",\"x\":" + std::to_string(x) + ",\"y\":" + std::to_string(y));
}
std::string key(double t, const char* name) {
  return event(t, std::string("\"key\",\"key\":\"") + name + "\"");
}
std::string quit(double t) {
  return event(t, "\"quit\"");
}

std::vector<std::string> names_of(const engine::Engine& engine) {
  std::vector<std::string> names;
  for (const engine::BodyReport& body : engine.bodies()) names.push_back(body.name);
  return names;
}
std::size_t count_of(const engine::Engine& engine, const std::string& prototype) {
  std::size_t count = 0;
  for (const std::string& name : names_of(engine)) count += name.rfind(prototype + "#", 0) == 0 ? 1 : 0;
  return count;
}

/// Clicks, pulls, pauses, steps, pans and zooms. None is at a boundary of a tick or a frame.
std::string busy_script() {
  std::string script;
  double t = 0.0113;
  for (int i = 0; i < 24; ++i) {
    const char* buttons[] = {"left", "right", "middle"};
    script += mouse(t, "click", buttons[i % 3], 120 + 23.0 * i, 80 + 3.0 * (i % 5), i % 7 == 6);
    t += 0.0371;
  }
  script += event(t += 0.05, "\"wheel\",\"x\":300,\"y\":200,\"steps\":2");
  script += key(t += 0.0217, "left");
  script += mouse(t += 0.0217, "click", "left", 420, 60);
  script += mouse(t += 0.9, "press", "left", 420, 60);
  for (int i = 0; i < 20; ++i) script += move(t += 0.0073, 420 + 4.0 * i, 60 + 2.0 * i);
  script += key(t += 0.0091, "space");
  script += mouse(t += 0.1, "click", "right", 250, 50);
  script += key(t += 0.05, ".");
  script += key(t += 0.05, ".");
  script += key(t += 0.05, "space");
  script += mouse(t += 0.31, "release", "left", 500, 100);
  return script + quit(t + 0.503);
}

TEST_CASE("a session is the same trace, byte for byte, at 30, 60, 144 and 17 frames a second", "[play][determinism]") {
  const test::TemporaryDirectory directory;
  for (const char* name : {"thesis", "thesis?precision=f64", "pyramid?base=6"}) {
    CAPTURE(name);
    const PlayedSession at_60 = play_script(test::builtin_scene(name), busy_script(), 60, directory.file("60.ttr"));
    REQUIRE(at_60.tick_count > 120);
    REQUIRE(at_60.engine->bodies().size() > 20);
    for (const double hz : {30.0, 144.0, 17.0}) {
      CAPTURE(hz);
      const PlayedSession other =
          play_script(test::builtin_scene(name), busy_script(), hz, directory.file("other.ttr"));
      std::filesystem::remove(directory.file("other.ttr"));
      CHECK(other.tick_count == at_60.tick_count);
      CHECK((other.trace == at_60.trace));
    }
    // Negative control: a click one tick later is another session.
    std::string later = busy_script();
    later.replace(later.find("0.0113"), 6, "0.0413");
    CHECK((play_script(test::builtin_scene(name), later, 60, directory.file("later.ttr")).trace != at_60.trace));
    std::filesystem::remove(directory.file("later.ttr"));
    std::filesystem::remove(directory.file("60.ttr"));
  }
}

TEST_CASE("looking with every layer on changes no bit of what is recorded", "[play][determinism]") {
  const test::TemporaryDirectory directory;
  const PlayedSession plain =
      play_script(test::builtin_scene("thesis"), busy_script(), 60, directory.file("plain.ttr"));
  play::LayerSet all;
  for (const play::LayerInfo& info : play::all_layers) all.toggle(info.layer);
  play::Canvas canvas(800, 600);
  std::unique_ptr<play::WorldPicture> picture;
  const PlayedSession drawn = play_script(test::builtin_scene("thesis"), busy_script(), 60, directory.file("drawn.ttr"),
                                          [&](const engine::Engine& engine, const play::Session& session) {
                                            if (!picture) picture = std::make_unique<play::WorldPicture>(engine);
                                            picture->draw(canvas, session.view(), all);
                                          });
  CHECK((plain.trace == drawn.trace));
}

TEST_CASE("what was played verifies, from the scene inside the trace", "[play][verify]") {
  const test::TemporaryDirectory directory;
  for (const char* name : {"thesis", "bridge?planks=8", "shapes?bodies=10", "projectile"}) {
    CAPTURE(name);
    const std::string path = directory.file("played.ttr");
    const PlayedSession played = play_script(test::builtin_scene(name), busy_script(), 60, path);
    auto reader = replay::TraceReader::open(path);
    REQUIRE(reader);
    CHECK(*tool::scene_of(reader->setup()) == played.playable->scene);
    verifier::VerifyOptions options;
    options.simulation = &engine::engine_info();
    const verifier::Report report = verifier::verify(*reader, options);
    CHECK(report.verdict == verifier::Verdict::match);
    CHECK(report.ticks_compared == played.tick_count);
    std::filesystem::remove(path);
  }
}

TEST_CASE("each button makes its piece where it was clicked, ctrl makes it static", "[play][inputs]") {
  const test::TemporaryDirectory directory;
  const std::string script = mouse(0.02, "click", "left", 100, 100) + mouse(0.03, "click", "right", 200, 100) +
                             mouse(0.04, "click", "middle", 300, 100) + mouse(0.05, "click", "left", 400, 100, true) +
                             mouse(0.06, "click", "right", 500, 100, true) +
                             mouse(0.07, "click", "middle", 600, 100, true) + quit(0.12);
  engine::Scene scene = test::builtin_scene("thesis");
  scene.gravity = {0, 0};
  const PlayedSession played = play_script(scene, script, 60, directory.file("a.ttr"));
  const std::vector<engine::BodyReport> bodies = played.engine->bodies();
  REQUIRE(bodies.size() == 5 + 6);
  const char* expected[] = {"circle#5", "box#6", "polygon#7", "static_circle#8", "static_box#9", "static_polygon#10"};
  for (std::size_t i = 0; i < 6; ++i) {
    const engine::BodyReport& body = bodies[5 + i];
    CAPTURE(body.name);
    CHECK(body.name == expected[i]);
    CHECK((body.type == engine::BodyType::static_body) == (i >= 3));
    const play::Pixel at = played.view.to_pixel(body.origin);
    CHECK(at.x == Approx(100 + 100 * static_cast<double>(i)).margin(0.01));
    CHECK(at.y == Approx(100).margin(0.01));
  }
}

TEST_CASE("a press on a body pulls it to the pointer, and a release lets it go", "[play][inputs]") {
  const test::TemporaryDirectory directory;
  engine::Scene scene = test::builtin_scene("thesis");
  scene.gravity = {0, 0};
  const std::string begin = mouse(0.02, "click", "left", 150, 150) + mouse(0.2, "press", "left", 150, 150) +
                            move(0.3, 250, 200) + move(0.4, 330, 130);
  const PlayedSession held = play_script(scene, begin + quit(2.5), 60, directory.file("held.ttr"));
  REQUIRE(held.engine->bodies().size() == 6);
  const play::Pixel at = held.view.to_pixel(held.engine->bodies()[5].center);
  CHECK(std::hypot(at.x - 330, at.y - 130) < 2);

  bool was_pulled = false;
  const PlayedSession released = play_script(
      scene, begin + mouse(2.5, "release", "left", 330, 130) + move(2.6, 600, 300) + quit(3.5), 60,
      directory.file("released.ttr"),
      [&](const engine::Engine&, const play::Session& session) { was_pulled |= session.pull().has_value(); });
  const play::Pixel rest = released.view.to_pixel(released.engine->bodies()[5].center);
  CHECK(was_pulled);
  CHECK(std::hypot(rest.x - 330, rest.y - 130) < 2);  // after the release, moving the pointer has no effect
}

TEST_CASE("nothing is made inside of a body", "[play][inputs]") {
  const test::TemporaryDirectory directory;
  // In the window of the thesis scene, the floor is at the lower edge and the disc is left of the middle.
  const std::string script = mouse(0.02, "click", "left", 400, 590) + mouse(0.03, "click", "right", 400, 590) +
                             mouse(0.04, "click", "middle", 205, 300) + mouse(0.05, "click", "left", 205, 300, true) +
                             quit(0.1);
  CHECK(play_script(test::builtin_scene("thesis"), script, 60, directory.file("a.ttr")).engine->bodies().size() == 5);
}

TEST_CASE("while paused no tick runs; each . runs one", "[play][pause]") {
  const test::TemporaryDirectory directory;
  const std::string script = key(0.51, "space") + key(1.0, ".") + key(1.1, ".") + key(1.2, ".") +
                             mouse(1.3, "click", "left", 100, 100) + quit(5);
  const PlayedSession played = play_script(test::builtin_scene("stack"), script, 60, directory.file("a.ttr"));
  CHECK(played.tick_count == 30 + 3);
  CHECK(count_of(*played.engine, "circle") == 0);  // clicked while paused: the tick of the click never ran
  const PlayedSession stepped =
      play_script(test::builtin_scene("stack"), script.substr(0, script.rfind("{")) + key(1.4, ".") + quit(5), 60,
                  directory.file("b.ttr"));
  CHECK(stepped.tick_count == 30 + 4);
  CHECK(count_of(*stepped.engine, "circle") == 1);
}

TEST_CASE("dragging with the middle button pans and makes nothing", "[play][view]") {
  const test::TemporaryDirectory directory;
  const std::string script = mouse(0.1, "press", "middle", 100, 100) + move(0.15, 140, 90) +
                             mouse(0.2, "release", "middle", 140, 90) + quit(0.5);
  const engine::Scene scene = test::builtin_scene("thesis");
  const PlayedSession played = play_script(scene, script, 60, directory.file("a.ttr"));
  CHECK(played.engine->bodies().size() == 5);
  const play::View before = play::first_view(*played.engine, 800, 600);
  const engine::Point point = before.to_world({100, 100});
  const play::Pixel after = played.view.to_pixel(point);
  CHECK(after.x == Approx(140).margin(1e-6));
  CHECK(after.y == Approx(90).margin(1e-6));
}

TEST_CASE("zooming keeps what is under the pointer", "[play][view]") {
  play::View view;
  view.width = 800;
  view.height = 600;
  view.center = {3, -2};
  const engine::Point point = view.to_world({123, 456});
  view.zoom({123, 456}, 1.7);
  CHECK(view.to_pixel(point).x == Approx(123).margin(1e-9));
  CHECK(view.to_pixel(point).y == Approx(456).margin(1e-9));
  CHECK(view.scale == Approx(34));
}

TEST_CASE("keys ask for a restart, another scene, or the end", "[play][keys]") {
  const test::TemporaryDirectory directory;
  const std::pair<const char*, play::Request> rows[] = {{"r", play::Request::restart},
                                                        {"4", play::Request::scene},
                                                        {"q", play::Request::quit},
                                                        {"escape", play::Request::quit}};
  for (const auto& [name, request] : rows) {
    CAPTURE(name);
    const auto playable = play::make_playable(test::builtin_scene("stack"));
    REQUIRE(playable);
    auto engine = engine::make_engine(playable->scene);
    REQUIRE(engine);
    bool pressed = false;
    play::Session session(**engine, *playable, play::first_view(**engine, 800, 600), {}, [&](const play::Session&) {
      play::HostFrame frame;
      frame.seconds = 0.1;
      play::Event event;
      event.kind = play::EventKind::key;
      event.key = name;
      event.at_s = 0.1;
      if (pressed) FAIL("a frame after the session ended");
      pressed = true;
      frame.events.push_back(event);
      return Result<play::HostFrame>(frame);
    });
    for (std::uint64_t tick = 0;; ++tick) {
      const auto input = session.next(tick);
      REQUIRE(input);
      if (!*input) {
        CHECK(tick == 6);  // the ticks of the tenth of a second before the key
        break;
      }
    }
    CHECK(session.request() == request);
    if (request == play::Request::scene) CHECK(session.requested_scene() == 4);
  }
}

TEST_CASE("a scene gets what playing needs, keeps its own pieces, and is else as it was", "[play][scene]") {
  const engine::Scene thesis = test::builtin_scene("thesis");
  const auto playable = play::make_playable(thesis);
  REQUIRE(playable);
  CHECK(playable->can_touch);
  CHECK(playable->scene.bodies == thesis.bodies);
  CHECK(playable->scene.settings == thesis.settings);
  REQUIRE(playable->scene.prototypes.size() == 6);
  for (std::size_t piece = 0; piece < 3; ++piece) {
    CHECK(playable->scene.prototypes[playable->moving[piece]] == thesis.prototypes[piece]);
    const engine::Body& fixed = playable->scene.prototypes[playable->fixed[piece]];
    CHECK(fixed.type == engine::BodyType::static_body);
    CHECK(fixed.shapes == thesis.prototypes[piece].shapes);
  }
  CHECK(playable->scene.pointer->spawns.empty());
}

TEST_CASE("a scene whose choices allow no contacts is only looked at", "[play][scene]") {
  const engine::Scene scene = test::builtin_scene("projectile?integrator=yoshida4");
  const auto playable = play::make_playable(scene);
  REQUIRE(playable);
  CHECK_FALSE(playable->can_touch);
  CHECK(playable->scene == scene);
  CHECK_FALSE(playable->note.empty());
  const test::TemporaryDirectory directory;
  const PlayedSession played =
      play_script(scene, mouse(0.1, "click", "left", 100, 100) + quit(0.51), 60, directory.file("a.ttr"));
  CHECK(played.tick_count == 30);
  CHECK(played.engine->bodies().size() == scene.bodies.size());
}

TEST_CASE("every clock plays and its session verifies", "[play][clocks]") {
  const test::TemporaryDirectory directory;
  for (const auto& clock : engine::clock_kinds) {
    CAPTURE(clock.name);
    engine::Scene scene = test::builtin_scene("thesis");
    scene.settings.clock.kind = clock.kind;
    const std::string path = directory.file(std::string(clock.name) + ".ttr");
    const PlayedSession played = play_script(
        scene, mouse(0.1, "click", "left", 100, 100) + mouse(0.3, "click", "right", 300, 100) + quit(1), 45, path);
    CHECK(played.tick_count >= 40);
    CHECK(played.engine->bodies().size() == 7);
    auto reader = replay::TraceReader::open(path);
    REQUIRE(reader);
    verifier::VerifyOptions options;
    options.simulation = &engine::engine_info();
    CHECK(verifier::verify(*reader, options).verdict == verifier::Verdict::match);
  }
}

}  // namespace
}  // namespace ticktrue
