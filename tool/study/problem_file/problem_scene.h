// Reads the JSON parts and the scene that users' problems and stress cases share.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/json/json_tree.h"
#include "engine/scene/json_reader.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

inline constexpr std::size_t problem_file_size_max = std::size_t{64} << 20;

class OwnFileReader : public engine::JsonReader {
 public:
  explicit OwnFileReader(std::string place) : JsonReader(std::move(place), ErrorCode::usage) {}

  /// An error at a key of the file.
  Error error_at(std::string_view key, const std::string& what, std::string hint = {});

 protected:
  bool positive(const engine::JsonValue& value, const engine::JsonPath& path, double& out);
  bool read_duration(const engine::JsonValue& value, const engine::JsonPath& path, double& out);  // s
  /// Refuses a scene, and a file with this key, which another command reads.
  bool is_own_kind(const engine::JsonValue& root, const std::string& own_command, std::string_view other_key,
                   const std::string& other_command);
  /// Reads one text, or several.
  bool read_texts(const engine::JsonValue& value, const engine::JsonPath& path, std::vector<std::string>& out);
};

/// Reads the scene from `value`, which is under "scene" in `json`, the text of the file. The value is a scene, a path
/// relative to this file, or the name of a built-in scene. Errors: usage; those of parse_scene and of loading a scene.
Result<engine::Scene> scene_of_problem(const engine::JsonValue& value, const std::string& json,
                                       const std::string& path);

}  // namespace ticktrue::tool
