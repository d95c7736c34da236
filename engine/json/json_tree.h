// JSON text as a tree of values: within limits, with repeated keys refused and a place for every error.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"

namespace ticktrue::engine {

struct JsonValue {
  enum class Type : std::uint8_t { null, boolean, number, text, array, object };
  Type type = Type::null;
  bool flag = false;
  double number = 0;
  std::string text;
  std::vector<std::string> keys;  // object: of the items, in order
  std::vector<JsonValue> items;

  const JsonValue* find(std::string_view key) const {
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (keys[i] == key) return &items[i];
    return nullptr;
  }
};

/// The text as a JSON string; control characters as \u00xx.
std::string in_quotes(std::string_view text);

/// At most 60 bytes of the text, not cut inside a character, for messages.
std::string shortened(std::string_view text);

/// The description of a found value in a message.
std::string found_text(const JsonValue& value);

/// An array of the top object whose elements are taken one at a time, so that memory does not grow with the text.
struct StreamedList {
  std::string_view key;
  std::size_t count_max = 0;
};
using TakeElement = std::function<Status(std::string_view list, std::size_t index, const JsonValue& element)>;

/// `place` comes first in messages. The arrays of `lists` are empty in the tree: their elements went to `take`, whose
/// first error ends the parsing.
/// Errors: `code` (syntax, a key given twice), limit (nesting, keys of an object, values of an element, elements).
Result<JsonValue> parse_json(std::string_view text, const std::string& place, ErrorCode code,
                             const std::vector<StreamedList>& lists = {}, const TakeElement& take = {});

}  // namespace ticktrue::engine
