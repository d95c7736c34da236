// Reads the scene of a user's problem or stress file.
// SPDX-License-Identifier: MIT
#include "tool/study/problem_file/problem_scene.h"

#include <filesystem>

#include "engine/json/number_text.h"
#include "engine/scene/scene_json.h"
#include "tool/output/json_output.h"

namespace ticktrue::tool {

using engine::JsonPath;
using engine::JsonValue;

namespace {

constexpr std::size_t list_count_max = 64;

}  // namespace

Error OwnFileReader::error_at(std::string_view key, const std::string& what, std::string hint) {
  const JsonPath path;
  fail({&path, key}, what, std::move(hint));
  return error();
}

bool OwnFileReader::positive(const JsonValue& value, const JsonPath& path, double& out) {
  if (!read(value, path, out)) return false;
  return out > 0 || fail(path, "found " + engine::number_text(out) + ", expected a number above 0");
}

bool OwnFileReader::read_duration(const engine::JsonValue& value, const engine::JsonPath& path, double& out) {
  constexpr double duration_max = 1e6;
  if (!positive(value, path, out)) return false;
  return out <= duration_max || fail(path, "found " + engine::number_text(out) + " s, expected at most " +
                                               engine::number_text(duration_max) + " s");
}

bool OwnFileReader::is_own_kind(const JsonValue& root, const std::string& own_command, std::string_view other_key,
                                const std::string& other_command) {
  const JsonPath path;
  if (root.type != JsonValue::Type::object) return true;
  if (root.find("bodies") != nullptr && root.find("scene") == nullptr)
    return fail(path, "found a scene, expected a file that names one",
                own_command + " --example prints one: the scene stands under \"scene\"");
  if (root.find(other_key) != nullptr)
    return fail({&path, other_key}, "found a key of " + other_command + ", expected none", other_command + " FILE");
  return true;
}

bool OwnFileReader::read_texts(const JsonValue& value, const JsonPath& path, std::vector<std::string>& out) {
  if (value.type == JsonValue::Type::text) return read(value, path, out.emplace_back());
  if (value.type == JsonValue::Type::array && value.items.size() > list_count_max)
    return fail(path,
                "found " + std::to_string(value.items.size()) + ", expected at most " + std::to_string(list_count_max));
  return list(value, path, out, [&](const auto& v, const auto& p, std::string& text) { return read(v, p, text); });
}

Result<engine::Scene> scene_of_problem(const engine::JsonValue& value, const std::string& json,
                                       const std::string& path) {
  using Type = engine::JsonValue::Type;
  if (value.type == Type::object)
    return engine::parse_scene(cli::Json::parse(json).at("scene").dump(), path + ": scene");
  if (value.type != Type::text)
    return Error{ErrorCode::usage,
                 path + ": scene: found " + engine::found_text(value) +
                     ", expected a scene, a file beside this one, or the name of a built-in scene",
                 ""};
  const std::filesystem::path beside = std::filesystem::path(path).parent_path() / value.text;
  std::error_code failed;
  const bool is_file = std::filesystem::is_regular_file(beside, failed);
  return cli::load_scene_argument(is_file ? beside.string() : value.text);
}

}  // namespace ticktrue::tool
