// Printing scenes and inputs as JSON.
// SPDX-License-Identifier: MIT
#include "base/bytes.h"
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
    const Scene& scene = scene_;
    const Settings& settings = scene.settings;
    text_ = "{\n  \"name\": " + in_quotes(scene.name) + ",\n  \"gravity\": ";
    point(scene.gravity);
    text_ += ",\n  \"settings\": ";
    open();
    name("precision", info_of(precisions, settings.precision).name);
    key("dt");
    dt(settings.dt);
    substeps(settings);
    number("iterations", settings.iterations);
    name("solver", info_of(solvers, settings.solver).name);
    name("integrator", info_of(integrators, settings.integrator).name);
    name("broad_phase", info_of(broad_phases, settings.broad_phase).name);
    name("friction_mix", info_of(mix_rules, settings.friction_mix).name);
    name("restitution_mix", info_of(mix_rules, settings.restitution_mix).name);
    number("restitution_threshold", settings.restitution_threshold);
    flag("locate_impacts", settings.locate_impacts);
    flag("continuous", settings.continuous);
    sleep(settings);
    flag("events", settings.events);
    clock_settings(settings.clock);
    close();
    elements("bodies", scene.bodies);
    if (!scene.joints.empty()) elements("joints", scene.joints);
    if (!scene.forces.empty()) elements("forces", scene.forces);
    if (!scene.prototypes.empty()) elements("prototypes", scene.prototypes);
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
  void flag(std::string_view name_of_key, bool value) {
    key(name_of_key);
    text_ += value ? "true" : "false";
  }
  void point(const Point& value) { text_ += "[" + number_json(value.x) + ", " + number_json(value.y) + "]"; }
  void point(std::string_view name_of_key, const Point& value) {
    key(name_of_key);
    point(value);
  }
  void point_unless_zero(std::string_view name_of_key, const Point& value) {
    if (bits_of(value.x) != 0 || bits_of(value.y) != 0) point(name_of_key, value);
  }
  void points(std::string_view name_of_key, const std::vector<Point>& values) {
    key(name_of_key);
    text_ += "[";
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i > 0) text_ += ", ";
      point(values[i]);
    }
    text_ += "]";
  }
  void dt(double value) {
    for (int n = 1; n <= 1000; ++n) {
      if (1.0 / n != value) continue;
      text_ += "\"1/" + std::to_string(n) + "\"";
      return;
    }
    text_ += number_json(value);
  }

  void substeps(const Settings& settings) {
    if (!settings.auto_substeps) return number("substeps", settings.substeps);
    key("substeps");
    open();
    number("least", settings.substeps);
    number("target_error", settings.auto_substeps->target_error);
    number("most", settings.auto_substeps->substeps_max);
    close();
  }

  void sleep(const Settings& settings) {
    if (!settings.sleep) return flag("sleep", false);
    key("sleep");
    open();
    number("after", settings.sleep->after_s);
    number("speed_max", settings.sleep->speed_max);
    close();
  }

  void clock_settings(const ClockSettings& clock) {
    key("clock");
    open();
    name("type", info_of(clock_kinds, clock.kind).name);
    for (const auto& entry : info_of(clock_fields, clock.kind).keys) {
      if (entry.key.empty()) break;
      switch (entry.field) {
        case ClockField::ticks_per_frame_max:
          number(entry.key, clock.ticks_per_frame_max);
          break;
        case ClockField::tolerance:
          number(entry.key, clock.tolerance);
          break;
        case ClockField::dt_min:
          number(entry.key, clock.dt_min);
          break;
        case ClockField::dt_max:
          number(entry.key, clock.dt_max);
          break;
      }
    }
    close();
  }

  template <typename Element>
  void elements(std::string_view list, const std::vector<Element>& elements) {
    text_ += ",\n  " + in_quotes(list) + ": [";
    for (std::size_t i = 0; i < elements.size(); ++i) {
      text_ += i == 0 ? "\n    " : ",\n    ";
      element(elements[i]);
    }
    text_ += elements.empty() ? "]" : "\n  ]";
  }

  template <typename Element>
  std::string name_or_index(const std::vector<Element>& elements, std::uint32_t index) const {
    const bool has_name = index < elements.size() && !elements[index].name.empty();
    return has_name ? in_quotes(elements[index].name) : std::to_string(index);
  }
  void reference(std::string_view name_of_key, std::uint32_t body) {
    key(name_of_key);
    text_ += name_or_index(scene_.bodies, body);
  }

  void element(const Joint& joint) {
    const Joint unset;
    open();
    name("type", info_of(joint_kinds, joint.kind).name);
    if (!joint.name.empty()) name("name", joint.name);
    for (const FieldKey<JointField>& entry : info_of(joint_kinds, joint.kind).keys) {
      if (entry.key.empty()) break;
      for_each_joint_field([&](JointField field, const char*, auto member, const FieldRange&) {
        if (field == entry.field) joint_value(entry, joint.*member, unset.*member);
      });
    }
    close();
  }

  using JointKey = FieldKey<JointField>;
  void joint_value(const JointKey& entry, std::uint32_t body, std::uint32_t) { reference(entry.key, body); }
  void joint_value(const JointKey& entry, const Point& value, const Point&) {
    entry.required ? point(entry.key, value) : point_unless_zero(entry.key, value);
  }
  void joint_value(const JointKey& entry, double value, double unset) {
    entry.required ? number(entry.key, value) : number(entry.key, value, unset);
  }
  void joint_value(const JointKey& entry, bool value, bool) {
    if (value) flag(entry.key, true);
  }
  void joint_value(const JointKey& entry, const std::optional<Range>& value, const std::optional<Range>&) {
    if (value) point(entry.key, {value->lower, value->upper});
  }
  void joint_value(const JointKey& entry, const std::optional<JointMotor>& value, const std::optional<JointMotor>&) {
    if (value) motor(entry.key, *value);
  }
  void joint_value(const JointKey& entry, const std::optional<JointSpring>& value, const std::optional<JointSpring>&) {
    if (value) spring(entry.key, *value);
  }

  void motor(std::string_view name_of_key, const JointMotor& motor) {
    key(name_of_key);
    open();
    number("speed", motor.speed);
    number("force_max", motor.force_max);
    close();
  }

  void spring(std::string_view name_of_key, const JointSpring& spring) {
    key(name_of_key);
    open();
    number(spring.absolute ? "stiffness" : "hertz", spring.absolute ? spring.stiffness : spring.hertz);
    number(spring.absolute ? "damping" : "damping_ratio", spring.absolute ? spring.damping : spring.damping_ratio);
    close();
  }

  void element(const Force& force) {
    const Force unset;
    open();
    name("type", info_of(force_kinds, force.kind).name);
    if (!force.name.empty()) name("name", force.name);
    for (const auto& [field, key_name, required] : info_of(force_fields, force.kind).keys) {
      if (key_name.empty()) break;
      const auto value = [&, key_name = key_name, required = required](double is, double default_value) {
        required ? number(key_name, is) : number(key_name, is, default_value);
      };
      const auto vector = [&, key_name = key_name, required = required](const Point& is) {
        required ? point(key_name, is) : point_unless_zero(key_name, is);
      };
      switch (field) {
        case ForceField::body:
          if (force.body) reference(key_name, *force.body);
          break;
        case ForceField::other:
          if (force.other) reference(key_name, *force.other);
          break;
        case ForceField::anchor:
          vector(force.anchor);
          break;
        case ForceField::point:
          vector(force.point);
          break;
        case ForceField::vector:
          vector(force.vector);
          break;
        case ForceField::torque:
          value(force.torque, unset.torque);
          break;
        case ForceField::coefficient:
          value(force.coefficient, unset.coefficient);
          break;
        case ForceField::angular_coefficient:
          value(force.angular_coefficient, unset.angular_coefficient);
          break;
        case ForceField::exponent:
          value(force.exponent, unset.exponent);
          break;
        case ForceField::stiffness:
          value(force.stiffness, unset.stiffness);
          break;
        case ForceField::damping:
          value(force.damping, unset.damping);
          break;
        case ForceField::rest_length:
          value(force.rest_length, unset.rest_length);
          break;
      }
    }
    close();
  }

  void element(const Body& body) {
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
    if (body.fixed_rotation) flag("fixed_rotation", true);
    if (body.bullet) flag("bullet", true);
    if (!body.can_sleep) flag("can_sleep", false);
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
        points("vertices", shape.vertices);
        break;
      case ShapeKind::capsule:
        points("points", shape.vertices);
        number("radius", shape.radius);
        break;
      case ShapeKind::segment:
        points("points", shape.vertices);
        break;
      case ShapeKind::chain:
        points("points", shape.vertices);
        if (shape.loop) flag("loop", true);
        break;
    }
    if (shape.kind == ShapeKind::box || shape.kind == ShapeKind::polygon) number("radius", shape.radius, unset.radius);
    number("density", shape.density, unset.density);
    number("friction", shape.material.friction, unset.material.friction);
    number("restitution", shape.material.restitution, unset.material.restitution);
    number("tangent_speed", shape.material.tangent_speed, unset.material.tangent_speed);
    number("rolling_resistance", shape.material.rolling_resistance, unset.material.rolling_resistance);
    if (shape.filter != unset.filter) filter(shape.filter);
    if (shape.sensor) flag("sensor", true);
    close();
  }

  void filter(const Filter& filter) {
    key("filter");
    open();
    number("category", filter.category);
    number("mask", filter.mask);
    number("group", filter.group);
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
