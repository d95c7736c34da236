// Reads the JSON that R.U.B.E. exports: world, bodies with fixtures, joints.
// SPDX-License-Identifier: MIT
// Source: Campbell, "R.U.B.E. JSON structure", iforce2d.net/rube/json-structure, 2011 to 2017 (the format); Catto,
// Box2D manual 2.3 (the meaning of the values).
#include "tool/import/import_rube.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/limits.h"
#include "engine/json/number_text.h"
#include "engine/scene/hull.h"
#include "tool/import/rube_joints.h"
#include "tool/import/rube_reader.h"

namespace ticktrue::tool {
namespace {

using Json = nlohmann::json;
using engine::Body;
using engine::BodyType;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;

constexpr std::size_t depth_max = 16;                 // a vertex's coordinate is at depth 8
constexpr std::size_t value_count_max = 4'000'000;    // of a file; each value needs 64 bytes in memory
constexpr std::size_t polygon_point_count_max = 256;  // before cleaning
constexpr double weld_distance = 0.0025;              // m; Box2D merges polygon vertices closer than half its slop
constexpr double chain_distance = 0.005;              // m; Box2D refuses chain points closer than its slop
constexpr double skin = 0.0075;                       // m; half of the gap that Box2D leaves between resting polygons
constexpr double density_min = 1e-9;                  // kg/m^2; replaces a density of 0 in the file
constexpr double tiny_radius = 0.01;                  // m, of the sensor that replaces missing shapes of a body

// Keys that an exporter writes and the import ignores: names of layers, settings of Box2D's solver.
constexpr std::array<const char*, 8> world_keys_without_effect{
    "collisionbitplanes", "autoClearForces", "positionIterations", "velocityIterations",
    "warmStarting",       "subStepping",     "allowSleep",         "contactListener"};

double distance(const Point& a, const Point& b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

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

class Importer {
 public:
  Importer(const Json& root, const std::string& source) : root_(root), in_(source) {}

  Result<RubeImport> run(const std::string& name) {
    scene_.name = name;
    const RubePlace world{&root_, ""};
    if (!root_.is_object()) {
      in_.refuse(world, "an object with \"body\"");
      return *in_.error();
    }
    read_world(world);
    const auto each = [&](const char* key, std::size_t count_max, auto read) {
      for (std::size_t i = 0; i < in_.list_size(world, key, count_max) && !in_.has_failed(); ++i)
        read(world.at(key).at(i));
    };
    each("body", limits::body_count_max, [&](const RubePlace& at) { body_names_.reserve(in_.name_of(at)); });
    each("body", limits::body_count_max, [&](const RubePlace& at) { read_body(at); });
    each("joint", limits::joint_count_max, [&](const RubePlace& at) { joint_names_.reserve(in_.name_of(at)); });
    each("joint", limits::joint_count_max,
         [&](const RubePlace& at) { read_rube_joint(in_, at, body_ids_, joint_ids_, joint_names_, scene_); });
    each("joint", limits::joint_count_max,
         [&](const RubePlace& at) { read_rube_gear(in_, at, joint_ids_, joint_names_, scene_); });
    each("image", limits::body_count_max,
         [&](const RubePlace& at) { in_.note("not imported: " + RubeReader::label(at) + " (no physics)"); });
    if (in_.has_failed()) return *in_.error();
    in_.note_ignored_keys();
    return RubeImport{std::move(scene_), in_.take_notes()};
  }

 private:
  // ---- World ----

  void read_world(const RubePlace& world) {
    scene_.gravity = in_.point(world, "gravity");
    const double steps = in_.number(world, "stepsPerSecond", 60);
    if (!(steps >= 1 / limits::dt_max_s && steps <= 1 / limits::dt_min_s) && !in_.has_failed())
      in_.refuse(world.at("stepsPerSecond"), "steps per second, at least " + engine::number_text(1 / limits::dt_max_s));
    scene_.settings.dt = 1 / steps;
    scene_.settings.continuous = in_.flag(world, "continuousPhysics");
    for (const char* key : world_keys_without_effect) in_.use(world, key);
    for (const char* key : {"body", "joint", "image"}) in_.use(world, key);
    in_.count_ignored(world, "world");
  }

  // ---- Bodies ----

  void read_body(const RubePlace& at) {
    body_ids_.emplace_back();
    const bool is_active = in_.flag(at, "active", true);
    if (in_.has_failed()) return;
    if (!is_active) {
      in_.exchange_used({});
      return in_.note("not imported: " + RubeReader::label(at) + ": is inactive");
    }
    Body body;
    body.name = body_names_.take(in_.name_of(at));
    constexpr std::array types{BodyType::static_body, BodyType::kinematic_body, BodyType::dynamic_body};
    body.type = types[static_cast<std::size_t>(in_.whole(at, "type", 0, 2, 0))];
    const bool is_static = body.type == BodyType::static_body;
    body.position = in_.point(at, "position");
    body.angle = in_.number(at, "angle");
    const Point velocity = in_.point(at, "linearVelocity");
    const double angular_velocity = in_.number(at, "angularVelocity");
    if (is_static && (velocity != Point{} || angular_velocity != 0))
      in_.note("not imported: " + RubeReader::label(at) + ": velocity of a static body");
    body.angular_velocity = is_static ? 0 : angular_velocity;
    body.linear_damping = in_.number(at, "linearDamping");
    body.angular_damping = in_.number(at, "angularDamping");
    body.gravity_scale = in_.number(at, "gravityScale", 1);
    body.fixed_rotation = in_.flag(at, "fixedRotation");
    body.bullet = in_.flag(at, "bullet");
    body.can_sleep = in_.flag(at, "allowSleep", true);
    if (!in_.flag(at, "awake") && body.type == BodyType::dynamic_body)
      in_.note("not imported: " + RubeReader::label(at) + ": sleeps at the start");
    in_.use(at, "fixture");
    if (at.has("fixture")) read_fixtures(at, body);
    if (in_.has_failed()) return;
    if (body.shapes.empty()) add_placeholder(at, body);
    read_mass(at, body);
    // Box2D states the velocity of the body's origin, and a scene the velocity of the centre of mass.
    if (!is_static) {
      const Point arm = rotated_point(body.angle, center_of(at, body));
      body.velocity = {velocity.x - body.angular_velocity * arm.y, velocity.y + body.angular_velocity * arm.x};
    }
    in_.count_ignored(at, "body");
    body_ids_.back() = static_cast<std::uint32_t>(scene_.bodies.size());
    scene_.bodies.push_back(std::move(body));
  }

  void read_fixtures(const RubePlace& at, Body& body) {
    const std::size_t count = in_.list_size(at, "fixture", limits::shape_count_per_body_max);
    RubeReader::UsedKeys used_by_body = in_.exchange_used({});
    for (std::size_t i = 0; i < count && !in_.has_failed(); ++i) read_fixture(at.at("fixture").at(i), body);
    in_.exchange_used(std::move(used_by_body));
  }

  void read_fixture(const RubePlace& at, Body& body) {
    if (!at.value->is_object()) return in_.refuse(at, "an object");
    in_.use(at, "name");
    Shape shape;
    const double density = in_.number(at, "density");
    shape.density = density > 0 ? density : density_min;
    shape.material.friction = in_.number(at, "friction");
    shape.material.restitution = in_.number(at, "restitution");
    shape.sensor = in_.flag(at, "sensor");
    // The format has 16 bits each. An exporter that treats the bits as signed writes -1 if all bits are set.
    shape.filter.category =
        static_cast<std::uint32_t>(in_.whole(at, "filter-categoryBits", -32768, 65535, 1)) & 0xffffu;
    const auto mask = static_cast<std::uint32_t>(in_.whole(at, "filter-maskBits", -32768, 65535, 65535)) & 0xffffu;
    shape.filter.mask = mask == 0xffffu ? engine::Filter{}.mask : mask;  // a full mask means every category
    shape.filter.group = static_cast<std::int32_t>(in_.whole(at, "filter-groupIndex", -32768, 32767, 0));
    for (const char* key : {"circle", "polygon", "chain"}) in_.use(at, key);
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
      in_.refuse(at, "a \"circle\", \"polygon\" or \"chain\" in it");
    }
    if (!in_.has_failed()) in_.count_ignored(at, "fixture");
  }

  void read_circle(const RubePlace& at, Shape& shape) {
    if (!at.value->is_object()) return in_.refuse(at, "an object with \"radius\"");
    shape.kind = ShapeKind::circle;
    shape.radius = in_.number(at, "radius");
    shape.center = in_.point(at, "center");
    if (!in_.has_failed() && !(shape.radius > 0))
      in_.fail(ErrorCode::invalid_scene, at, "found no radius, expected one above 0");
  }

  void read_polygon(const RubePlace& at, Shape& shape) {
    shape.kind = ShapeKind::polygon;
    shape.radius = skin;  // editors save resting bodies one skin apart
    shape.vertices = in_.points(at, polygon_point_count_max);
    if (in_.has_failed()) return;
    const std::size_t count = shape.vertices.size();
    if (engine::build_hull(shape.vertices).has_value()) return;
    shape.vertices = cleaned(shape.vertices);
    if (const auto hull = engine::build_hull(shape.vertices); !hull)
      return in_.fail(ErrorCode::invalid_scene, at,
                      "not a convex polygon of area, even without what Box2D leaves out: " + hull.error().message);
    in_.note("changed: " + at.path + ": " + std::to_string(count) + " vertices, of which " +
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
  void read_chain(const RubePlace& at, Shape& shape, Body& body) {
    const std::vector<Point> given = in_.points(at, limits::chain_vertex_count_max + 1);
    if (in_.has_failed()) return;
    for (const Point& p : given)
      if (shape.vertices.empty() || distance(shape.vertices.back(), p) >= chain_distance) shape.vertices.push_back(p);
    const bool has_previous = in_.flag(at, "hasPrevVertex");
    const bool has_next = in_.flag(at, "hasNextVertex");
    const Point previous = in_.point(at, "prevVertex");
    const Point next = in_.point(at, "nextVertex");
    std::vector<Point>& line = shape.vertices;
    shape.loop = line.size() >= 4 && distance(line.front(), line.back()) < chain_distance;
    if (shape.loop) line.pop_back();
    if (line.size() < 2)
      return in_.fail(ErrorCode::invalid_scene, at, "found fewer than 2 different points of a chain");
    if (line.size() + (shape.loop ? 1 : 0) != given.size())
      in_.note("changed: " + at.path + ": points closer than " + engine::number_text(chain_distance) +
               " m are one point");
    const bool continues =
        shape.loop && distance(previous, line.back()) < chain_distance && distance(next, line[1]) < chain_distance;
    if ((has_previous || has_next) && !continues)
      in_.note("not imported: " + at.path + ": what lies beyond its ends (prevVertex, nextVertex)");
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
  void add_placeholder(const RubePlace& at, Body& body) {
    Shape shape;
    shape.radius = tiny_radius;
    shape.density = density_min;
    shape.sensor = true;
    shape.filter = {0, 0, 0};
    body.shapes.push_back(shape);
    in_.note("changed: " + RubeReader::label(at) + ": has no fixture, gets a sensor that sees nothing");
  }

  void read_mass(const RubePlace& at, Body& body) {
    const double mass = in_.number(at, "massData-mass");
    const double inertia_of_origin = in_.number(at, "massData-I");
    const Point center = in_.point(at, "massData-center");
    if (in_.has_failed() || body.type != BodyType::dynamic_body) return;
    if (mass < 0) return in_.refuse(at.at("massData-mass"), "at least 0");
    if (mass > 0) {
      body.mass.emplace();
      body.mass->mass = mass;
      body.mass->center = center;
      // The file states the inertia about the body's origin, and a scene about the centre of mass (parallel axes).
      const double inertia = inertia_of_origin - mass * (center.x * center.x + center.y * center.y);
      if (inertia > 0 && !body.fixed_rotation) body.mass->inertia = inertia;
      if (inertia <= 0 && inertia_of_origin > 0 && !body.fixed_rotation)
        in_.note("not imported: " + RubeReader::label(at) + ": massData-I, less than its mass at its centre gives");
      return;
    }
    for (const Shape& shape : body.shapes)
      if (shape.kind <= ShapeKind::polygon && shape.density > density_min) return;
    // As in Box2D, a dynamic body without mass gets 1 kg and a fixed rotation.
    body.mass = engine::ExplicitMass{1, {}, Point{}};
    body.fixed_rotation = true;
    in_.note("changed: " + RubeReader::label(at) + ": has no mass, gets 1 kg and does not turn");
  }

  Point center_of(const RubePlace& at, const Body& body) {
    if (body.mass && body.mass->center) return *body.mass->center;
    Body solid = body;
    solid.shapes.erase(std::remove_if(solid.shapes.begin(), solid.shapes.end(),
                                      [](const Shape& shape) { return shape.kind > ShapeKind::polygon; }),
                       solid.shapes.end());
    if (solid.shapes.empty()) return {};
    const Point center = engine::body_mass(solid).center;
    if (body.type == BodyType::kinematic_body && body.angular_velocity != 0 && distance(center, {}) > weld_distance)
      in_.note("changed: " + RubeReader::label(at) + ": turns about the centre of its shapes, not about its origin");
    return center;
  }

  const Json& root_;
  RubeReader in_;
  engine::Scene scene_;
  RubeNames body_names_;
  RubeNames joint_names_;
  RubeIds body_ids_;
  RubeIds joint_ids_;
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

}  // namespace ticktrue::tool
