// Fuzzes the binary inputs of a tick: what is accepted encodes to the same bytes, and the engine steps with it.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/input.h"
#include "tests/fuzz/support/fuzz.h"
#include "tests/fuzz/support/worlds.h"

namespace {

using namespace ticktrue;

/// An engine and its state after a few ticks, which each input begins with.
struct World {
  std::unique_ptr<engine::Engine> engine;
  Bytes start;
};

World& world_of(std::size_t index) {
  static std::array<World, fuzz::worlds.size()> made;
  World& world = made[index];
  if (!world.engine) {
    auto scene = engine::make_builtin_scene(fuzz::worlds[index]);
    if (!scene) fuzz::require(false, scene.error().message.c_str());
    // Every kind but those of the pointer and of prototypes, which the scene must have on its own.
    for (const engine::InputInfo& info : engine::input_kinds) {
      const bool is_pointer = info.kind == engine::InputKind::press || info.kind == engine::InputKind::drag ||
                              info.kind == engine::InputKind::release;
      if (is_pointer || info.has_prototype || info.kind == engine::InputKind::end) continue;
      const auto has_motor = [](const engine::Joint& joint) { return joint.motor.has_value(); };
      if (info.has_joint && std::none_of(scene->joints.begin(), scene->joints.end(), has_motor)) continue;
      scene->inputs.push_back(info.kind);
    }
    std::sort(scene->inputs.begin(), scene->inputs.end());
    scene->inputs.erase(std::unique(scene->inputs.begin(), scene->inputs.end()), scene->inputs.end());
    auto engine = engine::make_engine(*scene);
    if (!engine) fuzz::require(false, engine.error().message.c_str());
    world.engine = std::move(*engine);
    for (int tick = 0; tick < 5; ++tick)
      fuzz::require(world.engine->step({scene->settings.dt, {}}, nullptr).has_value(), "a small world does its ticks");
    encode_image(world.engine->state(), world.start);
  }
  return world;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  World& world = world_of(data[0] % fuzz::worlds.size());
  engine::Engine& engine = *world.engine;
  const ByteView bytes(data + 1, size - 1);
  std::vector<engine::Input> inputs;
  const Status decoded = engine::decode_inputs(engine.scene(), bytes, inputs);
  if (!decoded) fuzz::require_message(decoded.error());
  if (decoded) {
    Bytes again;
    engine::encode_inputs(inputs, again);
    fuzz::require(std::equal(bytes.begin(), bytes.end(), again.begin(), again.end()), "inputs have one encoding");
  }
  const TickInput input{engine.scene().settings.dt, bytes};
  const Status accepted = engine.accept(input);
  fuzz::require(decoded || !accepted, "inputs that cannot be decoded are not accepted");
  if (!accepted) {
    fuzz::require_message(accepted.error());
    return 0;
  }
  fuzz::require(engine.load(world.start).has_value(), "the start loads");
  if (!engine.accept(input)) return 0;
  engine.inputs_text(5, bytes);
  const Status did = engine.step(input, nullptr);
  if (!did) fuzz::require_message(did.error());
  if (did && !find_non_finite(engine.state())) fuzz::run_a_little(engine, input.dt, 2);
  return 0;
}
