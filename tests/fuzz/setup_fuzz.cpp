// Fuzzes the setup of the engine as it stands in traces: what is accepted encodes to the same bytes, and runs.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "engine/scene/scene_binary.h"
#include "tests/fuzz/support/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  const ByteView bytes(data, size);
  const auto scene = engine::decode_scene(bytes);
  if (!scene) {
    fuzz::require_message(scene.error());
    return 0;
  }
  const Bytes again = engine::encode_scene(*scene);
  fuzz::require(std::equal(bytes.begin(), bytes.end(), again.begin(), again.end()), "a scene has one encoding");
  if (!fuzz::is_small(*scene)) return 0;
  const auto engine = engine::make_engine(*scene);
  if (engine) fuzz::run_a_little(**engine, scene->settings.dt, 2);
  return 0;
}
