// Scenes and inputs as JSON, the form that people read and write. Schema: scenes/scene.schema.json.
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

/// `source` comes first in messages. Unknown keys, wrong types and non-finite numbers are refused with the JSON path,
/// the found value and the allowed values. Calls check_scene.
Result<Scene> parse_scene(std::string_view json, const std::string& source);

/// The scene as JSON that parse_scene reads back to an equal scene.
std::string print_scene(const Scene& scene);

/// One JSON object of an input file: {"tick":120,"player":0,"kind":"impulse","body":7,"ix":1.5,"iy":0,"px":0,"py":0}.
/// `player` may be absent (0), and so may values that are zero. The caller sets `sequence`. `place` is "file:line".
/// Calls check_input.
Result<Input> parse_input(const Scene& scene, std::string_view line, const std::string& place);

/// The line that parse_input reads back to the same input except for its sequence, without line break.
std::string print_input(const Scene& scene, const Input& input);

}  // namespace ticktrue::engine
