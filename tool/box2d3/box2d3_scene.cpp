// Writes a scene for peer.mjs. Joints are a table: one row for each kind.
// SPDX-License-Identifier: MIT
#include "tool/box2d3/box2d3_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "tool/box2d/length_scale.h"

namespace ticktrue::tool {
namespace {

using engine::BodyType;
using engine::JointKind;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;
using nlohmann::json;

constexpr std::size_t polygon_vertex_max = 8;
constexpr double slop_m = 0.005;  // Box2D m

struct SceneWriter {
  double scale;

  double length(double meters) const { return meters * scale; }
  json point(const Point& p) const { return json::array({p.x * scale, p.y * scale}); }
  json points(const std::vector<Point>& list) const {
    json array = json::array();
    for (const Point& p : list) array.push_back(point(p));
    return array;
  }
};

Error refused_by_3(const std::string& place, std::string_view why) {
  return Error{ErrorCode::unsupported, fmt::format("{}: {}", place, why), {}};
}

// ---- Shapes ----

// Box2D's open chains end one point before their ends. The added points continue the chain straight on.
std::vector<Point> chain_points(const Shape& shape) {
  std::vector<Point> points = shape.vertices;
  if (shape.loop) return points;
  const auto beyond = [](const Point& end, const Point& next) { return Point{2 * end.x - next.x, 2 * end.y - next.y}; };
  const std::size_t last = points.size() - 1;
  const Point before = beyond(points[0], points[1]);
  const Point after = beyond(points[last], points[last - 1]);
  points.insert(points.begin(), before);
  points.push_back(after);
  return points;
}

Result<json> shape_json(const Shape& shape, const SceneWriter& writer, const std::string& place) {
  json object;
  object["kind"] = engine::info_of(engine::shape_kinds, shape.kind).name;
  object["radius"] = writer.length(shape.radius);
  switch (shape.kind) {
    case ShapeKind::circle:
      object["center"] = writer.point(shape.center);
      break;
    case ShapeKind::box:
      object["center"] = writer.point(shape.center);
      object["half_size"] = writer.point(shape.half_size);
      object["angle"] = shape.angle;
      break;
    case ShapeKind::polygon: {
      const Result<std::vector<Point>> hull = engine::build_hull(shape.vertices);
      if (!hull) return hull.error();
      if (hull->size() > polygon_vertex_max)
        return refused_by_3(place + "/vertices", fmt::format("too many for Box2D 3: found {}, expected at most {}",
                                                             hull->size(), polygon_vertex_max));
      object["points"] = writer.points(*hull);
      break;
    }
    case ShapeKind::capsule:
      object["points"] = writer.points(shape.vertices);
      break;
    case ShapeKind::segment:
      if (shape.radius > 0) return refused_by_3(place, "Box2D 3 rounds no lines");
      object["points"] = writer.points(shape.vertices);
      break;
    case ShapeKind::chain:
      if (shape.radius > 0) return refused_by_3(place, "Box2D 3 rounds no lines");
      if (shape.loop && shape.vertices.size() < 4)
        return refused_by_3(place, "Box2D 3 has no loops of fewer than 4 points");
      object["points"] = writer.points(chain_points(shape));
      object["loop"] = shape.loop;
      break;
  }
  object["friction"] = shape.material.friction;
  object["restitution"] = shape.material.restitution;
  object["rolling_resistance"] = shape.material.rolling_resistance;
  object["tangent_speed"] = -writer.length(shape.material.tangent_speed);  // Box2D's belts run clockwise
  object["category"] = shape.filter.category;
  object["mask"] = shape.filter.mask;
  object["group"] = shape.filter.group;
  return object;
}

// ---- Bodies ----

Result<json> body_json(const engine::Body& body, const SceneWriter& writer, const std::string& place) {
  const double reach = writer.length(std::max(std::fabs(body.position.x), std::fabs(body.position.y)));
  if (reach > box2d_coordinate_max_m)
    return refused_by_3(place + "/position",
                        fmt::format("too far out for Box2D's floats: found {:g} m, expected at most {:g} m",
                                    reach / writer.scale, box2d_coordinate_max_m / writer.scale));
  const engine::MassProperties mass = engine::body_mass(body);
  json object;
  object["type"] = engine::info_of(engine::body_types, body.type).name;
  object["position"] = writer.point(body.position);
  object["angle"] = std::remainder(body.angle, 2 * engine::pi);
  // A scene gives the velocity of the centre of mass. Box2D's kinematic bodies turn about their origin instead.
  Point velocity = body.velocity;
  if (body.type == BodyType::kinematic_body) {
    const engine::SinCos turn = engine::sin_cos(body.angle);
    const Point arm{turn.cos * mass.center.x - turn.sin * mass.center.y,
                    turn.sin * mass.center.x + turn.cos * mass.center.y};
    velocity.x += body.angular_velocity * arm.y;
    velocity.y -= body.angular_velocity * arm.x;
  }
  object["velocity"] = writer.point(velocity);
  object["spin"] = body.angular_velocity;
  object["linear_damping"] = body.linear_damping;
  object["angular_damping"] = body.angular_damping;
  object["gravity_scale"] = body.gravity_scale;
  object["fixed_rotation"] = body.fixed_rotation;
  object["bullet"] = body.bullet;
  object["mass"] = mass.mass;
  object["inertia"] = mass.inertia * writer.scale * writer.scale;
  object["center"] = writer.point(mass.center);
  object["shapes"] = json::array();
  for (std::size_t i = 0; i < body.shapes.size(); ++i) {
    if (body.shapes[i].sensor) continue;  // masses are explicit, and a sensor touches nothing
    Result<json> shape = shape_json(body.shapes[i], writer, fmt::format("{}/shapes/{}", place, i));
    if (!shape) return shape.error();
    object["shapes"].push_back(*std::move(shape));
  }
  return object;
}

// ---- Joints ----

// A joint under construction: the angles of its frames, and the fields of Box2D's definition.
struct JointJson {
  double angle_a = 0;
  double angle_b = 0;
  json fields = json::object();
};

void add_spring(const engine::Joint& joint, JointJson& out) {
  out.fields["enableSpring"] = joint.spring.has_value();
  if (!joint.spring) return;
  out.fields["hertz"] = joint.spring->hertz;
  out.fields["dampingRatio"] = joint.spring->damping_ratio;
}

void add_motor(const engine::Joint& joint, const char* limit, double speed_unit, double force_unit, JointJson& out) {
  if (!joint.motor) return;
  out.fields["enableMotor"] = true;
  out.fields["motorSpeed"] = joint.motor->speed * speed_unit;
  out.fields[limit] = joint.motor->force_max * force_unit;
}

void add_limits(const engine::Joint& joint, const char* lower, const char* upper, double unit, JointJson& out) {
  if (!joint.limits) return;
  out.fields["enableLimit"] = true;
  out.fields[lower] = joint.limits->lower * unit;
  out.fields[upper] = joint.limits->upper * unit;
}

// Each function fills `out` and returns why Box2D 3 cannot represent the joint, or null.
using WriteJoint = const char* (*)(const engine::Joint& joint, double scale, JointJson& out);

const char* write_revolute(const engine::Joint& joint, double scale, JointJson& out) {
  constexpr double limit_max = 0.99 * engine::pi;
  if (joint.limits && (joint.limits->lower < -limit_max || joint.limits->upper > limit_max))
    return "Box2D 3 has no limits beyond 178 degrees";
  out.angle_a = joint.reference_angle;
  add_spring(joint, out);
  add_limits(joint, "lowerAngle", "upperAngle", 1, out);
  add_motor(joint, "maxMotorTorque", 1, scale * scale, out);
  return nullptr;
}

const char* write_prismatic(const engine::Joint& joint, double scale, JointJson& out) {
  out.angle_a = std::atan2(joint.axis.y, joint.axis.x);
  out.angle_b = out.angle_a - joint.reference_angle;
  add_spring(joint, out);
  add_limits(joint, "lowerTranslation", "upperTranslation", scale, out);
  add_motor(joint, "maxMotorForce", scale, scale, out);
  return nullptr;
}

const char* write_wheel(const engine::Joint& joint, double scale, JointJson& out) {
  out.angle_a = std::atan2(joint.axis.y, joint.axis.x);
  add_spring(joint, out);
  add_limits(joint, "lowerTranslation", "upperTranslation", scale, out);
  add_motor(joint, "maxMotorTorque", 1, scale * scale, out);
  return nullptr;
}

const char* write_distance(const engine::Joint& joint, double scale, JointJson& out) {
  const bool is_rod = !joint.limits && !joint.spring;
  if (is_rod && joint.motor) return "Box2D 3 has no motors in rods";
  if (is_rod && joint.length * scale < slop_m) return "Box2D 3 has no rods shorter than its slop";
  out.fields["length"] = joint.length * scale;
  add_spring(joint, out);
  if (joint.limits && !joint.spring) {  // a rope: without the spring, Box2D would make it a rod
    out.fields["enableSpring"] = true;
    out.fields["hertz"] = 0;
  }
  add_limits(joint, "minLength", "maxLength", scale, out);
  add_motor(joint, "maxMotorForce", scale, scale, out);
  return nullptr;
}

const char* write_weld(const engine::Joint& joint, double, JointJson& out) {
  out.angle_a = joint.reference_angle;
  if (joint.spring) {
    out.fields["angularHertz"] = joint.spring->hertz;
    out.fields["angularDampingRatio"] = joint.spring->damping_ratio;
  }
  if (joint.linear_spring) {
    out.fields["linearHertz"] = joint.linear_spring->hertz;
    out.fields["linearDampingRatio"] = joint.linear_spring->damping_ratio;
  }
  return nullptr;
}

const char* no_motor_joint(const engine::Joint&, double, JointJson&) {
  return "Box2D 3 has no motor joints that hold an offset rigidly";
}
const char* no_friction_joint(const engine::Joint&, double, JointJson&) {
  return "Box2D 3 has no friction joints";
}
const char* no_target_joint(const engine::Joint&, double, JointJson&) {
  return "Box2D 3 has no mouse joints";
}
const char* no_pulley_joint(const engine::Joint&, double, JointJson&) {
  return "Box2D 3 has no pulley joints";
}
const char* no_gear_joint(const engine::Joint&, double, JointJson&) {
  return "Box2D 3 has no gear joints";
}

struct Box2d3Joint {
  JointKind kind;
  WriteJoint write;
};
constexpr std::array<Box2d3Joint, engine::joint_kinds.size()> box2d3_joints{{
    {JointKind::revolute, write_revolute},
    {JointKind::prismatic, write_prismatic},
    {JointKind::distance, write_distance},
    {JointKind::weld, write_weld},
    {JointKind::wheel, write_wheel},
    {JointKind::motor, no_motor_joint},
    {JointKind::friction, no_friction_joint},
    {JointKind::target, no_target_joint},
    {JointKind::pulley, no_pulley_joint},
    {JointKind::gear, no_gear_joint},
}};
static_assert(engine::rows_are_in_order(box2d3_joints));

// The check for every kind of joint.
const char* unknown_spring(const engine::Joint& joint) {
  for (const auto& spring : {joint.spring, joint.linear_spring}) {
    if (spring && spring->absolute) return "Box2D 3 has springs in hertz only, not in N/m";
    if (spring && !(spring->hertz > 0)) return "Box2D 3 has no damper alone";
  }
  return nullptr;
}

Result<json> joint_json(const engine::Joint& joint, const SceneWriter& writer, const std::string& place) {
  JointJson out;
  const char* refusal = info_of(box2d3_joints, joint.kind).write(joint, writer.scale, out);
  if (refusal == nullptr) refusal = unknown_spring(joint);
  if (refusal != nullptr) return refused_by_3(place, refusal);
  json object;
  object["kind"] = engine::info_of(engine::joint_kinds, joint.kind).name;
  object["body_a"] = joint.body_a;
  object["body_b"] = joint.body_b;
  object["collide_connected"] = joint.collide_connected;
  object["anchor_a"] = writer.point(joint.anchor_a);
  object["anchor_b"] = writer.point(joint.anchor_b);
  object["angle_a"] = out.angle_a;
  object["angle_b"] = out.angle_b;
  object["fields"] = std::move(out.fields);
  return object;
}

}  // namespace

Result<std::string> box2d3_scene_text(const engine::Scene& scene, const Box2d3Options& options, const Box2d3Plan& plan,
                                      double length_scale) {
  const SceneWriter writer{length_scale};
  if (!scene.forces.empty()) return refused_by_3(scene.name + ": /forces", "Box2D 3 has no force elements");
  const engine::Settings& settings = scene.settings;
  json object;
  object["gravity"] = writer.point(scene.gravity);
  object["dt"] = settings.dt;
  object["steps_per_tick"] = options.steps_per_tick;
  object["substeps"] = options.substeps;
  object["ticks"] = plan.tick_count;
  object["body_interval"] = plan.body_interval;
  object["contact_window"] = plan.contact_window;
  object["contact_interval"] = plan.contact_interval;
  object["warm_up"] = plan.warm_up;
  object["continuous"] = settings.continuous;
  object["restitution_threshold"] = writer.length(settings.restitution_threshold);
  object["friction_mix"] = engine::info_of(engine::mix_rules, settings.friction_mix).name;
  object["restitution_mix"] = engine::info_of(engine::mix_rules, settings.restitution_mix).name;
  object["bounds"] = nullptr;
  if (scene.bounds)
    object["bounds"] = {writer.length(scene.bounds->lower.x), writer.length(scene.bounds->lower.y),
                        writer.length(scene.bounds->upper.x), writer.length(scene.bounds->upper.y)};
  object["bodies"] = json::array();
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    Result<json> body = body_json(scene.bodies[i], writer, fmt::format("{}: /bodies/{}", scene.name, i));
    if (!body) return body.error();
    object["bodies"].push_back(*std::move(body));
  }
  object["joints"] = json::array();
  for (std::size_t i = 0; i < scene.joints.size(); ++i) {
    Result<json> joint = joint_json(scene.joints[i], writer, fmt::format("{}: /joints/{}", scene.name, i));
    if (!joint) return joint.error();
    object["joints"].push_back(*std::move(joint));
  }
  return object.dump();
}

}  // namespace ticktrue::tool
