// Fuzzes the import of mouse sessions: what is imported is accepted by the scene it was imported for, in order.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/builtin_scenes.h"
#include "tests/fuzz/support/fuzz.h"
#include "tool/import/import_mouse.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  static const engine::Scene scene = *engine::make_builtin_scene("thesis");
  tool::MouseImportOptions options;
  options.right_presses = size % 2 == 1;
  const auto inputs = tool::import_mouse(fuzz::text_of({data, size}), "s.csv", scene, options);
  if (!inputs) {
    fuzz::require_message(inputs.error());
    return 0;
  }
  std::uint64_t tick = 0;
  for (const engine::Input& input : *inputs) {
    fuzz::require(input.tick >= tick, "inputs come in the order of ticks");
    tick = input.tick;
    if (input.kind == engine::InputKind::end) continue;
    fuzz::require(engine::check_input(scene, input, "s.csv").has_value(), "imported inputs are accepted");
  }
  return 0;
}
