// Sets a key of a scene through its JSON form.
// SPDX-License-Identifier: MIT
#include "tool/session/scene_key.h"

#include <algorithm>
#include <charconv>
#include <optional>

#include "engine/json/number_text.h"
#include "engine/scene/scene_json.h"
#include "tool/output/json_output.h"

namespace ticktrue::tool {
namespace {

using cli::Json;

constexpr std::size_t value_count_max = 1000;

std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

std::optional<std::size_t> index_of(const std::string& part) {
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
  if (error != std::errc() || end != part.data() + part.size()) return {};
  return index;
}

/// The values between commas; a comma within brackets or quotes belongs to its value.
std::vector<std::string> values_of(const std::string& text) {
  std::vector<std::string> values(1);
  int depth = 0;
  bool is_quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' && (i == 0 || text[i - 1] != '\\')) is_quoted = !is_quoted;
    if (!is_quoted) depth += (c == '[' || c == '{') - (c == ']' || c == '}');
    if (c == ',' && !is_quoted && depth == 0)
      values.emplace_back();
    else
      values.back() += c;
  }
  return values;
}

/// The name of an element of a list; empty if it has none.
std::string name_of(const Json& element) {
  const auto name = element.is_object() ? element.find("name") : element.end();
  return name != element.end() && name->is_string() ? name->get<std::string>() : std::string();
}

/// The element of a list with this index or name.
std::optional<std::size_t> element_of(const Json& list, const std::string& part) {
  if (const auto index = index_of(part)) return *index < list.size() ? index : std::nullopt;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!part.empty() && name_of(list[i]) == part) return i;
  return {};
}

/// " or a name: top, floor", if elements have names.
std::string or_names_of(const Json& list) {
  std::string names;
  for (const Json& element : list)
    if (const std::string name = name_of(element); !name.empty() && names.size() < 200)
      names += (names.empty() ? "" : ", ") + name;
  return names.empty() ? names : " or a name: " + names;
}

/// Parses "0.1:0.9:9" into nine values; absent if the text is not such a range.
std::optional<std::vector<std::string>> range_of(const std::string& text) {
  const std::vector<std::string> parts = parts_of(text, ':');
  if (parts.size() != 3) return {};
  const auto first = engine::parse_number(parts[0]);
  const auto last = engine::parse_number(parts[1]);
  const auto count = index_of(parts[2]);
  if (!first || !last || !count || *count < 2 || *count > value_count_max) return {};
  std::vector<std::string> values;
  for (std::size_t i = 0; i < *count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(*count - 1);
    values.push_back(engine::number_text(i + 1 == *count ? *last : *first + (*last - *first) * share));
  }
  return values;
}

/// The key with an index for each name of a list element. A part that the scene does not have stays as it is.
std::string key_by_index(const Json& tree, const std::string& key) {
  std::string path;
  const Json* at = &tree;
  for (const std::string& part : parts_of(key, '.')) {
    if (at != nullptr && at->is_array()) {
      const std::size_t index = element_of(*at, part).value_or(at->size());
      if (index < at->size()) {
        path += std::to_string(index) + ".";
        at = &(*at)[index];
        continue;
      }
    }
    path += part + ".";
    at = at != nullptr && at->is_object() && at->contains(part) ? &(*at)[part] : nullptr;
  }
  return path;
}

}  // namespace

Status check_apart(const std::vector<VariedKey>& keys, const engine::Scene& scene, const std::string& place) {
  const Json tree = Json::parse(engine::print_scene(scene));
  std::vector<std::string> paths;
  for (const VariedKey& varied : keys) {
    const std::string path = key_by_index(tree, varied.key);
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const std::size_t shared = std::min(path.size(), paths[i].size());
      if (path.compare(0, shared, paths[i], 0, shared) == 0)
        return Error{
            ErrorCode::usage,
            place + ": found " + varied.key + ", which " + keys[i].key + " sets as well, expected one of the two", ""};
    }
    paths.push_back(path);
  }
  return {};
}

Result<engine::Scene> scene_with(const engine::Scene& scene, const std::string& key, const std::string& value,
                                 const std::string& place) {
  engine::Scene base = scene;
  // A number cannot stand beside what only automatic substeps have; "auto" and an object keep it.
  if (key == "settings.substeps" && engine::parse_number(value))
    engine::use_fixed_substeps(base.settings, base.settings.substeps);
  Json tree = Json::parse(engine::print_scene(base));
  Json* at = &tree;
  std::string path;
  for (const std::string& part : parts_of(key, '.')) {
    path += (path.empty() ? "" : ".") + part;
    if (at->is_array()) {
      const auto index = element_of(*at, part);
      if (!index)
        return Error{
            ErrorCode::usage,
            place + ": found " + path + ", expected an index below " + std::to_string(at->size()) + or_names_of(*at),
            ""};
      at = &(*at)[*index];
    } else if (at->is_object() || at->is_null()) {
      at = &(*at)[part];
    } else {
      return Error{ErrorCode::usage, place + ": found " + path + " below a value that has no keys", ""};
    }
  }
  const Json parsed = Json::parse(value, nullptr, false);
  *at = parsed.is_discarded() ? Json(value) : parsed;
  Result<engine::Scene> changed = engine::parse_scene(tree.dump(), place);
  if (changed) changed->name = scene.name;
  return changed;
}

Result<VariedKey> parse_varied(const std::string& text, const std::string& option) {
  const auto wrong = [&](const std::string& expected) {
    return Error{ErrorCode::usage, option + ": found " + text + ", expected " + expected,
                 "such as bodies.3.shapes.0.friction=0.1:0.9:9 (nine values) or settings.substeps=1,4,16"};
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) return wrong("KEY=VALUES");
  VariedKey varied;
  varied.key = text.substr(0, equals);
  const std::string values = text.substr(equals + 1);
  if (auto range = range_of(values))
    varied.values = *std::move(range);
  else if (values.find(':') != std::string::npos && values.find_first_of("[{\"") == std::string::npos)
    return wrong("FIRST:LAST:COUNT with 2 to 1000 values");
  else
    varied.values = values_of(values);
  if (varied.values.size() > value_count_max) return wrong("at most 1000 values");
  for (const std::string& value : varied.values)
    if (value.empty()) return wrong("a value between commas");
  return varied;
}

void label_keys(std::vector<VariedKey>& keys) {
  const auto ends_with = [](const std::string& key, const std::string& end) {
    return key == end || (key.size() > end.size() && key.compare(key.size() - end.size(), end.size(), end) == 0 &&
                          key[key.size() - end.size() - 1] == '.');
  };
  for (VariedKey& varied : keys) {
    const auto is_shared = [&](const std::string& end) {
      return std::any_of(keys.begin(), keys.end(),
                         [&](const VariedKey& other) { return &other != &varied && ends_with(other.key, end); });
    };
    const auto says_little = [&](const std::string& end) { return is_shared(end) || index_of(end).has_value(); };
    std::size_t begin = varied.key.rfind('.');
    while (begin != std::string::npos && says_little(varied.key.substr(begin + 1)))
      begin = begin == 0 ? std::string::npos : varied.key.rfind('.', begin - 1);
    varied.label = begin == std::string::npos ? varied.key : varied.key.substr(begin + 1);
  }
}

}  // namespace ticktrue::tool
