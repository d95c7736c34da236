// Compares the list of scene fields with hand-written text: JSON Schema, docs/scenes.md and docs/engine_setup.md.
// SPDX-License-Identifier: MIT
//
// Verified: keys, ranges and defaults in the schema; keys and defaults in docs/scenes.md; names, order and types of the
// binary form in docs/engine_setup.md; round trips of every random world and built-in scene through both forms.
// Not verified: the descriptions.
#include "engine/scene/scene_fields.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/builtin_scenes/builtin_scenes.h"
#include "engine/json/number_text.h"
#include "engine/random_worlds/random_world.h"
#include "engine/scene/scene_binary.h"
#include "engine/scene/scene_json.h"
#include "tests/support/catch.h"

using namespace ticktrue;
using namespace ticktrue::engine;
using nlohmann::json;

namespace {

std::string file_text(const char* path) {
  std::ifstream in(std::filesystem::path(TICKTRUE_SOURCE_DIR) / path, std::ios::binary);
  REQUIRE(in);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

template <typename Value>
constexpr bool is_number = std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>;
template <typename Value>
using Plain = std::remove_cvref_t<Value>;

// ---- JSON Schema ----

/// The rule of a key, with the definitions that the rule refers to.
json rule_of(const json& schema, const std::string& definition, const std::string& key) {
  const json& defs = schema["$defs"];
  CAPTURE(definition, key);
  const json& object = definition.empty() ? schema : defs[definition];
  REQUIRE(object["properties"].contains(key));
  json rule = object["properties"][key];
  while (rule.contains("$ref")) {
    const std::string target = rule["$ref"];
    rule.erase("$ref");
    json general = defs[target.substr(target.rfind('/') + 1)];
    general.update(rule);
    rule = general;
  }
  return rule;
}

template <typename Value>
json json_of(const Value& value) {
  if constexpr (std::is_same_v<Value, Point>)
    return json{value.x, value.y};
  else if constexpr (std::is_same_v<Value, InputKind> || !std::is_enum_v<Value>)
    return json(value);
  else
    return json(info_of(Tables::of(value), value).name);
}

template <typename Value>
void check_rule(const json& rule, FieldRange range, const Value& default_value) {
  if constexpr (is_number<Value>) {
    if (rule.contains("enum") || rule.contains("anyOf")) return;  // powers of two, or several forms
    CHECK(rule["maximum"] == range.max);
    CHECK((rule.contains("minimum") ? rule["minimum"] : rule["exclusiveMinimum"]) == range.min);
  }
  if constexpr (is_number<Value> || std::is_same_v<Value, bool> || std::is_same_v<Value, Point> ||
                (std::is_enum_v<Value> && !std::is_same_v<Value, InputKind>)) {
    if (rule.contains("default")) CHECK(rule["default"] == json_of(default_value));
  }
}

template <typename Element>
void check_rule(const json& rule, FieldRange range, const std::vector<Element>&) {
  if (rule.contains("maxItems")) CHECK(rule["maxItems"] <= range.max);  // a kind may allow fewer
}
template <typename Value>
void check_rule(const json& rule, FieldRange range, const std::optional<Value>&) {
  check_rule(rule, range, Value{});
}
void check_rule(const json& rule, FieldRange, const std::string& default_value) {
  if (rule.contains("default")) CHECK(rule["default"] == default_value);
}

template <typename Struct>
void check_schema_of(const json& schema, const std::string& definition) {
  const Struct unset;
  visit_fields(
      [&](const FieldInfo& field, const auto& default_value) {
        if (field.name.empty()) return;
        const std::string key(field.name);
        CAPTURE(definition, key);
        if (key == "dt") return;  // a quotient
        check_rule(rule_of(schema, definition, key), field.range, default_value);
      },
      unset);
}

template <typename Struct, typename Table>
void check_schema_of_kinds(const json& schema, const Table& table, const std::string& suffix) {
  const Struct unset;
  for (const auto& row : table)
    for (const auto& entry : row.keys) {
      if (entry.key.empty()) break;
      visit_own_fields(
          [&](const auto& field, const auto& default_value) {
            if (field.own != entry.field || field.is_body || field.is_joint) return;
            const std::string definition = std::string(row.name) + suffix;
            CAPTURE(definition, field.name);
            check_rule(rule_of(schema, definition, std::string(entry.key)), range_of(row, field.own, field.range),
                       default_value);
          },
          unset);
    }
}

// ---- Tables of documents ----

using Row = std::vector<std::string>;

std::string trimmed(std::string text) {
  text.erase(0, text.find_first_not_of(' '));
  return text.erase(text.find_last_not_of(' ') + 1);
}

/// The rows of the tables between `begin` and `end`. With an empty `end`, the rows of the first table only.
std::vector<Row> rows_between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t first = text.find(begin);
  CAPTURE(begin);
  REQUIRE(first != std::string::npos);
  std::istringstream in(text.substr(first + begin.size(), end.empty() ? end.npos : text.find(end, first + 1) - first));
  std::vector<Row> rows;
  for (std::string line; std::getline(in, line);) {
    if (end.empty() && !rows.empty() && line.empty()) break;
    if (line.empty() || line[0] != '|') continue;
    Row row;
    std::istringstream cells(line.substr(1));
    for (std::string cell; std::getline(cells, cell, '|');) row.push_back(trimmed(cell));
    rows.push_back(row);
  }
  return rows;
}

std::string default_text(double value) {
  return number_text(value);
}
std::string default_text(int value) {
  return std::to_string(value);
}
std::string default_text(bool value) {
  return value ? "true" : "false";
}
std::string default_text(const Point& value) {
  return value == Point{} ? "0" : "`[" + number_text(value.x) + ", " + number_text(value.y) + "]`";
}
template <typename Value>
std::string default_text(const Value& value) {
  if constexpr (std::is_enum_v<Value>)
    return "`\"" + std::string(info_of(Tables::of(value), value).name) + "\"`";
  else
    return "";  // described in words
}

/// Each key is in the first column of a row. Its default is in the second column, which has one default for all keys or
/// one for each.
template <typename Struct>
void check_documented(const std::vector<Row>& rows) {
  const Struct unset;
  visit_fields(
      [&](const FieldInfo& field, const auto& default_value) {
        if (field.name.empty() || field.name == "dt") return;
        const std::string key = "`" + std::string(field.name) + "`";
        CAPTURE(key);
        const auto found = std::find_if(rows.begin(), rows.end(),
                                        [&](const Row& row) { return row[0].find(key) != std::string::npos; });
        REQUIRE(found != rows.end());
        const std::string text = default_text(default_value);
        if (!text.empty()) CHECK((", " + (*found)[1] + ", ").find(", " + text + ", ") != std::string::npos);
      },
      unset);
}

// ---- The binary form ----

/// Name and type of the stored values, in order. Empty type: text explains the value.
struct BinaryRows {
  std::vector<std::pair<std::string, std::string>> rows;

  template <typename Value>
  void add(std::string_view name, const Value& value) {
    if constexpr (std::is_same_v<Value, Settings> || std::is_same_v<Value, Filter>)
      add_fields(value);
    else if constexpr (std::is_same_v<Value, ClockSettings>) {
      add(name, value.kind);
      add_own_fields(value);
    } else
      rows.emplace_back(name.empty() ? "auto_substeps" : name, type_of(value));
  }
  template <typename Struct>
  void add_fields(const Struct& object) {
    visit_fields([&](const FieldInfo& field, const auto& value) { add(field.name, value); }, object);
  }
  template <typename Struct>
  void add_own_fields(const Struct& object) {
    visit_own_fields([&](const auto& field, const auto& value) { add(field.name, value); }, object);
  }

  static std::string type_of(double) { return "f64"; }
  static std::string type_of(int) { return "i32"; }
  static std::string type_of(std::uint32_t) { return "u32"; }
  static std::string type_of(bool) { return "flag"; }
  static std::string type_of(const Point&) { return "point"; }
  static std::string type_of(const std::string&) { return "text"; }
  template <typename Value>
  static std::string type_of(const Value&) {
    return std::is_enum_v<Value> ? "u8" : "";
  }
};

void check_binary_rows(const BinaryRows& expected, std::vector<Row> rows) {
  rows.erase(rows.begin(), rows.begin() + 2);  // heading
  REQUIRE(rows.size() >= expected.rows.size());
  for (std::size_t i = 0; i < expected.rows.size(); ++i) {
    const auto& [name, type] = expected.rows[i];
    CAPTURE(name);
    CHECK(rows[i][1] == name);
    if (!type.empty()) CHECK(rows[i][2] == type);
  }
}

void check_forms(const Scene& scene) {
  const Bytes bytes = encode_scene(scene);
  const auto decoded = decode_scene(bytes);
  if (!decoded) FAIL(decoded.error().message);
  CHECK(*decoded == scene);
  const auto parsed = parse_scene(print_scene(scene), "s.json");
  if (!parsed) FAIL(parsed.error().message);
  CHECK(encode_scene(*parsed) == bytes);
}

}  // namespace

TEST_CASE("every random world and built-in scene comes back from JSON and binary with the same bits",
          "[engine][scene_fields][scene_json][scene_binary][equivalence]") {
  for (const BuiltinScene& builtin : builtin_scenes()) check_forms(*make_builtin_scene(builtin.name));
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    CAPTURE(seed);
    check_forms(random_world(seed).scene);
  }
}

TEST_CASE("the JSON Schema has the keys, ranges and defaults of the list of fields",
          "[engine][scene_fields][scene_json][equivalence]") {
  const json schema = json::parse(file_text("scenes/scene.schema.json"));
  check_schema_of<Scene>(schema, "");
  check_schema_of<Settings>(schema, "settings");
  check_schema_of<AutoSubsteps>(schema, "auto_substeps");
  check_schema_of<SleepSettings>(schema, "sleep");
  check_schema_of<Body>(schema, "body");
  check_schema_of<ExplicitMass>(schema, "body");
  check_schema_of<Filter>(schema, "filter");
  check_schema_of<JointMotor>(schema, "motor");
  check_schema_of<PointerSettings>(schema, "pointer");
  check_schema_of<Bounds>(schema, "bounds");
  for (const auto& row : shape_kinds) check_schema_of<Shape>(schema, std::string(row.name));
  for (const auto& row : joint_kinds) check_schema_of<Joint>(schema, std::string(row.name) + "_joint");
  for (const auto& row : force_kinds) check_schema_of<Force>(schema, std::string(row.name) + "_force");
  check_schema_of_kinds<Shape>(schema, shape_kinds, "");
  check_schema_of_kinds<Joint>(schema, joint_kinds, "_joint");
  check_schema_of_kinds<Force>(schema, force_kinds, "_force");
  check_schema_of_kinds<ClockSettings>(schema, clock_kinds, "_clock");
}

TEST_CASE("docs/scenes.md has the keys and defaults of the list of fields", "[engine][scene_fields][docs]") {
  const std::string text = file_text("docs/scenes.md");
  check_documented<Scene>(rows_between(text, "## Keys of a scene", "### settings"));
  check_documented<Settings>(rows_between(text, "### settings", "### bodies"));
  check_documented<Body>(rows_between(text, "### bodies", "### shapes"));
  check_documented<Shape>(rows_between(text, "Each has also:", "### joints"));
  check_documented<PointerSettings>(rows_between(text, "### pointer", "## Inputs"));
  const auto check_kinds = [&](const char* begin, const char* end, const auto& table) {
    const std::vector<Row> rows = rows_between(text, begin, end);
    for (const auto& row : table) {
      const std::string kind = "`" + std::string(row.name) + "`";
      std::string general;  // keys that another table explains
      std::string own;
      for (const Row& line : rows) (line[0] == kind ? own : general) += line[0] + line[1];
      for (const auto& entry : row.keys) {
        if (entry.key.empty()) break;
        CAPTURE(kind, entry.key);
        const std::string key = "`" + std::string(entry.key) + "`";
        CHECK((own + general).find(key) != std::string::npos);
      }
    }
  };
  check_kinds("### shapes", "Each has also:", shape_kinds);
  check_kinds("### forces", "### pointer", force_kinds);
  check_kinds("| Clock |", "`free_flight` solves", clock_kinds);
}

TEST_CASE("docs/engine_setup.md has the binary form of the list of fields", "[engine][scene_fields][docs]") {
  const std::string text = file_text("docs/engine_setup.md");
  BinaryRows scene, body, shape, joint, force;
  scene.rows.emplace_back("version", "u16");
  scene.add_fields(Scene{});
  check_binary_rows(scene, rows_between(text, "## Setup of ticktrue.engine", ""));
  body.add_fields(Body{});
  check_binary_rows(body, rows_between(text, "`body`:", ""));
  shape.add("type", ShapeKind::circle);
  shape.add_fields(Shape{});
  check_binary_rows(shape, rows_between(text, "`shape`:", ""));
  joint.add_fields(Joint{});
  joint.rows.emplace_back("type", "u8");
  joint.add_own_fields(Joint{});
  check_binary_rows(joint, rows_between(text, "`joint`. A field", ""));
  force.add_fields(Force{});
  force.rows.emplace_back("type", "u8");
  force.add_own_fields(Force{});
  check_binary_rows(force, rows_between(text, "`force`, with", ""));
}

TEST_CASE("docs/engine_setup.md has the number of every choice", "[engine][scene_fields][docs]") {
  const std::string text = file_text("docs/engine_setup.md");
  const auto check_numbers = [&](std::string_view field, const auto& table) {
    CAPTURE(field);
    const std::size_t begin = text.find("| " + std::string(field) + " | u8 | 0 " + std::string(table[0].name));
    REQUIRE(begin != std::string::npos);
    const std::string line = text.substr(begin, text.find('\n', begin) - begin);
    for (std::size_t i = 0; i < table.size(); ++i)
      CHECK(line.find(std::to_string(i) + " " + std::string(table[i].name)) != std::string::npos);
    CHECK(line.find(", " + std::to_string(table.size()) + " ") == std::string::npos);
  };
  check_numbers("precision", precisions);
  check_numbers("solver", solvers);
  check_numbers("integrator", integrators);
  check_numbers("broad_phase", broad_phases);
  check_numbers("friction_mix", mix_rules);
  check_numbers("clock", clock_kinds);
  check_numbers("joints", joint_solvers);
  check_numbers("substep_loads", substep_loads);
  check_numbers("type", body_types);
  check_numbers("type", shape_kinds);
  check_numbers("type", joint_kinds);
  check_numbers("type", force_kinds);
}
