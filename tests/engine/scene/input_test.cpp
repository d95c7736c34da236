// Inputs: their canonical bytes, and refusals.
// SPDX-License-Identifier: MIT
#include "engine/scene/input.h"

#include <cmath>

#include "base/limits.h"
#include "base/state/state_view.h"
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// A scene that takes every kind of input.
Scene open_scene() {
  Scene scene = *make_builtin_scene("thesis");
  scene.inputs.clear();
  for (const InputInfo& info : input_kinds) scene.inputs.push_back(info.kind);
  scene.joints.resize(3);
  scene.joints[2].motor.emplace();
  return scene;
}

/// One input of each kind except `end`, with all relevant fields set.
std::vector<Input> one_of_each() {
  std::vector<Input> inputs;
  for (const InputInfo& info : input_kinds) {
    if (info.kind == InputKind::end) continue;
    Input input;
    input.player = static_cast<std::uint8_t>(inputs.size() / 4);
    input.sequence = static_cast<std::uint32_t>(1000 * inputs.size());
    input.kind = info.kind;
    if (info.has_body) input.body = 0x01020304;
    if (info.has_prototype) input.prototype = 2;
    if (info.has_joint) input.joint = 2;
    for (std::size_t i = 0; i < info.value_count; ++i) input.values[i] = 0.1 * static_cast<double>(i + 1);
    inputs.push_back(input);
  }
  return inputs;
}

Error refusal(const Scene& scene, const std::vector<Input>& inputs) {
  Bytes bytes;
  encode_inputs(inputs, bytes);
  std::vector<Input> out;
  const Status status = decode_inputs(scene, bytes, out);
  return status ? Error{ErrorCode::io, "accepted", ""} : status.error();
}

}  // namespace

TEST_CASE("inputs of every kind come back from their bytes", "[engine][input][equivalence]") {
  const Scene scene = open_scene();
  const std::vector<Input> inputs = one_of_each();
  REQUIRE(inputs.size() == input_kinds.size() - 1);
  Bytes bytes;
  encode_inputs(inputs, bytes);
  std::vector<Input> back;
  REQUIRE(decode_inputs(scene, bytes, back));
  CHECK(back == inputs);
  Bytes again;
  encode_inputs(back, again);
  CHECK(again == bytes);
  encode_inputs({}, bytes);
  CHECK(bytes.empty());
  REQUIRE(decode_inputs(scene, bytes, back));
  CHECK(back.empty());
}

TEST_CASE("the bytes of an input are those of the documented example", "[engine][input][golden]") {
  Input press;
  press.player = 3;
  press.sequence = 0x0102;
  press.kind = InputKind::press;
  press.values = {1.0, -2.0, 9, 9, 9, 9};  // only the first two count
  Bytes bytes;
  encode_inputs({press}, bytes);
  CHECK(bytes == Bytes{3, 2, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f, 0, 0, 0, 0, 0, 0, 0, 0xc0});
}

TEST_CASE("inputs that are cut anywhere are refused, unless between two inputs", "[engine][input][corruption]") {
  const Scene scene = open_scene();
  Bytes bytes;
  encode_inputs(one_of_each(), bytes);
  std::vector<Input> back;
  std::size_t accepted = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    if (decode_inputs(scene, ByteView(bytes).first(size), back))
      ++accepted;
    else
      CHECK(decode_inputs(scene, ByteView(bytes).first(size), back).error().code == ErrorCode::invalid_input);
  }
  CHECK(accepted == one_of_each().size());  // the empty prefix is accepted, the whole sequence is not counted
}

TEST_CASE("inputs that break a rule are refused with their place", "[engine][input][corruption]") {
  const Scene scene = open_scene();
  Input spawn;
  spawn.kind = InputKind::spawn;
  CHECK(refusal(scene, {spawn}).message == "accepted");

  Input bad = spawn;
  bad.prototype = 3;
  CHECK(refusal(scene, {bad}).message == "input 0: prototype: unknown: found number 3, expected 0..2");
  bad = spawn;
  bad.values[1] = std::nan("");
  CHECK_THAT(refusal(scene, {bad}).message, StartsWith("input 0: y: must be finite: found "));
  bad.values[1] = 1.5e7;
  CHECK(refusal(scene, {bad}).message == "input 0: y: out of range: found 1.5e+07, expected -1e+07..1e+07");
  bad = Input{};
  CHECK_THAT(refusal(scene, {bad}).message, Contains("end is part of no tick"));
  bad.kind = InputKind::remove;
  bad.body = no_reference;
  CHECK_THAT(refusal(scene, {bad}).message, Contains("no body has this id"));

  Input second = spawn;
  CHECK_THAT(refusal(scene, {spawn, second}).message, StartsWith("input 1: out of order"));
  second.sequence = 1;
  CHECK(refusal(scene, {spawn, second}).message == "accepted");
  CHECK_THAT(refusal(scene, {second, spawn}).message,
             Contains("found (player 0, sequence 0) after (player 0, sequence 1)"));
  spawn.player = 1;
  CHECK(refusal(scene, {second, spawn}).message == "accepted");

  std::vector<Input> back;
  const Bytes unknown{0, 0, 0, 0, 0, 12};
  CHECK_THAT(decode_inputs(scene, unknown, back).error().message,
             StartsWith("input 0: kind: unknown: found number 12"));
}

TEST_CASE("a motor is set only where a joint has one, and to a force that is not negative",
          "[engine][input][corruption]") {
  const Scene scene = open_scene();
  Input input;
  input.kind = InputKind::set_motor;
  input.joint = 2;
  input.values = {-3, 10};
  CHECK(refusal(scene, {input}).message == "accepted");
  Input bad = input;
  bad.joint = 3;
  CHECK(refusal(scene, {bad}).message == "input 0: joint: unknown: found number 3, expected less than 3");
  bad.joint = 1;
  CHECK(refusal(scene, {bad}).message == "input 0: joint: has no motor: found number 1");
  CHECK_THAT(refusal(scene, {bad}).hint, Contains("force_max may be 0"));
  bad = input;
  bad.values[1] = -1;
  CHECK_THAT(refusal(scene, {bad}).message, StartsWith("input 0: force_max: out of range: found -1, expected 0.."));
  bad.values = {2e9, 0};
  CHECK_THAT(refusal(scene, {bad}).message, StartsWith("input 0: speed: out of range: found 2e+09"));
  Bytes bytes;
  encode_inputs({input}, bytes);
  CHECK(bytes == Bytes{0, 0, 0, 0, 0, 11, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 8, 0xc0, 0, 0, 0, 0, 0, 0, 0x24, 0x40});
}

TEST_CASE("an input of a kind that the scene did not declare is refused, but a session may always end",
          "[engine][input][analytic]") {
  const Scene scene = *make_builtin_scene("projectile");
  Input input;
  CHECK(check_input(scene, input, "f:1"));
  input.kind = InputKind::torque;
  const Status status = check_input(scene, input, "f:1");
  REQUIRE_FALSE(status);
  CHECK(status.error().message ==
        "f:1: kind: not declared by scene projectile: found torque, expected none: it takes no inputs");
  const Status press = check_input(*make_builtin_scene("thesis"), input, "f:1");
  CHECK_THAT(press.error().message, Contains("expected spawn, remove, impulse, press, drag, release, end"));
}

TEST_CASE("more inputs than a tick may have are refused", "[engine][input][corruption]") {
  const Scene scene = open_scene();
  std::vector<Input> inputs(limits::inputs_per_tick_max);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    inputs[i].kind = InputKind::release;
    inputs[i].sequence = static_cast<std::uint32_t>(i);
  }
  CHECK(refusal(scene, inputs).message == "accepted");
  inputs.push_back(inputs.back());
  ++inputs.back().sequence;
  CHECK_THAT(refusal(scene, inputs).message, Contains("too many inputs in one tick"));
}

TEST_CASE("the largest burst of inputs fits a record of a trace", "[engine][input][analytic]") {
  std::vector<Input> one(1);
  one[0].kind = InputKind::spawn;
  Bytes bytes;
  encode_inputs(one, bytes);
  CHECK(bytes.size() * limits::inputs_per_tick_max < limits::record_size_max);
}
