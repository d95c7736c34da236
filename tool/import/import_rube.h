// Imports scenes drawn in the R.U.B.E. Box2D editor.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

struct RubeImport {
  engine::Scene scene;
  std::vector<std::string> notes;  // one line for each omission or change, with its name; at most rube_note_count_max
};
inline constexpr std::size_t rube_note_count_max = 100;  // beyond it, the last note counts the omitted notes
inline constexpr std::size_t rube_file_size_max = 64u << 20;

/// The scene of a "raw info" JSON export. docs/scenes.md, "Scenes of R.U.B.E.", has the rules. Messages begin with
/// `source`. The scene gets the name `name`. The result may break rules of a scene that the format does not have: call
/// check_scene. Errors: invalid_scene (with the JSON path, found, expected), limit, unsupported.
Result<RubeImport> import_rube(std::string_view json, const std::string& source, const std::string& name);

}  // namespace ticktrue::tool
