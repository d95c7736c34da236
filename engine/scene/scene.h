// Scene: the plain description of a world, in f64 and SI units, in the form that people write.
// SPDX-License-Identifier: MIT
//
// The same type is read from JSON (scene_json.h), built from parameters (builtin_scenes.h) and embedded in traces in
// binary (scene_binary.h). Engines of both precisions are made from it (engine.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/limits.h"
#include "base/result.h"
#include "engine/scene/choices.h"
#include "engine/scene/input.h"
#include "engine/scene/joint_kinds.h"

namespace ticktrue::engine {

/// A vector of the description, m. The engine's own vectors are of its precision (math/vec2.h).
struct Point {
  double x = 0;
  double y = 0;
  bool operator==(const Point&) const = default;
};

struct Material {
  double friction = 0.6;          // Coulomb coefficient, >= 0
  double restitution = 0.0;       // 0..1
  double tangent_speed = 0;       // m/s: a conveyor: drives touching bodies along the surface, counter-clockwise
  double rolling_resistance = 0;  // >= 0; torque at most this times radius times normal force
  bool operator==(const Material&) const = default;
};

/// The rule for pairs of shapes. Shapes of the same non-zero group: a positive group always touches, a negative never.
/// Otherwise the category of each shape must be in the other's mask.
struct Filter {
  std::uint32_t category = 1;
  std::uint32_t mask = 0xffffffff;
  std::int32_t group = 0;
  bool operator==(const Filter&) const = default;
};

struct Shape {
  ShapeKind kind = ShapeKind::circle;
  Point center;                 // circle, box: in the body's frame, m
  double angle = 0;             // box: rad
  double radius = 0;            // circle, capsule: m; box, polygon: rounding, m, 0 for sharp corners
  Point half_size;              // box: m, without the rounding
  std::vector<Point> vertices;  // in the body's frame, m. polygon: any order, 3..16, strictly convex as a set;
                                // capsule: its two centres; segment: its two ends; chain: 2.. points in order
  bool loop = false;            // chain: the last point joins the first
  double density = 1;           // kg/m^2; not used if the body states its mass
  Material material;
  Filter filter;
  bool sensor = false;  // detects overlaps, touches nothing
  bool operator==(const Shape&) const = default;
};

/// Replaces the result of the shapes' densities.
struct ExplicitMass {
  double mass = 1;                // kg, > 0
  std::optional<double> inertia;  // kg m^2 about the centre of mass, > 0; absent: that of the shapes, scaled to `mass`
  std::optional<Point> center;    // centre of mass in the body's frame, m; absent: that of the shapes
  bool operator==(const ExplicitMass&) const = default;
};

struct Body {
  std::string name;  // may be empty; unique otherwise
  BodyType type = BodyType::dynamic_body;
  Point position;               // of the body's origin, m
  double angle = 0;             // rad
  Point velocity;               // of the centre of mass, m/s
  double angular_velocity = 0;  // rad/s
  double linear_damping = 0;    // 1/s
  double angular_damping = 0;   // 1/s
  double gravity_scale = 1;
  bool fixed_rotation = false;
  bool bullet = false;    // never passes other moving bodies at any speed (walls stop every body)
  bool can_sleep = true;  // if the scene lets bodies sleep
  std::optional<ExplicitMass> mass;
  std::vector<Shape> shapes;  // at least one
  bool operator==(const Body&) const = default;
};

struct Range {
  double lower = 0;
  double upper = 0;
  bool operator==(const Range&) const = default;
};

/// Stiffness of a joint: either hertz and damping ratio, relative to the joint's effective mass, or stiffness and
/// damping.
struct JointSpring {
  bool absolute = false;     // true: stiffness and damping are used; false: hertz and damping_ratio
  double hertz = 0;          // >= 0; 0: damping alone
  double damping_ratio = 0;  // >= 0
  double stiffness = 0;      // N/m or N m/rad, >= 0
  double damping = 0;        // N s/m or N m s/rad, >= 0
  bool operator==(const JointSpring&) const = default;
};

struct JointMotor {
  double speed = 0;      // m/s or rad/s, of B relative to A
  double force_max = 0;  // N or N m, >= 0
  bool operator==(const JointMotor&) const = default;
};

/// A joint of two bodies of the scene, or of the bodies of two earlier joints (gear). Comments list the kinds that use
/// a field; other kinds keep its default. A joint is removed when one of its bodies is removed.
struct Joint {
  std::string name;  // may be empty; unique otherwise
  JointKind kind = JointKind::revolute;
  std::uint32_t body_a = 0;           // index in Scene::bodies; target, gear: not used
  std::uint32_t body_b = 0;           // index in Scene::bodies; gear: not used
  Point anchor_a;                     // in A's frame, from its origin, m; all but motor, friction, target, gear
  Point anchor_b;                     // in B's frame, from its origin, m; all but motor, friction, gear
  Point axis{1, 0};                   // in A's frame, any length > 0; prismatic, wheel
  double reference_angle = 0;         // of B relative to A at rest, rad; revolute, prismatic, weld
  double length = 1;                  // m, of the rod or the relaxed spring; distance; pulley: l_a + ratio l_b
  std::optional<Range> limits;        // rad: revolute; m: prismatic, wheel, distance (limits and no spring: a rope)
  std::optional<JointMotor> motor;    // revolute, prismatic, wheel, distance
  std::optional<JointSpring> spring;  // revolute, prismatic, distance, wheel; weld: of the angle; target; motor
  std::optional<JointSpring> linear_spring;  // weld
  Point offset;                              // motor: of B's origin in A's frame, m; target: the point of the world, m
  double angle_offset = 0;                   // motor: of B relative to A, rad
  double force_max = 0;                      // N; motor, friction, target
  double torque_max = 0;                     // N m; motor, friction
  bool collide_connected = false;            // whether the two bodies touch each other
  Point ground_anchor_a;                     // pulley: point of the world, m; one end of A's rope
  Point ground_anchor_b;                     // pulley: point of the world, m; one end of B's rope
  double ratio = 1;                          // pulley: r > 0 in l_a + r l_b; gear: r != 0 in c_a + r c_b
  std::uint32_t joint_a = 0;                 // gear: index in Scene::joints, below the gear's own
  std::uint32_t joint_b = 0;                 // gear: likewise
  bool operator==(const Joint&) const = default;
};

/// Calls visit(point) for each point of the world to which a joint is attached.
template <typename Visit>
void for_each_world_point(Joint& joint, Visit visit) {
  if (traits_of(joint.kind).offset_is_of_world) visit(joint.offset);
  if (has_field(joint.kind, JointField::ground_anchor_a)) visit(joint.ground_anchor_a);
  if (has_field(joint.kind, JointField::ground_anchor_b)) visit(joint.ground_anchor_b);
}

/// A force element, evaluated by the integrator at each of its stages. Comments list the kinds that use a field.
struct Force {
  std::string name;  // may be empty; unique otherwise
  ForceKind kind = ForceKind::constant;
  std::optional<std::uint32_t> body;   // index in Scene::bodies; absent: every dynamic body (not for springs); not wind
  std::optional<std::uint32_t> other;  // spring: index of the other body; absent: `point` is fixed in the world
  Point anchor;                        // spring: in the body's frame, from its origin, m
  Point point;                         // spring: anchor of the other body, or a point of the world, m; central: centre
  Point vector;                        // constant: N; wind: m/s
  double torque = 0;                   // constant: N m
  double coefficient = 0;              // linear_drag: kg/s; quadratic_drag: kg/m; central: k, N/(kg m^p), > 0 attracts
  double angular_coefficient = 0;      // linear_drag: N m s; quadratic_drag: N m s^2
  double exponent = -2;                // central: p; whole, -3..3
  double stiffness = 0;                // spring: N/m
  double damping = 0;                  // spring: N s/m
  double rest_length = 0;              // spring: m
  bool operator==(const Force&) const = default;
};

/// The conversion of host frames to ticks. The clock acts while a session is recorded; the trace stores the ticks' dt.
struct ClockSettings {
  ClockKind kind = ClockKind::fixed;
  int ticks_per_frame_max = 5;  // semi_fixed
  double tolerance = 1e-4;      // adaptive: m (and rad) per tick
  double dt_min = 1e-6;         // s; adaptive
  double dt_max = 0.1;          // s; adaptive, variable: longer frames are cut to this length, and a report says so
  bool operator==(const ClockSettings&) const = default;
};

struct SleepSettings {
  double after_s = 0.5;     // idle time before sleep
  double speed_max = 0.05;  // m/s, upper bound for all points of an idle body
  bool operator==(const SleepSettings&) const = default;
};

/// Substeps are chosen per island, so that the expected error stays below the target.
struct AutoSubsteps {
  double target_error = 0.005;  // relative to the size of the smallest shape of the island
  int substeps_max = 256;       // 1..256; a power of two
  bool operator==(const AutoSubsteps&) const = default;
};

struct Bounds {
  Point lower;  // m
  Point upper;  // m
  bool operator==(const Bounds&) const = default;
};

/// A pointer (mouse, finger) that presses, drags and releases.
struct PointerSettings {
  std::vector<std::string> spawns;  // prototypes that a press on empty space spawns, in turn; empty: nothing is spawned
  double hertz = 5;                 // of the mouse joint
  double damping_ratio = 0.7;
  double force_max_per_kg = 1000;  // N per kg of the pulled body
  std::optional<Bounds> window;    // the view of the pointer's screen (imports, pictures); absent: the scene's bounds
  bool operator==(const PointerSettings&) const = default;
};

struct Settings {
  Precision precision = Precision::f32;
  double dt = 1.0 / 60.0;                     // s
  int substeps = 4;                           // 1..256; 1 if the solver does not substep
  std::optional<AutoSubsteps> auto_substeps;  // present: `substeps` is the least number of an island
  int iterations = 10;                        // 1..1000; of solvers that iterate
  SolverKind solver = SolverKind::tgs_soft;
  IntegratorKind integrator = IntegratorKind::semi_implicit_euler;
  BroadPhaseKind broad_phase = BroadPhaseKind::aabb_tree;
  MixRule friction_mix = MixRule::geometric_mean;
  MixRule restitution_mix = MixRule::maximum;
  double restitution_threshold = 1.0;  // m/s: slower approaches do not bounce
  bool locate_impacts = false;         // bounces happen at the moment of impact, not at the end of the tick
  bool continuous = true;              // fast bodies do not pass walls, bullets pass nothing
  std::optional<SleepSettings> sleep;  // present: islands at rest sleep
  bool events = false;                 // begin and end of contacts are part of the state
  ClockSettings clock;
  JointSolverKind joints = JointSolverKind::iterative;
  SubstepLoads substep_loads = SubstepLoads::weight;  // the loads that determine automatic substeps
  int substep_budget = 0;  // a tick costs at most about as much as so many fixed substeps; 0: no limit
  bool operator==(const Settings&) const = default;
};

inline constexpr int default_substep_budget = 184;

/// Automatic substeps as scene files have them by `"substeps": "auto"` alone: from all loads, within a budget, and with
/// joints that are solved directly if the solver can.
inline void choose_substeps(Settings& settings) {
  settings.auto_substeps.emplace();
  settings.substep_loads = SubstepLoads::measured;
  settings.substep_budget = default_substep_budget;
  if (info_of(solvers, settings.solver).chooses_joints) settings.joints = JointSolverKind::direct;
}

/// Removes automatic substeps, and the settings that only they have.
inline void fix_substeps(Settings& settings) {
  settings.auto_substeps.reset();
  settings.substep_loads = SubstepLoads::weight;
  settings.substep_budget = 0;
}

/// A fixed number of substeps in place of automatic ones, with joints that are iterative again.
inline void use_fixed_substeps(Settings& settings, int count) {
  if (settings.auto_substeps) settings.joints = JointSolverKind::iterative;
  fix_substeps(settings);
  settings.substeps = count;
}

struct Scene {
  std::string name = "scene";
  Settings settings;
  Point gravity{0, -10};     // m/s^2
  std::vector<Body> bodies;  // ids 0, 1, 2, ... in this order
  std::vector<Joint> joints;
  std::vector<Force> forces;
  std::vector<Body> prototypes;   // named bodies that inputs may spawn; the input gives position, angle, velocity
  std::vector<InputKind> inputs;  // kinds that may occur, ascending; an input of another kind is refused
  std::optional<PointerSettings> pointer;    // present if press, drag and release may occur
  std::optional<Bounds> bounds;              // a body whose centre of mass leaves them is removed
  std::optional<std::uint32_t> spawned_max;  // with more spawned bodies, the oldest one is removed
  bool operator==(const Scene&) const = default;
};

/// Calls visit(body) with the index of each body of a joint, a gear's bodies included. A body may come twice. Requires:
/// a joint of a scene that check_scene accepts.
template <typename Visit>
void for_each_body(const Scene& scene, const Joint& joint, Visit visit) {
  if (joins_joints(joint.kind)) {
    for (const std::uint32_t part : {joint.joint_a, joint.joint_b}) {
      visit(scene.joints[part].body_a);
      visit(scene.joints[part].body_b);
    }
    return;
  }
  if (has_body_a(joint.kind)) visit(joint.body_a);
  visit(joint.body_b);
}

inline constexpr std::uint32_t no_joint = 0xffffffff;
/// Removes the joints for which `is_kept` is 0, and gears of removed joints. Returns the new index of each joint, or
/// no_joint. Requires: is_kept.size() == scene.joints.size().
std::vector<std::uint32_t> keep_joints(Scene& scene, const std::vector<std::uint8_t>& is_kept);

/// Whether two shapes can ever touch: a dynamic body and another body that it may touch exist, or inputs may spawn
/// them. Both the pipeline and check_scene use this function, so that they agree.
bool can_collide(const Scene& scene);

/// Checks every rule for scenes, whatever their origin: ranges, names, hulls, masses, limits, declared inputs. `source`
/// is the first place in an error (a file name). Messages carry the JSON path.
/// Errors: invalid_scene, limit, incompatible (choices that do not go together; the message names choices that would
/// work).
Status check_scene(const Scene& scene, const std::string& source);

}  // namespace ticktrue::engine
