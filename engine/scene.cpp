// The rules of a scene, and what follows from it for the pipeline.
// SPDX-License-Identifier: MIT
#include "engine/scene.h"

#include <map>
#include <string_view>
#include <utility>

#include "base/bytes.h"
#include "base/limits.h"
#include "engine/geometry/hull.h"
#include "engine/number_text.h"
#include "engine/scene_fields.h"

namespace ticktrue::engine {
namespace {

// Limits of this file's own. All leave room in f32, whose numbers end at 1e-38 and 3e38.
constexpr double angle_max_rad = 1e6;      // sin_cos is exact to its last digits up to here
constexpr double coefficient_max = 1e9;    // friction, damping ratios, hertz, scales: anything larger means "endless"
constexpr double inertia_min = 1e-30;      // kg m^2
constexpr double inertia_max = 1e30;       // kg m^2
constexpr double force_per_kg_max = 1e15;  // N/kg
constexpr double force_max = limits::mass_max_kg * limits::speed_max;  // N, N m: as of inputs
constexpr double stiffness_max = 1e18;                                 // N/m, N s/m, N m/rad, N m s/rad
constexpr double error_target_min = 1e-6;                              // of automatic substeps
constexpr double error_target_max = 0.1;
constexpr double tolerance_min = 1e-12;  // m and rad, of the adaptive clock
constexpr double tolerance_max = 1;
constexpr double exponent_max = 3;  // of central forces, either sign

/// Whether the filter of some shape lets it meet anything: an empty mask does not.
bool touches_something(const Body& body) {
  for (const Shape& shape : body.shapes)
    if (shape.filter.mask != 0 || shape.filter.group > 0) return true;
  return false;
}

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
                      check_bodies(scene_.prototypes, "prototypes") && check_joints() && check_forces() &&
                      check_inputs() && check_pointer() && check_bounds() && check_choices();
    if (good) return {};
    return error_;
  }

 private:
  std::string place(const std::string& key) const {
    std::string text = source_ + ": ";
    if (list_ != nullptr) {
      text += std::string(list_) + "[" + std::to_string(item_index_) + "]";
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
        !count("prototypes", scene_.prototypes.size(), limits::prototype_count_max) ||
        !count("joints", scene_.joints.size(), limits::joint_count_max) ||
        !count("forces", scene_.forces.size(), limits::force_count_max))
      return false;
    if (scene_.bodies.empty() && scene_.prototypes.empty())
      return refuse("bodies", "nothing to simulate: found no body and no prototype, expected at least one");
    return true;
  }

  template <typename Table, typename Kind>
  bool row(const char* key, const Table& table, Kind kind) {
    return is_row(table, kind) || refuse(key, "unknown: found number " + std::to_string(static_cast<unsigned>(kind)) +
                                                  ", expected " + choice_names(table));
  }

  bool check_settings() {
    const Settings& settings = scene_.settings;
    return row("settings.precision", precisions, settings.precision) &&
           row("settings.solver", solvers, settings.solver) &&
           row("settings.integrator", integrators, settings.integrator) &&
           row("settings.broad_phase", broad_phases, settings.broad_phase) &&
           row("settings.friction_mix", mix_rules, settings.friction_mix) &&
           row("settings.restitution_mix", mix_rules, settings.restitution_mix) &&
           row("settings.clock", clock_kinds, settings.clock.kind) &&
           number("settings.dt", settings.dt, limits::dt_min_s, limits::dt_max_s, -1,
                  "seconds per tick, such as 1/60") &&
           check_substeps() && number("settings.iterations", settings.iterations, 1, limits::iteration_count_max) &&
           number("settings.restitution_threshold", settings.restitution_threshold, 0, limits::speed_max) &&
           check_sleep() && check_clock() && point("gravity", scene_.gravity, limits::speed_max);
  }

  bool check_substeps() {
    const int least = scene_.settings.substeps;
    if (!scene_.settings.auto_substeps) return number("settings.substeps", least, 1, limits::substep_count_max);
    const AutoSubsteps& automatic = *scene_.settings.auto_substeps;
    const int most = automatic.substeps_max;
    if (!number("settings.substeps.least", least, 1, limits::substep_count_max) ||
        !number("settings.substeps.target_error", automatic.target_error, error_target_min, error_target_max) ||
        !number("settings.substeps.most", most, 1, limits::substep_count_max))
      return false;
    if ((most & (most - 1)) != 0)
      return refuse("settings.substeps.most", "must be a power of two: found " + std::to_string(most) +
                                                  ", expected 1, 2, 4, 8, ... or " +
                                                  std::to_string(limits::substep_count_max));
    return least <= most || refuse("settings.substeps.least", "must not be above most: found " + std::to_string(least) +
                                                                  ", expected at most " + std::to_string(most));
  }

  bool check_sleep() {
    if (!scene_.settings.sleep) return true;
    const SleepSettings& sleep = *scene_.settings.sleep;
    return number("settings.sleep.after", sleep.after_s, 0, coefficient_max) &&
           number("settings.sleep.speed_max", sleep.speed_max, 0, limits::speed_max);
  }

  bool check_clock() {
    const ClockSettings& clock = scene_.settings.clock;
    const ClockSettings unset;
    const auto& fields = info_of(clock_fields, clock.kind);
    const auto has_no = [&](ClockField field, const char* key, double value, double default_value) {
      return !key_of(fields, field).empty() || bits_of(value) == bits_of(default_value) ||
             refuse(std::string("settings.clock.") + key,
                    "a clock of kind " + std::string(info_of(clock_kinds, clock.kind).name) + " has none: found one");
    };
    if (!has_no(ClockField::ticks_per_frame_max, "ticks_per_frame_max", clock.ticks_per_frame_max,
                unset.ticks_per_frame_max) ||
        !has_no(ClockField::tolerance, "tolerance", clock.tolerance, unset.tolerance) ||
        !has_no(ClockField::dt_min, "dt_min", clock.dt_min, unset.dt_min) ||
        !has_no(ClockField::dt_max, "dt_max", clock.dt_max, unset.dt_max) ||
        !number("settings.clock.ticks_per_frame_max", clock.ticks_per_frame_max, 1, limits::ticks_per_frame_max) ||
        !number("settings.clock.tolerance", clock.tolerance, tolerance_min, tolerance_max) ||
        !number("settings.clock.dt_min", clock.dt_min, limits::dt_min_s, limits::dt_max_s) ||
        !number("settings.clock.dt_max", clock.dt_max, limits::dt_min_s, limits::dt_max_s))
      return false;
    return clock.kind != ClockKind::adaptive || clock.dt_min <= clock.dt_max ||
           refuse("settings.clock.dt_min", "must not be above dt_max: found " + number_text(clock.dt_min) +
                                               ", expected at most " + number_text(clock.dt_max));
  }

  bool check_bodies(const std::vector<Body>& bodies, const char* list) {
    const bool is_prototype = &bodies == &scene_.prototypes;
    Names names;
    list_ = list;
    for (item_index_ = 0; item_index_ < bodies.size(); ++item_index_) {
      const Body& body = bodies[item_index_];
      if (!check_body(body)) return false;
      if (is_prototype && !check_prototype(body)) return false;
      if (!unique(body.name, names)) return false;
    }
    list_ = nullptr;
    return true;
  }

  using Names = std::map<std::string_view, std::size_t>;

  /// Among those of the list before it.
  bool unique(const std::string& text, Names& names) {
    if (text.empty()) return true;
    const auto [at, is_new] = names.emplace(text, item_index_);
    return is_new || refuse("name",
                            "must be unique: found \"" + text + "\", which " + list_ + "[" +
                                std::to_string(at->second) + "] has already",
                            "leave a name out where none is needed");
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
    if (!row("type", body_types, body.type)) return false;
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
    std::size_t child_count = 0;
    for (const Shape& shape : body.shapes)
      child_count += shape.kind == ShapeKind::chain ? shape.vertices.size() - (shape.loop ? 0 : 1) : 1;
    if (child_count > limits::child_count_per_body_max)
      return fail(ErrorCode::limit, "shapes",
                  "too many, with every edge of a chain: found " + std::to_string(child_count) + ", expected at most " +
                      std::to_string(limits::child_count_per_body_max),
                  "spread them over several bodies");
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

  static bool has_area(ShapeKind kind) {
    switch (kind) {
      case ShapeKind::circle:
      case ShapeKind::box:
      case ShapeKind::polygon:
      case ShapeKind::capsule:
        return true;
      case ShapeKind::segment:
      case ShapeKind::chain:
        return false;
    }
    return false;
  }

  bool check_resulting_mass(const Body& body) {
    bool some_area = false;
    for (const Shape& shape : body.shapes) some_area = some_area || has_area(shape.kind);
    if (!some_area) {
      constexpr const char* hint =
          "segments and chains bring no mass: state \"mass\" and \"inertia\", or make the body static";
      if (!body.mass) return refuse("mass", "missing: found shapes without area only, expected a stated mass", hint);
      if (!body.mass->inertia && !body.fixed_rotation)
        return refuse("inertia", "missing: found shapes without area only, expected a stated inertia", hint);
      return true;
    }
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
    if (!row("type", shape_kinds, shape.kind)) return false;
    const std::string kind(info_of(shape_kinds, shape.kind).name);
    const auto has_no = [&](const char* key, bool is_unset) {
      return is_unset || refuse(key, "a " + kind + " has none: found one");
    };
    const bool is_circle = shape.kind == ShapeKind::circle;
    const bool is_box = shape.kind == ShapeKind::box;
    const bool is_polygon = shape.kind == ShapeKind::polygon;
    const bool is_capsule = shape.kind == ShapeKind::capsule;
    const bool is_chain = shape.kind == ShapeKind::chain;
    if (!has_no("radius", is_circle || is_box || is_polygon || is_capsule || shape.radius == 0) ||
        !has_no("half_size", is_box || shape.half_size == Point{}) || !has_no("angle", is_box || shape.angle == 0) ||
        !has_no("center", is_circle || is_box || shape.center == Point{}) ||
        !has_no("vertices", !(is_circle || is_box) || shape.vertices.empty()) ||
        !has_no("loop", is_chain || !shape.loop))
      return false;

    const double radius_min = is_circle || is_capsule ? limits::size_min_m : 0;
    if (!number("radius", shape.radius, radius_min, limits::size_max_m)) return false;
    if (is_box && (!number("half_size", shape.half_size.x, limits::size_min_m, limits::size_max_m, 0) ||
                   !number("half_size", shape.half_size.y, limits::size_min_m, limits::size_max_m, 1)))
      return false;
    if (!point("center", shape.center, limits::size_max_m) ||
        !number("angle", shape.angle, -angle_max_rad, angle_max_rad))
      return false;
    if (is_polygon && !check_polygon(shape)) return false;
    if (!is_circle && !is_box && !is_polygon && !check_points(shape)) return false;
    return number("density", shape.density, limits::mass_min_kg, limits::mass_max_kg, -1,
                  "kg/m^2; a body that states its mass needs no density") &&
           number("friction", shape.material.friction, 0, coefficient_max) &&
           number("restitution", shape.material.restitution, 0, 1) &&
           number("tangent_speed", shape.material.tangent_speed, -limits::speed_max, limits::speed_max) &&
           number("rolling_resistance", shape.material.rolling_resistance, 0, coefficient_max);
  }

  /// Of capsules, segments and chains.
  bool check_points(const Shape& shape) {
    const std::size_t count = shape.vertices.size();
    const std::string found = "wrong number of points: found " + std::to_string(count) + ", expected ";
    if (shape.kind != ShapeKind::chain && count != 2) return refuse("points", found + "2");
    if (count > limits::chain_vertex_count_max)
      return fail(ErrorCode::limit, "points", found + "at most " + std::to_string(limits::chain_vertex_count_max),
                  "make several chains of it");
    const std::size_t min = shape.loop ? 3 : 2;
    if (count < min)
      return refuse("points", found + "at least " + std::to_string(min) + (shape.loop ? " of a loop" : ""));
    for (std::size_t i = 0; i < count; ++i)
      if (const Point& p = shape.vertices[i]; !is_within(p, limits::size_max_m)) {
        const std::string key = "points[" + std::to_string(i) + "]";
        return point(key.c_str(), p, limits::size_max_m);
      }
    const std::size_t edge_count = shape.loop ? count : count - 1;
    for (std::size_t i = 0; i < edge_count; ++i) {
      const std::size_t next = i + 1 == count ? 0 : i + 1;
      const double x = shape.vertices[next].x - shape.vertices[i].x;
      const double y = shape.vertices[next].y - shape.vertices[i].y;
      if (x * x + y * y >= limits::size_min_m * limits::size_min_m) continue;
      return refuse("points",
                    "points " + std::to_string(i) + " and " + std::to_string(next) + " coincide: found less than " +
                        number_text(limits::size_min_m) + " m between them",
                    shape.loop && next == 0 ? "a loop closes itself: leave the repeated point out" : "");
    }
    return true;
  }

  static bool is_within(const Point& p, double max) { return p.x >= -max && p.x <= max && p.y >= -max && p.y <= max; }

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

  // ---- Joints and forces ----

  bool check_joints() {
    Names names;
    list_ = "joints";
    for (item_index_ = 0; item_index_ < scene_.joints.size(); ++item_index_) {
      const Joint& joint = scene_.joints[item_index_];
      if (!name("name", joint.name) || !unique(joint.name, names) || !row("type", joint_kinds, joint.kind) ||
          !check_joint(joint))
        return false;
    }
    list_ = nullptr;
    return true;
  }

  /// Of a joint or force: that the kind has no such field, where it keeps the value that it has when unset.
  template <typename Row, typename Field>
  bool unused(const Row& fields, Field field, const char* key, bool is_unset, std::string_view kind) {
    return !key_of(fields, field).empty() || is_unset || refuse(key, "a " + std::string(kind) + " has none: found one");
  }
  static bool same(double a, double b) { return bits_of(a) == bits_of(b); }
  static bool same(const Point& a, const Point& b) { return same(a.x, b.x) && same(a.y, b.y); }

  bool check_joint(const Joint& joint) {
    const Joint unset;
    const auto& fields = info_of(joint_fields, joint.kind);
    const auto has_no = [&](JointField field, const char* key, bool is_unset) {
      return unused(fields, field, key, is_unset, std::string(info_of(joint_kinds, joint.kind).name) + " joint");
    };
    if (!has_no(JointField::body_a, "body_a", joint.body_a == unset.body_a) ||
        !has_no(JointField::anchor_a, "anchor_a", same(joint.anchor_a, unset.anchor_a)) ||
        !has_no(JointField::anchor_b, "anchor_b", same(joint.anchor_b, unset.anchor_b)) ||
        !has_no(JointField::axis, "axis", same(joint.axis, unset.axis)) ||
        !has_no(JointField::reference_angle, "reference_angle", same(joint.reference_angle, unset.reference_angle)) ||
        !has_no(JointField::length, "length", same(joint.length, unset.length)) ||
        !has_no(JointField::limits, "limits", !joint.limits) || !has_no(JointField::motor, "motor", !joint.motor) ||
        !has_no(JointField::spring, "spring", !joint.spring) ||
        !has_no(JointField::linear_spring, "linear_spring", !joint.linear_spring) ||
        !has_no(JointField::offset, "offset", same(joint.offset, unset.offset)) ||
        !has_no(JointField::angle_offset, "angle_offset", same(joint.angle_offset, unset.angle_offset)) ||
        !has_no(JointField::force_max, "force_max", same(joint.force_max, unset.force_max)) ||
        !has_no(JointField::torque_max, "torque_max", same(joint.torque_max, unset.torque_max)) ||
        !has_no(JointField::collide_connected, "collide_connected", !joint.collide_connected))
      return false;

    const bool has_a = !key_of(fields, JointField::body_a).empty();
    const std::string_view offset_key = key_of(fields, JointField::offset);
    return (!has_a || check_body_index("body_a", joint.body_a)) && check_body_index("body_b", joint.body_b) &&
           check_pair(joint, has_a) && point("anchor_a", joint.anchor_a, limits::size_max_m) &&
           point("anchor_b", joint.anchor_b, limits::size_max_m) && check_axis(joint) &&
           number("reference_angle", joint.reference_angle, -angle_max_rad, angle_max_rad) && check_length(joint) &&
           (!joint.limits || check_limits(joint)) && (!joint.motor || check_motor(*joint.motor)) &&
           (!joint.spring || check_spring("spring", *joint.spring)) &&
           (!joint.linear_spring || check_spring("linear_spring", *joint.linear_spring)) &&
           (offset_key.empty() || point(std::string(offset_key).c_str(), joint.offset, limits::coordinate_max_m)) &&
           number("angle_offset", joint.angle_offset, -angle_max_rad, angle_max_rad) &&
           number("force_max", joint.force_max, 0, force_max) && number("torque_max", joint.torque_max, 0, force_max);
  }

  bool check_body_index(const char* key, std::uint32_t index) {
    if (index < scene_.bodies.size()) return true;
    return refuse(key, "no body has this index: found " + std::to_string(index) + ", expected " +
                           (scene_.bodies.empty() ? "none: the scene has no bodies"
                                                  : "0.." + std::to_string(scene_.bodies.size() - 1)));
  }

  bool check_pair(const Joint& joint, bool has_a) {
    const BodyType type_b = scene_.bodies[joint.body_b].type;
    if (!has_a)
      return type_b == BodyType::dynamic_body ||
             refuse("body_b", "must be dynamic: found a " + std::string(info_of(body_types, type_b).name) + " body");
    if (joint.body_a == joint.body_b)
      return refuse("body_b", "joins a body with itself: found body " + std::to_string(joint.body_b) + " twice");
    const BodyType type_a = scene_.bodies[joint.body_a].type;
    return type_a == BodyType::dynamic_body || type_b == BodyType::dynamic_body ||
           refuse("body_b", "one of the two bodies must be dynamic: found a " +
                                std::string(info_of(body_types, type_a).name) + " and a " +
                                std::string(info_of(body_types, type_b).name) + " body");
  }

  bool check_axis(const Joint& joint) {
    if (!point("axis", joint.axis, limits::coordinate_max_m)) return false;
    const double x = joint.axis.x < 0 ? -joint.axis.x : joint.axis.x;
    const double y = joint.axis.y < 0 ? -joint.axis.y : joint.axis.y;
    return (x > y ? x : y) >= limits::size_min_m ||
           refuse("axis", "has no direction: found (" + number_text(joint.axis.x) + ", " + number_text(joint.axis.y) +
                              "), expected a length of at least " + number_text(limits::size_min_m));
  }

  bool check_length(const Joint& joint) {
    const bool is_rigid = joint.kind == JointKind::distance && !joint.spring;
    return number("length", joint.length, is_rigid ? limits::size_min_m : 0, limits::coordinate_max_m, -1,
                  is_rigid ? "a revolute joint keeps two anchors together; a spring may have no length" : "");
  }

  bool check_limits(const Joint& joint) {
    const bool is_angle = joint.kind == JointKind::revolute;
    const double max = is_angle ? angle_max_rad : limits::coordinate_max_m;
    const double min = joint.kind == JointKind::distance ? 0 : -max;
    const Range& range = *joint.limits;
    if (!number("limits", range.lower, min, max, 0) || !number("limits", range.upper, min, max, 1)) return false;
    return range.lower <= range.upper ||
           refuse("limits", "lower is above upper: found [" + number_text(range.lower) + ", " +
                                number_text(range.upper) + "], expected [lower, upper]");
  }

  bool check_motor(const JointMotor& motor) {
    return number("motor.speed", motor.speed, -limits::speed_max, limits::speed_max) &&
           number("motor.force_max", motor.force_max, 0, force_max);
  }

  bool check_spring(const std::string& key, const JointSpring& spring) {
    const bool mixed =
        spring.absolute ? spring.hertz != 0 || spring.damping_ratio != 0 : spring.stiffness != 0 || spring.damping != 0;
    if (mixed)
      return refuse(key,
                    "must be one of two forms: found keys of both, expected hertz and damping_ratio, or stiffness "
                    "and damping");
    return number((key + ".hertz").c_str(), spring.hertz, 0, coefficient_max) &&
           number((key + ".damping_ratio").c_str(), spring.damping_ratio, 0, coefficient_max) &&
           number((key + ".stiffness").c_str(), spring.stiffness, 0, stiffness_max) &&
           number((key + ".damping").c_str(), spring.damping, 0, stiffness_max);
  }

  bool check_forces() {
    Names names;
    list_ = "forces";
    for (item_index_ = 0; item_index_ < scene_.forces.size(); ++item_index_) {
      const Force& force = scene_.forces[item_index_];
      if (!name("name", force.name) || !unique(force.name, names) || !row("type", force_kinds, force.kind) ||
          !check_force(force))
        return false;
    }
    list_ = nullptr;
    return true;
  }

  bool check_force(const Force& force) {
    const Force unset;
    const auto& fields = info_of(force_fields, force.kind);
    const auto has_no = [&](ForceField field, const char* key, bool is_unset) {
      return unused(fields, field, key, is_unset, std::string(info_of(force_kinds, force.kind).name) + " force");
    };
    if (!has_no(ForceField::body, "body", !force.body) || !has_no(ForceField::other, "other", !force.other) ||
        !has_no(ForceField::anchor, "anchor", same(force.anchor, unset.anchor)) ||
        !has_no(ForceField::point, "point", same(force.point, unset.point)) ||
        !has_no(ForceField::vector, "vector", same(force.vector, unset.vector)) ||
        !has_no(ForceField::torque, "torque", same(force.torque, unset.torque)) ||
        !has_no(ForceField::coefficient, "coefficient", same(force.coefficient, unset.coefficient)) ||
        !has_no(ForceField::angular_coefficient, "angular_coefficient",
                same(force.angular_coefficient, unset.angular_coefficient)) ||
        !has_no(ForceField::exponent, "exponent", same(force.exponent, unset.exponent)) ||
        !has_no(ForceField::stiffness, "stiffness", same(force.stiffness, unset.stiffness)) ||
        !has_no(ForceField::damping, "damping", same(force.damping, unset.damping)) ||
        !has_no(ForceField::rest_length, "rest_length", same(force.rest_length, unset.rest_length)))
      return false;

    // Drags slow down; what a central force does depends on its sign.
    const double coefficient_min = force.kind == ForceKind::central ? -stiffness_max : 0;
    const double vector_max = force.kind == ForceKind::wind ? limits::speed_max : force_max;
    const std::string vector_key(key_of(fields, ForceField::vector));
    const std::string point_key(key_of(fields, ForceField::point));
    return check_force_bodies(force) && point("anchor", force.anchor, limits::size_max_m) &&
           point(point_key.c_str(), force.point, limits::coordinate_max_m) &&
           point(vector_key.c_str(), force.vector, vector_max) &&
           number("torque", force.torque, -force_max, force_max) &&
           number("coefficient", force.coefficient, coefficient_min, stiffness_max) &&
           number("angular_coefficient", force.angular_coefficient, 0, stiffness_max) && check_exponent(force) &&
           number("stiffness", force.stiffness, 0, stiffness_max) &&
           number("damping", force.damping, 0, stiffness_max) &&
           number("rest_length", force.rest_length, 0, limits::coordinate_max_m);
  }

  bool check_force_bodies(const Force& force) {
    if (force.kind == ForceKind::spring && !force.body)
      return refuse("body", "missing: a spring needs a body: found none, expected one");
    if (force.body && !check_body_index("body", *force.body)) return false;
    if (force.other && !check_body_index("other", *force.other)) return false;
    if (!force.body) return true;
    if (force.other && *force.other == *force.body)
      return refuse("other", "joins a body with itself: found body " + std::to_string(*force.other) + " twice");
    const bool moves = scene_.bodies[*force.body].type == BodyType::dynamic_body ||
                       (force.other && scene_.bodies[*force.other].type == BodyType::dynamic_body);
    return moves || refuse("body",
                           "must be dynamic: found a " +
                               std::string(info_of(body_types, scene_.bodies[*force.body].type).name) + " body",
                           "forces move dynamic bodies only");
  }

  bool check_exponent(const Force& force) {
    if (!number("exponent", force.exponent, -exponent_max, exponent_max)) return false;
    return static_cast<double>(static_cast<int>(force.exponent)) == force.exponent ||
           refuse("exponent", "must be whole: found " + number_text(force.exponent) + ", expected -3, -2, ... or 3");
  }

  // ---- What comes from outside, and choices ----

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
    if (declares(scene_, InputKind::set_motor)) {
      bool some_motor = false;
      for (const Joint& joint : scene_.joints) some_motor = some_motor || joint.motor;
      if (!some_motor)
        return refuse("inputs", "set_motor is declared, but there is no motor to set: found no joint with one",
                      "give a joint a \"motor\"; its force_max may be 0");
    }
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

  bool check_choices() {
    const SolverInfo& solver = info_of(solvers, scene_.settings.solver);
    const IntegratorInfo& integrator = info_of(integrators, scene_.settings.integrator);
    const std::string name_of_solver(solver.name);
    const auto substeps = [](const SolverInfo& s) { return s.substeps; };
    if (!solver.substeps && (scene_.settings.substeps != 1 || scene_.settings.auto_substeps))
      return fail(ErrorCode::incompatible, "settings.substeps",
                  name_of_solver + " does not substep: found " +
                      (scene_.settings.auto_substeps ? "auto" : std::to_string(scene_.settings.substeps)) +
                      ", expected 1",
                  "set substeps to 1, or use " + names_where(solvers, substeps));
    if (scene_.settings.sleep && !solver.solves_joints)
      return fail(
          ErrorCode::incompatible, "settings.sleep", name_of_solver + " has no islands: found sleep",
          "leave sleep out, or use " + names_where(solvers, [](const SolverInfo& s) { return s.solves_joints; }));
    if (!check_contact_needs(solver)) return false;
    if (scene_.settings.locate_impacts && scene_.settings.integrator != IntegratorKind::semi_implicit_euler)
      return fail(ErrorCode::incompatible, "settings.locate_impacts",
                  "bounces are located under one integrator only: found " + std::string(integrator.name) +
                      ", expected semi_implicit_euler",
                  "between impacts it moves bodies along exact parabolas");
    const bool collide = can_collide(scene_);
    const std::size_t joint_count = scene_.joints.size();
    const std::string joints = std::to_string(joint_count) + (joint_count == 1 ? " joint" : " joints");
    if (!solver.solves_constraints && (collide || scene_.pointer))
      return fail(ErrorCode::incompatible, "settings.solver",
                  name_of_solver + " solves no contacts and moves nothing by a pointer: found " +
                      (collide ? "bodies that may collide" : "a pointer"),
                  "use " + names_where(solvers, [](const SolverInfo& s) { return s.solves_constraints; }));
    if (!solver.solves_joints && joint_count > 0)
      return fail(ErrorCode::incompatible, "settings.solver", name_of_solver + " solves no joints: found " + joints,
                  "use " + names_where(solvers, [](const SolverInfo& s) { return s.solves_joints; }));
    if (!integrator.carries_constraints && (collide || joint_count > 0 || scene_.pointer))
      return fail(ErrorCode::incompatible, "settings.integrator",
                  std::string(integrator.name) + " carries no contacts, no joints and no pointer (" +
                      std::string(integrator.why_free) + "): found " +
                      (joint_count > 0 ? joints
                       : collide       ? "bodies that may collide"
                                       : "a pointer"),
                  "use " + names_where(integrators, [](const IntegratorInfo& i) { return i.carries_constraints; }));
    return true;
  }

  /// What only solvers that read the narrow phase's contacts can do.
  bool check_contact_needs(const SolverInfo& solver) {
    if (solver.reads_contacts) return true;
    const std::string able = names_where(solvers, [](const SolverInfo& s) { return s.reads_contacts; });
    const auto cannot = [&](const char* key, const std::string& what) {
      return fail(ErrorCode::incompatible, key, std::string(solver.name) + " " + what, "use " + able);
    };
    if (scene_.settings.events) return cannot("settings.events", "reports no contacts: found true, expected false");
    for (const std::vector<Body>* list : {&scene_.bodies, &scene_.prototypes})
      for (const Body& body : *list)
        for (const Shape& shape : body.shapes) {
          if (shape.sensor) return cannot("settings.solver", "has no sensors: found one");
          if (!solver.solves_constraints) continue;
          const bool is_plain =
              shape.kind == ShapeKind::circle ||
              ((shape.kind == ShapeKind::box || shape.kind == ShapeKind::polygon) && shape.radius == 0);
          if (!is_plain) return cannot("settings.solver", "knows circles and sharp polygons only: found another shape");
          if (shape.filter != Filter{}) return cannot("settings.solver", "tests every pair: found a filter");
          if (shape.material.tangent_speed != 0 || shape.material.rolling_resistance != 0)
            return cannot("settings.solver", "knows friction and restitution only: found another material");
        }
    return true;
  }

  static constexpr std::size_t no_shape = static_cast<std::size_t>(-1);
  const Scene& scene_;
  const std::string& source_;
  const char* list_ = nullptr;
  std::size_t item_index_ = 0;
  std::size_t shape_index_ = no_shape;
  Error error_{};
};

}  // namespace

bool can_collide(const Scene& scene) {
  // What can exist: the bodies, and any number of each prototype that inputs may spawn.
  std::size_t dynamic_count = 0, fixed_count = 0;
  for (const Body& body : scene.bodies)
    if (touches_something(body)) ++(body.type == BodyType::dynamic_body ? dynamic_count : fixed_count);
  const bool spawns = declares(scene, InputKind::spawn);
  const bool presses = scene.pointer && declares(scene, InputKind::press);
  for (const Body& prototype : scene.prototypes) {
    bool can_come = spawns;
    if (presses)
      for (const std::string& name : scene.pointer->spawns) can_come = can_come || name == prototype.name;
    if (can_come && touches_something(prototype))
      (prototype.type == BodyType::dynamic_body ? dynamic_count : fixed_count) += 2;
  }
  return dynamic_count >= 1 && dynamic_count + fixed_count >= 2;
}

Status check_scene(const Scene& scene, const std::string& source) {
  return Checker(scene, source).run();
}

}  // namespace ticktrue::engine
