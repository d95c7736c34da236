// One key of a scene's JSON form: setting it, and lists of values for it.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::verifier {

/// The scene with another value at a key, such as `settings.substeps` or `bodies.3.shapes.0.friction`; numbers are
/// indices of lists. A key that is not there yet is added. `value` is JSON; what is no JSON is a text. `place` comes
/// first in messages. Errors: usage (there is no such list element); those of parse_scene.
Result<engine::Scene> scene_with(const engine::Scene& scene, const std::string& key, const std::string& value,
                                 const std::string& place);

/// A key and the values that it takes in turn.
struct VariedKey {
  std::string key;
  std::vector<std::string> values;
};
/// "bodies.3.shapes.0.friction=0.1:0.9:9": nine values from 0.1 to 0.9; "settings.substeps=1,4,16": these three.
/// `option` comes first in messages. Errors: usage.
Result<VariedKey> parse_varied(const std::string& text, const std::string& option);

}  // namespace ticktrue::verifier
