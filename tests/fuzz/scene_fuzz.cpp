// Fuzzes scenes as JSON: what is accepted prints to text that reads back to the same scene, and runs.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_json.h"
#include "tests/fuzz/support/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  const auto scene = engine::parse_scene(fuzz::text_of({data, size}), "scene.json");
  if (!scene) {
    fuzz::require_message(scene.error());
    return 0;
  }
  const auto again = engine::parse_scene(engine::print_scene(*scene), "again.json");
  fuzz::require(again.has_value(), "a printed scene is accepted");
  fuzz::require(*again == *scene, "a printed scene reads back to the same scene");
  if (!fuzz::is_small(*scene)) return 0;
  const auto engine = engine::make_engine(*scene);
  if (engine) fuzz::run_a_little(**engine, scene->settings.dt, 2);
  return 0;
}
