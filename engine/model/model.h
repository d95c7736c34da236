// Model: a scene in the engine's precision, constant for the whole run.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "base/state/schema.h"
#include "engine/joints/joint_model.h"
#include "engine/math/vec2.h"
#include "engine/model/solver_kernels.h"
#include "engine/scene/scene.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

struct Model;

/// The classes of shapes that the narrow phase distinguishes.
enum class ShapeFamily : std::uint8_t {
  circle,
  polygon,     // a hull with sharp corners, boxes included
  round,       // a hull of 2..16 vertices and a radius: rounded polygons, capsules, and segments with radius 0
  chain_edge,  // one edge of a chain: has contacts on its right side only
};
inline constexpr std::size_t shape_family_count = 4;

/// A quadrilateral: its corners and the normals of the edges that begin there, in lanes of four.
struct Quad {
  Real x[4], y[4];  // m
  Real normal_x[4], normal_y[4];
};
inline constexpr std::uint32_t no_quad = 0xffffffff;

/// A convex shape, or one edge of a chain. Equal shapes of different bodies share one ShapeModel.
struct ShapeModel {
  ShapeFamily family = ShapeFamily::circle;
  Vec2 center;                     // of the circle; of the core's area; from the body's centre of mass, m
  Real radius = 0;                 // of the circle, or around the core, m; 0 for sharp corners
  Real bounding_radius = 0;        // of the circle around `center` that holds the shape, m
  Real size = 0;                   // twice the radius of the largest circle around `center` inside, m; of lines 0
  std::uint32_t first_vertex = 0;  // in Model::vertices and Model::normals
  std::uint32_t vertex_count = 0;
  Real friction = 0;
  Real restitution = 0;
  Real tangent_speed = 0;       // m/s
  Real rolling_resistance = 0;  // m: coefficient times radius
  Filter filter;
  std::uint32_t material = 0;    // index of its friction and restitution
  std::uint32_t quad = no_quad;  // in Model::quads, of a polygon with four corners
  bool is_sensor = false;
  bool has_before = false;  // chain edge: another edge ends where this one begins
  bool has_after = false;   // chain edge: another edge begins where this one ends
  Vec2 before;              // the begin of the edge before, m
  Vec2 after;               // the end of the edge after, m
};
/// Segments and chains: no area, no mass, and no contact with each other.
inline bool is_line(const ShapeModel& shape) {
  return shape.size == 0;
}
/// The size of a pair, to which tolerances are relative: that of the smaller shape. Lines have no size.
inline Real pair_size(const ShapeModel& a, const ShapeModel& b) {
  if (a.size == 0) return b.size;
  if (b.size == 0) return a.size;
  return smaller(a.size, b.size);
}

/// The constants of all bodies of one description.
struct BodyModel {
  BodyType type = BodyType::dynamic_body;
  Real mass = 0;                 // kg; 0 unless dynamic
  Real inv_mass = 0;             // 1/kg; 0 unless dynamic
  Real inertia = 0;              // kg m^2; 0 unless dynamic and free to rotate
  Real inv_inertia = 0;          // 1/(kg m^2)
  Real impulse_inv_inertia = 0;  // by the thesis' formulas; used by the `impulse` solver alone
  Vec2 center;                   // of mass, from the body's origin in its frame, m
  Real linear_damping = 0;       // 1/s, with linear drags
  Real angular_damping = 0;      // 1/s, with linear drags
  Real gravity_scale = 1;
  Real size = 0;    // of the smallest shape, m
  Real extent = 0;  // distance of the farthest point from the centre of mass, m
  bool can_sleep = true;
  bool is_bullet = false;
  bool is_jointed = false;        // some joint of the scene acts on it
  std::uint32_t first_shape = 0;  // in Model::body_shapes
  std::uint32_t shape_count = 0;  // children: one for each shape, for a chain one for each edge
};

/// Force element: an acceleration of strength * |r|^exponent towards a centre.
struct CentralForce {
  bool every = true;       // acts on every dynamic body; otherwise on one
  std::uint32_t body = 0;  // id of the one body
  Vec2 center;             // m
  Real strength = 0;       // 1/(s^2 m^(exponent - 1)); > 0 attracts
  int exponent = 0;
};

/// Force element: spring and damper along the line between two points.
struct SpringForce {
  std::uint32_t body = 0;   // id
  std::uint32_t other = 0;  // id; no_reference: the second point is fixed in the world
  Vec2 anchor;              // from the body's centre of mass, in its frame, m
  Vec2 point;               // from the other's centre of mass, in its frame, or of the world, m
  Real stiffness = 0;       // N/m
  Real damping = 0;         // N s/m
  Real rest_length = 0;     // m
};

/// The constant contribution of force elements to a body, per source.
struct BodyForces {
  Vec2 acceleration;                // m/s^2: constant forces, and linear drag in the wind
  Real angular_acceleration = 0;    // rad/s^2
  Real quadratic_drag = 0;          // 1/m
  Real angular_quadratic_drag = 0;  // 1/rad
};

/// Friction and restitution of a pair.
struct MixedMaterial {
  Real friction = 0;
  Real restitution = 0;
};

struct MotionWorkspace;
struct SolvedSet;
/// Adds the accelerations of forces that depend on positions, at the present poses, to MotionWorkspace::accelerations.
using PositionForces = void (*)(const SolvedSet& solved, MotionWorkspace& work);

struct Model {
  Scene scene;
  std::vector<BodyModel> bodies;               // [source]: the scene's bodies, then its prototypes
  std::uint32_t first_prototype = 0;           // source index of prototype 0
  std::vector<std::uint32_t> body_shapes;      // [body's first_shape + child]: index in `shapes`
  std::vector<std::uint8_t> is_non_colliding;  // [body's first_shape + child]: no other shape of the scene can touch it
  std::vector<ShapeModel> shapes;
  std::vector<Vec2> vertices;  // counter-clockwise, from the body's centre of mass, m
  std::vector<Vec2> normals;   // [vertex]: outward normal of the edge to the next vertex

  std::vector<Quad> quads;
  std::vector<MixedMaterial> mixed_materials;  // [material of A * material_count + material of B]; empty if too many
  std::uint32_t material_count = 0;

  std::vector<JointModel> joints;  // [joint of the scene]
  std::vector<GearModel> gears;    // in the order of their joints
  std::vector<LightBody> light_bodies;
  std::vector<SeparatedPair> separated;  // ascending; may contain a pair twice
  std::uint32_t separated_span = 0;      // the largest difference of two ids of a pair, for a quick rejection
  std::uint32_t last_joined = 0;         // the largest id of a body that has joints

  std::vector<std::uint32_t> pointer_spawns;  // prototypes spawned by presses on empty space, in turn

  std::vector<BodyForces> body_forces;  // [source]; empty if the scene has no force elements
  std::vector<CentralForce> centrals;
  std::vector<SpringForce> springs;
  Vec2 wind;                                 // m/s, the air's velocity
  PositionForces position_forces = nullptr;  // null if no force depends on positions
  bool has_velocity_forces = false;          // quadratic drags or dampers; linear drags are part of the damping

  Real restitution_threshold = 1;  // m/s
  bool can_collide = false;
  bool takes_inputs = false;
  bool has_pointer = false;
  bool has_bounds = false;
  bool finds_islands = false;  // bodies may sleep, or islands choose their substeps
  bool bounces = false;        // some pair of materials may have restitution > 0
  bool has_surfaces = false;   // some material has tangent speed or rolling resistance
  bool has_sensors = false;
  std::uint32_t child_count_max = 0;  // of a body
  bool is_composed = true;  // stages that the scene does not need are left out; false: EngineOptions::full_pipeline
  unsigned contact_features = 0;  // bits of contact_feature
  SolverKernels kernels{};        // for these features and an instruction set; no choice changes a bit
  Box bounds;

  const ShapeModel& shape(const BodyModel& body, std::uint32_t child) const {
    return shapes[body_shapes[body.first_shape + child]];
  }
};

/// Calls visit(id) for each body of a joint: two, one if the other is the world, or the four of a gear. A body of a
/// gear may come twice.
template <typename Visit>
void for_each_body(const Model& model, const JointModel& joint, Visit visit) {
  if (joint.gear != no_gear) {
    for (const std::uint32_t id : model.gears[joint.gear].bodies) visit(id);
    return;
  }
  if (joint.body_a != no_reference) visit(joint.body_a);
  visit(joint.body_b);
}

/// Whether the scene bounds the work of automatic substeps.
inline bool has_budget(const Model& model) {
  return model.scene.settings.substep_budget > 0;
}

/// Requires: check_scene(scene).
Model make_model(const Scene& scene);

/// Friction or restitution of a pair.
Real mix(MixRule rule, Real a, Real b);

/// Friction and restitution of a pair, from the model's table if it has one.
inline MixedMaterial mixed_material(const Model& model, const ShapeModel& a, const ShapeModel& b) {
  if (!model.mixed_materials.empty()) return model.mixed_materials[a.material * model.material_count + b.material];
  const Settings& settings = model.scene.settings;
  return {mix(settings.friction_mix, a.friction, b.friction),
          mix(settings.restitution_mix, a.restitution, b.restitution)};
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
