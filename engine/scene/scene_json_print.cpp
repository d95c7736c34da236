// Printing scenes and inputs as JSON.
// SPDX-License-Identifier: MIT
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "engine/json/json_tree.h"
#include "engine/json/number_text.h"
#include "engine/scene/scene_fields.h"
#include "engine/scene/scene_json.h"

namespace ticktrue::engine {
namespace {

std::string number_json(double value) {
  std::string text = number_text(value);
  return text == "-0" ? "-0.0" : text;  // "-0" would be read as the integer zero
}

class Printer {
 public:
  explicit Printer(const Scene& scene) : scene_(scene) {}

  std::string scene() {
    text_ = "{\n  \"name\": " + in_quotes(scene_.name) + ",\n  \"gravity\": ";
    put(scene_.gravity);
    visit_fields([&](const FieldInfo& field, const auto& value) { add_line(field.name, value); }, scene_);
    return text_ + "\n}\n";
  }

  std::string input(const Input& input) {
    const InputInfo& info = info_of(input_kinds, input.kind);
    text_ = "{\"tick\":" + std::to_string(input.tick);
    if (input.player != 0) text_ += ",\"player\":" + std::to_string(input.player);
    text_ += ",\"kind\":" + in_quotes(info.name);
    if (info.has_body) text_ += ",\"body\":" + std::to_string(input.body);
    if (info.has_prototype)
      text_ += ",\"prototype\":" +
               in_quotes(input.prototype < scene_.prototypes.size() ? scene_.prototypes[input.prototype].name : "");
    if (info.has_joint) text_ += ",\"joint\":" + name_or_index(scene_.joints, input.joint);
    for (std::size_t i = 0; i < info.value_count; ++i)
      text_ += "," + in_quotes(info.value_names[i]) + ":" + number_json(input.values[i]);
    return text_ + "}";
  }

 private:
  // ---- Lines of the scene after name and gravity ----

  void begin_line(std::string_view name) { text_ += ",\n  " + in_quotes(name) + ": "; }
  void add_line(std::string_view, const std::string&) {}
  void add_line(std::string_view, const Point&) {}
  void add_line(std::string_view name, const Settings& value) {
    begin_line(name);
    put(value);
  }
  void add_line(std::string_view name, const std::vector<InputKind>& kinds) {
    if (kinds.empty()) return;
    begin_line(name);
    put(kinds);
  }
  void add_line(std::string_view name, const std::optional<std::uint32_t>& count) {
    if (!count) return;
    begin_line(name);
    text_ += std::to_string(*count);
  }
  template <typename Struct>
  void add_line(std::string_view name, const std::optional<Struct>& value) {
    if (!value) return;
    begin_line(name);
    put(*value);
  }
  template <typename Element>
  void add_line(std::string_view name, const std::vector<Element>& elements) {
    if (elements.empty() && name != "bodies") return;
    begin_line(name);
    text_ += "[";
    for (std::size_t i = 0; i < elements.size(); ++i) {
      text_ += i == 0 ? "\n    " : ",\n    ";
      put(elements[i]);
    }
    text_ += elements.empty() ? "]" : "\n  ]";
  }

  // ---- Fields of an object ----

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
  template <typename Value>
  void add(std::string_view name, const Value& value) {
    key(name);
    put(value);
  }
  template <typename Value>
  void add(std::string_view name, const std::optional<Value>& value) {
    if (value) add(name, *value);
  }
  void add(std::string_view, const std::optional<ExplicitMass>& mass) {
    if (mass) add_fields(*mass);
  }
  void add(std::string_view, const std::optional<AutoSubsteps>&) {}  // `substeps` prints it
  void add(std::string_view name, const std::optional<SleepSettings>& sleep) {
    key(name);
    sleep ? put(*sleep) : put(false);
  }
  template <typename Struct>
  void add_fields(const Struct& object) {
    visit_fields([&](const FieldInfo& field, const auto& value) { add(field.name, value); }, object);
  }
  /// Leaves out fields that have the bits of the default. A -0 is printed.
  template <typename Struct>
  void add_stated_fields(const Struct& object) {
    const Struct unset;
    visit_fields(
        [&](const FieldInfo& field, const auto& value, const auto& default_value) {
          if (!same_bits(value, default_value)) add(field.name, value);
        },
        object, unset);
  }
  /// The fields of a row, in its order. `all`: fields with the default value, too.
  template <typename Struct, typename Row>
  void add_own_fields(const Struct& object, const Row& row, bool all = false) {
    const Struct unset;
    for (const auto& entry : row.keys) {
      if (entry.key.empty()) break;
      visit_own_fields(
          [&](const auto& field, const auto& value, const auto& default_value) {
            if (field.own != entry.field) return;
            if (field.is_body)
              add_index(scene_.bodies, entry.key, value);
            else if (field.is_joint)
              add_index(scene_.joints, entry.key, value);
            else if (all || entry.required || !same_bits(value, default_value))
              add(entry.key, value);
          },
          object, unset);
    }
  }

  template <typename Element>
  std::string name_or_index(const std::vector<Element>& elements, std::uint32_t index) const {
    const bool has_name = index < elements.size() && !elements[index].name.empty();
    return has_name ? in_quotes(elements[index].name) : std::to_string(index);
  }
  template <typename Element>
  void add_index(const std::vector<Element>& elements, std::string_view name, std::uint32_t index) {
    key(name);
    text_ += name_or_index(elements, index);
  }
  template <typename Element>
  void add_index(const std::vector<Element>& elements, std::string_view name,
                 const std::optional<std::uint32_t>& index) {
    if (index) add_index(elements, name, *index);
  }
  template <typename Element, typename Value>
  void add_index(const std::vector<Element>&, std::string_view, const Value&) {}  // never called: the value is no index

  // ---- Values ----

  void put(bool value) { text_ += value ? "true" : "false"; }
  void put(int value) { text_ += number_json(value); }
  void put(std::uint32_t value) { text_ += number_json(value); }
  void put(double value) { text_ += number_json(value); }
  void put(const std::string& value) { text_ += in_quotes(value); }
  void put(InputKind kind) { text_ += in_quotes(info_of(input_kinds, kind).name); }
  void put(const Point& value) { text_ += "[" + number_json(value.x) + ", " + number_json(value.y) + "]"; }
  void put(const Range& value) { put(Point{value.lower, value.upper}); }
  template <typename Value>
  void put(const std::vector<Value>& values) {
    text_ += "[";
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0) text_ += ", ";
      put(values[i]);
    }
    text_ += "]";
  }
  /// A choice or a struct that is printed whole.
  template <typename Value>
  void put(const Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      text_ += in_quotes(info_of(Tables::of(value), value).name);
    } else {
      open();
      add_fields(value);
      close();
    }
  }
  void put(const Settings& settings) {
    open();
    const Settings unset;
    visit_fields(
        [&](const FieldInfo& field, const auto& value, const auto& default_value) {
          // With automatic substeps, a reader would choose other values for settings that are left out.
          if (field.since > 0 && !settings.auto_substeps && same_bits(value, default_value)) return;
          if (field.name == "dt")
            add_dt(settings.dt);
          else if (field.name == "substeps")
            add_substeps(settings);
          else
            add(field.name, value);
        },
        settings, unset);
    close();
  }
  void put(const ClockSettings& clock) { put_of_kind(clock, info_of(clock_kinds, clock.kind), true); }
  void put(const Joint& joint) { put_of_kind(joint, info_of(joint_kinds, joint.kind)); }
  void put(const Force& force) { put_of_kind(force, info_of(force_kinds, force.kind)); }
  template <typename Struct, typename Row>
  void put_of_kind(const Struct& object, const Row& row, bool all = false) {
    open();
    add("type", std::string(row.name));
    if constexpr (requires { object.name; }) add_stated_fields(object);
    add_own_fields(object, row, all);
    close();
  }
  void put(const Shape& shape) {
    const ShapeKindInfo& row = info_of(shape_kinds, shape.kind);
    open();
    add("type", std::string(row.name));
    add_own_fields(shape, row);
    add_stated_fields(shape);
    close();
  }
  void put(const Body& body) {
    open();
    add_stated_fields(body);
    close();
  }
  void put(const JointSpring& spring) {
    open();
    visit_own_fields(
        [&](const auto& field, double value) {
          if (field.own == spring.absolute) add(field.name, value);
        },
        spring);
    close();
  }

  void add_dt(double value) {
    key("dt");
    for (int n = 1; n <= 1000; ++n) {
      if (1.0 / n != value) continue;
      text_ += "\"1/" + std::to_string(n) + "\"";
      return;
    }
    put(value);
  }
  void add_substeps(const Settings& settings) {
    if (!settings.auto_substeps) return add("substeps", settings.substeps);
    key("substeps");
    open();
    add("least", settings.substeps);
    add_fields(*settings.auto_substeps);
    close();
  }

  const Scene& scene_;
  std::string text_;
  bool is_first_ = true;
};

}  // namespace

std::string print_scene(const Scene& scene) {
  return Printer(scene).scene();
}

std::string print_input(const Scene& scene, const Input& input) {
  return Printer(scene).input(input);
}

}  // namespace ticktrue::engine
