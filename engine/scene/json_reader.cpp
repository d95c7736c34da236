// Typed reads of a JSON tree.
// SPDX-License-Identifier: MIT
#include "engine/scene/json_reader.h"

#include "engine/json/number_text.h"

namespace ticktrue::engine {

std::string listed(const std::vector<std::string_view>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + std::string(words[i]);
  return text;
}

bool JsonReader::fail(const JsonPath& path, const std::string& what, std::string hint) {
  const std::string where = path.text();
  error_ = Error{code_, place_ + ": " + (where.empty() ? "" : where + ": ") + what, std::move(hint)};
  return false;
}

bool JsonReader::wrong_type(const JsonPath& path, const JsonValue& value, const char* expected) {
  return fail(path, "wrong type: found " + found_text(value) + ", expected " + expected);
}

bool JsonReader::out_of_range(const JsonPath& path, double found, FieldRange range) {
  return fail(path, "must be a whole number in range: found " + number_text(found) + ", expected " +
                        number_text(range.min) + ".." + number_text(range.max));
}

bool JsonReader::object(const JsonValue& value, const JsonPath& path, const std::vector<Field>& fields) {
  if (value.type != JsonValue::Type::object) return wrong_type(path, value, "an object");
  for (std::size_t i = 0; i < value.keys.size(); ++i) {
    const Field* field = nullptr;
    for (const Field& candidate : fields)
      if (candidate.key == value.keys[i]) field = &candidate;
    if (field == nullptr) {
      std::vector<std::string_view> known;
      for (const Field& candidate : fields) known.push_back(candidate.key);
      return fail(path, "unknown key: found " + in_quotes(shortened(value.keys[i])) + ", expected " + listed(known),
                  suggestion(value.keys[i], known));
    }
    if (!field->read(value.items[i], JsonPath{&path, field->key})) return false;
  }
  for (const Field& field : fields)
    if (field.required && value.find(field.key) == nullptr)
      return fail(JsonPath{&path, field.key}, "missing: found no such key, expected one");
  return true;
}

bool JsonReader::read(const JsonValue& value, const JsonPath& path, double& out) {
  if (value.type != JsonValue::Type::number) return wrong_type(path, value, "a number");
  out = value.number;
  return true;
}

bool JsonReader::read(const JsonValue& value, const JsonPath& path, bool& out) {
  if (value.type != JsonValue::Type::boolean) return wrong_type(path, value, "true or false");
  out = value.flag;
  return true;
}

bool JsonReader::read(const JsonValue& value, const JsonPath& path, std::string& out) {
  if (value.type != JsonValue::Type::text) return wrong_type(path, value, "a string");
  out = value.text;
  return true;
}

bool JsonReader::pair(const JsonValue& value, const JsonPath& path, const char* form, double& first, double& second) {
  if (value.type != JsonValue::Type::array || value.items.size() != 2) return wrong_type(path, value, form);
  return read(value.items[0], JsonPath{&path, {}, 0}, first) && read(value.items[1], JsonPath{&path, {}, 1}, second);
}

}  // namespace ticktrue::engine
