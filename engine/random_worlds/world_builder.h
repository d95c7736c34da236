// Makes the bodies of a random world.
// SPDX-License-Identifier: MIT
#pragma once

#include "engine/random_worlds/world_plan.h"

namespace ticktrue::engine {

/// The prefix of the names of bodies that inputs shoot at a wall.
inline constexpr const char* shot_prefix = "shot_";

/// The initial pose and motion of a body.
struct Placement {
  Point position;
  double angle = 0;
  Point velocity;
  double angular_velocity = 0;
};

class WorldBuilder {
 public:
  WorldBuilder(Draw& draw, const WorldPlan& plan);

  /// Makes all bodies and prototypes.
  void build();

  /// Adds a dynamic body of about this size (width and height, m), with features of the plan.
  void add(const Placement& placement, double size);
  /// The same as a disc or a square of exactly this size, so that bodies one size apart touch exactly.
  void add_exact(const Placement& placement, double size, ShapeKind kind);
  /// Draws circle or box, if the plan has one; otherwise circle.
  ShapeKind draw_exact_kind();
  void add_kinematic(const Placement& placement, double size);
  void add_static(Point position, Shape shape);

  bool is_full() const { return scene.bodies.size() >= plan.body_count; }
  bool has_gravity() const { return plan.gravity != Point{}; }

  Draw& draw;
  const WorldPlan& plan;
  Scene scene;
  double size = 1;     // m, of most bodies
  Point lower, upper;  // around all positions so far, m, before the world is moved from the origin

 private:
  Shape draw_shape(double size);
  Material draw_material();
  Filter draw_filter();
  Body draw_body(BodyType type, double size);
  void decorate(Body& body);
  void add_terrain();
  void add_structures();
  void add_links(std::uint32_t count);  // a row
  void add_plate(std::uint32_t count);  // a long box under as many discs that touch it
  void add_ring(std::uint32_t count);   // a large body at rest; all others fly at it from every side
  void add_shots(std::uint32_t count);  // a thin wall; all others are almost at rest beside it
  void add_net(std::uint32_t columns, std::uint32_t rows);  // of joints; nothing touches
  void add_prototypes();
  void finish();
  void push(Body body, const Placement& placement);

  bool all_alike_ = false;  // every body has the same shape and material
  std::optional<Shape> shape_;
};

/// A few bodies at rest near each other, and the rest of `count` bodies gliding or touching. Resting bodies are a
/// minority, the case in which caches look at moving bodies alone. Returns the used width, m.
double add_quiet_corner(WorldBuilder& builder, Point corner, std::uint32_t count);

/// Adds up to `count` bodies in one of the arrangements, from `corner` to the right and upwards; `count` >= 1. Returns
/// the used width, m.
double add_arrangement(WorldBuilder& builder, Point corner, std::uint32_t count);

/// A shape of a kind of about this size around the body's origin. Requires: a kind of the table.
Shape make_shape(Draw& draw, ShapeKind kind, double size);

/// `size`: of most bodies, m.
void add_joints(Draw& draw, const WorldPlan& plan, double size, Scene& scene);
void add_forces(Draw& draw, const WorldPlan& plan, Scene& scene);
/// Also declares the kinds of the inputs, and gives the scene a pointer if an input needs one.
std::vector<Input> add_inputs(Draw& draw, const WorldPlan& plan, Scene& scene);

}  // namespace ticktrue::engine
