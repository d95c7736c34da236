// Reads the JSON that R.U.B.E. exports: world, bodies with fixtures, joints.
// SPDX-License-Identifier: MIT
// Source: Campbell, "R.U.B.E. JSON structure", iforce2d.net/rube/json-structure, 2011 to 2017 (the format); Catto,
// Box2D manual 2.3 (the meaning of the values).
//
// An invalid value stops the import: the reading functions store the first error in `error_`, and then return zeros.
#include "tool/import/import_rube.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "base/bytes.h"
#include "base/limits.h"
#include "engine/json/number_text.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"

namespace ticktrue::verifier {
namespace {

using Json = nlohmann::json;
using engine::Body;
using engine::BodyType;
using engine::Joint;
using engine::JointKind;
using engine::JointSpring;
using engine::Point;
using engine::Range;
using engine::Shape;
using engine::ShapeKind;

constexpr std::size_t depth_max = 16;                 // a vertex's coordinate is at depth 8
constexpr std::size_t value_count_max = 4'000'000;    // of a file; each value needs 64 bytes in memory
constexpr std::size_t polygon_point_count_max = 256;  // before cleaning
constexpr std::size_t found_size_max = 40;            // bytes of a text quoted in a message
constexpr double weld_distance = 0.0025;              // m; Box2D merges polygon vertices closer than half its slop
constexpr double chain_distance = 0.005;              // m; Box2D refuses chain points closer than its slop
constexpr double skin = 0.0075;                       // m; half of the gap that Box2D leaves between resting polygons
constexpr double density_min = 1e-9;                  // kg/m^2; replaces a density of 0 in the file
constexpr double default_correction = 0.3;  // share of a motor joint's error removed per step; Box2D's default
constexpr double tiny_radius = 0.01;        // m, of the sensor that replaces missing shapes of a body

// Keys that an exporter writes and the import ignores: names of layers, settings of Box2D's solver.
constexpr std::array<std::string_view, 8> world_keys_without_effect{
    "collisionbitplanes", "autoClearForces", "positionIterations", "velocityIterations",
    "warmStarting",       "subStepping",     "allowSleep",         "contactListener"};

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, found_size_max)) out += c >= 0x20 && c < 0x7f && c != '"' ? c : '?';
  return out + (text.size() > found_size_max ? "...\"" : "\"");
}

std::string found_text(const Json& value) {
  if (value.is_number()) return engine::number_text(value.get<double>());
  if (value.is_string()) return in_quotes(value.get_ref<const std::string&>());
  if (value.is_boolean()) return value.get<bool>() ? "true" : "false";
  if (value.is_array()) return "an array of " + std::to_string(value.size());
  return value.is_null() ? "null" : "an object";
}

double distance(const Point& a, const Point& b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}
Point rotated(double angle, const Point& p) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.y, s * p.x + c * p.y};
}

/// A JSON value and its path.
struct Place {
  const Json* value;
  std::string path;

  bool has(const char* key) const { return value->contains(key); }
  Place at(const char* key) const { return {&value->at(key), path.empty() ? key : path + "." + key}; }
  Place at(std::size_t index) const { return {&value->at(index), path + "[" + std::to_string(index) + "]"}; }
};

/// Counts depth and values before memory is allocated for them. Errors: limit.
Status check_extent(std::string_view json, const std::string& source) {
  std::size_t depth = 0, value_count = 1;
  bool in_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_text) {
      if (c == '\\') ++i;
      if (c == '"') in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '[' || c == '{') {
      ++value_count;
      if (++depth > depth_max)
        return Error{ErrorCode::limit,
                     source + ": nested too deeply: expected at most " + std::to_string(depth_max) + " levels", ""};
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    } else if (c == ',') {
      ++value_count;
    }
  }
  if (value_count > value_count_max)
    return Error{ErrorCode::limit,
                 source + ": too many values: found " + std::to_string(value_count) + ", expected at most " +
                     std::to_string(value_count_max),
                 ""};
  return {};
}

/// Makes names unique: "wheel", "wheel#2", "wheel#3".
class UniqueNames {
 public:
  void reserve(const std::string& name) { given_by_file_.insert(name); }
  std::string take(const std::string& name) {
    if (name.empty() || taken_.insert(name).second) return name;
    std::size_t& count = counts_.emplace(name, 1).first->second;
    std::string unique;
    do {
      unique = name + "#" + std::to_string(++count);
    } while (given_by_file_.count(unique) > 0 || !taken_.insert(unique).second);
    return unique;
  }

 private:
  std::set<std::string> given_by_file_;
  std::set<std::string> taken_;
  std::map<std::string, std::size_t> counts_;
};

class Importer {
 public:
  Importer(const Json& root, const std::string& source) : root_(root), source_(source) {}

  Result<RubeImport> run(const std::string& name) {
    out_.scene.name = name;
    if (!root_.is_object()) return refused({&root_, ""}, "an object with \"body\"");
    const Place world{&root_, ""};
    read_world(world);
    const auto each = [&](const char* key, std::size_t count_max, auto read) {
      for (std::size_t i = 0; i < list_size(world, key, count_max) && !error_; ++i) read(world.at(key).at(i), i);
    };
    each("body", limits::body_count_max, [&](const Place& at, std::size_t) { body_names_.reserve(name_of(at)); });
    each("body", limits::body_count_max, [&](const Place& at, std::size_t) { read_body(at); });
    each("joint", limits::joint_count_max, [&](const Place& at, std::size_t) { joint_names_.reserve(name_of(at)); });
    each("joint", limits::joint_count_max, [&](const Place& at, std::size_t) { read_joint(at); });
    each("joint", limits::joint_count_max, [&](const Place& at, std::size_t) { read_gear(at); });
    each("image", limits::body_count_max,
         [&](const Place& at, std::size_t) { note("not imported: " + label(at) + " (no physics)"); });
    if (error_) return *error_;
    note_ignored_keys();
    if (note_count_ > rube_note_count_max) {
      const std::size_t more = note_count_ - rube_note_count_max + 1;
      out_.notes.back() = "and " + std::to_string(more) + " more of this kind";
    }
    return std::move(out_);
  }

 private:
  // ---- Values ----

  Error refused(const Place& at, const std::string& expected) const {
    return Error{ErrorCode::invalid_scene,
                 source_ + ": " + (at.path.empty() ? "" : at.path + ": ") + "found " + found_text(*at.value) +
                     ", expected " + expected,
                 ""};
  }
  void refuse(const Place& at, const std::string& expected) {
    if (!error_) error_ = refused(at, expected);
  }
  void fail(ErrorCode code, const Place& at, const std::string& what) {
    if (!error_) error_ = Error{code, source_ + ": " + at.path + ": " + what, ""};
  }
  void note(std::string text) {
    if (++note_count_ <= rube_note_count_max) out_.notes.push_back(std::move(text));
  }

  /// A number, or a text with the bits of a 32-bit float as eight hexadecimal digits.
  double to_number(const Place& at) {
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
  double number(const Place& object, const char* key, double missing = 0) {
    use(object, key);
    return object.has(key) ? to_number(object.at(key)) : missing;
  }
  bool flag(const Place& object, const char* key, bool missing = false) {
    use(object, key);
    if (!object.has(key)) return missing;
    const Place at = object.at(key);
    if (!at.value->is_boolean()) refuse(at, "true or false");
    return at.value->is_boolean() && at.value->get<bool>();
  }
  /// An integer within limits.
  std::int64_t whole(const Place& object, const char* key, std::int64_t min, std::int64_t max, std::int64_t missing) {
    use(object, key);
    if (!object.has(key)) return missing;
    const Place at = object.at(key);
    const double value = at.value->is_number() ? at.value->get<double>() : 0.5;
    if (!(value >= static_cast<double>(min) && value <= static_cast<double>(max)) || value != std::floor(value)) {
      refuse(at, "a whole number, " + std::to_string(min) + ".." + std::to_string(max));
      return missing;
    }
    return static_cast<std::int64_t>(value);
  }
  Point to_point(const Place& at) {
    if (at.value->is_number() && at.value->get<double>() == 0) return {};
    if (!at.value->is_object() || !at.has("x") || !at.has("y")) {
      refuse(at, "{\"x\": ..., \"y\": ...}, or 0");
      return {};
    }
    const double x = to_number(at.at("x"));
    const double y = to_number(at.at("y"));
    return {x, y};
  }
  Point point(const Place& object, const char* key) {
    use(object, key);
    return object.has(key) ? to_point(object.at(key)) : Point{};
  }
  std::string text(const Place& object, const char* key) {
    use(object, key);
    if (!object.has(key)) return {};
    const Place at = object.at(key);
    if (!at.value->is_string()) refuse(at, "a text");
    return at.value->is_string() ? at.value->get<std::string>() : std::string();
  }
  std::size_t list_size(const Place& object, const char* key, std::size_t count_max) {
    use(object, key);
    if (!object.has(key)) return 0;
    const Place at = object.at(key);
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
  std::vector<Point> points(const Place& shape, std::size_t count_max) {
    std::vector<Point> out;
    if (!shape.value->is_object() || !shape.has("vertices")) {
      refuse(shape, "an object with \"vertices\"");
      return out;
    }
    const Place vertices = shape.at("vertices");
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

  /// The name of a body or joint. Stores an error if the value is not an object.
  std::string name_of(const Place& at) {
    if (!at.value->is_object()) {
      refuse(at, "an object");
      return {};
    }
    return text(at, "name");
  }
  /// `joint[3] "wheel"`, for notes.
  static std::string label(const Place& at) {
    const bool named = at.value->is_object() && at.has("name") && at.value->at("name").is_string();
    return at.path + (named ? " " + in_quotes(at.value->at("name").get_ref<const std::string&>()) : "");
  }

  // ---- Keys that were not read ----

  void use(const Place& object, const char* key) { used_.insert({object.value, key}); }
  /// Adds a note for each key of an object that no function has read.
  void count_ignored(const Place& object, const std::string& kind) {
    for (const auto& [key, value] : object.value->items())
      if (used_.count({object.value, key}) == 0) ++ignored_[kind + " key " + in_quotes(key)];
    used_.clear();
  }
  void note_ignored_keys() {
    for (const auto& [what, count] : ignored_)
      note("not imported: " + what + (count > 1 ? " (" + std::to_string(count) + " times)" : ""));
  }

  // ---- World ----

  void read_world(const Place& world) {
    out_.scene.gravity = point(world, "gravity");
    const double steps = number(world, "stepsPerSecond", 60);
    if (!(steps >= 1 / limits::dt_max_s && steps <= 1 / limits::dt_min_s) && !error_)
      refuse(world.at("stepsPerSecond"), "steps per second, at least " + engine::number_text(1 / limits::dt_max_s));
    out_.scene.settings.dt = 1 / steps;
    out_.scene.settings.continuous = flag(world, "continuousPhysics");
    for (const std::string_view key : world_keys_without_effect) used_.insert({world.value, std::string(key)});
    for (const char* key : {"body", "joint", "image"}) use(world, key);
    count_ignored(world, "world");
  }

  // ---- Bodies ----

  void read_body(const Place& at) {
    body_ids_.emplace_back();
    const bool is_active = flag(at, "active", true);
    if (error_) return;
    if (!is_active) {
      used_.clear();
      return note("not imported: " + label(at) + ": is inactive");
    }
    Body body;
    body.name = body_names_.take(name_of(at));
    constexpr std::array types{BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body};
    body.type = types[static_cast<std::size_t>(whole(at, "type", 0, 2, 0))];
    const bool is_static = body.type == BodyType::static_body;
    body.position = point(at, "position");
    body.angle = number(at, "angle");
    const Point velocity = point(at, "linearVelocity");
    const double angular_velocity = number(at, "angularVelocity");
    if (is_static && (velocity != Point{} || angular_velocity != 0))
      note("not imported: " + label(at) + ": velocity of a static body");
    body.angular_velocity = is_static ? 0 : angular_velocity;
    body.linear_damping = number(at, "linearDamping");
    body.angular_damping = number(at, "angularDamping");
    body.gravity_scale = number(at, "gravityScale", 1);
    body.fixed_rotation = flag(at, "fixedRotation");
    body.bullet = flag(at, "bullet");
    body.can_sleep = flag(at, "allowSleep", true);
    if (!flag(at, "awake") && body.type == BodyType::dynamic_body)
      note("not imported: " + label(at) + ": sleeps at the start");
    use(at, "fixture");
    if (at.has("fixture")) read_fixtures(at, body);
    if (error_) return;
    if (body.shapes.empty()) add_placeholder(at, body);
    read_mass(at, body);
    // Box2D states the velocity of the body's origin, and a scene the velocity of the centre of mass.
    if (!is_static) {
      const Point arm = rotated(body.angle, center_of(at, body));
      body.velocity = {velocity.x - body.angular_velocity * arm.y, velocity.y + body.angular_velocity * arm.x};
    }
    count_ignored(at, "body");
    body_ids_.back() = static_cast<std::uint32_t>(out_.scene.bodies.size());
    out_.scene.bodies.push_back(std::move(body));
  }

  void read_fixtures(const Place& at, Body& body) {
    const std::size_t count = list_size(at, "fixture", limits::shape_count_per_body_max);
    const auto used_by_body = std::exchange(used_, {});
    for (std::size_t i = 0; i < count && !error_; ++i) read_fixture(at.at("fixture").at(i), body);
    used_ = used_by_body;
  }

  void read_fixture(const Place& at, Body& body) {
    if (!at.value->is_object()) return refuse(at, "an object");
    use(at, "name");
    Shape shape;
    const double density = number(at, "density");
    shape.density = density > 0 ? density : density_min;
    shape.material.friction = number(at, "friction");
    shape.material.restitution = number(at, "restitution");
    shape.sensor = flag(at, "sensor");
    // The format has 16 bits each. An exporter that treats the bits as signed writes -1 if all bits are set.
    shape.filter.category = static_cast<std::uint32_t>(whole(at, "filter-categoryBits", -32768, 65535, 1)) & 0xffffu;
    const auto mask = static_cast<std::uint32_t>(whole(at, "filter-maskBits", -32768, 65535, 65535)) & 0xffffu;
    shape.filter.mask = mask == 0xffffu ? engine::Filter{}.mask : mask;  // a full mask means every category
    shape.filter.group = static_cast<std::int32_t>(whole(at, "filter-groupIndex", -32768, 32767, 0));
    for (const char* key : {"circle", "polygon", "chain"}) use(at, key);
    if (at.has("circle")) {
      read_circle(at.at("circle"), shape);
      body.shapes.push_back(std::move(shape));
    } else if (at.has("polygon")) {
      read_polygon(at.at("polygon"), shape);
      body.shapes.push_back(std::move(shape));
    } else if (at.has("chain")) {
      shape.density = Shape{}.density;
      read_chain(at.at("chain"), shape, body);
    } else {
      refuse(at, "a \"circle\", \"polygon\" or \"chain\" in it");
    }
    if (!error_) count_ignored(at, "fixture");
  }

  void read_circle(const Place& at, Shape& shape) {
    if (!at.value->is_object()) return refuse(at, "an object with \"radius\"");
    shape.kind = ShapeKind::circle;
    shape.radius = number(at, "radius");
    shape.center = point(at, "center");
    if (!error_ && !(shape.radius > 0)) fail(ErrorCode::invalid_scene, at, "found no radius, expected one above 0");
  }

  void read_polygon(const Place& at, Shape& shape) {
    shape.kind = ShapeKind::polygon;
    shape.radius = skin;  // editors save resting bodies one skin apart
    shape.vertices = points(at, polygon_point_count_max);
    if (error_) return;
    const std::size_t count = shape.vertices.size();
    if (engine::build_hull(shape.vertices).has_value()) return;
    shape.vertices = cleaned(shape.vertices);
    if (const auto hull = engine::build_hull(shape.vertices); !hull)
      return fail(ErrorCode::invalid_scene, at,
                  "not a convex polygon of area, even without what Box2D leaves out: " + hull.error().message);
    note("changed: " + at.path + ": " + std::to_string(count) + " vertices, of which " +
         std::to_string(shape.vertices.size()) + " are corners");
  }

  /// The corners of the convex hull. Like Box2D, merges close vertices, and drops vertices on an edge or inside the
  /// hull.
  static std::vector<Point> cleaned(const std::vector<Point>& vertices) {
    std::vector<Point> rest;
    double extent = 0;
    for (const Point& p : vertices) extent = std::max(extent, distance(p, vertices[0]));
    const double near = std::max(weld_distance, 2e-4 * extent);
    for (const Point& p : vertices)
      if (std::none_of(rest.begin(), rest.end(), [&](const Point& q) { return distance(p, q) < near; }))
        rest.push_back(p);
    std::sort(rest.begin(), rest.end(),
              [](const Point& a, const Point& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
    // Monotone chain (Andrew, 1979). A vertex is a corner if it stands out from the line between its neighbours.
    std::vector<Point> hull;
    const auto add = [&](const Point& p, std::size_t count_min) {
      while (hull.size() > count_min) {
        const Point& a = hull[hull.size() - 2];
        const Point& b = hull.back();
        const double area = (b.x - a.x) * (p.y - b.y) - (b.y - a.y) * (p.x - b.x);
        if (area > 2e-5 * extent * distance(a, p)) break;
        hull.pop_back();
      }
      hull.push_back(p);
    };
    for (const Point& p : rest) add(p, 1);
    const std::size_t lower_count = hull.size();
    for (std::size_t i = rest.size() < 2 ? 0 : rest.size() - 1; i-- > 0;) add(rest[i], lower_count);
    if (hull.size() > 1) hull.pop_back();
    return hull;
  }

  /// Lines of Box2D 2.3, the origin of the format, have two sides. Two points become a segment. More points become a
  /// chain and a second chain in reverse order.
  void read_chain(const Place& at, Shape& shape, Body& body) {
    const std::vector<Point> given = points(at, limits::chain_vertex_count_max + 1);
    if (error_) return;
    for (const Point& p : given)
      if (shape.vertices.empty() || distance(shape.vertices.back(), p) >= chain_distance) shape.vertices.push_back(p);
    const bool has_previous = flag(at, "hasPrevVertex");
    const bool has_next = flag(at, "hasNextVertex");
    const Point previous = point(at, "prevVertex");
    const Point next = point(at, "nextVertex");
    std::vector<Point>& line = shape.vertices;
    shape.loop = line.size() >= 4 && distance(line.front(), line.back()) < chain_distance;
    if (shape.loop) line.pop_back();
    if (line.size() < 2) return fail(ErrorCode::invalid_scene, at, "found fewer than 2 different points of a chain");
    if (line.size() + (shape.loop ? 1 : 0) != given.size())
      note("changed: " + at.path + ": points closer than " + engine::number_text(chain_distance) + " m are one point");
    const bool continues =
        shape.loop && distance(previous, line.back()) < chain_distance && distance(next, line[1]) < chain_distance;
    if ((has_previous || has_next) && !continues)
      note("not imported: " + at.path + ": what lies beyond its ends (prevVertex, nextVertex)");
    if (line.size() == 2) {
      shape.kind = ShapeKind::segment;
      body.shapes.push_back(std::move(shape));
      return;
    }
    shape.kind = ShapeKind::chain;
    body.shapes.push_back(shape);
    std::reverse(line.begin(), line.end());
    body.shapes.push_back(std::move(shape));
  }

  /// Gives a body without shapes a small sensor. The format allows bodies without shapes, to hold joints; a scene does
  /// not.
  void add_placeholder(const Place& at, Body& body) {
    Shape shape;
    shape.radius = tiny_radius;
    shape.density = density_min;
    shape.sensor = true;
    shape.filter = {0, 0, 0};
    body.shapes.push_back(shape);
    note("changed: " + label(at) + ": has no fixture, gets a sensor that sees nothing");
  }

  void read_mass(const Place& at, Body& body) {
    const double mass = number(at, "massData-mass");
    const double inertia_of_origin = number(at, "massData-I");
    const Point center = point(at, "massData-center");
    if (error_ || body.type != BodyType::dynamic_body) return;
    if (mass < 0) return refuse(at.at("massData-mass"), "at least 0");
    if (mass > 0) {
      body.mass.emplace();
      body.mass->mass = mass;
      body.mass->center = center;
      // The file states the inertia about the body's origin, and a scene about the centre of mass (parallel axes).
      const double inertia = inertia_of_origin - mass * (center.x * center.x + center.y * center.y);
      if (inertia > 0 && !body.fixed_rotation) body.mass->inertia = inertia;
      if (inertia <= 0 && inertia_of_origin > 0 && !body.fixed_rotation)
        note("not imported: " + label(at) + ": massData-I, less than its mass at its centre gives");
      return;
    }
    for (const Shape& shape : body.shapes)
      if (shape.kind <= ShapeKind::polygon && shape.density > density_min) return;
    // As in Box2D, a dynamic body without mass gets 1 kg and a fixed rotation.
    body.mass = engine::ExplicitMass{1, {}, Point{}};
    body.fixed_rotation = true;
    note("changed: " + label(at) + ": has no mass, gets 1 kg and does not turn");
  }

  Point center_of(const Place& at, const Body& body) {
    if (body.mass && body.mass->center) return *body.mass->center;
    Body solid = body;
    solid.shapes.erase(std::remove_if(solid.shapes.begin(), solid.shapes.end(),
                                      [](const Shape& shape) { return shape.kind > ShapeKind::polygon; }),
                       solid.shapes.end());
    if (solid.shapes.empty()) return {};
    const Point center = engine::body_mass(solid).center;
    if (body.type == BodyType::kinematic_body && body.angular_velocity != 0 && distance(center, {}) > weld_distance)
      note("changed: " + label(at) + ": turns about the centre of its shapes, not about its origin");
    return center;
  }

  // ---- Joints ----

  void read_joint(const Place& at) {
    joint_ids_.emplace_back();
    const std::string type = text(at, "type");
    if (type == "gear") return;  // read_gear, when all other joints are known
    Joint joint;
    const std::size_t body_count = body_ids_.size();
    for (const char* key : {"bodyA", "bodyB"})
      if (!at.has(key)) return fail(ErrorCode::invalid_scene, at, "found no \"" + std::string(key) + "\"");
    if (body_count == 0) return fail(ErrorCode::invalid_scene, at, "found a joint, expected none: there are no bodies");
    const auto last = static_cast<std::int64_t>(body_count) - 1;
    const auto place_a = static_cast<std::size_t>(whole(at, "bodyA", 0, last, 0));
    const auto place_b = static_cast<std::size_t>(whole(at, "bodyB", 0, last, 0));
    if (error_) return;
    if (type == "pulley") return note("not imported: " + label(at) + ": " + type);
    const auto is_dynamic = [&](std::uint32_t body) { return out_.scene.bodies[body].type == BodyType::dynamic_body; };
    if (place_a == place_b)
      return fail(ErrorCode::invalid_scene, at, "found body " + std::to_string(place_a) + " twice, expected two");
    if (!body_ids_[place_a] || !body_ids_[place_b])
      return note("not imported: " + label(at) + ": one of its bodies is inactive");
    joint.body_a = *body_ids_[place_a];
    joint.body_b = *body_ids_[place_b];
    if (!is_dynamic(joint.body_b) && (type == "mouse" || !is_dynamic(joint.body_a)))
      return note("not imported: " + label(at) + ": joins nothing that moves freely");
    joint.name = joint_names_.take(name_of(at));
    joint.collide_connected = flag(at, "collideConnected");
    joint.anchor_a = point(at, "anchorA");
    joint.anchor_b = point(at, "anchorB");
    use(at, "jointSpeed");  // the last speed of the joint is not a setting

    if (type == "revolute")
      read_revolute(at, joint);
    else if (type == "prismatic")
      read_prismatic(at, joint);
    else if (type == "distance")
      read_distance(at, joint);
    else if (type == "rope")
      read_rope(at, joint);
    else if (type == "wheel")
      read_wheel(at, joint);
    else if (type == "weld")
      read_weld(at, joint);
    else if (type == "motor")
      read_motor_joint(at, joint);
    else if (type == "friction")
      read_friction(at, joint);
    else if (type == "mouse")
      read_mouse(at, joint);
    else if (at.has("type"))
      refuse(at.at("type"), "revolute, prismatic, distance, rope, wheel, weld, motor, friction, mouse, gear or pulley");
    else
      fail(ErrorCode::invalid_scene, at, "found no \"type\"");
    if (error_) return;
    count_ignored(at, "joint");
    joint_ids_.back() = static_cast<std::uint32_t>(out_.scene.joints.size());
    out_.scene.joints.push_back(std::move(joint));
  }

  void read_gear(const Place& at) {
    if (text(at, "type") != "gear") return;
    const auto leave_out = [&](const std::string& why) { note("not imported: " + label(at) + ": gear, " + why); };
    Joint gear;
    gear.kind = JointKind::gear;
    std::uint32_t* const parts[] = {&gear.joint_a, &gear.joint_b};
    const char* const keys[] = {"joint1", "joint2"};
    for (std::size_t i = 0; i < 2; ++i) {
      if (!at.has(keys[i])) return leave_out("which names no " + std::string(keys[i]));
      const auto last = static_cast<std::int64_t>(joint_ids_.size()) - 1;
      const auto place = static_cast<std::size_t>(whole(at, keys[i], 0, last, 0));
      if (error_) return;
      if (!joint_ids_[place]) return leave_out("a joint of which was not imported");
      *parts[i] = *joint_ids_[place];
      if (!traits_of(out_.scene.joints[*parts[i]].kind).has_coordinate)
        return leave_out("a joint of which is neither revolute nor prismatic");
    }
    if (out_.scene.joints[gear.joint_a].body_b == out_.scene.joints[gear.joint_b].body_b)
      return leave_out("both joints of which have the same bodyB");
    gear.ratio = at.has("ratio") ? number(at, "ratio") : 1;
    const double size = gear.ratio < 0 ? -gear.ratio : gear.ratio;
    if (error_) return;
    if (!(size >= 1e-3 && size <= 1e3)) return leave_out("the ratio of which is 0 or extreme");
    gear.name = joint_names_.take(name_of(at));
    gear.collide_connected = flag(at, "collideConnected");
    for (const char* key : {"bodyA", "bodyB", "anchorA", "anchorB", "jointSpeed"}) use(at, key);  // of its joints
    count_ignored(at, "joint");
    out_.scene.joints.push_back(std::move(gear));
  }

  void read_limits(const Place& at, Joint& joint) {
    const double lower = number(at, "lowerLimit");
    const double upper = number(at, "upperLimit");
    if (!flag(at, "enableLimit")) return;
    // A limit that is missing in the file is 0.
    if (lower > upper && at.has("lowerLimit"))
      refuse(at.at("lowerLimit"), "at most upperLimit: " + engine::number_text(upper));
    else if (lower > upper)
      refuse(at.at("upperLimit"), "at least 0, since there is no lowerLimit");
    joint.limits = Range{lower, upper};
  }
  void read_motor(const Place& at, const char* force_key, Joint& joint) {
    const double speed = number(at, "motorSpeed");
    const double force_max = number(at, force_key);
    if (flag(at, "enableMotor")) joint.motor = engine::JointMotor{speed, force_max};
  }
  void read_axis(const Place& at, Joint& joint) {
    use(at, "localAxisA");
    const char* key = at.has("localAxisA") ? "localAxisA" : "localAxis1";  // the older name
    joint.axis = point(at, key);
    if (!error_ && !(distance(joint.axis, {}) > 0)) fail(ErrorCode::invalid_scene, at, "found no axis of a length");
  }
  /// In Box2D, a frequency of 0 means no spring.
  void read_spring(const Place& at, const char* frequency_key, const char* ratio_key, Joint& joint) {
    JointSpring spring;
    spring.hertz = number(at, frequency_key);
    spring.damping_ratio = number(at, ratio_key);
    if (spring.hertz > 0) joint.spring = spring;
  }

  /// Box2D derives the stiffness of this spring from masses and inertias. `hertz` in a scene also depends on the
  /// distance of the anchor from the centre of mass, so the spring gets absolute values.
  JointSpring absolute_spring(const JointSpring& spring, double inertia) const {
    const double omega = 2 * engine::pi * spring.hertz;
    return {true, 0, 0, inertia * omega * omega, 2 * spring.damping_ratio * omega * inertia};
  }
  double inertia_of(std::uint32_t body) const { return engine::body_mass(out_.scene.bodies[body]).inertia; }

  void read_revolute(const Place& at, Joint& joint) {
    joint.kind = JointKind::revolute;
    joint.reference_angle = number(at, "refAngle");
    read_limits(at, joint);
    read_motor(at, "maxMotorTorque", joint);
  }
  void read_prismatic(const Place& at, Joint& joint) {
    joint.kind = JointKind::prismatic;
    joint.reference_angle = number(at, "refAngle");
    read_axis(at, joint);
    read_limits(at, joint);
    read_motor(at, "maxMotorForce", joint);
  }
  void read_distance(const Place& at, Joint& joint) {
    joint.kind = JointKind::distance;
    joint.length = number(at, "length");
    read_spring(at, "frequency", "dampingRatio", joint);
  }
  void read_rope(const Place& at, Joint& joint) {
    joint.kind = JointKind::distance;
    joint.length = number(at, "maxLength");
    joint.limits = Range{0, joint.length};
    joint.spring.emplace().absolute = true;  // without stiffness
  }
  void read_wheel(const Place& at, Joint& joint) {
    joint.kind = JointKind::wheel;
    read_axis(at, joint);
    read_motor(at, "maxMotorTorque", joint);
    read_spring(at, "springFrequency", "springDampingRatio", joint);
  }
  void read_weld(const Place& at, Joint& joint) {
    joint.kind = JointKind::weld;
    joint.reference_angle = number(at, "refAngle");
    read_spring(at, "frequency", "dampingRatio", joint);
    const double inertia_a = inertia_of(joint.body_a), inertia_b = inertia_of(joint.body_b);
    const double inverse = (inertia_a > 0 ? 1 / inertia_a : 0) + (inertia_b > 0 ? 1 / inertia_b : 0);
    if (joint.spring && inverse > 0) joint.spring = absolute_spring(*joint.spring, 1 / inverse);
  }
  void read_motor_joint(const Place& at, Joint& joint) {
    joint.kind = JointKind::motor;
    joint.offset = std::exchange(joint.anchor_a, {});  // the format stores the offset under this key
    joint.anchor_b = {};
    joint.angle_offset = number(at, "refAngle");
    joint.force_max = number(at, "maxForce");
    joint.torque_max = number(at, "maxTorque");
    const double factor = number(at, "correctionFactor", default_correction);
    if (error_) return;
    if (!(factor > 0 && factor <= 1)) return refuse(at.at("correctionFactor"), "above 0, at most 1");
    // Each step removes the share `factor` of the error. An overdamped spring returns at the rate omega / (2
    // damping_ratio), which is set to factor / dt.
    const double hertz = 1 / out_.scene.settings.dt;
    joint.spring = JointSpring{false, hertz, engine::pi / factor, 0, 0};
  }
  void read_friction(const Place& at, Joint& joint) {
    joint.kind = JointKind::friction;
    if (joint.anchor_b != Point{})
      note("not imported: " + label(at) + ": anchors; it acts at the centre of mass of its second body");
    joint.anchor_a = joint.anchor_b = {};
    joint.force_max = number(at, "maxForce");
    joint.torque_max = number(at, "maxTorque");
  }
  /// Box2D grips B at the point where the target is when the joint is created.
  void read_mouse(const Place& at, Joint& joint) {
    const Body& body = out_.scene.bodies[joint.body_b];
    joint.kind = JointKind::target;
    joint.body_a = 0;
    joint.anchor_a = {};
    joint.collide_connected = false;
    joint.offset = point(at, "target");
    joint.anchor_b = rotated(-body.angle, {joint.offset.x - body.position.x, joint.offset.y - body.position.y});
    joint.force_max = number(at, "maxForce");
    read_spring(at, "frequency", "dampingRatio", joint);
    if (joint.spring) joint.spring = absolute_spring(*joint.spring, engine::body_mass(body).mass);
  }

  const Json& root_;
  const std::string& source_;
  RubeImport out_;
  UniqueNames body_names_;
  UniqueNames joint_names_;
  std::vector<std::optional<std::uint32_t>> joint_ids_;  // [index in the file]: index in the scene; absent: left out
  std::vector<std::optional<std::uint32_t>> body_ids_;   // [index in the file]: index in the scene; absent: left out
  std::set<std::pair<const Json*, std::string>> used_;
  std::map<std::string, std::size_t> ignored_;
  std::size_t note_count_ = 0;
  std::optional<Error> error_;
};

}  // namespace

Result<RubeImport> import_rube(std::string_view json, const std::string& source, const std::string& name) {
  if (json.size() > rube_file_size_max)
    return Error{ErrorCode::limit,
                 source + ": too large: found " + std::to_string(json.size()) + " bytes, expected at most " +
                     std::to_string(rube_file_size_max),
                 ""};
  if (const Status status = check_extent(json, source); !status) return status.error();
  Json root;
  try {
    root = Json::parse(json);
  } catch (const Json::exception& exception) {
    std::string_view reason = exception.what();
    if (const std::size_t at = reason.find("] "); at != std::string_view::npos) reason.remove_prefix(at + 2);
    std::string printable;
    for (const char c : reason.substr(0, 160)) printable += c >= 0x20 && c < 0x7f ? c : '?';
    return Error{ErrorCode::invalid_scene, source + ": broken JSON: " + printable, ""};
  }
  return Importer(root, source).run(name);
}

}  // namespace ticktrue::verifier
