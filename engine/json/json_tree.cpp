// JSON text as a tree of values.
// SPDX-License-Identifier: MIT
//
// nlohmann::json parses the syntax. Its events build a small tree, which keeps repeated keys (nlohmann's own tree drops
// them), stays within limits and can be read element by element.
#include "engine/json/json_tree.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "base/limits.h"
#include "engine/json/number_text.h"

namespace ticktrue::engine {
namespace {

constexpr std::size_t depth_max = 16;                // a vertex's coordinate is at depth 7
constexpr std::size_t key_count_max = 64;            // of one object; the largest has 19
constexpr std::size_t pending_value_max = 1u << 18;  // of one body: 1,024 shapes of 16 vertices are 54,000
constexpr std::size_t found_size_max = 60;           // bytes of a text quoted in a message

/// Receives the parser's events and builds the tree.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(std::string_view text, const std::string& place, ErrorCode code, const std::vector<StreamedList>& lists,
              const TakeElement& take)
      : text_(text), place_(place), code_(code), lists_(lists), take_(take) {}

  bool null() override { return add(JsonValue{}); }
  bool boolean(bool flag) override {
    JsonValue value;
    value.type = JsonValue::Type::boolean;
    value.flag = flag;
    return add(std::move(value));
  }
  bool number_integer(std::int64_t number) override { return add_number(static_cast<double>(number)); }
  bool number_unsigned(std::uint64_t number) override { return add_number(static_cast<double>(number)); }
  bool number_float(double number, const std::string&) override { return add_number(number); }
  bool string(std::string& text) override {
    JsonValue value;
    value.type = JsonValue::Type::text;
    value.text = std::move(text);
    return add(std::move(value));
  }
  bool binary(nlohmann::json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(JsonValue::Type::object); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(JsonValue::Type::array); }
  bool end_array() override { return close(); }

  bool key(std::string& key) override {
    Frame& frame = stack_.back();
    if (frame.value.find(key) != nullptr)
      return fail(code_, path(), "key given twice: found " + in_quotes(shortened(key)) + " again");
    if (frame.value.keys.size() == key_count_max)
      return fail(ErrorCode::limit, path(), "too many keys: expected at most " + std::to_string(key_count_max));
    frame.value.keys.push_back(std::move(key));
    return true;
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& exception) override {
    std::size_t line = 1, column = 0;
    for (std::size_t i = 0; i < position && i < text_.size(); ++i) {
      ++column;
      if (text_[i] != '\n') continue;
      ++line;
      column = 0;
    }
    // The reason is the last part of "[json.exception.parse_error.101] parse error at line 1, column 8: syntax error
    // while ...".
    std::string_view reason = exception.what();
    if (const std::size_t at = reason.find("] "); at != std::string_view::npos) reason.remove_prefix(at + 2);
    if (reason.substr(0, 11) == "parse error")
      if (const std::size_t at = reason.find(": "); at != std::string_view::npos) reason.remove_prefix(at + 2);
    std::string printable;
    for (const char c : reason.substr(0, 160)) printable += c >= 0x20 && c < 0x7f ? c : '?';
    const bool is_literal = printable.find("invalid literal") != std::string::npos;
    error_ =
        Error{code_, place_ + ":" + std::to_string(line) + ":" + std::to_string(column) + ": broken JSON: " + printable,
              is_literal ? "JSON has no NaN, no Infinity, no comments and no quotes but \"" : ""};
    return false;
  }

  JsonValue& root() { return root_; }
  const Error& error() const { return error_; }

 private:
  struct Frame {
    JsonValue value;
    std::size_t taken_count = 0;  // number of elements passed to take_
  };

  bool fail(ErrorCode code, const std::string& where, const std::string& what) {
    error_ = Error{code, place_ + ": " + (where.empty() ? "" : where + ": ") + what, ""};
    return false;
  }

  /// The path of the open value.
  std::string path() const {
    std::string text;
    for (std::size_t i = 0; i + 1 < stack_.size(); ++i) {
      const Frame& frame = stack_[i];
      if (frame.value.type == JsonValue::Type::object)
        text += (text.empty() ? "" : ".") + shortened(frame.value.keys.back());
      else
        text += "[" + std::to_string(frame.taken_count + frame.value.items.size()) + "]";
    }
    return text;
  }

  bool add_number(double number) {
    JsonValue value;
    value.type = JsonValue::Type::number;
    value.number = number;
    return add(std::move(value));
  }

  bool open(JsonValue::Type type) {
    if (stack_.size() == depth_max)
      return fail(ErrorCode::limit, path(),
                  "nested too deeply: expected at most " + std::to_string(depth_max) + " levels");
    stack_.emplace_back();
    stack_.back().value.type = type;
    return true;
  }

  bool close() {
    JsonValue value = std::move(stack_.back().value);
    stack_.pop_back();
    return add(std::move(value));
  }

  bool add(JsonValue value) {
    if (stack_.empty()) {
      root_ = std::move(value);
      return true;
    }
    Frame& frame = stack_.back();
    if (++pending_count_ > pending_value_max)
      return fail(ErrorCode::limit, path(), "too many values: expected at most " + std::to_string(pending_value_max));
    if (frame.value.type == JsonValue::Type::array) {
      const StreamedList* list = streamed_list();
      const std::size_t max = list != nullptr ? list->count_max : limits::body_count_max;
      if (frame.taken_count + frame.value.items.size() == max)
        return fail(ErrorCode::limit, path(),
                    "too many: found more than " + std::to_string(max) + ", expected at most " + std::to_string(max));
      if (list != nullptr) return take(*list, frame, value);
    }
    frame.value.items.push_back(std::move(value));
    return true;
  }

  bool take(const StreamedList& list, Frame& frame, const JsonValue& element) {
    pending_count_ = 0;
    const std::size_t index = frame.taken_count++;
    const Status status = take_(list.key, index, element);
    if (!status) error_ = status.error();
    return status.has_value();
  }

  /// The streamed list of the open array, or null.
  const StreamedList* streamed_list() const {
    if (stack_.size() != 2 || stack_[0].value.type != JsonValue::Type::object) return nullptr;
    for (const StreamedList& list : lists_)
      if (list.key == stack_[0].value.keys.back()) return &list;
    return nullptr;
  }

  std::string_view text_;
  const std::string& place_;
  ErrorCode code_;
  const std::vector<StreamedList>& lists_;
  const TakeElement& take_;
  std::vector<Frame> stack_;
  JsonValue root_;
  std::size_t pending_count_ = 0;
  Error error_{};
};

}  // namespace

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      constexpr std::string_view digits = "0123456789abcdef";
      out += "\\u00";
      out += digits[byte >> 4];
      out += digits[byte & 15];
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string shortened(std::string_view text) {
  if (text.size() <= found_size_max) return std::string(text);
  std::size_t size = found_size_max;
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xc0) == 0x80) --size;
  return std::string(text.substr(0, size)) + "...";
}

std::string found_text(const JsonValue& value) {
  switch (value.type) {
    case JsonValue::Type::null:
      return "null";
    case JsonValue::Type::boolean:
      return value.flag ? "true" : "false";
    case JsonValue::Type::number:
      return number_text(value.number);
    case JsonValue::Type::text:
      return in_quotes(shortened(value.text));
    case JsonValue::Type::array:
      return "an array of " + std::to_string(value.items.size());
    case JsonValue::Type::object:
      return "an object";
  }
  return {};
}

Result<JsonValue> parse_json(std::string_view text, const std::string& place, ErrorCode code,
                             const std::vector<StreamedList>& lists, const TakeElement& take) {
  // The parser would take a NUL for the end of the text.
  if (text.find('\0') != std::string_view::npos)
    return Error{code, place + ": broken JSON: found a NUL byte, expected text", ""};
  TreeBuilder builder(text, place, code, lists, take);
  if (!nlohmann::json::sax_parse(text.begin(), text.end(), &builder)) return builder.error();
  return std::move(builder.root());
}

}  // namespace ticktrue::engine
