// Typed reads of a JSON tree: each refusal names the path, the value found and the values allowed.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/json/json_tree.h"
#include "engine/json/nearest_name.h"
#include "engine/scene/choices.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// The path of a value, on the stack. It is printed only for an error.
struct JsonPath {
  const JsonPath* parent = nullptr;
  std::string_view key;   // of an object
  std::size_t index = 0;  // of an array, if key is empty

  std::string text() const {
    std::string prefix = parent != nullptr ? parent->text() : "";
    if (key.empty()) return parent == nullptr ? "" : prefix + "[" + std::to_string(index) + "]";
    return prefix.empty() ? std::string(key) : prefix + "." + std::string(key);
  }
};

/// "a, b or c".
std::string listed(const std::vector<std::string_view>& words);

/// Stores the first error. Every read returns whether it succeeded.
class JsonReader {
 public:
  JsonReader(std::string place, ErrorCode code) : place_(std::move(place)), code_(code) {}
  const Error& error() const { return error_; }

 protected:
  bool fail(const JsonPath& path, const std::string& what, std::string hint = {});
  bool wrong_type(const JsonPath& path, const JsonValue& value, const char* expected);

  struct Field {
    std::string_view key;
    std::function<bool(const JsonValue&, const JsonPath&)> read;
    bool required = false;
  };
  /// Reads every member of an object by the field of its key; refuses keys without one.
  bool object(const JsonValue& value, const JsonPath& path, const std::vector<Field>& fields);

  bool read(const JsonValue& value, const JsonPath& path, double& out);
  bool read(const JsonValue& value, const JsonPath& path, bool& out);
  bool read(const JsonValue& value, const JsonPath& path, std::string& out);
  bool read(const JsonValue& value, const JsonPath& path, Point& out) {
    return pair(value, path, "[x, y]", out.x, out.y);
  }
  /// Requires: -2^53 <= min, max <= 2^53.
  template <typename Whole>
  bool whole(const JsonValue& value, const JsonPath& path, FieldRange range, Whole& out) {
    if (value.type != JsonValue::Type::number) return wrong_type(path, value, "a whole number");
    if (!(value.number >= range.min && value.number <= range.max) ||
        static_cast<double>(static_cast<std::int64_t>(value.number)) != value.number)
      return out_of_range(path, value.number, range);
    out = static_cast<Whole>(static_cast<std::int64_t>(value.number));
    return true;
  }
  /// [x, y] for any pair of doubles.
  bool pair(const JsonValue& value, const JsonPath& path, const char* form, double& first, double& second);
  template <typename Table, typename Kind>
  bool choice(const JsonValue& value, const JsonPath& path, const Table& table, Kind& out) {
    if (value.type == JsonValue::Type::text) {
      if (const auto* row = find_choice(table, value.text)) {
        out = row->kind;
        return true;
      }
    }
    std::vector<std::string_view> known;
    for (const auto& row : table) known.push_back(row.name);
    return fail(path, "unknown: found " + found_text(value) + ", expected " + listed(known),
                value.type == JsonValue::Type::text ? suggestion(value.text, known) : "");
  }
  /// Reads the kind that an object's `key` names. The kind determines the other keys of the object.
  template <typename Table, typename Kind>
  bool kind_of(const JsonValue& value, const JsonPath& path, std::string_view key, const Table& table, Kind& out) {
    if (value.type != JsonValue::Type::object) return wrong_type(path, value, "an object");
    const JsonValue* kind = value.find(key);
    if (kind == nullptr)
      return fail(JsonPath{&path, key}, "missing: found no such key, expected " + choice_names(table));
    return choice(*kind, JsonPath{&path, key}, table, out);
  }
  template <typename Element, typename Read>
  bool list(const JsonValue& value, const JsonPath& path, std::vector<Element>& out, Read read) {
    if (value.type != JsonValue::Type::array) return wrong_type(path, value, "an array");
    out.resize(value.items.size());
    for (std::size_t i = 0; i < value.items.size(); ++i)
      if (!read(value.items[i], JsonPath{&path, {}, i}, out[i])) return false;
    return true;
  }

  /// A field that is read directly into a number.
  Field number(std::string_view key, double& out) {
    return {key, [this, &out](const JsonValue& v, const JsonPath& p) { return read(v, p, out); }};
  }
  template <typename Whole>
  Field whole(std::string_view key, FieldRange range, Whole& out, bool required = false) {
    return {key, [this, range, &out](const JsonValue& v, const JsonPath& p) { return whole(v, p, range, out); },
            required};
  }
  template <typename Table, typename Kind>
  Field choice(std::string_view key, const Table& table, Kind& out) {
    return {key, [this, &table, &out](const JsonValue& v, const JsonPath& p) { return choice(v, p, table, out); }};
  }

 private:
  bool out_of_range(const JsonPath& path, double found, FieldRange range);

  std::string place_;
  ErrorCode code_;
  Error error_{};
};

}  // namespace ticktrue::engine
