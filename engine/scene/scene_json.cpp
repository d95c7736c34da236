// Reading scenes and inputs from JSON.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_json.h"

#include <map>
#include <optional>
#include <type_traits>
#include <utility>

#include "base/limits.h"
#include "engine/json/json_tree.h"
#include "engine/json/number_text.h"
#include "engine/math/trig.h"
#include "engine/scene/json_reader.h"
#include "engine/scene/scene_fields.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

/// Converts a point of the world to the frame of a body in its initial pose.
Point in_frame_of(const Body& body, const Point& point) {
  const SinCos rotation = pose_sin_cos(body.angle);
  const double x = point.x - body.position.x;
  const double y = point.y - body.position.y;
  return {rotation.cos * x + rotation.sin * y, rotation.cos * y - rotation.sin * x};
}

/// Reads a scene. The elements of its lists are read first, one at a time, in the order of the text, and then the rest.
/// Last, names of bodies and joints, points in world coordinates and settings that follow from bodies are resolved.
class SceneJsonReader : public JsonReader {
 public:
  SceneJsonReader(const std::string& source, Scene& scene)
      : JsonReader(source, ErrorCode::invalid_scene), scene_(scene) {}

  static std::vector<StreamedList> lists() {
    return {{"bodies", limits::body_count_max},
            {"prototypes", limits::prototype_count_max},
            {"joints", limits::joint_count_max},
            {"forces", limits::force_count_max}};
  }

  bool element(std::string_view list, std::size_t index, const JsonValue& value) {
    const JsonPath root, list_path{&root, list}, path{&list_path, {}, index};
    if (list == "bodies") return read(value, path, scene_.bodies.emplace_back());
    if (list == "prototypes") return read(value, path, scene_.prototypes.emplace_back());
    if (list == "joints") return read(value, path, scene_.joints.emplace_back());
    return read(value, path, scene_.forces.emplace_back());
  }

  /// Reads all but the elements of the lists.
  bool rest(const JsonValue& value) { return read(value, JsonPath{}, scene_) && resolve(); }

 private:
  using JsonReader::read;
  template <typename Value>
  static constexpr bool is_index =
      std::is_same_v<Value, std::uint32_t> || std::is_same_v<Value, std::optional<std::uint32_t>>;

  // ---- Fields ----

  /// A field whose type determines its reader.
  template <typename Info, typename Value>
  Field field(std::string_view key, const Info& info, Value& out, bool required) {
    if constexpr (is_index<Value>)
      if (info.is_body || info.is_joint) return index_field(key, out, required, info.is_joint);
    if constexpr (is_index<Value> || (std::is_integral_v<Value> && !std::is_same_v<Value, bool>))
      return whole(key, info.range, out, required);
    else if constexpr (std::is_enum_v<Value>)
      return choice(key, Tables::of(out), out);
    else
      return {key, [this, &out](const JsonValue& v, const JsonPath& p) { return read(v, p, out); }, required};
  }
  template <typename Struct>
  void add_fields(std::vector<Field>& fields, Struct& out) {
    visit_fields(
        [&](const FieldInfo& info, auto& value) {
          if (!info.name.empty()) fields.push_back(field(info.name, info, value, info.required));
        },
        out);
  }
  template <typename Struct, typename Row>
  void add_own_fields(std::vector<Field>& fields, Struct& out, const Row& row) {
    for (const auto& entry : row.keys) {
      if (entry.key.empty()) break;
      visit_own_fields(
          [&](const auto& info, auto& value) {
            if (info.own == entry.field) fields.push_back(field(entry.key, info, value, entry.required));
          },
          out);
    }
  }
  template <typename Struct>
  std::vector<Field> fields_of(Struct& out) {
    std::vector<Field> fields;
    add_fields(fields, out);
    return fields;
  }

  static Field* find(std::vector<Field>& fields, std::string_view key) {
    for (Field& field : fields)
      if (field.key == key) return &field;
    return nullptr;
  }
  /// Sets `has` if the field is present. Does nothing without a field.
  static void note(Field* field, bool& has) {
    if (field == nullptr) return;
    field->read = [&has, read = std::move(field->read)](const JsonValue& v, const JsonPath& p) {
      return (has = true) && read(v, p);
    };
  }

  // ---- Values of any type ----

  template <typename Value>
  bool read(const JsonValue& value, const JsonPath& path, std::optional<Value>& out) {
    return read(value, path, out.emplace());
  }
  template <typename Value>
  bool read(const JsonValue& value, const JsonPath& path, std::vector<Value>& out) {
    return list(value, path, out,
                [this](const JsonValue& v, const JsonPath& p, Value& element) { return read(v, p, element); });
  }
  template <typename Struct>
  bool read(const JsonValue& value, const JsonPath& path, Struct& out) {
    return object(value, path, fields_of(out));
  }
  bool read(const JsonValue& value, const JsonPath& path, InputKind& out) {
    return choice(value, path, input_kinds, out);
  }

  // ---- Bodies ----

  bool read(const JsonValue& value, const JsonPath& path, Body& out) {
    ExplicitMass mass;
    bool has_mass = false;
    std::vector<Field> fields;
    visit_fields(
        [&](const FieldInfo& info, auto& field_value) {
          if constexpr (std::is_same_v<decltype(field_value), std::optional<ExplicitMass>&>)
            add_fields(fields, mass);
          else
            fields.push_back(field(info.name, info, field_value, info.required));
        },
        out);
    note(find(fields, "mass"), has_mass);
    if (!object(value, path, fields)) return false;
    if (has_mass) out.mass = mass;
    if (has_mass || (!mass.inertia && !mass.center)) return true;
    return fail(JsonPath{&path, mass.inertia ? "inertia" : "center_of_mass"},
                "needs a stated mass: found it without one", "add \"mass\", or let the shapes' densities decide");
  }

  bool read(const JsonValue& value, const JsonPath& path, Shape& out) {
    if (!kind_of(value, path, "type", shape_kinds, out.kind)) return false;
    std::vector<Field> fields{choice("type", shape_kinds, out.kind)};
    add_own_fields(fields, out, info_of(shape_kinds, out.kind));
    add_fields(fields, out);
    return object(value, path, fields);
  }

  // ---- Joints and forces ----

  /// A reference by name, resolved when all bodies and joints are known.
  struct NamedElement {
    bool of_joint = false;  // false: of a force
    bool is_joint = false;  // the name of a joint; false: of a body
    std::size_t index = 0;  // of the joint or force
    std::string_view key;
    std::string name;
  };
  /// An anchor in world coordinates, for both bodies of a joint.
  struct WorldAnchor {
    std::size_t joint = 0;
    Point point;
  };

  /// A body or joint given by index or name.
  template <typename Index>
  Field index_field(std::string_view key, Index& out, bool required, bool is_joint) {
    const auto read_index = [this, key, &out, is_joint](const JsonValue& v, const JsonPath& p) {
      const double count_max = is_joint ? limits::joint_count_max : limits::body_count_max;
      if (v.type == JsonValue::Type::number) return whole(v, p, {0, count_max - 1}, out);
      if (v.type != JsonValue::Type::text)
        return wrong_type(p, v, is_joint ? "the index or the name of a joint" : "the index or the name of a body");
      names_.push_back({p.parent->parent->key == "joints", is_joint, p.parent->index, key, v.text});
      return true;
    };
    return {key, read_index, required};
  }

  bool read(const JsonValue& value, const JsonPath& path, Joint& out) {
    if (!kind_of(value, path, "type", joint_kinds, out.kind)) return false;
    const JointKindInfo& row = info_of(joint_kinds, out.kind);
    std::vector<Field> fields{choice("type", joint_kinds, out.kind)};
    add_fields(fields, out);
    add_own_fields(fields, out, row);
    bool has_anchor = false, has_anchor_a = false, has_anchor_b = false;
    Point anchor;
    note(find(fields, "anchor_a"), has_anchor_a);
    note(find(fields, "anchor_b"), has_anchor_b);
    if (has_field(out.kind, JointField::anchor_b) && row.traits.has_one_anchor) {
      fields.push_back(field("anchor", FieldInfo{}, anchor, false));
      note(&fields.back(), has_anchor);
    }
    if (!object(value, path, fields)) return false;
    if (!has_anchor) return true;
    if (has_anchor_a || has_anchor_b)
      return fail(JsonPath{&path, "anchor"},
                  std::string("replaces the anchors in the bodies' frames: found ") +
                      (has_anchor_a ? "anchor_a" : "anchor_b") + " as well",
                  "give either anchor, in world coordinates, or anchor_a and anchor_b");
    anchors_.push_back({path.index, anchor});
    return true;
  }

  bool read(const JsonValue& value, const JsonPath& path, Range& out) {
    return pair(value, path, "[lower, upper]", out.lower, out.upper);
  }

  bool read(const JsonValue& value, const JsonPath& path, JointSpring& out) {
    bool relative = false;
    std::vector<Field> fields;
    visit_own_fields(
        [&](const auto& info, double& number_of_form) {
          fields.push_back(number(info.name, number_of_form));
          note(&fields.back(), info.own ? out.absolute : relative);
        },
        out);
    if (!object(value, path, fields)) return false;
    return relative != out.absolute ||
           fail(path, std::string("must be one of two forms: found ") + (relative ? "keys of both" : "no key") +
                          ", expected hertz and damping_ratio, or stiffness and damping");
  }

  bool read(const JsonValue& value, const JsonPath& path, Force& out) {
    if (!kind_of(value, path, "type", force_kinds, out.kind)) return false;
    std::vector<Field> fields{choice("type", force_kinds, out.kind)};
    add_fields(fields, out);
    add_own_fields(fields, out, info_of(force_kinds, out.kind));
    return object(value, path, fields);
  }

  template <typename Struct, typename Row>
  static void set_index(Struct& object, const Row& row, std::string_view key, std::uint32_t index) {
    visit_own_fields(
        [&](const auto& info, auto& value) {
          if constexpr (is_index<std::remove_reference_t<decltype(value)>>)
            if ((info.is_body || info.is_joint) && key_of(row, info.own) == key) value = index;
        },
        object);
  }

  using NameMap = std::map<std::string_view, std::uint32_t>;
  template <typename Element>
  NameMap names_of(const std::vector<Element>& elements) const {
    NameMap names;
    if (!names_.empty())
      for (std::size_t i = 0; i < elements.size(); ++i)
        if (!elements[i].name.empty()) names.emplace(elements[i].name, static_cast<std::uint32_t>(i));
    return names;
  }

  bool resolve() {
    const NameMap bodies = names_of(scene_.bodies), joints = names_of(scene_.joints);
    for (const NamedElement& named : names_) {
      const NameMap& elements = named.is_joint ? joints : bodies;
      const auto found = elements.find(named.name);
      if (found == elements.end())
        return named.is_joint ? unknown_name(named, scene_.joints, "joint")
                              : unknown_name(named, scene_.bodies, "body");
      if (named.of_joint) {
        Joint& joint = scene_.joints[named.index];
        set_index(joint, info_of(joint_kinds, joint.kind), named.key, found->second);
      } else {
        Force& force = scene_.forces[named.index];
        set_index(force, info_of(force_kinds, force.kind), named.key, found->second);
      }
    }
    for (const WorldAnchor& anchor : anchors_) {
      Joint& joint = scene_.joints[anchor.joint];
      const std::size_t count = scene_.bodies.size();
      if (joint.body_a >= count || joint.body_b >= count) continue;  // check_scene refuses the scene
      if (has_body_a(joint.kind)) joint.anchor_a = in_frame_of(scene_.bodies[joint.body_a], anchor.point);
      joint.anchor_b = in_frame_of(scene_.bodies[joint.body_b], anchor.point);
    }
    if (locates_by_restitution_) scene_.settings.locate_impacts = locates_bounces(scene_);
    return true;
  }

  template <typename Element>
  bool unknown_name(const NamedElement& named, const std::vector<Element>& elements, const std::string& what) {
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < elements.size() && known.size() < 16; ++i)
      if (!elements[i].name.empty()) known.push_back(elements[i].name);
    const JsonPath root, list{&root, named.of_joint ? "joints" : "forces"}, item{&list, {}, named.index};
    return fail(JsonPath{&item, named.key},
                "no " + what + " of the scene has this name: found " + in_quotes(shortened(named.name)) +
                    ", expected " + (known.empty() ? "none: no " + what + " has a name" : listed(known)),
                suggestion(named.name, known));
  }

  // ---- Settings and the rest ----

  /// A number of seconds, or a quotient of two numbers as text.
  bool dt(const JsonValue& value, const JsonPath& path, double& out) {
    if (value.type == JsonValue::Type::number) return read(value, path, out);
    if (value.type != JsonValue::Type::text)
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

  bool substeps(const JsonValue& value, const JsonPath& path, Settings& out) {
    if (value.type == JsonValue::Type::number) return whole(value, path, ranges::substeps, out.substeps);
    const bool is_auto = value.type == JsonValue::Type::text && value.text == "auto";
    if (!is_auto && value.type != JsonValue::Type::object)
      return wrong_type(path, value, "a number, \"auto\" or {\"least\", \"target_error\", \"most\"}");
    std::vector<Field> fields{whole("least", ranges::substeps, out.substeps)};
    add_fields(fields, out.auto_substeps.emplace());
    return is_auto || object(value, path, fields);
  }

  bool read(const JsonValue& value, const JsonPath& path, std::optional<SleepSettings>& out) {
    if (value.type != JsonValue::Type::boolean && value.type != JsonValue::Type::object)
      return wrong_type(path, value, "true, false or {\"after\", \"speed_max\"}");
    if (value.type == JsonValue::Type::boolean && !value.flag) return true;
    SleepSettings& sleep = out.emplace();
    return value.type == JsonValue::Type::boolean || read(value, path, sleep);
  }

  bool read(const JsonValue& value, const JsonPath& path, ClockSettings& out) {
    if (value.type != JsonValue::Type::object) return choice(value, path, clock_kinds, out.kind);
    if (!kind_of(value, path, "type", clock_kinds, out.kind)) return false;
    std::vector<Field> fields{choice("type", clock_kinds, out.kind)};
    add_own_fields(fields, out, info_of(clock_kinds, out.kind));
    return object(value, path, fields);
  }

  bool read(const JsonValue& value, const JsonPath& path, Settings& out) {
    bool has_substeps = false, has_joints = false, has_loads = false, has_budget = false;
    std::vector<Field> fields = fields_of(out);
    find(fields, "dt")->read = [&](const JsonValue& v, const JsonPath& p) { return dt(v, p, out.dt); };
    find(fields, "locate_impacts")->read = [&](const JsonValue& v, const JsonPath& p) {
      locates_by_restitution_ = v.type == JsonValue::Type::text && v.text == "auto";
      if (!locates_by_restitution_ && v.type != JsonValue::Type::boolean)
        return wrong_type(p, v, "true, false or \"auto\"");
      return locates_by_restitution_ || read(v, p, out.locate_impacts);
    };
    find(fields, "substeps")->read = [&](const JsonValue& v, const JsonPath& p) { return substeps(v, p, out); };
    note(find(fields, "substeps"), has_substeps);
    note(find(fields, "joints"), has_joints);
    note(find(fields, "substep_loads"), has_loads);
    note(find(fields, "substep_budget"), has_budget);
    if (!object(value, path, fields)) return false;
    if (!has_substeps && !info_of(solvers, out.solver).substeps) out.substeps = 1;
    if (!out.auto_substeps) return true;
    Settings chosen = out;
    choose_substeps(chosen);
    if (!has_joints) out.joints = chosen.joints;
    if (!has_loads) out.substep_loads = chosen.substep_loads;
    if (!has_budget) out.substep_budget = chosen.substep_budget;
    return true;
  }

  // The elements of these lists have been read before.
  bool read(const JsonValue& value, const JsonPath& path, std::vector<Body>&) { return is_array(value, path); }
  bool read(const JsonValue& value, const JsonPath& path, std::vector<Joint>&) { return is_array(value, path); }
  bool read(const JsonValue& value, const JsonPath& path, std::vector<Force>&) { return is_array(value, path); }
  bool is_array(const JsonValue& value, const JsonPath& path) {
    return value.type == JsonValue::Type::array || wrong_type(path, value, "an array");
  }

  bool read(const JsonValue& value, const JsonPath& path, Scene& out) {
    std::string schema;  // for editors; it does not affect the world
    std::vector<Field> fields{field("$schema", FieldInfo{}, schema, false)};
    add_fields(fields, out);
    std::swap(*find(fields, "settings"), *find(fields, "gravity"));
    return object(value, path, fields);
  }

  Scene& scene_;
  std::vector<NamedElement> names_;
  std::vector<WorldAnchor> anchors_;
  bool locates_by_restitution_ = false;  // `"locate_impacts": "auto"`
};

class InputReader : public JsonReader {
 public:
  explicit InputReader(const std::string& place) : JsonReader(place, ErrorCode::invalid_input) {}

  bool input(const JsonValue& value, const Scene& scene, Input& out) {
    const JsonPath path;
    if (!kind_of(value, path, "kind", input_kinds, out.kind)) return false;
    const InputInfo& info = info_of(input_kinds, out.kind);
    std::vector<Field> fields{whole("tick", {0, static_cast<double>(limits::tick_count_max - 1)}, out.tick, true),
                              whole("player", {0, limits::player_count_max - 1}, out.player),
                              choice("kind", input_kinds, out.kind)};
    if (info.has_body) fields.push_back(whole("body", {0, 0xfffffffeu}, out.body, true));
    if (info.has_prototype)
      fields.push_back({"prototype",
                        [&](const JsonValue& v, const JsonPath& p) { return prototype(v, p, scene, out.prototype); },
                        true});
    if (info.has_joint)
      fields.push_back(
          {"joint", [&](const JsonValue& v, const JsonPath& p) { return joint(v, p, scene, out.joint); }, true});
    for (std::size_t i = 0; i < info.value_count; ++i) fields.push_back(number(info.value_names[i], out.values[i]));
    return object(value, path, fields);
  }

 private:
  bool joint(const JsonValue& value, const JsonPath& path, const Scene& scene, std::uint32_t& out) {
    if (value.type == JsonValue::Type::number) return whole(value, path, {0, limits::joint_count_max - 1}, out);
    if (value.type != JsonValue::Type::text) return wrong_type(path, value, "the index or the name of a joint");
    return named(value, path, scene.joints, "joint", out);
  }

  bool prototype(const JsonValue& value, const JsonPath& path, const Scene& scene, std::uint16_t& out) {
    if (value.type != JsonValue::Type::text) return wrong_type(path, value, "the name of a prototype");
    return named(value, path, scene.prototypes, "prototype", out);
  }

  template <typename Element, typename Index>
  bool named(const JsonValue& value, const JsonPath& path, const std::vector<Element>& elements, const char* what,
             Index& out) {
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      if (elements[i].name.empty()) continue;
      if (elements[i].name == value.text) {
        out = static_cast<Index>(i);
        return true;
      }
      if (known.size() < 16) known.push_back(elements[i].name);
    }
    const std::string kind(what);
    return fail(path,
                "no " + kind + " of the scene has this name: found " + found_text(value) + ", expected " +
                    (known.empty() ? "none: the scene has no " + kind + "s with names" : listed(known)),
                suggestion(value.text, known));
  }
};

}  // namespace

Result<Scene> parse_scene(std::string_view json, const std::string& source) {
  if (json.size() > limits::scene_file_size_max)
    return Error{ErrorCode::limit,
                 source + ": too large: found " + std::to_string(json.size()) + " bytes, expected at most " +
                     std::to_string(limits::scene_file_size_max),
                 ""};
  Scene scene;
  SceneJsonReader reader(source, scene);
  const auto take = [&](std::string_view list, std::size_t index, const JsonValue& element) {
    return reader.element(list, index, element) ? Status{} : Status(reader.error());
  };
  const Result<JsonValue> tree = parse_json(json, source, ErrorCode::invalid_scene, SceneJsonReader::lists(), take);
  if (!tree) return tree.error();
  if (!reader.rest(*tree)) return reader.error();
  if (Status status = check_scene(scene, source); !status) return status.error();
  return scene;
}

Result<Input> parse_input(const Scene& scene, std::string_view line, const std::string& place) {
  if (line.size() > limits::input_line_size_max)
    return Error{ErrorCode::limit,
                 place + ": line too long: found " + std::to_string(line.size()) + " bytes, expected at most " +
                     std::to_string(limits::input_line_size_max),
                 ""};
  const Result<JsonValue> tree = parse_json(line, place, ErrorCode::invalid_input);
  if (!tree) return tree.error();
  Input input;
  InputReader reader(place);
  if (!reader.input(*tree, scene, input)) return reader.error();
  if (Status status = check_input(scene, input, place); !status) return status.error();
  return input;
}

}  // namespace ticktrue::engine
