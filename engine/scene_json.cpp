// Scenes and inputs as JSON: reading with a place for every error, and printing.
// SPDX-License-Identifier: MIT
//
// nlohmann::json does the syntax. Its events build a small tree that keeps what its own drops (repeated keys), stays
// within limits, and is taken apart body by body, so that memory does not grow with the text.
#include "engine/scene_json.h"

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/limits.h"
#include "engine/number_text.h"

namespace ticktrue::engine {
namespace {

// ---- The tree ----

constexpr std::size_t depth_max = 16;                // a vertex's coordinate is at depth 7
constexpr std::size_t key_count_max = 64;            // of one object; the largest has 18
constexpr std::size_t pending_value_max = 1u << 18;  // of one body: 1,024 shapes of 16 vertices are 54,000
constexpr std::size_t found_size_max = 60;           // bytes of a text quoted in a message

struct Value {
  enum class Type : std::uint8_t { null, boolean, number, text, array, object };
  Type type = Type::null;
  bool flag = false;
  double number = 0;
  std::string text;
  std::vector<std::string> keys;  // object: of the items, in order
  std::vector<Value> items;

  const Value* find(std::string_view key) const {
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (keys[i] == key) return &items[i];
    return nullptr;
  }
};

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

/// At most found_size_max bytes, not cut inside a character.
std::string shortened(std::string_view text) {
  if (text.size() <= found_size_max) return std::string(text);
  std::size_t size = found_size_max;
  while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xc0) == 0x80) --size;
  return std::string(text.substr(0, size)) + "...";
}

std::string found_text(const Value& value) {
  switch (value.type) {
    case Value::Type::null:
      return "null";
    case Value::Type::boolean:
      return value.flag ? "true" : "false";
    case Value::Type::number:
      return number_text(value.number);
    case Value::Type::text:
      return in_quotes(shortened(value.text));
    case Value::Type::array:
      return "an array of " + std::to_string(value.items.size());
    case Value::Type::object:
      return "an object";
  }
  return {};
}

/// Receives the parser's events and builds the tree.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  /// Takes an element of a top-level array out of the tree. False stops the parser.
  using Take = std::function<bool(std::string_view list, std::size_t index, const Value& element)>;

  TreeBuilder(std::string_view text, std::string place, ErrorCode code, Take take = {})
      : text_(text), place_(std::move(place)), code_(code), take_(std::move(take)) {}

  bool null() override { return add(Value{}); }
  bool boolean(bool flag) override {
    Value value;
    value.type = Value::Type::boolean;
    value.flag = flag;
    return add(std::move(value));
  }
  bool number_integer(std::int64_t number) override { return add_number(static_cast<double>(number)); }
  bool number_unsigned(std::uint64_t number) override { return add_number(static_cast<double>(number)); }
  bool number_float(double number, const std::string&) override { return add_number(number); }
  bool string(std::string& text) override {
    Value value;
    value.type = Value::Type::text;
    value.text = std::move(text);
    return add(std::move(value));
  }
  bool binary(nlohmann::json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Value::Type::object); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(Value::Type::array); }
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
    // "[json.exception.parse_error.101] parse error at line 1, column 8: syntax error while ...": the last part.
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

  Value& root() { return root_; }
  const Error& error() const { return error_; }
  void set_error(Error error) { error_ = std::move(error); }

 private:
  struct Frame {
    Value value;
    std::size_t taken_count = 0;  // elements that went to take_
  };

  bool fail(ErrorCode code, const std::string& where, const std::string& what) {
    error_ = Error{code, place_ + ": " + (where.empty() ? "" : where + ": ") + what, ""};
    return false;
  }

  /// Of the value that is open.
  std::string path() const {
    std::string text;
    for (std::size_t i = 0; i + 1 < stack_.size(); ++i) {
      const Frame& frame = stack_[i];
      if (frame.value.type == Value::Type::object)
        text += (text.empty() ? "" : ".") + shortened(frame.value.keys.back());
      else
        text += "[" + std::to_string(frame.taken_count + frame.value.items.size()) + "]";
    }
    return text;
  }

  bool add_number(double number) {
    Value value;
    value.type = Value::Type::number;
    value.number = number;
    return add(std::move(value));
  }

  bool open(Value::Type type) {
    if (stack_.size() == depth_max)
      return fail(ErrorCode::limit, path(),
                  "nested too deeply: expected at most " + std::to_string(depth_max) + " levels");
    stack_.emplace_back();
    stack_.back().value.type = type;
    return true;
  }

  bool close() {
    Value value = std::move(stack_.back().value);
    stack_.pop_back();
    return add(std::move(value));
  }

  bool add(Value value) {
    if (stack_.empty()) {
      root_ = std::move(value);
      return true;
    }
    Frame& frame = stack_.back();
    if (++pending_count_ > pending_value_max)
      return fail(ErrorCode::limit, path(), "too many values: expected at most " + std::to_string(pending_value_max));
    if (frame.value.type == Value::Type::array) {
      if (frame.taken_count + frame.value.items.size() == limits::body_count_max)
        return fail(ErrorCode::limit, path(),
                    "too many: found more than " + std::to_string(limits::body_count_max) + ", expected at most " +
                        std::to_string(limits::body_count_max));
      if (take_ && stack_.size() == 2 && is_streamed(stack_[0].value.keys.back())) {
        pending_count_ = 0;
        return take_(stack_[0].value.keys.back(), frame.taken_count++, value);
      }
    }
    frame.value.items.push_back(std::move(value));
    return true;
  }

  bool is_streamed(const std::string& key) const {
    return stack_[0].value.type == Value::Type::object && (key == "bodies" || key == "prototypes");
  }

  std::string_view text_;
  std::string place_;
  ErrorCode code_;
  Take take_;
  std::vector<Frame> stack_;
  Value root_;
  std::size_t pending_count_ = 0;
  Error error_{};
};

// ---- Reading values ----

/// The way to a value, kept on the stack and put into words only for an error.
struct Path {
  const Path* parent = nullptr;
  std::string_view key;   // of an object
  std::size_t index = 0;  // of an array, where key is empty

  std::string text() const {
    std::string prefix = parent != nullptr ? parent->text() : "";
    if (key.empty()) return parent == nullptr ? "" : prefix + "[" + std::to_string(index) + "]";
    return prefix.empty() ? std::string(key) : prefix + "." + std::string(key);
  }
};

/// Insertions, deletions and replacements that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      std::size_t best = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      if (above + 1 < best) best = above + 1;
      if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
      row[j] = best;
      diagonal = above;
    }
  }
  return row[b.size()];
}

/// "did you mean x?", or nothing where no known word is near.
std::string suggestion(std::string_view word, const std::vector<std::string_view>& known) {
  if (word.size() > limits::name_size_max) return {};
  std::string_view best;
  std::size_t best_distance = word.size() / 3 + 2;
  for (const std::string_view candidate : known) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance >= best_distance || distance >= candidate.size()) continue;
    best_distance = distance;
    best = candidate;
  }
  return best.empty() ? std::string() : "did you mean " + std::string(best) + "?";
}

std::string listed(const std::vector<std::string_view>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " or " : ", ") + std::string(words[i]);
  return text;
}

class Reader {
 public:
  Reader(std::string place, ErrorCode code) : place_(std::move(place)), code_(code) {}
  const Error& error() const { return error_; }

  bool fail(const Path& path, const std::string& what, std::string hint = {}) {
    const std::string where = path.text();
    error_ = Error{code_, place_ + ": " + (where.empty() ? "" : where + ": ") + what, std::move(hint)};
    return false;
  }
  bool wrong_type(const Path& path, const Value& value, const char* expected) {
    return fail(path, "wrong type: found " + found_text(value) + ", expected " + expected);
  }

  struct Field {
    std::string_view key;
    std::function<bool(const Value&, const Path&)> read;
    bool required = false;
  };
  /// Reads every member of an object by the field of its key; refuses keys without one.
  bool object(const Value& value, const Path& path, const std::vector<Field>& fields) {
    if (value.type != Value::Type::object) return wrong_type(path, value, "an object");
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
      if (!field->read(value.items[i], Path{&path, field->key})) return false;
    }
    for (const Field& field : fields)
      if (field.required && value.find(field.key) == nullptr)
        return fail(Path{&path, field.key}, "missing: found no such key, expected one");
    return true;
  }

  bool number(const Value& value, const Path& path, double& out) {
    if (value.type != Value::Type::number) return wrong_type(path, value, "a number");
    out = value.number;
    return true;
  }
  /// 0 <= min, max <= 2^53.
  bool whole(const Value& value, const Path& path, double min, double max, std::uint64_t& out) {
    if (value.type != Value::Type::number) return wrong_type(path, value, "a whole number");
    if (!(value.number >= min && value.number <= max) ||
        static_cast<double>(static_cast<std::uint64_t>(value.number)) != value.number)
      return fail(path, "must be a whole number in range: found " + number_text(value.number) + ", expected " +
                            number_text(min) + ".." + number_text(max));
    out = static_cast<std::uint64_t>(value.number);
    return true;
  }
  bool flag(const Value& value, const Path& path, bool& out) {
    if (value.type != Value::Type::boolean) return wrong_type(path, value, "true or false");
    out = value.flag;
    return true;
  }
  bool text(const Value& value, const Path& path, std::string& out) {
    if (value.type != Value::Type::text) return wrong_type(path, value, "a string");
    out = value.text;
    return true;
  }
  bool point(const Value& value, const Path& path, Point& out) {
    if (value.type != Value::Type::array || value.items.size() != 2) return wrong_type(path, value, "[x, y]");
    return number(value.items[0], Path{&path, {}, 0}, out.x) && number(value.items[1], Path{&path, {}, 1}, out.y);
  }
  template <typename Table, typename Kind>
  bool choice(const Value& value, const Path& path, const Table& table, Kind& out) {
    if (value.type == Value::Type::text) {
      if (const auto* row = find_choice(table, value.text)) {
        out = row->kind;
        return true;
      }
    }
    std::vector<std::string_view> known;
    for (const auto& row : table) known.push_back(row.name);
    return fail(path, "unknown: found " + found_text(value) + ", expected " + listed(known),
                value.type == Value::Type::text ? suggestion(value.text, known) : "");
  }
  template <typename Element, typename Read>
  bool list(const Value& value, const Path& path, std::vector<Element>& out, Read read) {
    if (value.type != Value::Type::array) return wrong_type(path, value, "an array");
    out.resize(value.items.size());
    for (std::size_t i = 0; i < value.items.size(); ++i)
      if (!read(value.items[i], Path{&path, {}, i}, out[i])) return false;
    return true;
  }

  // Fields that are read straight into a variable.
  Field number(std::string_view key, double& out, bool required = false) {
    return {key, [this, &out](const Value& v, const Path& p) { return number(v, p, out); }, required};
  }
  Field flag(std::string_view key, bool& out) {
    return {key, [this, &out](const Value& v, const Path& p) { return flag(v, p, out); }};
  }
  Field text(std::string_view key, std::string& out) {
    return {key, [this, &out](const Value& v, const Path& p) { return text(v, p, out); }};
  }
  Field point(std::string_view key, Point& out, bool required = false) {
    return {key, [this, &out](const Value& v, const Path& p) { return point(v, p, out); }, required};
  }
  template <typename Table, typename Kind>
  Field choice(std::string_view key, const Table& table, Kind& out) {
    return {key, [this, &table, &out](const Value& v, const Path& p) { return choice(v, p, table, out); }};
  }

  // ---- Scenes ----

  bool body(const Value& value, const Path& path, Body& out) {
    ExplicitMass mass;
    bool has_mass = false, has_inertia = false, has_center = false;
    double inertia = 0;
    Point center;
    const auto noted = [](bool& has, Field field) {
      return Field{field.key,
                   [&has, read = field.read](const Value& v, const Path& p) { return (has = true) && read(v, p); }};
    };
    const auto shapes = [&](const Value& v, const Path& p) {
      return list(v, p, out.shapes, [this](const Value& sv, const Path& sp, Shape& s) { return shape(sv, sp, s); });
    };
    if (!object(value, path,
                {text("name", out.name),
                 choice("type", body_types, out.type),
                 point("position", out.position),
                 number("angle", out.angle),
                 point("velocity", out.velocity),
                 number("angular_velocity", out.angular_velocity),
                 number("linear_damping", out.linear_damping),
                 number("angular_damping", out.angular_damping),
                 number("gravity_scale", out.gravity_scale),
                 flag("fixed_rotation", out.fixed_rotation),
                 noted(has_mass, number("mass", mass.mass)),
                 noted(has_inertia, number("inertia", inertia)),
                 noted(has_center, point("center_of_mass", center)),
                 {"shapes", shapes}}))
      return false;
    if (has_inertia) mass.inertia = inertia;
    if (has_center) mass.center = center;
    if (has_mass) {
      out.mass = mass;
      return true;
    }
    if (!has_inertia && !has_center) return true;
    return fail(Path{&path, has_inertia ? "inertia" : "center_of_mass"}, "needs a stated mass: found it without one",
                "add \"mass\", or let the shapes' densities decide");
  }

  bool shape(const Value& value, const Path& path, Shape& out) {
    if (value.type != Value::Type::object) return wrong_type(path, value, "an object");
    // The type decides which keys there are.
    const Value* type = value.find("type");
    if (type == nullptr)
      return fail(Path{&path, "type"}, "missing: found no such key, expected " + choice_names(shape_kinds));
    if (!choice(*type, Path{&path, "type"}, shape_kinds, out.kind)) return false;
    std::vector<Field> fields{choice("type", shape_kinds, out.kind)};
    switch (out.kind) {
      case ShapeKind::circle:
        fields.push_back(number("radius", out.radius, true));
        fields.push_back(point("center", out.center));
        break;
      case ShapeKind::box:
        fields.push_back(point("half_size", out.half_size, true));
        fields.push_back(point("center", out.center));
        fields.push_back(number("angle", out.angle));
        break;
      case ShapeKind::polygon:
        fields.push_back({"vertices",
                          [&](const Value& v, const Path& p) {
                            return list(v, p, out.vertices, [this](const Value& pv, const Path& pp, Point& point_out) {
                              return point(pv, pp, point_out);
                            });
                          },
                          true});
        break;
      case ShapeKind::capsule:
      case ShapeKind::segment:
      case ShapeKind::chain:
        break;
    }
    fields.push_back(number("density", out.density));
    fields.push_back(number("friction", out.material.friction));
    fields.push_back(number("restitution", out.material.restitution));
    return object(value, path, fields);
  }

  /// A number of seconds, or a quotient of two numbers as text.
  bool dt(const Value& value, const Path& path, double& out) {
    if (value.type == Value::Type::number) return number(value, path, out);
    if (value.type != Value::Type::text)
      return wrong_type(path, value, "a number of seconds or a quotient such as \"1/60\"");
    const std::size_t slash = value.text.find('/');
    const auto above = parse_number(std::string_view(value.text).substr(0, slash));
    const auto below =
        slash == std::string::npos ? std::nullopt : parse_number(std::string_view(value.text).substr(slash + 1));
    if (!above || !below || !(*below > 0))
      return fail(path, "not a quotient: found " + found_text(value) + ", expected a form such as \"1/60\"");
    out = *above / *below;
    return true;
  }

  bool settings(const Value& value, const Path& path, Settings& out) {
    bool has_substeps = false;
    const auto substeps = [&](const Value& v, const Path& p) {
      std::uint64_t count = 0;
      has_substeps = true;
      if (!whole(v, p, 1, limits::substep_count_max, count)) return false;
      out.substeps = static_cast<int>(count);
      return true;
    };
    if (!object(value, path,
                {choice("precision", precisions, out.precision),
                 {"dt", [&](const Value& v, const Path& p) { return dt(v, p, out.dt); }},
                 {"substeps", substeps},
                 choice("solver", solvers, out.solver),
                 choice("integrator", integrators, out.integrator),
                 choice("broad_phase", broad_phases, out.broad_phase),
                 choice("friction_mix", mix_rules, out.friction_mix),
                 choice("restitution_mix", mix_rules, out.restitution_mix),
                 number("restitution_threshold", out.restitution_threshold)}))
      return false;
    if (!has_substeps && !info_of(solvers, out.solver).substeps) out.substeps = 1;
    return true;
  }

  bool bounds(const Value& value, const Path& path, Bounds& out) {
    return object(value, path, {point("lower", out.lower, true), point("upper", out.upper, true)});
  }

  bool pointer(const Value& value, const Path& path, PointerSettings& out) {
    const auto spawns = [&](const Value& v, const Path& p) {
      return list(v, p, out.spawns,
                  [this](const Value& nv, const Path& np, std::string& name) { return text(nv, np, name); });
    };
    return object(value, path,
                  {{"spawns", spawns},
                   number("hertz", out.hertz),
                   number("damping_ratio", out.damping_ratio),
                   number("force_max_per_kg", out.force_max_per_kg),
                   {"window", [&](const Value& v, const Path& p) { return bounds(v, p, out.window.emplace()); }}});
  }

  /// All but the elements of bodies and prototypes, which the tree builder has handed out already.
  bool scene(const Value& value, const Path& path, Scene& out) {
    const auto taken = [this](const Value& v, const Path& p) {
      return v.type == Value::Type::array || wrong_type(p, v, "an array");
    };
    const auto inputs = [&](const Value& v, const Path& p) {
      return list(v, p, out.inputs, [this](const Value& kv, const Path& kp, InputKind& kind) {
        return choice(kv, kp, input_kinds, kind);
      });
    };
    const auto spawned_max = [&](const Value& v, const Path& p) {
      std::uint64_t count = 0;
      if (!whole(v, p, 1, limits::body_count_max, count)) return false;
      out.spawned_max = static_cast<std::uint32_t>(count);
      return true;
    };
    std::string schema;  // for editors; says nothing about the world
    return object(value, path,
                  {text("$schema", schema),
                   text("name", out.name),
                   point("gravity", out.gravity),
                   {"settings", [&](const Value& v, const Path& p) { return settings(v, p, out.settings); }},
                   {"bodies", taken},
                   {"prototypes", taken},
                   {"inputs", inputs},
                   {"pointer", [&](const Value& v, const Path& p) { return pointer(v, p, out.pointer.emplace()); }},
                   {"bounds", [&](const Value& v, const Path& p) { return bounds(v, p, out.bounds.emplace()); }},
                   {"spawned_max", spawned_max}});
  }

  // ---- Inputs ----

  bool input(const Value& value, const Path& path, const Scene& scene, Input& out) {
    if (value.type != Value::Type::object) return wrong_type(path, value, "an object");
    // The kind decides which keys there are.
    const Value* kind = value.find("kind");
    if (kind == nullptr)
      return fail(Path{&path, "kind"}, "missing: found no such key, expected " + choice_names(input_kinds));
    if (!choice(*kind, Path{&path, "kind"}, input_kinds, out.kind)) return false;
    const InputInfo& info = info_of(input_kinds, out.kind);
    std::uint64_t player = 0, body = 0;
    std::vector<Field> fields{
        {"tick",
         [&](const Value& v, const Path& p) {
           return whole(v, p, 0, static_cast<double>(limits::tick_count_max - 1), out.tick);
         },
         true},
        {"player", [&](const Value& v, const Path& p) { return whole(v, p, 0, limits::player_count_max - 1, player); }},
        choice("kind", input_kinds, out.kind)};
    if (info.has_body)
      fields.push_back(
          {"body", [&](const Value& v, const Path& p) { return whole(v, p, 0, 0xfffffffeu, body); }, true});
    if (info.has_prototype)
      fields.push_back(
          {"prototype", [&](const Value& v, const Path& p) { return prototype(v, p, scene, out.prototype); }, true});
    for (std::size_t i = 0; i < info.value_count; ++i) fields.push_back(number(info.value_names[i], out.values[i]));
    if (!object(value, path, fields)) return false;
    out.player = static_cast<std::uint8_t>(player);
    out.body = static_cast<std::uint32_t>(body);
    return true;
  }

  bool prototype(const Value& value, const Path& path, const Scene& scene, std::uint16_t& out) {
    if (value.type != Value::Type::text) return wrong_type(path, value, "the name of a prototype");
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < scene.prototypes.size(); ++i) {
      if (scene.prototypes[i].name == value.text) {
        out = static_cast<std::uint16_t>(i);
        return true;
      }
      if (known.size() < 16) known.push_back(scene.prototypes[i].name);
    }
    return fail(path,
                "no prototype of the scene has this name: found " + found_text(value) + ", expected " +
                    (known.empty() ? "none: the scene has no prototypes" : listed(known)),
                suggestion(value.text, known));
  }

 private:
  std::string place_;
  ErrorCode code_;
  Error error_{};
};

// ---- Printing ----

std::string number_json(double value) {
  std::string text = number_text(value);
  return text == "-0" ? "-0.0" : text;  // "-0" would be read as the integer zero
}

class Printer {
 public:
  std::string scene(const Scene& scene) {
    const Settings& settings = scene.settings;
    text_ = "{\n  \"name\": " + in_quotes(scene.name) + ",\n  \"gravity\": ";
    point(scene.gravity);
    text_ += ",\n  \"settings\": ";
    open();
    name("precision", info_of(precisions, settings.precision).name);
    key("dt");
    dt(settings.dt);
    number("substeps", settings.substeps);
    name("solver", info_of(solvers, settings.solver).name);
    name("integrator", info_of(integrators, settings.integrator).name);
    name("broad_phase", info_of(broad_phases, settings.broad_phase).name);
    name("friction_mix", info_of(mix_rules, settings.friction_mix).name);
    name("restitution_mix", info_of(mix_rules, settings.restitution_mix).name);
    number("restitution_threshold", settings.restitution_threshold);
    close();
    bodies("bodies", scene.bodies);
    if (!scene.prototypes.empty()) bodies("prototypes", scene.prototypes);
    if (!scene.inputs.empty()) {
      text_ += ",\n  \"inputs\": [";
      for (std::size_t i = 0; i < scene.inputs.size(); ++i)
        text_ += (i == 0 ? "" : ", ") + in_quotes(info_of(input_kinds, scene.inputs[i]).name);
      text_ += "]";
    }
    if (scene.pointer) {
      text_ += ",\n  \"pointer\": ";
      pointer(*scene.pointer);
    }
    if (scene.bounds) {
      text_ += ",\n  \"bounds\": ";
      bounds(*scene.bounds);
    }
    if (scene.spawned_max) text_ += ",\n  \"spawned_max\": " + std::to_string(*scene.spawned_max);
    return text_ + "\n}\n";
  }

  std::string input(const Scene& scene, const Input& input) {
    const InputInfo& info = info_of(input_kinds, input.kind);
    text_ = "{\"tick\":" + std::to_string(input.tick);
    if (input.player != 0) text_ += ",\"player\":" + std::to_string(input.player);
    text_ += ",\"kind\":" + in_quotes(info.name);
    if (info.has_body) text_ += ",\"body\":" + std::to_string(input.body);
    if (info.has_prototype)
      text_ += ",\"prototype\":" +
               in_quotes(input.prototype < scene.prototypes.size() ? scene.prototypes[input.prototype].name : "");
    for (std::size_t i = 0; i < info.value_count; ++i)
      text_ += "," + in_quotes(info.value_names[i]) + ":" + number_json(input.values[i]);
    return text_ + "}";
  }

 private:
  void open() {
    text_ += "{";
    is_first_ = true;
  }
  void close() {
    text_ += "}";
    is_first_ = false;
  }
  void key(std::string_view name) {
    text_ += (is_first_ ? "" : ", ") + in_quotes(name) + ": ";
    is_first_ = false;
  }
  void name(std::string_view name_of_key, std::string_view value) {
    key(name_of_key);
    text_ += in_quotes(value);
  }
  void number(std::string_view name_of_key, double value) {
    key(name_of_key);
    text_ += number_json(value);
  }
  /// Left out where the value has the bits of the default (so that -0 is kept).
  void number(std::string_view name_of_key, double value, double unset) {
    if (bits_of(value) != bits_of(unset)) number(name_of_key, value);
  }
  void point(const Point& value) { text_ += "[" + number_json(value.x) + ", " + number_json(value.y) + "]"; }
  void point(std::string_view name_of_key, const Point& value) {
    key(name_of_key);
    point(value);
  }
  void point_unless_zero(std::string_view name_of_key, const Point& value) {
    if (bits_of(value.x) != 0 || bits_of(value.y) != 0) point(name_of_key, value);
  }
  void dt(double value) {
    for (int n = 1; n <= 1000; ++n) {
      if (1.0 / n != value) continue;
      text_ += "\"1/" + std::to_string(n) + "\"";
      return;
    }
    text_ += number_json(value);
  }

  void bodies(std::string_view list, const std::vector<Body>& bodies) {
    text_ += ",\n  " + in_quotes(list) + ": [";
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      text_ += i == 0 ? "\n    " : ",\n    ";
      body(bodies[i]);
    }
    text_ += bodies.empty() ? "]" : "\n  ]";
  }

  void body(const Body& body) {
    const Body unset;
    open();
    if (!body.name.empty()) name("name", body.name);
    if (body.type != unset.type) name("type", info_of(body_types, body.type).name);
    point_unless_zero("position", body.position);
    number("angle", body.angle, unset.angle);
    point_unless_zero("velocity", body.velocity);
    number("angular_velocity", body.angular_velocity, unset.angular_velocity);
    number("linear_damping", body.linear_damping, unset.linear_damping);
    number("angular_damping", body.angular_damping, unset.angular_damping);
    number("gravity_scale", body.gravity_scale, unset.gravity_scale);
    if (body.fixed_rotation) {
      key("fixed_rotation");
      text_ += "true";
    }
    if (body.mass) {
      number("mass", body.mass->mass);
      if (body.mass->inertia) number("inertia", *body.mass->inertia);
      if (body.mass->center) point("center_of_mass", *body.mass->center);
    }
    key("shapes");
    text_ += "[";
    for (std::size_t i = 0; i < body.shapes.size(); ++i) {
      if (i > 0) text_ += ", ";
      shape(body.shapes[i]);
    }
    text_ += "]";
    close();
  }

  void shape(const Shape& shape) {
    const Shape unset;
    open();
    name("type", info_of(shape_kinds, shape.kind).name);
    switch (shape.kind) {
      case ShapeKind::circle:
        number("radius", shape.radius);
        point_unless_zero("center", shape.center);
        break;
      case ShapeKind::box:
        point("half_size", shape.half_size);
        point_unless_zero("center", shape.center);
        number("angle", shape.angle, unset.angle);
        break;
      case ShapeKind::polygon:
        key("vertices");
        text_ += "[";
        for (std::size_t i = 0; i < shape.vertices.size(); ++i) {
          if (i > 0) text_ += ", ";
          point(shape.vertices[i]);
        }
        text_ += "]";
        break;
      case ShapeKind::capsule:
      case ShapeKind::segment:
      case ShapeKind::chain:
        break;
    }
    number("density", shape.density, unset.density);
    number("friction", shape.material.friction, unset.material.friction);
    number("restitution", shape.material.restitution, unset.material.restitution);
    close();
  }

  void pointer(const PointerSettings& pointer) {
    open();
    key("spawns");
    text_ += "[";
    for (std::size_t i = 0; i < pointer.spawns.size(); ++i)
      text_ += (i == 0 ? "" : ", ") + in_quotes(pointer.spawns[i]);
    text_ += "]";
    number("hertz", pointer.hertz);
    number("damping_ratio", pointer.damping_ratio);
    number("force_max_per_kg", pointer.force_max_per_kg);
    if (pointer.window) {
      key("window");
      bounds(*pointer.window);
    }
    close();
  }

  void bounds(const Bounds& bounds) {
    open();
    point("lower", bounds.lower);
    point("upper", bounds.upper);
    close();
  }

  std::string text_;
  bool is_first_ = true;
};

}  // namespace

Result<Scene> parse_scene(std::string_view json, const std::string& source) {
  if (json.size() > limits::scene_file_size_max)
    return Error{ErrorCode::limit,
                 source + ": too large: found " + std::to_string(json.size()) + " bytes, expected at most " +
                     std::to_string(limits::scene_file_size_max),
                 ""};
  Scene scene;
  Reader reader(source, ErrorCode::invalid_scene);
  const Path root;
  TreeBuilder* builder_in_use = nullptr;
  TreeBuilder builder(json, source, ErrorCode::invalid_scene,
                      [&](std::string_view list, std::size_t index, const Value& element) {
                        const Path list_path{&root, list};
                        std::vector<Body>& bodies = list == "bodies" ? scene.bodies : scene.prototypes;
                        if (reader.body(element, Path{&list_path, {}, index}, bodies.emplace_back())) return true;
                        builder_in_use->set_error(reader.error());
                        return false;
                      });
  builder_in_use = &builder;
  // The parser takes a NUL for the end of the text.
  if (json.find('\0') != std::string_view::npos)
    return Error{ErrorCode::invalid_scene, source + ": broken JSON: found a NUL byte, expected text", ""};
  if (!nlohmann::json::sax_parse(json.begin(), json.end(), &builder)) return builder.error();
  if (!reader.scene(builder.root(), root, scene)) return reader.error();
  if (Status status = check_scene(scene, source); !status) return status.error();
  return scene;
}

std::string print_scene(const Scene& scene) {
  return Printer().scene(scene);
}

Result<Input> parse_input(const Scene& scene, std::string_view line, const std::string& place) {
  if (line.size() > limits::input_line_size_max)
    return Error{ErrorCode::limit,
                 place + ": line too long: found " + std::to_string(line.size()) + " bytes, expected at most " +
                     std::to_string(limits::input_line_size_max),
                 ""};
  if (line.find('\0') != std::string_view::npos)
    return Error{ErrorCode::invalid_input, place + ": broken JSON: found a NUL byte, expected text", ""};
  TreeBuilder builder(line, place, ErrorCode::invalid_input);
  if (!nlohmann::json::sax_parse(line.begin(), line.end(), &builder)) return builder.error();
  Input input;
  Reader reader(place, ErrorCode::invalid_input);
  if (!reader.input(builder.root(), Path{}, scene, input)) return reader.error();
  if (Status status = check_input(scene, input, place); !status) return status.error();
  return input;
}

std::string print_input(const Scene& scene, const Input& input) {
  return Printer().input(scene, input);
}

}  // namespace ticktrue::engine
