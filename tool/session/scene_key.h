// One key of a scene's JSON form: setting it, and lists of values for it.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// The scene with another value at a key such as `settings.substeps` or `bodies.3.shapes.0.friction`. A list takes
/// an index or the name of its element: `bodies.top.mass`. A missing key is added. `value` is JSON; a value that is not
/// JSON is a text. Messages begin with `place`. Errors: usage (no such list element); those of parse_scene.
Result<engine::Scene> scene_with(const engine::Scene& scene, const std::string& key, const std::string& value,
                                 const std::string& place);

/// A key, and the values to try in turn.
struct VariedKey {
  std::string key;
  std::vector<std::string> values;
  std::string label = {};  // in names of variants; empty: the last part of the key
};
/// Parses "bodies.3.shapes.0.friction=0.1:0.9:9" (nine values from 0.1 to 0.9), "settings.substeps=1,4,16" (three
/// values) or "gravity=[0,-10],[0,-2]" (two vectors). Messages begin with `option`. Errors: usage.
Result<VariedKey> parse_varied(const std::string& text, const std::string& option);
/// Refuses a key that sets what an earlier one sets as well, or a part of it: `bodies.1.mass` beside `bodies.top.mass`.
/// Messages begin with `place`. Errors: usage.
Status check_apart(const std::vector<VariedKey>& keys, const engine::Scene& scene, const std::string& place);
/// Labels each key by its shortest end, in whole parts, that no other key ends with and that does not begin with an
/// index.
void label_keys(std::vector<VariedKey>& keys);

}  // namespace ticktrue::tool
