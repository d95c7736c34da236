// Fuzzes the loading of state images into the engine: what is accepted is the state afterwards, and runs on.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <memory>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/fuzz/support/fuzz.h"
#include "tests/fuzz/support/worlds.h"

namespace {

using namespace ticktrue;

engine::Engine& engine_of(std::size_t world) {
  static std::array<std::unique_ptr<engine::Engine>, fuzz::worlds.size()> engines;
  if (!engines[world]) {
    const auto scene = engine::make_builtin_scene(fuzz::worlds[world]);
    if (!scene) fuzz::require(false, scene.error().message.c_str());
    auto engine = engine::make_engine(*scene);
    if (!engine) fuzz::require(false, engine.error().message.c_str());
    engines[world] = std::move(*engine);
  }
  return *engines[world];
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  engine::Engine& engine = engine_of(data[0] % fuzz::worlds.size());
  const ByteView image(data + 1, size - 1);
  Bytes before;
  encode_image(engine.state(), before);
  const Status loaded = engine.load(image);
  Bytes after;
  encode_image(engine.state(), after);
  if (!loaded) {
    fuzz::require_message(loaded.error());
    fuzz::require(before == after, "a refused image changes nothing");
    return 0;
  }
  fuzz::require(std::equal(image.begin(), image.end(), after.begin(), after.end()), "an accepted image is the state");
  fuzz::run_a_little(engine, engine.scene().settings.dt, 2);
  return 0;
}
