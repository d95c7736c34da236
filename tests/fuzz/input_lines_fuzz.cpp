// Fuzzes files of inputs as JSON Lines: checked as a whole, then returned tick by tick, and printed.
// SPDX-License-Identifier: MIT
#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/scene/scene_json.h"
#include "tests/fuzz/support/fuzz.h"
#include "tool/session/input_source.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  static const engine::Scene scene = *engine::make_builtin_scene("thesis");
  const fuzz::MemoryFile file({data, size});
  const auto summary = tool::check_inputs(scene, file.path(), {});
  if (!summary) fuzz::require_message(summary.error());
  auto source = tool::JsonLinesInputs::open(scene, file.path(), {});
  fuzz::require(source.has_value(), "a file opens");
  bool has_failed = false;
  for (std::uint64_t tick = 0; tick < 200; ++tick) {
    const auto input = (*source)->next(tick);
    if (!input) {
      fuzz::require_message(input.error());
      has_failed = true;
      break;
    }
    if (!input->has_value()) break;
    if ((*input)->inputs.empty()) continue;
    std::vector<engine::Input> inputs;
    fuzz::require(engine::decode_inputs(scene, (*input)->inputs, inputs).has_value(), "what is given out decodes");
    for (engine::Input& one : inputs) {
      one.tick = tick;
      const auto again = engine::parse_input(scene, engine::print_input(scene, one), "again");
      fuzz::require(again.has_value(), "a printed input is accepted");
      one.sequence = again->sequence;
      fuzz::require(*again == one, "a printed input reads back to the same input");
    }
  }
  fuzz::require(!has_failed || !summary, "a file that was checked gives no error later");
  return 0;
}
