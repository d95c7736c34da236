// Scenes and inputs as JSON: the form people read and write. Schema: scenes/scene.schema.json.
// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/input.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// `source` is what messages name first. Unknown keys, wrong types and non-finite numbers are refused with the JSON
/// path, what was found and what is allowed. Calls check_scene.
Result<Scene> parse_scene(std::string_view json, const std::string& source);

/// The scene as JSON that parse_scene reads back to an equal scene.
std::string print_scene(const Scene& scene);

/// One JSON object of an input file: {"tick":120,"player":0,"kind":"impulse","body":7,"ix":1.5,"iy":0,"px":0,"py":0}.
/// `player` may be absent (0), so may values that are zero. `sequence` is the caller's to count.
/// `place` is "file:line". Calls check_input.
Result<Input> parse_input(const Scene& scene, std::string_view line, const std::string& place);

/// The line that parse_input reads back to the same input (its sequence apart), without line break.
std::string print_input(const Scene& scene, const Input& input);

}  // namespace ticktrue::engine
