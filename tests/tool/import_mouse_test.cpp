// Mouse sessions: the inputs from their rows, refusals, and the model that makes sessions.
// SPDX-License-Identifier: MIT
#include "tool/import/import_mouse.h"

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/scene_json.h"
#include "tests/support/catch.h"
#include "tool/import/mouse_model.h"

using namespace ticktrue;
using namespace ticktrue::engine;
using namespace ticktrue::tool;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string header = "record timestamp,client timestamp,button,state,x,y\n";

/// The thesis scene with ticks of 0.1 s and a window of 10 x 20 m.
Scene scene_of_tenths() {
  Scene scene = *make_builtin_scene("thesis?dt=0.1");
  scene.pointer->window = Bounds{{0, 0}, {10, 20}};
  return scene;
}

std::vector<Input> imported(const std::string& rows, const tool::MouseImportOptions& options = {}) {
  auto inputs = import_mouse(header + rows, "s.csv", scene_of_tenths(), options);
  if (!inputs) FAIL(inputs.error().message);
  return *std::move(inputs);
}

std::string refusal(const std::string& csv) {
  const auto inputs = tool::import_mouse(csv, "s.csv", scene_of_tenths());
  return inputs ? "accepted" : inputs.error().message;
}

std::size_t count_of(const std::vector<Input>& inputs, InputKind kind) {
  std::size_t count = 0;
  for (const Input& input : inputs) count += input.kind == kind ? 1 : 0;
  return count;
}

std::string file_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

void check_well_formed(const Scene& scene, const std::vector<Input>& inputs) {
  bool is_held = false;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const Input& input = inputs[i];
    REQUIRE(check_input(scene, input, "x"));
    if (i > 0) {
      const Input& last = inputs[i - 1];
      REQUIRE(last.tick <= input.tick);
      REQUIRE(input.sequence == (last.tick == input.tick ? last.sequence + 1 : 0));
      REQUIRE_FALSE((last.kind == InputKind::drag && input.kind == InputKind::drag && last.tick == input.tick));
    }
    if (input.kind == InputKind::press) {
      REQUIRE_FALSE(is_held);
      is_held = true;
    }
    if (input.kind == InputKind::drag) REQUIRE(is_held);
    if (input.kind == InputKind::release) {
      REQUIRE(is_held);
      is_held = false;
    }
    REQUIRE((input.kind == InputKind::end) == (i + 1 == inputs.size()));
  }
}

}  // namespace

TEST_CASE("presses, drags and releases fall into their ticks and places, and the session ends",
          "[verifier][import_mouse][analytic]") {
  const std::vector<Input> inputs = imported(
      "0.0,0.0,NoButton,Move,99,199\n"
      "0.2,0.25,Left,Pressed,9,49\n"
      "0.3,0.31,NoButton,Drag,20,49\n"
      "0.3,0.35,NoButton,Drag,30,59\n"
      "0.4,0.45,NoButton,Drag,40,69\n"
      "0.5,0.46,Left,Released,40,69\n"
      "0.5,1.0,NoButton,Move,50,69\n");
  REQUIRE(inputs.size() == 5);
  // 100 x 200 px map to 10 x 20 m. Inputs are at the centres of pixels, and y is inverted.
  CHECK(inputs[0].tick == 2);
  CHECK(inputs[0].kind == InputKind::press);
  CHECK(inputs[0].values[0] == Approx(0.95));
  CHECK(inputs[0].values[1] == Approx(20 - 4.95));
  CHECK(inputs[1].tick == 3);
  CHECK(inputs[1].kind == InputKind::drag);
  CHECK(inputs[1].values[0] == Approx(3.05));  // the last of the two drags in this tick
  CHECK(inputs[1].values[1] == Approx(20 - 5.95));
  CHECK(inputs[2].tick == 4);
  CHECK(inputs[2].sequence == 0);
  CHECK(inputs[3].tick == 4);
  CHECK(inputs[3].kind == InputKind::release);
  CHECK(inputs[3].sequence == 1);
  CHECK(inputs[4].kind == InputKind::end);
  CHECK(inputs[4].tick == 11);
  check_well_formed(scene_of_tenths(), inputs);
}

TEST_CASE("unknown positions are skipped, but a release counts wherever it is", "[verifier][import_mouse][analytic]") {
  const std::vector<Input> inputs = imported(
      "0,0,Left,Pressed,65535,65535\n"
      "0,0.1,Left,Released,65535,65535\n"
      "0,0.2,Left,Pressed,5,5\n"
      "0,0.3,NoButton,Drag,65535,65535\n"
      "0,0.4,Left,Released,65535,65535\n");
  REQUIRE(inputs.size() == 3);
  CHECK(inputs[0].kind == InputKind::press);
  CHECK(inputs[0].values[0] == Approx(10 * 5.5 / 6));  // the largest coordinates determine the size of the screen
  CHECK(inputs[1].kind == InputKind::release);
}

TEST_CASE("the right button counts only where asked for, and drags belong to the button that is held",
          "[verifier][import_mouse][analytic]") {
  const std::string rows =
      "0,0.0,Right,Pressed,5,5\n"
      "0,0.1,NoButton,Drag,6,5\n"
      "0,0.2,Left,Released,6,5\n"
      "0,0.35,Right,Released,6,5\n"
      "0,0.4,Scroll,Down,0,0\n"
      "0,0.5,Left,Released,6,5\n";
  CHECK(imported(rows).size() == 1);
  tool::MouseImportOptions options;
  options.right_presses = true;
  const std::vector<Input> inputs = imported(rows, options);
  REQUIRE(inputs.size() == 4);
  CHECK(inputs[2].kind == InputKind::release);
  CHECK(inputs[2].tick == 3);
}

TEST_CASE("a press without a release before it is given one", "[verifier][import_mouse][analytic]") {
  const std::vector<Input> inputs = imported(
      "0,0.0,Left,Pressed,5,5\n"
      "0,0.5,Left,Pressed,5,5\n"
      "0,0.6,Left,Released,5,5\n");
  REQUIRE(inputs.size() == 5);
  CHECK(inputs[1].kind == InputKind::release);
  CHECK(inputs[2].kind == InputKind::press);
  CHECK(inputs[2].sequence == 1);
  check_well_formed(scene_of_tenths(), inputs);
}

TEST_CASE("line ends of either kind, a byte order mark and empty lines change nothing",
          "[verifier][import_mouse][equivalence]") {
  const std::string row = "0,0.2,Left,Pressed,5,5";
  const std::vector<Input> expected = imported(row + "\n");
  CHECK(imported(row) == expected);
  CHECK(imported(row + "\r\n\n") == expected);
  const auto marked = tool::import_mouse("\xef\xbb\xbf" + header.substr(0, header.size() - 1) + "\r\n" + row, "s.csv",
                                         scene_of_tenths());
  REQUIRE(marked);
  CHECK(*marked == expected);
}

TEST_CASE("the screen is mapped to the window asked for, the pointer's, or the bounds",
          "[verifier][import_mouse][analytic]") {
  const std::string csv = header + "0,0.2,Left,Pressed,0,0\n";
  Scene scene = scene_of_tenths();
  const auto press_x = [&](const tool::MouseImportOptions& options) {
    return (*import_mouse(csv, "s.csv", scene, options))[0].values[0];
  };
  tool::MouseImportOptions options;
  options.window = Bounds{{100, 0}, {102, 1}};
  CHECK(press_x(options) == 101);
  CHECK(press_x({}) == 5);
  scene.pointer->window.reset();
  CHECK(press_x({}) == 16);
  scene.bounds.reset();
  CHECK(import_mouse(csv, "s.csv", scene, options));
  CHECK_THAT(tool::import_mouse(csv, "s.csv", scene).error().message,
             Contains("found neither pointer.window nor bounds"));
  const auto without = import_mouse(csv, "s.csv", *make_builtin_scene("stack"), options);
  REQUIRE_FALSE(without);
  CHECK(without.error().code == ErrorCode::incompatible);
  CHECK_THAT(without.error().message, Contains("takes no mouse: found no pointer"));
}

TEST_CASE("malformed sessions are refused with file, line and column", "[verifier][import_mouse][corruption]") {
  const std::string good = "0,0.2,Left,Pressed,5,5\n";
  CHECK(refusal(header + good) == "accepted");
  CHECK_THAT(refusal(""), StartsWith("s.csv:0: the session is empty") || StartsWith("s.csv:1: the session is empty"));
  CHECK_THAT(refusal(header), StartsWith("s.csv:1: the session is empty: found no row"));
  CHECK_THAT(refusal(good), StartsWith("s.csv:1: not a mouse session: found \"0,0.2,Left"));
  CHECK_THAT(refusal("\x89PNG\r\n\x1a\n"), StartsWith("s.csv:1: not a mouse session: found \"?PNG\""));
  CHECK(refusal(header + good + "1,2,Left\n") == "s.csv:3: wrong number of columns: found 3, expected 6");
  CHECK(refusal(header + "1,2,Left,Pressed,5,5,9\n") == "s.csv:2: wrong number of columns: found 7, expected 6");
  CHECK(refusal(header + good + good + "0,soon,Left,Pressed,5,5\n") ==
        "s.csv:4: client timestamp: not a number: found \"soon\"");
  CHECK_THAT(refusal(header + "nan,0,Left,Pressed,5,5\n"),
             StartsWith("s.csv:2: record timestamp: not a number: found \"nan\""));
  CHECK_THAT(refusal(header + "0,-1,Left,Pressed,5,5\n"),
             StartsWith("s.csv:2: client timestamp: out of range: found -1"));
  CHECK_THAT(refusal(header + "0,1,Left,Pressed,-5,5\n"), StartsWith("s.csv:2: x: out of range: found -5"));
  CHECK_THAT(refusal(header + "0,1,Left,Pressed,5,70000\n"), StartsWith("s.csv:2: y: out of range: found 70000"));
  CHECK_THAT(refusal(header + "0,1,left,Pressed,5,5\n"),
             StartsWith("s.csv:2: button: unknown: found \"left\", expected NoButton, Left"));
  CHECK_THAT(refusal(header + "0,1,Left,Press,5,5\n"),
             StartsWith("s.csv:2: state: unknown: found \"Press\", expected Move, Pressed"));
  CHECK_THAT(refusal(header + "0,1,Left,Pressed,5,5\n0,0.9,Left,Released,5,5\n"),
             StartsWith("s.csv:3: client timestamp: time runs backwards: found 0.9 after 1"));
  CHECK_THAT(refusal(header + std::string(5000, 'x')), StartsWith("s.csv:2: line too long: found 5000"));
}

TEST_CASE("a session cut anywhere is refused or a shorter session, never a crash",
          "[verifier][import_mouse][corruption]") {
  const std::string csv =
      header + "0.0,0.0,NoButton,Move,99,199\n0.2,0.25,Left,Pressed,9,49\n0.5,0.46,Left,Released,40,69\n";
  for (std::size_t size = 0; size < csv.size(); ++size) {
    const auto inputs = tool::import_mouse(std::string_view(csv).substr(0, size), "s.csv", scene_of_tenths());
    if (inputs) check_well_formed(scene_of_tenths(), *inputs);
  }
  CHECK(refusal(csv) == "accepted");
}

TEST_CASE("the modelled person clicks about once a second and drags one time in six",
          "[verifier][mouse_model][analytic]") {
  const Scene scene = *make_builtin_scene("thesis");
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const std::vector<Input> inputs = *tool::model_mouse_session(scene, seed, 600);
    check_well_formed(scene, inputs);
    CHECK(inputs.back().tick == static_cast<std::uint64_t>(600 / 0.0167));
    const std::size_t presses = count_of(inputs, InputKind::press);
    CHECK(presses >= 450);
    CHECK(presses <= 700);
    std::size_t drags = 0;
    for (std::size_t i = 1; i < inputs.size(); ++i)
      drags += inputs[i].kind == InputKind::drag && inputs[i - 1].kind == InputKind::press ? 1 : 0;
    CHECK(drags >= presses / 12);
    CHECK(drags <= presses / 3);
    for (const Input& input : inputs) {
      if (input.kind != InputKind::press && input.kind != InputKind::drag) continue;
      CHECK((input.values[0] >= 0 && input.values[0] <= 32));
      CHECK((input.values[1] >= 0 && input.values[1] <= 24));
    }
  }
  CHECK(*tool::model_mouse_session(scene, 1, 20) == *tool::model_mouse_session(scene, 1, 20));
  CHECK_FALSE(*tool::model_mouse_session(scene, 1, 20) == *tool::model_mouse_session(scene, 2, 20));
  CHECK(tool::model_mouse_session(scene, 1, 0)->size() == 1);
  CHECK_FALSE(tool::model_mouse_session(scene, 1, -1));
  CHECK_FALSE(tool::model_mouse_session(scene, 1, 1e9));
  CHECK_FALSE(tool::model_mouse_session(*make_builtin_scene("stack"), 1, 10));
  CHECK_FALSE(tool::model_mouse_session(*make_builtin_scene("thesis?dt=1e-9"), 1, 2000));
}

TEST_CASE("the repository's session is the model's with seed 1 over 60 seconds", "[verifier][mouse_model][golden]") {
  const Scene scene = *make_builtin_scene("thesis");
  std::string expected;
  const auto inputs = tool::model_mouse_session(scene, 1, 60);
  REQUIRE(inputs);
  for (const Input& input : *inputs) expected += print_input(scene, input) + "\n";
  CHECK(file_text(std::string(TICKTRUE_SOURCE_DIR) + "/scenes/thesis_session.jsonl") == expected);
}

TEST_CASE("the sessions of real people have the presses that their table counts",
          "[verifier][import_mouse][.sessions]") {
  // TICKTRUE_SESSIONS names the folder of the sessions. The repository does not contain them.
  const char* folder = std::getenv("TICKTRUE_SESSIONS");
  if (folder == nullptr) {
    WARN("TICKTRUE_SESSIONS is not set: nothing was checked");
    return;
  }
  const Scene scene = *make_builtin_scene("thesis");
  const std::map<std::string, std::size_t> left_presses{{"session_7914718036", 10},  {"session_8799729281", 59},
                                                        {"session_0032069206", 65},  {"session_7992883230", 91},
                                                        {"session_1391052664", 109}, {"session_5265929106", 1221}};
  for (const auto& [name, presses] : left_presses) {
    CAPTURE(name);
    const auto inputs = tool::import_mouse(file_text(std::string(folder) + "/" + name + ".csv"), name, scene);
    if (!inputs) FAIL(inputs.error().message);
    CHECK(count_of(*inputs, InputKind::press) == presses);
    CHECK(count_of(*inputs, InputKind::release) == presses);
    check_well_formed(scene, *inputs);
    WARN(name << ": " << inputs->size() << " inputs, " << count_of(*inputs, InputKind::drag)
              << " drags, ends before tick " << inputs->back().tick);
  }
}
