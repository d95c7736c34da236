// The rules of a scene, and what follows from it for the pipeline.
// SPDX-License-Identifier: MIT
#include "engine/scene.h"

#include <map>
#include <string_view>
#include <utility>

#include "base/limits.h"
#include "engine/geometry/hull.h"
#include "engine/number_text.h"

namespace ticktrue::engine {
namespace {

// Limits of this file's own. All leave room in f32, whose numbers end at 1e-38 and 3e38.
constexpr double angle_max_rad = 1e6;      // sin_cos is exact to its last digits up to here
constexpr double coefficient_max = 1e9;    // friction, damping ratios, hertz, scales: anything larger means "endless"
constexpr double inertia_min = 1e-30;      // kg m^2
constexpr double inertia_max = 1e30;       // kg m^2
constexpr double force_per_kg_max = 1e15;  // N/kg

bool is_finite(double value) {
  return value - value == 0;
}

template <typename Table, typename Kind>
bool is_row(const Table& table, Kind kind) {
  return static_cast<std::size_t>(kind) < table.size();
}

bool declares(const Scene& scene, InputKind kind) {
  for (const InputKind declared : scene.inputs)
    if (declared == kind) return true;
  return false;
}

/// "a, b or c" of the rows for which `wanted` holds.
template <typename Table, typename Predicate>
std::string names_where(const Table& table, Predicate wanted) {
  std::string text, last;
  for (const auto& row : table) {
    if (!wanted(row)) continue;
    if (!last.empty()) text += (text.empty() ? "" : ", ") + last;
    last = row.name;
  }
  return text.empty() ? last : text + " or " + last;
}

/// Valid UTF-8 without control characters: what can be printed and stored in JSON as it is.
bool is_printable(std::string_view text) {
  std::size_t i = 0;
  while (i < text.size()) {
    const auto lead = static_cast<unsigned char>(text[i++]);
    if (lead < 0x20 || lead == 0x7f) return false;
    if (lead < 0x80) continue;
    const int follow_count = lead >= 0xc2 && lead < 0xe0   ? 1
                             : lead >= 0xe0 && lead < 0xf0 ? 2
                             : lead >= 0xf0 && lead < 0xf5 ? 3
                                                           : 0;
    if (follow_count == 0) return false;
    std::uint32_t code = lead & (0x3fu >> follow_count);
    for (int k = 0; k < follow_count; ++k, ++i) {
      if (i == text.size() || (static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) return false;
      code = code << 6 | (static_cast<unsigned char>(text[i]) & 0x3fu);
    }
    const bool overlong = (follow_count == 2 && code < 0x800) || (follow_count == 3 && code < 0x10000);
    if (overlong || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff) return false;
  }
  return true;
}

/// Walks a scene and keeps the first rule broken. Places are put together only then: scenes have many bodies.
class Checker {
 public:
  Checker(const Scene& scene, const std::string& source) : scene_(scene), source_(source) {}

  Status run() {
    const bool good = check_counts() && check_settings() && check_bodies(scene_.bodies, "bodies") &&
                      check_bodies(scene_.prototypes, "prototypes") && check_inputs() && check_pointer() &&
                      check_bounds() && check_joint_bodies() && check_choices() && check_built();
    if (good) return {};
    return error_;
  }

 private:
  std::string place(const std::string& key) const {
    std::string text = source_ + ": ";
    if (list_ != nullptr) {
      text += std::string(list_) + "[" + std::to_string(body_index_) + "]";
      if (shape_index_ != no_shape) text += ".shapes[" + std::to_string(shape_index_) + "]";
      if (!key.empty()) text += ".";
    }
    return text + key;
  }

  bool fail(ErrorCode code, const std::string& key, const std::string& what, std::string hint = {}) {
    error_ = Error{code, place(key) + ": " + what, std::move(hint)};
    return false;
  }
  bool refuse(const std::string& key, const std::string& what, std::string hint = {}) {
    return fail(ErrorCode::invalid_scene, key, what, std::move(hint));
  }

  /// `index` >= 0: an element of the array `key`.
  bool number(const char* key, double value, double min, double max, int index = -1, const char* hint = "") {
    if (value >= min && value <= max) return true;
    const std::string name = index < 0 ? std::string(key) : std::string(key) + "[" + std::to_string(index) + "]";
    const char* what = !is_finite(value)       ? "must be finite"
                       : min > 0 && value <= 0 ? "must be > 0"
                       : min == 0 && value < 0 ? "must be >= 0"
                                               : "out of range";
    return refuse(name,
                  std::string(what) + ": found " + number_text(value) + ", expected " + number_text(min) + ".." +
                      number_text(max),
                  hint);
  }
  bool point(const char* key, const Point& value, double max) {
    return number(key, value.x, -max, max, 0) && number(key, value.y, -max, max, 1);
  }

  bool name(const char* key, const std::string& value) {
    if (value.size() > limits::name_size_max)
      return fail(ErrorCode::limit, key,
                  "too long: found " + std::to_string(value.size()) + " bytes, expected at most " +
                      std::to_string(limits::name_size_max));
    if (!is_printable(value)) return refuse(key, "must be UTF-8 without control characters: found other bytes");
    return true;
  }

  bool check_counts() {
    if (!name("name", scene_.name)) return false;
    const auto count = [&](const char* key, std::size_t found, std::size_t max) {
      return found <= max ||
             fail(ErrorCode::limit, key,
                  "too many: found " + std::to_string(found) + ", expected at most " + std::to_string(max));
    };
    if (!count("bodies", scene_.bodies.size(), limits::body_count_max) ||
        !count("prototypes", scene_.prototypes.size(), limits::prototype_count_max))
      return false;
    if (scene_.bodies.empty() && scene_.prototypes.empty())
      return refuse("bodies", "nothing to simulate: found no body and no prototype, expected at least one");
    return true;
  }

  bool check_settings() {
    const Settings& settings = scene_.settings;
    const auto row = [&](const char* key, const auto& table, auto kind) {
      return is_row(table, kind) || refuse(key, "unknown: found number " + std::to_string(static_cast<unsigned>(kind)) +
                                                    ", expected " + choice_names(table));
    };
    return row("settings.precision", precisions, settings.precision) &&
           row("settings.solver", solvers, settings.solver) &&
           row("settings.integrator", integrators, settings.integrator) &&
           row("settings.broad_phase", broad_phases, settings.broad_phase) &&
           row("settings.friction_mix", mix_rules, settings.friction_mix) &&
           row("settings.restitution_mix", mix_rules, settings.restitution_mix) &&
           number("settings.dt", settings.dt, limits::dt_min_s, limits::dt_max_s, -1,
                  "seconds per tick, such as 1/60") &&
           number("settings.substeps", settings.substeps, 1, limits::substep_count_max) &&
           number("settings.restitution_threshold", settings.restitution_threshold, 0, limits::speed_max) &&
           point("gravity", scene_.gravity, limits::speed_max);
  }

  bool check_bodies(const std::vector<Body>& bodies, const char* list) {
    const bool is_prototype = &bodies == &scene_.prototypes;
    std::map<std::string_view, std::size_t> names;
    list_ = list;
    for (body_index_ = 0; body_index_ < bodies.size(); ++body_index_) {
      const Body& body = bodies[body_index_];
      if (!check_body(body)) return false;
      if (is_prototype && !check_prototype(body)) return false;
      if (body.name.empty()) continue;
      const auto [at, is_new] = names.emplace(body.name, body_index_);
      if (!is_new)
        return refuse("name",
                      "must be unique: found \"" + body.name + "\", which " + list + "[" + std::to_string(at->second) +
                          "] has already",
                      "leave a name out where none is needed");
    }
    list_ = nullptr;
    return true;
  }

  bool check_prototype(const Body& body) {
    if (body.name.empty()) return refuse("name", "a prototype needs a name: found none", "inputs spawn it by its name");
    const Body unset;
    if (body.position != unset.position) return refuse("position", "is the input's to give: found one in a prototype");
    if (body.angle != 0) return refuse("angle", "is the input's to give: found one in a prototype");
    if (body.velocity != unset.velocity) return refuse("velocity", "is the input's to give: found one in a prototype");
    if (body.angular_velocity != 0)
      return refuse("angular_velocity", "is the input's to give: found one in a prototype");
    return true;
  }

  bool check_body(const Body& body) {
    if (!name("name", body.name)) return false;
    if (!is_row(body_types, body.type))
      return refuse("type", "unknown: found number " + std::to_string(static_cast<unsigned>(body.type)) +
                                ", expected " + choice_names(body_types));
    if (!point("position", body.position, limits::coordinate_max_m) ||
        !number("angle", body.angle, -angle_max_rad, angle_max_rad) ||
        !point("velocity", body.velocity, limits::speed_max) ||
        !number("angular_velocity", body.angular_velocity, -limits::speed_max, limits::speed_max) ||
        !number("linear_damping", body.linear_damping, 0, coefficient_max) ||
        !number("angular_damping", body.angular_damping, 0, coefficient_max) ||
        !number("gravity_scale", body.gravity_scale, -coefficient_max, coefficient_max))
      return false;
    if (body.type == BodyType::static_body) {
      if (body.velocity != Point{})
        return refuse("velocity", "a static body never moves: found one", "make it kinematic");
      if (body.angular_velocity != 0)
        return refuse("angular_velocity", "a static body never moves: found one", "make it kinematic");
    }
    if (body.mass && !check_mass(body)) return false;

    if (body.shapes.empty()) return refuse("shapes", "a body needs a shape: found none, expected at least one");
    if (body.shapes.size() > limits::shape_count_per_body_max)
      return fail(ErrorCode::limit, "shapes",
                  "too many: found " + std::to_string(body.shapes.size()) + ", expected at most " +
                      std::to_string(limits::shape_count_per_body_max),
                  "spread them over several bodies");
    for (shape_index_ = 0; shape_index_ < body.shapes.size(); ++shape_index_)
      if (!check_shape(body.shapes[shape_index_])) return false;
    shape_index_ = no_shape;
    return body.type != BodyType::dynamic_body || check_resulting_mass(body);
  }

  bool check_mass(const Body& body) {
    if (body.type != BodyType::dynamic_body)
      return refuse("mass",
                    "only dynamic bodies have a mass: found " + number_text(body.mass->mass) + " kg of a " +
                        std::string(info_of(body_types, body.type).name) + " body",
                    "leave it out, or make the body dynamic");
    if (!number("mass", body.mass->mass, limits::mass_min_kg, limits::mass_max_kg)) return false;
    if (body.mass->inertia && !number("inertia", *body.mass->inertia, inertia_min, inertia_max)) return false;
    return !body.mass->center || point("center_of_mass", *body.mass->center, limits::size_max_m);
  }

  bool check_resulting_mass(const Body& body) {
    const MassProperties mass = body_mass(body);
    if (!(mass.mass >= limits::mass_min_kg && mass.mass <= limits::mass_max_kg))
      return refuse("",
                    "mass of its shapes out of range: found " + number_text(mass.mass) + " kg, expected " +
                        number_text(limits::mass_min_kg) + ".." + number_text(limits::mass_max_kg),
                    "change density or size, or state the mass");
    if (!body.fixed_rotation && !(mass.inertia >= inertia_min && mass.inertia <= inertia_max))
      return refuse("",
                    "inertia out of range: found " + number_text(mass.inertia) + " kg m^2, expected " +
                        number_text(inertia_min) + ".." + number_text(inertia_max),
                    "change density or size, state the inertia, or fix the rotation");
    return true;
  }

  bool check_shape(const Shape& shape) {
    if (!is_row(shape_kinds, shape.kind))
      return refuse("type", "unknown: found number " + std::to_string(static_cast<unsigned>(shape.kind)) +
                                ", expected " + choice_names(shape_kinds));
    const std::string kind(info_of(shape_kinds, shape.kind).name);
    const auto has_no = [&](const char* key, bool is_unset) {
      return is_unset || refuse(key, "a " + kind + " has none: found one");
    };
    const bool is_circle = shape.kind == ShapeKind::circle;
    const bool is_box = shape.kind == ShapeKind::box;
    const bool is_polygon = shape.kind == ShapeKind::polygon;
    if (!has_no("radius", is_circle || shape.radius == 0) ||
        !has_no("half_size", is_box || shape.half_size == Point{}) || !has_no("angle", is_box || shape.angle == 0) ||
        !has_no("center", !is_polygon || shape.center == Point{}) ||
        !has_no("vertices", is_polygon || shape.vertices.empty()))
      return false;

    if (is_circle && !number("radius", shape.radius, limits::size_min_m, limits::size_max_m)) return false;
    if (is_box && (!number("half_size", shape.half_size.x, limits::size_min_m, limits::size_max_m, 0) ||
                   !number("half_size", shape.half_size.y, limits::size_min_m, limits::size_max_m, 1)))
      return false;
    if (!point("center", shape.center, limits::size_max_m) ||
        !number("angle", shape.angle, -angle_max_rad, angle_max_rad))
      return false;
    if (is_polygon && !check_polygon(shape)) return false;
    return number("density", shape.density, limits::mass_min_kg, limits::mass_max_kg, -1,
                  "kg/m^2; a body that states its mass needs no density") &&
           number("friction", shape.material.friction, 0, coefficient_max) &&
           number("restitution", shape.material.restitution, 0, 1);
  }

  bool check_polygon(const Shape& shape) {
    for (std::size_t i = 0; i < shape.vertices.size() && i < limits::polygon_vertex_count_max; ++i) {
      const std::string key = "vertices[" + std::to_string(i) + "]";
      if (!point(key.c_str(), shape.vertices[i], limits::size_max_m)) return false;
    }
    const Result<std::vector<Point>> hull = build_hull(shape.vertices);
    if (!hull) return refuse("vertices", hull.error().message, hull.error().hint);
    // The hull starts at its lowest point, so two passes give the extent.
    Point lower = (*hull)[0], upper = (*hull)[0];
    for (const Point& p : *hull) {
      lower.x = p.x < lower.x ? p.x : lower.x;
      upper = {p.x > upper.x ? p.x : upper.x, p.y > upper.y ? p.y : upper.y};
    }
    const double extent = upper.x - lower.x > upper.y - lower.y ? upper.x - lower.x : upper.y - lower.y;
    return extent >= limits::size_min_m ||
           refuse("vertices", "too small: found an extent of " + number_text(extent) + " m, expected at least " +
                                  number_text(limits::size_min_m));
  }

  bool check_inputs() {
    for (std::size_t i = 0; i < scene_.inputs.size(); ++i) {
      const std::string key = "inputs[" + std::to_string(i) + "]";
      const InputKind kind = scene_.inputs[i];
      if (!is_row(input_kinds, kind))
        return refuse(key, "unknown: found number " + std::to_string(static_cast<unsigned>(kind)) + ", expected " +
                               choice_names(input_kinds));
      if (i > 0 && kind <= scene_.inputs[i - 1]) {
        const bool twice = kind == scene_.inputs[i - 1];
        return refuse(key,
                      std::string(twice ? "declared twice" : "out of order") + ": found " +
                          std::string(info_of(input_kinds, kind).name) + " after " +
                          std::string(info_of(input_kinds, scene_.inputs[i - 1]).name) +
                          ", expected each once, ascending",
                      "the order is: " + choice_names(input_kinds));
      }
    }
    if (declares(scene_, InputKind::spawn) && scene_.prototypes.empty())
      return refuse("inputs", "spawn is declared, but there is nothing to spawn: found no prototypes");
    for (const InputKind kind : {InputKind::press, InputKind::drag, InputKind::release}) {
      if (declares(scene_, kind) == scene_.pointer.has_value()) continue;
      const std::string kind_name(info_of(input_kinds, kind).name);
      if (scene_.pointer)
        return refuse("inputs", "a pointer presses, drags and releases: found no " + kind_name,
                      "declare press, drag and release, or leave the pointer out");
      return refuse("pointer", "missing: found " + kind_name + " among the inputs, expected a pointer",
                    "\"pointer\": {} has useful defaults");
    }
    return true;
  }

  bool check_pointer() {
    if (!scene_.pointer) return true;
    const PointerSettings& pointer = *scene_.pointer;
    if (pointer.spawns.size() > limits::prototype_count_max)
      return fail(ErrorCode::limit, "pointer.spawns",
                  "too many: found " + std::to_string(pointer.spawns.size()) + ", expected at most " +
                      std::to_string(limits::prototype_count_max));
    for (std::size_t i = 0; i < pointer.spawns.size(); ++i) {
      bool known = false;
      std::string names;
      for (const Body& prototype : scene_.prototypes) {
        known = known || prototype.name == pointer.spawns[i];
        if (names.size() < limits::name_size_max) names += (names.empty() ? "" : ", ") + prototype.name;
      }
      if (!known)
        return refuse("pointer.spawns[" + std::to_string(i) + "]",
                      "no prototype has this name: found \"" +
                          (is_printable(pointer.spawns[i]) ? pointer.spawns[i] : std::string("?")) + "\", expected " +
                          (names.empty() ? "none: there are no prototypes" : "one of " + names));
    }
    return number("pointer.hertz", pointer.hertz, 1e-6, coefficient_max) &&
           number("pointer.damping_ratio", pointer.damping_ratio, 0, coefficient_max) &&
           number("pointer.force_max_per_kg", pointer.force_max_per_kg, 1e-6, force_per_kg_max) &&
           (!pointer.window || box("pointer.window", *pointer.window));
  }

  bool box(const std::string& key, const Bounds& bounds) {
    if (!point((key + ".lower").c_str(), bounds.lower, limits::coordinate_max_m) ||
        !point((key + ".upper").c_str(), bounds.upper, limits::coordinate_max_m))
      return false;
    const auto ascend = [&](const char* axis, double lower, double upper) {
      return lower < upper || refuse(key + ".upper[" + axis + "]", "must be above lower: found " + number_text(upper) +
                                                                       ", expected more than " + number_text(lower));
    };
    return ascend("0", bounds.lower.x, bounds.upper.x) && ascend("1", bounds.lower.y, bounds.upper.y);
  }

  bool check_bounds() {
    if (scene_.bounds && !box("bounds", *scene_.bounds)) return false;
    return !scene_.spawned_max || number("spawned_max", *scene_.spawned_max, 1, limits::body_count_max);
  }

  bool check_joint_bodies() {
    for (std::size_t i = 0; i < scene_.joints.size(); ++i) {
      const Joint& joint = scene_.joints[i];
      const std::string key = "joints[" + std::to_string(i) + "]";
      if (!is_row(joint_kinds, joint.kind)) return refuse(key + ".kind", "unknown");
      const bool has_a = joint.kind == JointKind::target || joint.body_a < scene_.bodies.size();
      if (!has_a || joint.body_b >= scene_.bodies.size())
        return refuse(key, "joins a body that the scene has not: found number " +
                               std::to_string(has_a ? joint.body_b : joint.body_a) + ", expected less than " +
                               std::to_string(scene_.bodies.size()));
      if (joint.kind != JointKind::target && joint.body_a == joint.body_b)
        return refuse(key, "joins a body to itself: found number " + std::to_string(joint.body_a));
    }
    return true;
  }

  bool check_choices() {
    const SolverInfo& solver = info_of(solvers, scene_.settings.solver);
    const IntegratorInfo& integrator = info_of(integrators, scene_.settings.integrator);
    const std::string name_of_solver(solver.name);
    if (!solver.substeps && scene_.settings.substeps != 1)
      return fail(
          ErrorCode::incompatible, "settings.substeps",
          name_of_solver + " does not substep: found " + std::to_string(scene_.settings.substeps) + ", expected 1",
          "set substeps to 1, or use " + names_where(solvers, [](const SolverInfo& s) { return s.substeps; }));
    const bool collide = can_collide(scene_);
    if (!scene_.joints.empty() && !solver.solves_joints)
      return fail(ErrorCode::incompatible, "settings.solver", name_of_solver + " solves no joints: found joints",
                  "use " + names_where(solvers, [](const SolverInfo& s) { return s.solves_joints; }));
    if (!collide && !scene_.pointer && scene_.joints.empty()) return true;
    const std::string found = collide ? "bodies that may collide" : scene_.pointer ? "a pointer" : "joints";
    if (!solver.solves_constraints)
      return fail(ErrorCode::incompatible, "settings.solver",
                  name_of_solver + " solves no contacts and moves nothing by a pointer: found " + found,
                  "use " + names_where(solvers, [](const SolverInfo& s) { return s.solves_constraints; }));
    if (!integrator.carries_constraints)
      return fail(ErrorCode::incompatible, "settings.integrator",
                  std::string(integrator.name) + " carries no contacts, no joints and no pointer: found " + found,
                  "use " + names_where(integrators, [](const IntegratorInfo& i) { return i.carries_constraints; }));
    return true;
  }

  /// What a scene can say and the engine cannot do yet.
  bool check_built() {
    const Settings& settings = scene_.settings;
    const Settings unset;
    if (!scene_.forces.empty()) return refuse("forces", "not built yet: found some, expected none");
    if (settings.locate_impacts) return refuse("settings.locate_impacts", "not built yet: found true, expected false");
    if (settings.events) return refuse("settings.events", "not built yet: found true, expected false");
    if (settings.clock != unset.clock) return refuse("settings.clock", "not built yet: expected fixed");
    for (const std::vector<Body>* list : {&scene_.bodies, &scene_.prototypes})
      for (const Body& body : *list)
        for (const Shape& shape : body.shapes) {
          const Material plain{shape.material.friction, shape.material.restitution};
          if (shape.kind > ShapeKind::polygon || shape.sensor || shape.filter != Filter{} || shape.material != plain ||
              (shape.kind != ShapeKind::circle && shape.radius != 0))
            return refuse("bodies", "not built yet: a capsule, segment, chain, rounding, sensor, filter or conveyor");
        }
    return true;
  }

  static constexpr std::size_t no_shape = static_cast<std::size_t>(-1);
  const Scene& scene_;
  const std::string& source_;
  const char* list_ = nullptr;
  std::size_t body_index_ = 0;
  std::size_t shape_index_ = no_shape;
  Error error_{};
};

}  // namespace

bool can_collide(const Scene& scene) {
  // What can exist: the bodies, and any number of each prototype that inputs may spawn.
  std::size_t dynamic_count = 0, fixed_count = 0;
  for (const Body& body : scene.bodies) ++(body.type == BodyType::dynamic_body ? dynamic_count : fixed_count);
  const bool spawns = declares(scene, InputKind::spawn);
  const bool presses = scene.pointer && declares(scene, InputKind::press);
  for (const Body& prototype : scene.prototypes) {
    bool can_come = spawns;
    if (presses)
      for (const std::string& name : scene.pointer->spawns) can_come = can_come || name == prototype.name;
    if (can_come) (prototype.type == BodyType::dynamic_body ? dynamic_count : fixed_count) += 2;
  }
  return dynamic_count >= 1 && dynamic_count + fixed_count >= 2;
}

Status check_scene(const Scene& scene, const std::string& source) {
  return Checker(scene, source).run();
}

}  // namespace ticktrue::engine
