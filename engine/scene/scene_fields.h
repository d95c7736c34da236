// The fields of a scene, one line each. JSON, binary form and rules follow from these lines and the types of the
// fields.
// SPDX-License-Identifier: MIT
//
// The order is that of the binary form and of JSON. A struct with a kind has two lists: fields of every kind, and own
// fields, which only some kinds have. The rows of the kinds (choices.h, joint_kinds.h) list their own fields and keys.
#pragma once

#include <functional>
#include <string_view>

#include "base/bytes.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine {

/// The properties of a field besides its type.
struct FieldInfo {
  std::string_view name;  // JSON key; empty: not in JSON
  FieldRange range{};
  const char* hint = "";    // if the value is out of range
  bool required = false;    // in JSON
  std::uint16_t since = 0;  // version of the binary form; older versions, and their JSON, mean the default
  static constexpr bool is_body = false;
  static constexpr bool is_joint = false;
};

/// The properties of a field that only some kinds have.
template <typename Field>
struct OwnField {
  Field own;
  std::string_view name;
  FieldRange range{};     // if the row of the kind has no other one
  bool is_body = false;   // an index in Scene::bodies; in JSON also a name
  bool is_joint = false;  // an index in Scene::joints; in JSON also a name
  static constexpr const char* hint = "";
};

/// The lists. `visit` takes a FieldInfo or OwnField, and a member, which std::invoke turns into a reference.
template <typename Struct>
struct Fields;

template <>
struct Fields<Bounds> {
  static void list(auto visit) {
    visit(FieldInfo{"lower", ranges::place, "", true}, &Bounds::lower);
    visit(FieldInfo{"upper", ranges::place, "", true}, &Bounds::upper);
  }
};

template <>
struct Fields<Filter> {
  static void list(auto visit) {
    visit(FieldInfo{"category", {0, 0xffffffffu}}, &Filter::category);
    visit(FieldInfo{"mask", {0, 0xffffffffu}}, &Filter::mask);
    visit(FieldInfo{"group", {-0x80000000LL, 0x7fffffff}}, &Filter::group);
  }
};

template <>
struct Fields<Shape> {
  static void list(auto visit) {
    const auto of_material = [](auto member) {
      return [member](auto& shape) -> auto& {
        return shape.material.*member;
      };
    };
    visit(FieldInfo{"density", ranges::mass, "kg/m^2; a body that states its mass needs no density"}, &Shape::density);
    visit(FieldInfo{"friction", ranges::coefficient}, of_material(&Material::friction));
    visit(FieldInfo{"restitution", {0, 1}}, of_material(&Material::restitution));
    visit(FieldInfo{"tangent_speed", ranges::speed}, of_material(&Material::tangent_speed));
    visit(FieldInfo{"rolling_resistance", ranges::coefficient}, of_material(&Material::rolling_resistance));
    visit(FieldInfo{"filter"}, &Shape::filter);
    visit(FieldInfo{"sensor"}, &Shape::sensor);
  }
  using Own = OwnField<ShapeField>;
  static void own(auto visit) {
    visit(Own{ShapeField::center, "center", ranges::anchor}, &Shape::center);
    visit(Own{ShapeField::angle, "angle", ranges::angle}, &Shape::angle);
    visit(Own{ShapeField::half_size, "half_size", ranges::size}, &Shape::half_size);
    visit(Own{ShapeField::vertices, "vertices", {0, limits::polygon_vertex_count_max}}, &Shape::vertices);
    visit(Own{ShapeField::radius, "radius", {0, limits::size_max_m}}, &Shape::radius);
    visit(Own{ShapeField::loop, "loop"}, &Shape::loop);
  }
};

template <>
struct Fields<ExplicitMass> {
  static void list(auto visit) {
    visit(FieldInfo{"mass", ranges::mass}, &ExplicitMass::mass);
    visit(FieldInfo{"inertia", ranges::inertia}, &ExplicitMass::inertia);
    visit(FieldInfo{"center_of_mass", ranges::anchor}, &ExplicitMass::center);
  }
};

template <>
struct Fields<Body> {
  static void list(auto visit) {
    visit(FieldInfo{"name"}, &Body::name);
    visit(FieldInfo{"type"}, &Body::type);
    visit(FieldInfo{"position", ranges::place}, &Body::position);
    visit(FieldInfo{"angle", ranges::angle}, &Body::angle);
    visit(FieldInfo{"velocity", ranges::speed}, &Body::velocity);
    visit(FieldInfo{"angular_velocity", ranges::speed}, &Body::angular_velocity);
    visit(FieldInfo{"linear_damping", ranges::coefficient}, &Body::linear_damping);
    visit(FieldInfo{"angular_damping", ranges::coefficient}, &Body::angular_damping);
    visit(FieldInfo{"gravity_scale", {-coefficient_max, coefficient_max}}, &Body::gravity_scale);
    visit(FieldInfo{"fixed_rotation"}, &Body::fixed_rotation);
    visit(FieldInfo{"bullet"}, &Body::bullet);
    visit(FieldInfo{"can_sleep"}, &Body::can_sleep);
    visit(FieldInfo{"mass"}, &Body::mass);  // in JSON its fields are fields of the body
    visit(FieldInfo{"shapes", {1, limits::shape_count_per_body_max}}, &Body::shapes);
  }
};

template <>
struct Fields<JointMotor> {
  static void list(auto visit) {
    visit(FieldInfo{"speed", ranges::speed}, &JointMotor::speed);
    visit(FieldInfo{"force_max", ranges::force_limit, "", true}, &JointMotor::force_max);
  }
};

/// `own`: the value of `absolute` for which a field is used.
template <>
struct Fields<JointSpring> {
  using Own = OwnField<bool>;
  static void own(auto visit) {
    visit(Own{false, "hertz", ranges::coefficient}, &JointSpring::hertz);
    visit(Own{false, "damping_ratio", ranges::coefficient}, &JointSpring::damping_ratio);
    visit(Own{true, "stiffness", ranges::stiffness}, &JointSpring::stiffness);
    visit(Own{true, "damping", ranges::stiffness}, &JointSpring::damping);
  }
};

template <>
struct Fields<Joint> {
  static void list(auto visit) { visit(FieldInfo{"name"}, &Joint::name); }
  using Own = OwnField<JointField>;
  static void own(auto visit) {
    visit(Own{JointField::body_a, "body_a", {}, true}, &Joint::body_a);
    visit(Own{JointField::body_b, "body_b", {}, true}, &Joint::body_b);
    visit(Own{JointField::anchor_a, "anchor_a", ranges::anchor}, &Joint::anchor_a);
    visit(Own{JointField::anchor_b, "anchor_b", ranges::anchor}, &Joint::anchor_b);
    visit(Own{JointField::axis, "axis", ranges::place}, &Joint::axis);
    visit(Own{JointField::reference_angle, "reference_angle", ranges::angle}, &Joint::reference_angle);
    visit(Own{JointField::length, "length", ranges::length}, &Joint::length);
    visit(Own{JointField::limits, "limits"}, &Joint::limits);
    visit(Own{JointField::motor, "motor"}, &Joint::motor);
    visit(Own{JointField::spring, "spring"}, &Joint::spring);
    visit(Own{JointField::linear_spring, "linear_spring"}, &Joint::linear_spring);
    visit(Own{JointField::offset, "offset", ranges::place}, &Joint::offset);
    visit(Own{JointField::angle_offset, "angle_offset", ranges::angle}, &Joint::angle_offset);
    visit(Own{JointField::force_max, "force_max", ranges::force_limit}, &Joint::force_max);
    visit(Own{JointField::torque_max, "torque_max", ranges::force_limit}, &Joint::torque_max);
    visit(Own{JointField::collide_connected, "collide_connected"}, &Joint::collide_connected);
    visit(Own{JointField::ground_anchor_a, "ground_anchor_a", ranges::place}, &Joint::ground_anchor_a);
    visit(Own{JointField::ground_anchor_b, "ground_anchor_b", ranges::place}, &Joint::ground_anchor_b);
    visit(Own{JointField::ratio, "ratio", {1e-3, 1e3}}, &Joint::ratio);
    visit(Own{JointField::joint_a, "joint_a", {}, false, true}, &Joint::joint_a);
    visit(Own{JointField::joint_b, "joint_b", {}, false, true}, &Joint::joint_b);
  }
};

template <>
struct Fields<Force> {
  static void list(auto visit) { visit(FieldInfo{"name"}, &Force::name); }
  using Own = OwnField<ForceField>;
  static void own(auto visit) {
    visit(Own{ForceField::body, "body", {}, true}, &Force::body);
    visit(Own{ForceField::other, "other", {}, true}, &Force::other);
    visit(Own{ForceField::anchor, "anchor", ranges::anchor}, &Force::anchor);
    visit(Own{ForceField::point, "point", ranges::place}, &Force::point);
    visit(Own{ForceField::vector, "vector", ranges::force}, &Force::vector);
    visit(Own{ForceField::torque, "torque", ranges::force}, &Force::torque);
    visit(Own{ForceField::coefficient, "coefficient", ranges::stiffness}, &Force::coefficient);
    visit(Own{ForceField::angular_coefficient, "angular_coefficient", ranges::stiffness}, &Force::angular_coefficient);
    visit(Own{ForceField::exponent, "exponent", {-3, 3}}, &Force::exponent);
    visit(Own{ForceField::stiffness, "stiffness", ranges::stiffness}, &Force::stiffness);
    visit(Own{ForceField::damping, "damping", ranges::stiffness}, &Force::damping);
    visit(Own{ForceField::rest_length, "rest_length", ranges::length}, &Force::rest_length);
  }
};

template <>
struct Fields<ClockSettings> {
  using Own = OwnField<ClockField>;
  static void own(auto visit) {
    visit(Own{ClockField::ticks_per_frame_max, "ticks_per_frame_max", {1, limits::ticks_per_frame_max}},
          &ClockSettings::ticks_per_frame_max);
    visit(Own{ClockField::tolerance, "tolerance", {1e-12, 1}}, &ClockSettings::tolerance);
    visit(Own{ClockField::dt_min, "dt_min", ranges::dt}, &ClockSettings::dt_min);
    visit(Own{ClockField::dt_max, "dt_max", ranges::dt}, &ClockSettings::dt_max);
  }
};

template <>
struct Fields<SleepSettings> {
  static void list(auto visit) {
    visit(FieldInfo{"after", ranges::coefficient}, &SleepSettings::after_s);
    visit(FieldInfo{"speed_max", {0, limits::speed_max}}, &SleepSettings::speed_max);
  }
};

template <>
struct Fields<AutoSubsteps> {
  static void list(auto visit) {
    visit(FieldInfo{"target_error", {1e-6, 0.1}}, &AutoSubsteps::target_error);
    visit(FieldInfo{"most", ranges::substeps}, &AutoSubsteps::substeps_max);
  }
};

template <>
struct Fields<PointerSettings> {
  static void list(auto visit) {
    visit(FieldInfo{"spawns", {0, limits::prototype_count_max}}, &PointerSettings::spawns);
    visit(FieldInfo{"hertz", {1e-6, coefficient_max}}, &PointerSettings::hertz);
    visit(FieldInfo{"damping_ratio", ranges::coefficient}, &PointerSettings::damping_ratio);
    visit(FieldInfo{"force_max_per_kg", {1e-6, 1e15}}, &PointerSettings::force_max_per_kg);
    visit(FieldInfo{"window"}, &PointerSettings::window);
  }
};

template <>
struct Fields<Settings> {
  static void list(auto visit) {
    visit(FieldInfo{"precision"}, &Settings::precision);
    visit(FieldInfo{"dt", ranges::dt, "seconds per tick, such as 1/60"}, &Settings::dt);
    visit(FieldInfo{"substeps", ranges::substeps}, &Settings::substeps);
    visit(FieldInfo{""}, &Settings::auto_substeps);  // in JSON a form of `substeps`
    visit(FieldInfo{"iterations", {1, limits::iteration_count_max}}, &Settings::iterations);
    visit(FieldInfo{"solver"}, &Settings::solver);
    visit(FieldInfo{"integrator"}, &Settings::integrator);
    visit(FieldInfo{"broad_phase"}, &Settings::broad_phase);
    visit(FieldInfo{"friction_mix"}, &Settings::friction_mix);
    visit(FieldInfo{"restitution_mix"}, &Settings::restitution_mix);
    visit(FieldInfo{"restitution_threshold", {0, limits::speed_max}}, &Settings::restitution_threshold);
    visit(FieldInfo{"locate_impacts"}, &Settings::locate_impacts);
    visit(FieldInfo{"continuous"}, &Settings::continuous);
    visit(FieldInfo{"sleep"}, &Settings::sleep);
    visit(FieldInfo{"events"}, &Settings::events);
    visit(FieldInfo{"clock"}, &Settings::clock);
    visit(FieldInfo{"joints", {}, "", false, 3}, &Settings::joints);
    visit(FieldInfo{"substep_loads", {}, "", false, 4}, &Settings::substep_loads);
    visit(FieldInfo{"substep_budget", ranges::substep_budget, "", false, 6}, &Settings::substep_budget);
  }
};

template <>
struct Fields<Scene> {
  static void list(auto visit) {
    visit(FieldInfo{"name"}, &Scene::name);
    visit(FieldInfo{"settings"}, &Scene::settings);
    visit(FieldInfo{"gravity", ranges::speed}, &Scene::gravity);  // JSON has it before the settings
    visit(FieldInfo{"bodies", {0, limits::body_count_max}}, &Scene::bodies);
    visit(FieldInfo{"joints", {0, limits::joint_count_max}}, &Scene::joints);
    visit(FieldInfo{"forces", {0, limits::force_count_max}}, &Scene::forces);
    visit(FieldInfo{"prototypes", {0, limits::prototype_count_max}}, &Scene::prototypes);
    visit(FieldInfo{"inputs", {0, input_kinds.size()}}, &Scene::inputs);
    visit(FieldInfo{"pointer"}, &Scene::pointer);
    visit(FieldInfo{"bounds"}, &Scene::bounds);
    visit(FieldInfo{"spawned_max", {1, limits::body_count_max}}, &Scene::spawned_max);
  }
};

/// Calls visit(info, field...) for each field that every kind has, with this field of each object.
template <typename Visit, typename Struct, typename... Others>
void visit_fields(Visit visit, Struct& object, Others&... others) {
  Fields<std::remove_const_t<Struct>>::list([&](const FieldInfo& info, auto member) {
    visit(info, std::invoke(member, object), std::invoke(member, others)...);
  });
}

/// Calls visit(info, field...) for each field that only some kinds have.
template <typename Visit, typename Struct, typename... Others>
void visit_own_fields(Visit visit, Struct& object, Others&... others) {
  Fields<std::remove_const_t<Struct>>::own(
      [&](const auto& info, auto member) { visit(info, std::invoke(member, object), std::invoke(member, others)...); });
}

/// Whether two values of a field are equal. Numbers are compared by their bits, so that -0 differs from 0.
inline bool same_bits(double a, double b) {
  return bits_of(a) == bits_of(b);
}
inline bool same_bits(const Point& a, const Point& b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y);
}
template <typename Value>
bool same_bits(const Value& a, const Value& b) {
  return a == b;
}

}  // namespace ticktrue::engine
