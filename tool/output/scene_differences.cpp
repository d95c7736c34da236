// Compares the JSON forms of two scenes key by key.
// SPDX-License-Identifier: MIT
#include "tool/output/scene_differences.h"

#include <algorithm>
#include <string>

#include "base/count_text.h"
#include "engine/engine.h"
#include "engine/scene/scene_binary.h"
#include "engine/scene/scene_json.h"
#include "tool/output/json_output.h"

namespace ticktrue::tool {
namespace {

using cli::Json;

constexpr std::size_t shown_max = 8;
constexpr std::size_t value_size_max = 60;

class SceneDiffer {
 public:
  verifier::SetupKeys run(const Json& a, const Json& b) {
    compare("", a, b);
    return std::move(found_);
  }

 private:
  void compare(const std::string& path, const Json& a, const Json& b) {
    if (a.is_object() && b.is_object()) return compare_objects(path, a, b);
    if (a.is_array() && b.is_array()) return compare_lists(path, a, b);
    if (a != b) add(path, text_of(a), text_of(b));
  }

  void compare_objects(const std::string& path, const Json& a, const Json& b) {
    const Json* const sides[] = {&a, &b};
    for (const Json* side : sides)
      for (const auto& [key, value] : side->items()) {
        if (side == &b && a.contains(key)) continue;
        if (path.empty() && key == "name") continue;  // the title of the trace
        const std::string below = path.empty() ? key : path + "." + key;
        if (a.contains(key) && b.contains(key))
          compare(below, a[key], b[key]);
        else
          add(below, a.contains(key) ? text_of(value) : "default", b.contains(key) ? text_of(value) : "default");
      }
  }

  void compare_lists(const std::string& path, const Json& a, const Json& b) {
    if (a.size() != b.size()) add(path, count_text(a.size(), "element"), count_text(b.size(), "element"));
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) compare(path + "." + std::to_string(i), a[i], b[i]);
  }

  void add(const std::string& path, std::string a, std::string b) {
    if (++found_.count <= shown_max) found_.first.push_back({path, std::move(a), std::move(b)});
  }

  static std::string text_of(const Json& value) {
    std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text.size() > value_size_max) text = text.substr(0, value_size_max) + "...";
    return text;
  }

  verifier::SetupKeys found_;
};

}  // namespace

verifier::SetupKeys scene_differences(const replay::TraceSetup& a, const replay::TraceSetup& b) {
  if (a.simulation != engine::simulation_name || b.simulation != engine::simulation_name) return {};
  const Result<engine::Scene> scene_a = engine::decode_scene(a.setup);
  const Result<engine::Scene> scene_b = engine::decode_scene(b.setup);
  if (!scene_a || !scene_b) return {};
  const Json tree_a = Json::parse(engine::print_scene(*scene_a), nullptr, false);
  const Json tree_b = Json::parse(engine::print_scene(*scene_b), nullptr, false);
  if (tree_a.is_discarded() || tree_b.is_discarded()) return {};
  return SceneDiffer().run(tree_a, tree_b);
}

}  // namespace ticktrue::tool
