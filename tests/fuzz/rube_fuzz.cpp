// Fuzzes the import of R.U.B.E. scenes: what is imported and keeps the rules of a scene runs.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/support/fuzz.h"
#include "tool/import/import_rube.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  const auto import = tool::import_rube(fuzz::text_of({data, size}), "drawn.json", "drawn");
  if (!import) {
    fuzz::require_message(import.error());
    return 0;
  }
  fuzz::require(import->notes.size() <= tool::rube_note_count_max, "notes are bounded");
  const Status valid = engine::check_scene(import->scene, "drawn.json");
  if (!valid) {
    fuzz::require_message(valid.error());
    return 0;
  }
  if (!fuzz::is_small(import->scene)) return 0;
  const auto engine = engine::make_engine(import->scene);
  if (engine) fuzz::run_a_little(**engine, import->scene.settings.dt, 2);
  return 0;
}
