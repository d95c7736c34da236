// Values, notes and ignored keys of a R.U.B.E. file.
// SPDX-License-Identifier: MIT
#include "tool/import/rube_reader.h"

#include <cmath>

#include "base/bytes.h"
#include "engine/json/number_text.h"
#include "tool/import/import_rube.h"

namespace ticktrue::tool {
namespace {

constexpr std::size_t quoted_size_max = 40;  // bytes of a text quoted in a message

std::string rube_quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, quoted_size_max)) out += c >= 0x20 && c < 0x7f && c != '"' ? c : '?';
  return out + (text.size() > quoted_size_max ? "...\"" : "\"");
}

std::string found_rube_text(const nlohmann::json& value) {
  if (value.is_number()) return engine::number_text(value.get<double>());
  if (value.is_string()) return rube_quoted(value.get_ref<const std::string&>());
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  return value.is_null() ? "null" : "an object";
}

}  // namespace

void RubeReader::refuse(const RubePlace& at, const std::string& expected) {
  if (!error_)
    error_ = Error{ErrorCode::invalid_scene,
                   source_ + ": " + (at.path.empty() ? "" : at.path + ": ") + "found " + found_rube_text(*at.value) +
                       ", expected " + expected,
                   ""};
}

void RubeReader::fail(ErrorCode code, const RubePlace& at, const std::string& what) {
  if (!error_) error_ = Error{code, source_ + ": " + at.path + ": " + what, ""};
}

void RubeReader::note(std::string text) {
  if (++note_count_ <= rube_note_count_max) notes_.push_back(std::move(text));
}

std::vector<std::string> RubeReader::take_notes() {
  if (note_count_ > rube_note_count_max)
    notes_.back() = "and " + std::to_string(note_count_ - rube_note_count_max + 1) + " more of this kind";
  return std::move(notes_);
}

double RubeReader::to_number(const RubePlace& at) {
  if (at.value->is_number()) {
    const double number = at.value->get<double>();
    if (std::isfinite(number)) return number;
  }
  if (at.value->is_string()) {
    const std::string& text = at.value->get_ref<const std::string&>();
    std::uint32_t bits = 0;
    bool is_hex = text.size() == 8;
    for (const char c : text) {
      const std::size_t digit = std::string_view("0123456789abcdef").find(static_cast<char>(c | 0x20));
      is_hex = is_hex && digit != std::string_view::npos && (c >= '0');
      bits = bits << 4 | static_cast<std::uint32_t>(digit & 15);
    }
    const double number = static_cast<double>(float_of_bits(bits));
    if (is_hex && std::isfinite(number)) return number;
  }
  refuse(at, "a finite number, or 8 hexadecimal digits of a 32-bit float");
  return 0;
}

double RubeReader::number(const RubePlace& object, const char* key, double missing) {
  use(object, key);
  return object.has(key) ? to_number(object.at(key)) : missing;
}

bool RubeReader::flag(const RubePlace& object, const char* key, bool missing) {
  use(object, key);
  if (!object.has(key)) return missing;
  const RubePlace at = object.at(key);
  if (!at.value->is_boolean()) refuse(at, "true or false");
  return at.value->is_boolean() && at.value->get<bool>();
}

std::int64_t RubeReader::whole(const RubePlace& object, const char* key, std::int64_t min, std::int64_t max,
                               std::int64_t missing) {
  use(object, key);
  if (!object.has(key)) return missing;
  const RubePlace at = object.at(key);
  const double value = at.value->is_number() ? at.value->get<double>() : 0.5;
  if (!(value >= static_cast<double>(min) && value <= static_cast<double>(max)) || value != std::floor(value)) {
    refuse(at, "a whole number, " + std::to_string(min) + ".." + std::to_string(max));
    return missing;
  }
  return static_cast<std::int64_t>(value);
}

engine::Point RubeReader::to_point(const RubePlace& at) {
  if (at.value->is_number() && at.value->get<double>() == 0) return {};
  if (!at.value->is_object() || !at.has("x") || !at.has("y")) {
    refuse(at, "{\"x\": ..., \"y\": ...}, or 0");
    return {};
  }
  const double x = to_number(at.at("x"));
  const double y = to_number(at.at("y"));
  return {x, y};
}

engine::Point RubeReader::point(const RubePlace& object, const char* key) {
  use(object, key);
  return object.has(key) ? to_point(object.at(key)) : engine::Point{};
}

std::string RubeReader::text(const RubePlace& object, const char* key) {
  use(object, key);
  if (!object.has(key)) return {};
  const RubePlace at = object.at(key);
  if (!at.value->is_string()) refuse(at, "a text");
  return at.value->is_string() ? at.value->get<std::string>() : std::string();
}

std::size_t RubeReader::list_size(const RubePlace& object, const char* key, std::size_t count_max) {
  use(object, key);
  if (!object.has(key)) return 0;
  const RubePlace at = object.at(key);
  if (!at.value->is_array()) {
    refuse(at, "an array");
    return 0;
  }
  if (at.value->size() > count_max) {
    fail(ErrorCode::limit, at,
         "too many: found " + std::to_string(at.value->size()) + ", expected at most " + std::to_string(count_max));
    return 0;
  }
  return at.value->size();
}

std::vector<engine::Point> RubeReader::points(const RubePlace& shape, std::size_t count_max) {
  std::vector<engine::Point> out;
  if (!shape.value->is_object() || !shape.has("vertices")) {
    refuse(shape, "an object with \"vertices\"");
    return out;
  }
  const RubePlace vertices = shape.at("vertices");
  if (!vertices.value->is_object() || !vertices.has("x") || !vertices.has("y")) {
    refuse(vertices, "{\"x\": [...], \"y\": [...]}");
    return out;
  }
  const std::size_t count = list_size(vertices, "x", count_max);
  const std::size_t y_count = list_size(vertices, "y", count_max);
  if (error_) return out;
  if (count != y_count) {
    refuse(vertices.at("y"), "as many as x: " + std::to_string(count));
    return out;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double x = to_number(vertices.at("x").at(i));
    const double y = to_number(vertices.at("y").at(i));
    out.push_back({x, y});
  }
  return out;
}

std::string RubeReader::name_of(const RubePlace& at) {
  if (!at.value->is_object()) {
    refuse(at, "an object");
    return {};
  }
  return text(at, "name");
}

std::string RubeReader::label(const RubePlace& at) {
  const bool named = at.value->is_object() && at.has("name") && at.value->at("name").is_string();
  return at.path + (named ? " " + rube_quoted(at.value->at("name").get_ref<const std::string&>()) : "");
}

void RubeReader::count_ignored(const RubePlace& object, const std::string& kind) {
  for (const auto& [key, value] : object.value->items())
    if (used_.count({object.value, key}) == 0) ++ignored_[kind + " key " + rube_quoted(key)];
  used_.clear();
}

void RubeReader::note_ignored_keys() {
  for (const auto& [what, count] : ignored_)
    note("not imported: " + what + (count > 1 ? " (" + std::to_string(count) + " times)" : ""));
}

engine::Point rotated_point(double angle, const engine::Point& p) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.y, s * p.x + c * p.y};
}

}  // namespace ticktrue::tool
