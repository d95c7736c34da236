// Reading scenes and inputs from JSON.
// SPDX-License-Identifier: MIT
#include "engine/scene/scene_json.h"

#include <map>
#include <optional>
#include <utility>

#include "base/limits.h"
#include "engine/json/json_tree.h"
#include "engine/json/number_text.h"
#include "engine/math/trig.h"
#include "engine/scene/json_reader.h"
#include "engine/scene/scene_fields.h"

namespace ticktrue::engine {
namespace {

/// Of the world, in the frame of a body in its initial pose.
Point in_frame_of(const Body& body, const Point& point) {
  const SinCos rotation = pose_sin_cos(body.angle);
  const double x = point.x - body.position.x;
  const double y = point.y - body.position.y;
  return {rotation.cos * x + rotation.sin * y, rotation.cos * y - rotation.sin * x};
}

/// Reads a scene. Elements of its lists come first, one by one, in the order of the text; then the rest; then what
/// refers to bodies by name or is given in world coordinates is resolved.
class SceneReader : public JsonReader {
 public:
  SceneReader(const std::string& source, Scene& scene) : JsonReader(source, ErrorCode::invalid_scene), scene_(scene) {}

  static std::vector<StreamedList> lists() {
    return {{"bodies", limits::body_count_max},
            {"prototypes", limits::prototype_count_max},
            {"joints", limits::joint_count_max},
            {"forces", limits::force_count_max}};
  }

  bool element(std::string_view list, std::size_t index, const JsonValue& value) {
    const JsonPath root, list_path{&root, list}, path{&list_path, {}, index};
    if (list == "bodies") return body(value, path, scene_.bodies.emplace_back());
    if (list == "prototypes") return body(value, path, scene_.prototypes.emplace_back());
    if (list == "joints") return joint(value, path, scene_.joints.emplace_back());
    return force(value, path, scene_.forces.emplace_back());
  }

  /// All but the elements of the lists.
  bool rest(const JsonValue& value) { return scene(value, JsonPath{}, scene_) && resolve(); }

 private:
  /// A field that notes that it was there.
  static Field noted(bool& has, Field field) {
    return {field.key, [&has, read = std::move(field.read)](const JsonValue& v, const JsonPath& p) {
              return (has = true) && read(v, p);
            }};
  }

  // ---- Bodies ----

  bool body(const JsonValue& value, const JsonPath& path, Body& out) {
    ExplicitMass mass;
    bool has_mass = false, has_inertia = false, has_center = false;
    double inertia = 0;
    Point center;
    const auto shapes = [&](const JsonValue& v, const JsonPath& p) {
      return list(v, p, out.shapes,
                  [this](const JsonValue& sv, const JsonPath& sp, Shape& s) { return shape(sv, sp, s); });
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
                 flag("bullet", out.bullet),
                 flag("can_sleep", out.can_sleep),
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
    return fail(JsonPath{&path, has_inertia ? "inertia" : "center_of_mass"},
                "needs a stated mass: found it without one", "add \"mass\", or let the shapes' densities decide");
  }

  bool shape(const JsonValue& value, const JsonPath& path, Shape& out) {
    if (!kind_of(value, path, "type", shape_kinds, out.kind)) return false;
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
        fields.push_back(number("radius", out.radius));
        break;
      case ShapeKind::polygon:
        fields.push_back(points("vertices", out.vertices));
        fields.push_back(number("radius", out.radius));
        break;
      case ShapeKind::capsule:
        fields.push_back(points("points", out.vertices));
        fields.push_back(number("radius", out.radius, true));
        break;
      case ShapeKind::segment:
        fields.push_back(points("points", out.vertices));
        break;
      case ShapeKind::chain:
        fields.push_back(points("points", out.vertices));
        fields.push_back(flag("loop", out.loop));
        break;
    }
    fields.push_back(number("density", out.density));
    fields.push_back(number("friction", out.material.friction));
    fields.push_back(number("restitution", out.material.restitution));
    fields.push_back(number("tangent_speed", out.material.tangent_speed));
    fields.push_back(number("rolling_resistance", out.material.rolling_resistance));
    fields.push_back({"filter", [&](const JsonValue& v, const JsonPath& p) { return filter(v, p, out.filter); }});
    fields.push_back(flag("sensor", out.sensor));
    return object(value, path, fields);
  }

  bool filter(const JsonValue& value, const JsonPath& path, Filter& out) {
    return object(value, path,
                  {whole("category", 0, 0xffffffffu, out.category), whole("mask", 0, 0xffffffffu, out.mask),
                   whole("group", -0x80000000LL, 0x7fffffff, out.group)});
  }

  // ---- Joints and forces ----

  /// A reference by name, resolved when all bodies are known.
  struct NamedBody {
    bool of_joint = false;  // else of a force
    std::size_t index = 0;  // of the joint or force
    std::string_view key;
    std::string name;
    std::uint32_t Joint::*joint_body = nullptr;
    std::optional<std::uint32_t> Force::*force_body = nullptr;
  };
  /// An anchor in world coordinates, for both bodies of a joint.
  struct WorldAnchor {
    std::size_t joint = 0;
    Point point;
  };

  /// An index into `index`, or a name into `name`.
  bool reference(const JsonValue& value, const JsonPath& path, std::uint32_t& index, std::optional<std::string>& name) {
    if (value.type == JsonValue::Type::number) return whole(value, path, 0, limits::body_count_max - 1, index);
    if (value.type != JsonValue::Type::text) return wrong_type(path, value, "the index or the name of a body");
    name = value.text;
    return true;
  }

  bool joint(const JsonValue& value, const JsonPath& path, Joint& out) {
    if (!kind_of(value, path, "type", joint_kinds, out.kind)) return false;
    const JointKindInfo& row = info_of(joint_kinds, out.kind);
    std::vector<Field> fields{choice("type", joint_kinds, out.kind), text("name", out.name)};
    bool has_anchor = false, has_anchor_a = false, has_anchor_b = false;
    Point anchor;
    for (const auto& entry : row.keys) {
      if (entry.key.empty()) break;
      Field field;
      for_each_joint_field([&](JointField of_list, const char*, auto member, const FieldRange&) {
        if (of_list == entry.field) field = joint_field(entry.key, out, member);
      });
      if (entry.field == JointField::anchor_a) field = noted(has_anchor_a, std::move(field));
      if (entry.field == JointField::anchor_b) field = noted(has_anchor_b, std::move(field));
      field.required = entry.required;
      fields.push_back(std::move(field));
    }
    const bool one_point = has_field(out.kind, JointField::anchor_b) && row.traits.has_one_anchor;
    if (one_point) fields.push_back(noted(has_anchor, point("anchor", anchor)));
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

  Field joint_body(std::string_view key, Joint& out, std::uint32_t Joint::*body) {
    return {key, [this, key, &out, body](const JsonValue& v, const JsonPath& p) {
              std::optional<std::string> name;
              if (!reference(v, p, out.*body, name)) return false;
              if (name) names_.push_back({true, p.parent->index, key, *name, body, nullptr});
              return true;
            }};
  }

  // By the type of the field.
  Field joint_field(std::string_view key, Joint& out, std::uint32_t Joint::*body) { return joint_body(key, out, body); }
  Field joint_field(std::string_view key, Joint& out, Point Joint::*value) { return point(key, out.*value); }
  Field joint_field(std::string_view key, Joint& out, double Joint::*value) { return number(key, out.*value); }
  Field joint_field(std::string_view key, Joint& out, bool Joint::*value) { return flag(key, out.*value); }
  Field joint_field(std::string_view key, Joint& out, std::optional<Range> Joint::*value) {
    return {key, [this, &out, value](const JsonValue& v, const JsonPath& p) {
              Range& range = (out.*value).emplace();
              return pair(v, p, "[lower, upper]", range.lower, range.upper);
            }};
  }
  Field joint_field(std::string_view key, Joint& out, std::optional<JointMotor> Joint::*value) {
    return {key, [this, &out, value](const JsonValue& v, const JsonPath& p) {
              JointMotor& motor = (out.*value).emplace();
              return object(v, p, {number("speed", motor.speed), number("force_max", motor.force_max, true)});
            }};
  }
  Field joint_field(std::string_view key, Joint& out, std::optional<JointSpring> Joint::*value) {
    return {key, [this, &out, value](const JsonValue& v, const JsonPath& p) {
              return spring(v, p, (out.*value).emplace());
            }};
  }

  bool spring(const JsonValue& value, const JsonPath& path, JointSpring& out) {
    bool relative = false;
    if (!object(
            value, path,
            {noted(relative, number("hertz", out.hertz)), noted(relative, number("damping_ratio", out.damping_ratio)),
             noted(out.absolute, number("stiffness", out.stiffness)),
             noted(out.absolute, number("damping", out.damping))}))
      return false;
    return relative != out.absolute ||
           fail(path, std::string("must be one of two forms: found ") + (relative ? "keys of both" : "no key") +
                          ", expected hertz and damping_ratio, or stiffness and damping");
  }

  Field force_body(std::string_view key, Force& out, std::optional<std::uint32_t> Force::*body) {
    return {key, [this, key, &out, body](const JsonValue& v, const JsonPath& p) {
              std::optional<std::string> name;
              if (!reference(v, p, (out.*body).emplace(), name)) return false;
              if (name) names_.push_back({false, p.parent->index, key, *name, nullptr, body});
              return true;
            }};
  }

  bool force(const JsonValue& value, const JsonPath& path, Force& out) {
    if (!kind_of(value, path, "type", force_kinds, out.kind)) return false;
    std::vector<Field> fields{choice("type", force_kinds, out.kind), text("name", out.name)};
    for (const auto& entry : info_of(force_fields, out.kind).keys) {
      if (entry.key.empty()) break;
      fields.push_back(force_field(entry.field, entry.key, out));
      fields.back().required = entry.required;
    }
    return object(value, path, fields);
  }

  Field force_field(ForceField field, std::string_view key, Force& out) {
    switch (field) {
      case ForceField::body:
        return force_body(key, out, &Force::body);
      case ForceField::other:
        return force_body(key, out, &Force::other);
      case ForceField::anchor:
        return point(key, out.anchor);
      case ForceField::point:
        return point(key, out.point);
      case ForceField::vector:
        return point(key, out.vector);
      case ForceField::torque:
        return number(key, out.torque);
      case ForceField::coefficient:
        return number(key, out.coefficient);
      case ForceField::angular_coefficient:
        return number(key, out.angular_coefficient);
      case ForceField::exponent:
        return number(key, out.exponent);
      case ForceField::stiffness:
        return number(key, out.stiffness);
      case ForceField::damping:
        return number(key, out.damping);
      case ForceField::rest_length:
        return number(key, out.rest_length);
    }
    return {};
  }

  bool resolve() {
    std::map<std::string_view, std::uint32_t> bodies;
    if (!names_.empty())
      for (std::size_t i = 0; i < scene_.bodies.size(); ++i)
        if (!scene_.bodies[i].name.empty()) bodies.emplace(scene_.bodies[i].name, static_cast<std::uint32_t>(i));
    for (const NamedBody& named : names_) {
      const auto found = bodies.find(named.name);
      if (found == bodies.end()) return unknown_body(named);
      if (named.of_joint)
        scene_.joints[named.index].*named.joint_body = found->second;
      else
        scene_.forces[named.index].*named.force_body = found->second;
    }
    for (const WorldAnchor& anchor : anchors_) {
      Joint& joint = scene_.joints[anchor.joint];
      const std::size_t count = scene_.bodies.size();
      if (joint.body_a >= count || joint.body_b >= count) continue;  // refused by check_scene
      if (has_body_a(joint.kind)) joint.anchor_a = in_frame_of(scene_.bodies[joint.body_a], anchor.point);
      joint.anchor_b = in_frame_of(scene_.bodies[joint.body_b], anchor.point);
    }
    return true;
  }

  bool unknown_body(const NamedBody& named) {
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < scene_.bodies.size() && known.size() < 16; ++i)
      if (!scene_.bodies[i].name.empty()) known.push_back(scene_.bodies[i].name);
    const JsonPath root, list{&root, named.of_joint ? "joints" : "forces"}, item{&list, {}, named.index};
    return fail(JsonPath{&item, named.key},
                "no body of the scene has this name: found " + in_quotes(shortened(named.name)) + ", expected " +
                    (known.empty() ? "none: no body has a name" : listed(known)),
                suggestion(named.name, known));
  }

  // ---- Settings and the rest ----

  /// A number of seconds, or a quotient of two numbers as text.
  bool dt(const JsonValue& value, const JsonPath& path, double& out) {
    if (value.type == JsonValue::Type::number) return number(value, path, out);
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
    if (value.type == JsonValue::Type::number) return whole(value, path, 1, limits::substep_count_max, out.substeps);
    const bool is_auto = value.type == JsonValue::Type::text && value.text == "auto";
    if (!is_auto && value.type != JsonValue::Type::object)
      return wrong_type(path, value, "a number, \"auto\" or {\"least\", \"target_error\", \"most\"}");
    AutoSubsteps& automatic = out.auto_substeps.emplace();
    return is_auto || object(value, path,
                             {whole("least", 1, limits::substep_count_max, out.substeps),
                              number("target_error", automatic.target_error),
                              whole("most", 1, limits::substep_count_max, automatic.substeps_max)});
  }

  bool sleep(const JsonValue& value, const JsonPath& path, Settings& out) {
    if (value.type != JsonValue::Type::boolean && value.type != JsonValue::Type::object)
      return wrong_type(path, value, "true, false or {\"after\", \"speed_max\"}");
    if (value.type == JsonValue::Type::boolean && !value.flag) return true;
    SleepSettings& sleep = out.sleep.emplace();
    return value.type == JsonValue::Type::boolean ||
           object(value, path, {number("after", sleep.after_s), number("speed_max", sleep.speed_max)});
  }

  bool clock_settings(const JsonValue& value, const JsonPath& path, ClockSettings& out) {
    if (value.type != JsonValue::Type::object) return choice(value, path, clock_kinds, out.kind);
    if (!kind_of(value, path, "type", clock_kinds, out.kind)) return false;
    std::vector<Field> fields{choice("type", clock_kinds, out.kind)};
    for (const auto& entry : info_of(clock_fields, out.kind).keys) {
      if (entry.key.empty()) break;
      fields.push_back(clock_field(entry.field, entry.key, out));
    }
    return object(value, path, fields);
  }

  Field clock_field(ClockField field, std::string_view key, ClockSettings& out) {
    switch (field) {
      case ClockField::ticks_per_frame_max:
        return whole(key, 1, limits::ticks_per_frame_max, out.ticks_per_frame_max);
      case ClockField::tolerance:
        return number(key, out.tolerance);
      case ClockField::dt_min:
        return number(key, out.dt_min);
      case ClockField::dt_max:
        return number(key, out.dt_max);
    }
    return {};
  }

  bool settings(const JsonValue& value, const JsonPath& path, Settings& out) {
    bool has_substeps = false;
    const Field substeps_field{"substeps", [&](const JsonValue& v, const JsonPath& p) { return substeps(v, p, out); }};
    if (!object(value, path,
                {choice("precision", precisions, out.precision),
                 {"dt", [&](const JsonValue& v, const JsonPath& p) { return dt(v, p, out.dt); }},
                 noted(has_substeps, substeps_field),
                 whole("iterations", 1, limits::iteration_count_max, out.iterations),
                 choice("solver", solvers, out.solver),
                 choice("integrator", integrators, out.integrator),
                 choice("broad_phase", broad_phases, out.broad_phase),
                 choice("friction_mix", mix_rules, out.friction_mix),
                 choice("restitution_mix", mix_rules, out.restitution_mix),
                 number("restitution_threshold", out.restitution_threshold),
                 flag("locate_impacts", out.locate_impacts),
                 flag("continuous", out.continuous),
                 {"sleep", [&](const JsonValue& v, const JsonPath& p) { return sleep(v, p, out); }},
                 flag("events", out.events),
                 {"clock", [&](const JsonValue& v, const JsonPath& p) { return clock_settings(v, p, out.clock); }}}))
      return false;
    if (!has_substeps && !info_of(solvers, out.solver).substeps) out.substeps = 1;
    return true;
  }

  bool bounds(const JsonValue& value, const JsonPath& path, Bounds& out) {
    return object(value, path, {point("lower", out.lower, true), point("upper", out.upper, true)});
  }

  bool pointer(const JsonValue& value, const JsonPath& path, PointerSettings& out) {
    const auto spawns = [&](const JsonValue& v, const JsonPath& p) {
      return list(v, p, out.spawns,
                  [this](const JsonValue& nv, const JsonPath& np, std::string& name) { return text(nv, np, name); });
    };
    return object(
        value, path,
        {{"spawns", spawns},
         number("hertz", out.hertz),
         number("damping_ratio", out.damping_ratio),
         number("force_max_per_kg", out.force_max_per_kg),
         {"window", [&](const JsonValue& v, const JsonPath& p) { return bounds(v, p, out.window.emplace()); }}});
  }

  bool scene(const JsonValue& value, const JsonPath& path, Scene& out) {
    const auto taken = [this](const JsonValue& v, const JsonPath& p) {
      return v.type == JsonValue::Type::array || wrong_type(p, v, "an array");
    };
    const auto inputs = [&](const JsonValue& v, const JsonPath& p) {
      return list(v, p, out.inputs, [this](const JsonValue& kv, const JsonPath& kp, InputKind& kind) {
        return choice(kv, kp, input_kinds, kind);
      });
    };
    const auto spawned_max = [&](const JsonValue& v, const JsonPath& p) {
      std::uint32_t count = 0;
      if (!whole(v, p, 1, limits::body_count_max, count)) return false;
      out.spawned_max = count;
      return true;
    };
    std::string schema;  // for editors; says nothing about the world
    return object(
        value, path,
        {text("$schema", schema),
         text("name", out.name),
         point("gravity", out.gravity),
         {"settings", [&](const JsonValue& v, const JsonPath& p) { return settings(v, p, out.settings); }},
         {"bodies", taken},
         {"joints", taken},
         {"forces", taken},
         {"prototypes", taken},
         {"inputs", inputs},
         {"pointer", [&](const JsonValue& v, const JsonPath& p) { return pointer(v, p, out.pointer.emplace()); }},
         {"bounds", [&](const JsonValue& v, const JsonPath& p) { return bounds(v, p, out.bounds.emplace()); }},
         {"spawned_max", spawned_max}});
  }

  Scene& scene_;
  std::vector<NamedBody> names_;
  std::vector<WorldAnchor> anchors_;
};

class InputReader : public JsonReader {
 public:
  explicit InputReader(const std::string& place) : JsonReader(place, ErrorCode::invalid_input) {}

  bool input(const JsonValue& value, const Scene& scene, Input& out) {
    const JsonPath path;
    if (!kind_of(value, path, "kind", input_kinds, out.kind)) return false;
    const InputInfo& info = info_of(input_kinds, out.kind);
    std::vector<Field> fields{whole("tick", 0, static_cast<double>(limits::tick_count_max - 1), out.tick, true),
                              whole("player", 0, limits::player_count_max - 1, out.player),
                              choice("kind", input_kinds, out.kind)};
    if (info.has_body) fields.push_back(whole("body", 0, 0xfffffffeu, out.body, true));
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
    if (value.type == JsonValue::Type::number) return whole(value, path, 0, limits::joint_count_max - 1, out);
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
  SceneReader reader(source, scene);
  const auto take = [&](std::string_view list, std::size_t index, const JsonValue& element) {
    return reader.element(list, index, element) ? Status{} : Status(reader.error());
  };
  const Result<JsonValue> tree = parse_json(json, source, ErrorCode::invalid_scene, SceneReader::lists(), take);
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
