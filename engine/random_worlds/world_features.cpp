// The recognition and the removal of each feature of a random world.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/world_features.h"

#include "engine/math/trig.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

template <typename Predicate>
bool any_body(const Scene& scene, Predicate predicate) {
  for (const std::vector<Body>* list : {&scene.bodies, &scene.prototypes})
    for (const Body& body : *list)
      if (predicate(body)) return true;
  return false;
}

template <typename Action>
void each_body(Scene& scene, Action action) {
  for (std::vector<Body>* list : {&scene.bodies, &scene.prototypes})
    for (Body& body : *list) action(body);
}

template <typename Predicate>
bool any_shape(const Scene& scene, Predicate predicate) {
  return any_body(scene, [&](const Body& body) {
    for (const Shape& shape : body.shapes)
      if (predicate(shape)) return true;
    return false;
  });
}

template <typename Action>
void each_shape(Scene& scene, Action action) {
  each_body(scene, [&](Body& body) {
    for (Shape& shape : body.shapes) action(shape);
  });
}

template <typename Predicate>
bool any_joint(const Scene& scene, Predicate predicate) {
  for (const Joint& joint : scene.joints)
    if (predicate(joint)) return true;
  return false;
}

bool is_rounded(const Shape& shape) {
  return (shape.kind == ShapeKind::box || shape.kind == ShapeKind::polygon) && shape.radius != 0;
}

bool is_mover(const Body& body) {
  return body.type == BodyType::kinematic_body && (body.velocity != Point{} || body.angular_velocity != 0);
}

/// The radius of a circle about the body's origin around a shape's core, without a square root.
double extent_of(const Shape& shape) {
  double extent = shape.half_size.x > shape.half_size.y ? shape.half_size.x : shape.half_size.y;
  for (const Point& p : shape.vertices)
    for (const double value : {p.x, -p.x, p.y, -p.y}) extent = value > extent ? value : extent;
  return extent + shape.radius;
}

bool has_size_ratio(const RandomWorld& world) {
  double least = limits::size_max_m, most = 0;
  for (const Body& body : world.scene.bodies) {
    if (body.type != BodyType::dynamic_body) continue;
    for (const Shape& shape : body.shapes) {
      const double extent = extent_of(shape);
      least = extent < least ? extent : least;
      most = extent > most ? extent : most;
    }
  }
  return most >= size_ratio_min * least;
}

bool is_far(const Body& body) {
  const Point p = body.position;
  return p.x >= far_m || p.x <= -far_m || p.y >= far_m || p.y <= -far_m;
}

/// Shrinks the larger shapes until the factor is 32.
void take_size_ratio(RandomWorld& world) {
  double least = limits::size_max_m;
  for (const Body& body : world.scene.bodies)
    if (body.type == BodyType::dynamic_body)
      for (const Shape& shape : body.shapes) least = extent_of(shape) < least ? extent_of(shape) : least;
  for (Body& body : world.scene.bodies)
    for (Shape& shape : body.shapes) {
      const double factor = 32 * least / extent_of(shape);
      if (body.type != BodyType::dynamic_body || factor >= 1) continue;
      shape.radius *= factor;
      for (Point* p : {&shape.center, &shape.half_size}) *p = {p->x * factor, p->y * factor};
      for (Point& p : shape.vertices) p = {p.x * factor, p.y * factor};
    }
}

/// Moves the whole world near the origin, with every place in it.
void take_far(RandomWorld& world) {
  Point by;  // from the origin to the first distant body
  for (std::size_t i = world.scene.bodies.size(); i-- > 0;)
    if (is_far(world.scene.bodies[i])) by = world.scene.bodies[i].position;
  const auto move = [by](Point& p) { p = {p.x - by.x, p.y - by.y}; };
  for (Body& body : world.scene.bodies) move(body.position);
  if (world.scene.bounds) {
    move(world.scene.bounds->lower);
    move(world.scene.bounds->upper);
  }
  for (Joint& joint : world.scene.joints) for_each_world_point(joint, move);
}

bool has_several_players(const RandomWorld& world) {
  for (const Input& input : world.inputs)
    if (input.kind != InputKind::end && input.player != world.inputs[0].player) return true;
  return false;
}

/// Whether a removal is followed by a spawn of the same player in the same tick.
bool is_teleport(const std::vector<Input>& inputs, std::size_t i) {
  return inputs[i].kind == InputKind::remove && i + 1 < inputs.size() && inputs[i + 1].kind == InputKind::spawn &&
         inputs[i + 1].tick == inputs[i].tick && inputs[i + 1].player == inputs[i].player;
}

bool has_teleports(const RandomWorld& world) {
  for (std::size_t i = 0; i < world.inputs.size(); ++i)
    if (is_teleport(world.inputs, i)) return true;
  return false;
}

void take_teleports(RandomWorld& world) {
  std::vector<Input> left;
  for (std::size_t i = 0; i < world.inputs.size(); ++i)
    if (!is_teleport(world.inputs, i)) left.push_back(world.inputs[i]);
  world.inputs = left;
}

bool is_quarter_turned(const Body& body) {
  return body.angle == pi / 2 || body.angle == -pi / 2 || body.angle == pi;
}

using World = RandomWorld;
using F = WorldFeature;

const std::array<WorldFeatureInfo, world_feature_count> features{{
    {{F::sleeping, "sleeping", "islands at rest sleep"},
     40,
     [](const World& w) { return w.scene.settings.sleep.has_value(); },
     [](World& w) { w.scene.settings.sleep.reset(); }},
    {{F::never_sleeps, "never_sleeps", "a body that may not sleep where others may"},
     45,
     [](const World& w) {
       return w.scene.settings.sleep && any_body(w.scene, [](const Body& b) { return !b.can_sleep; });
     },
     [](World& w) { each_body(w.scene, [](Body& b) { b.can_sleep = true; }); }},
    {{F::automatic_substeps, "automatic_substeps", "substeps chosen per island"},
     68,
     [](const World& w) { return w.scene.settings.auto_substeps.has_value(); },
     [](World& w) { fix_substeps(w.scene.settings); }},
    {{F::tight_target_error, "tight_target_error", "automatic substeps with a target below the default"},
     50,
     [](const World& w) {
       const auto& automatic = w.scene.settings.auto_substeps;
       return automatic && automatic->target_error < AutoSubsteps{}.target_error;
     },
     [](World& w) { w.scene.settings.auto_substeps->target_error = AutoSubsteps{}.target_error; }},
    {{F::loose_target_error, "loose_target_error", "automatic substeps with a target above the default"},
     100,
     [](const World& w) {
       const auto& automatic = w.scene.settings.auto_substeps;
       return automatic && automatic->target_error > AutoSubsteps{}.target_error;
     },
     [](World& w) { w.scene.settings.auto_substeps->target_error = AutoSubsteps{}.target_error; }},
    {{F::one_substep, "one_substep", "one substep, or one at least"},
     15,
     [](const World& w) { return w.scene.settings.substeps == 1; },
     [](World& w) { w.scene.settings.substeps = Settings{}.substeps; }},
    {{F::many_substeps, "many_substeps", "eight substeps or more"},
     15,
     [](const World& w) { return w.scene.settings.substeps >= 8; },
     [](World& w) { w.scene.settings.substeps = Settings{}.substeps; }},
    {{F::locate_impacts, "locate_impacts", "bounces happen at the moment of impact"},
     65,
     [](const World& w) { return w.scene.settings.locate_impacts; },
     [](World& w) { w.scene.settings.locate_impacts = false; }},
    {{F::continuous_off, "continuous_off", "fast bodies may pass walls"},
     30,
     [](const World& w) { return !w.scene.settings.continuous; },
     [](World& w) { w.scene.settings.continuous = true; }},
    {{F::events, "events", "begin and end of contacts are state"},
     25,
     [](const World& w) { return w.scene.settings.events; },
     [](World& w) { w.scene.settings.events = false; }},
    {{F::zero_gravity, "zero_gravity", "no gravity at the start"},
     45,
     [](const World& w) { return w.scene.gravity == Point{}; },
     [](World& w) { w.scene.gravity = Scene{}.gravity; }},
    {{F::sideways_gravity, "sideways_gravity", "gravity has a horizontal part"},
     30,
     [](const World& w) { return w.scene.gravity.x != 0; },
     [](World& w) { w.scene.gravity.x = 0; }},
    {{F::short_ticks, "short_ticks", "ticks shorter than 1/60 s"},
     25,
     [](const World& w) { return w.scene.settings.dt < Settings{}.dt; },
     [](World& w) { w.scene.settings.dt = Settings{}.dt; }},
    {{F::bounds, "bounds", "bodies that leave are removed"},
     20,
     [](const World& w) { return w.scene.bounds.has_value(); },
     [](World& w) { w.scene.bounds.reset(); }},
    {{F::spawned_max, "spawned_max", "the oldest spawned body goes"},
     45,
     [](const World& w) { return w.scene.spawned_max.has_value(); },
     [](World& w) { w.scene.spawned_max.reset(); }},
    {{F::bullets, "bullets", "bodies that pass no moving body"},
     35,
     [](const World& w) { return any_body(w.scene, [](const Body& b) { return b.bullet; }); },
     [](World& w) { each_body(w.scene, [](Body& b) { b.bullet = false; }); }},
    {{F::fixed_rotation, "fixed_rotation", "bodies that do not turn"},
     20,
     [](const World& w) { return any_body(w.scene, [](const Body& b) { return b.fixed_rotation; }); },
     [](World& w) { each_body(w.scene, [](Body& b) { b.fixed_rotation = false; }); }},
    {{F::explicit_mass, "explicit_mass", "bodies that state their mass"},
     20,
     [](const World& w) { return any_body(w.scene, [](const Body& b) { return b.mass.has_value(); }); },
     [](World& w) { each_body(w.scene, [](Body& b) { b.mass.reset(); }); }},
    {{F::gravity_scale, "gravity_scale", "bodies with a gravity of their own"},
     20,
     [](const World& w) { return any_body(w.scene, [](const Body& b) { return b.gravity_scale != 1; }); },
     [](World& w) { each_body(w.scene, [](Body& b) { b.gravity_scale = 1; }); }},
    {{F::linear_damping, "linear_damping", "damped bodies"},
     20,
     [](const World& w) { return any_body(w.scene, [](const Body& b) { return b.linear_damping != 0; }); },
     [](World& w) { each_body(w.scene, [](Body& b) { b.linear_damping = 0; }); }},
    {{F::angular_damping, "angular_damping", "bodies whose spin is damped"},
     20,
     [](const World& w) { return any_body(w.scene, [](const Body& b) { return b.angular_damping != 0; }); },
     [](World& w) { each_body(w.scene, [](Body& b) { b.angular_damping = 0; }); }},
    {{F::kinematic_movers, "kinematic_movers", "kinematic bodies that move"},
     30,
     [](const World& w) { return any_body(w.scene, is_mover); },
     [](World& w) {
       each_body(w.scene, [](Body& b) {
         if (!is_mover(b)) return;
         b.velocity = {};
         b.angular_velocity = 0;
       });
     }},
    {{F::several_shapes, "several_shapes", "bodies of several shapes"},
     25,
     [](const World& w) { return any_body(w.scene, [](const Body& b) { return b.shapes.size() > 1; }); },
     [](World& w) { each_body(w.scene, [](Body& b) { b.shapes.resize(1); }); }},
    {{F::sensors, "sensors", "shapes that see and touch nothing"},
     20,
     [](const World& w) { return any_shape(w.scene, [](const Shape& s) { return s.sensor; }); },
     [](World& w) { each_shape(w.scene, [](Shape& s) { s.sensor = false; }); }},
    {{F::category_filters, "category_filters", "categories and masks"},
     20,
     [](const World& w) {
       return any_shape(w.scene, [](const Shape& s) { return s.filter.category != 1 || s.filter.mask != 0xffffffff; });
     },
     [](World& w) {
       each_shape(w.scene, [](Shape& s) {
         s.filter.category = 1;
         s.filter.mask = 0xffffffff;
       });
     }},
    {{F::group_filters, "group_filters", "groups that always or never meet"},
     30,
     [](const World& w) { return any_shape(w.scene, [](const Shape& s) { return s.filter.group != 0; }); },
     [](World& w) { each_shape(w.scene, [](Shape& s) { s.filter.group = 0; }); }},
    {{F::restitution, "restitution", "shapes that bounce"},
     62,
     [](const World& w) { return any_shape(w.scene, [](const Shape& s) { return s.material.restitution != 0; }); },
     [](World& w) { each_shape(w.scene, [](Shape& s) { s.material.restitution = 0; }); }},
    {{F::no_restitution_threshold, "no_restitution_threshold", "the slowest approach bounces"},
     35,
     [](const World& w) { return w.scene.settings.restitution_threshold == 0; },
     [](World& w) { w.scene.settings.restitution_threshold = Settings{}.restitution_threshold; }},
    {{F::frictionless, "frictionless", "shapes without friction"},
     45,
     [](const World& w) { return any_shape(w.scene, [](const Shape& s) { return s.material.friction == 0; }); },
     [](World& w) {
       each_shape(w.scene, [](Shape& s) {
         if (s.material.friction == 0) s.material.friction = Material{}.friction;
       });
     }},
    {{F::tangent_speed, "tangent_speed", "surfaces that drive what touches them"},
     20,
     [](const World& w) { return any_shape(w.scene, [](const Shape& s) { return s.material.tangent_speed != 0; }); },
     [](World& w) { each_shape(w.scene, [](Shape& s) { s.material.tangent_speed = 0; }); }},
    {{F::rolling_resistance, "rolling_resistance", "surfaces that resist rolling"},
     20,
     [](const World& w) {
       return any_shape(w.scene, [](const Shape& s) { return s.material.rolling_resistance != 0; });
     },
     [](World& w) { each_shape(w.scene, [](Shape& s) { s.material.rolling_resistance = 0; }); }},
    {{F::rounded_shapes, "rounded_shapes", "boxes and polygons with rounded corners"},
     30,
     [](const World& w) { return any_shape(w.scene, is_rounded); },
     [](World& w) {
       each_shape(w.scene, [](Shape& s) {
         if (is_rounded(s)) s.radius = 0;
       });
     }},
    {{F::densities, "densities", "shapes of other densities than 1"},
     30,
     [](const World& w) { return any_shape(w.scene, [](const Shape& s) { return s.density != 1; }); },
     [](World& w) { each_shape(w.scene, [](Shape& s) { s.density = 1; }); }},
    {{F::joint_limits, "joint_limits", "joints with limits"},
     55,
     [](const World& w) { return any_joint(w.scene, [](const Joint& j) { return j.limits.has_value(); }); },
     [](World& w) {
       for (Joint& joint : w.scene.joints) joint.limits.reset();
     }},
    {{F::joint_motors, "joint_motors", "joints with motors"},
     60,
     [](const World& w) { return any_joint(w.scene, [](const Joint& j) { return j.motor.has_value(); }); },
     [](World& w) {
       for (Joint& joint : w.scene.joints) joint.motor.reset();
     }},
    {{F::joint_springs, "joint_springs", "joints with springs of a frequency"},
     60,
     [](const World& w) { return any_joint(w.scene, [](const Joint& j) { return j.spring && !j.spring->absolute; }); },
     [](World& w) {
       for (Joint& joint : w.scene.joints)
         if (joint.spring && !joint.spring->absolute) joint.spring.reset();
     }},
    {{F::absolute_springs, "absolute_springs", "joints with springs of a stiffness"},
     60,
     [](const World& w) { return any_joint(w.scene, [](const Joint& j) { return j.spring && j.spring->absolute; }); },
     [](World& w) {
       for (Joint& joint : w.scene.joints)
         if (joint.spring && joint.spring->absolute) joint.spring.reset();
     }},
    {{F::linear_springs, "linear_springs", "welds that give along their axes"},
     100,
     [](const World& w) { return any_joint(w.scene, [](const Joint& j) { return j.linear_spring.has_value(); }); },
     [](World& w) {
       for (Joint& joint : w.scene.joints) joint.linear_spring.reset();
     }},
    {{F::collide_connected, "collide_connected", "jointed bodies that touch each other"},
     55,
     [](const World& w) { return any_joint(w.scene, [](const Joint& j) { return j.collide_connected; }); },
     [](World& w) {
       for (Joint& joint : w.scene.joints) joint.collide_connected = false;
     }},
    {{F::several_players, "several_players", "inputs of several players"},
     50,
     has_several_players,
     [](World& w) {
       for (std::size_t i = w.inputs.size(); i-- > 0;)
         if (w.inputs[i].kind != InputKind::end && w.inputs[i].player != w.inputs[0].player)
           w.inputs.erase(w.inputs.begin() + static_cast<std::ptrdiff_t>(i));
     }},
    {{F::teleports, "teleports", "a body is removed and another comes in the same tick"},
     80,
     has_teleports,
     take_teleports},
    {{F::quarter_turns, "quarter_turns", "bodies turned by a quarter or a half"},
     35,
     [](const World& w) { return any_body(w.scene, is_quarter_turned); },
     [](World& w) {
       each_body(w.scene, [](Body& b) {
         if (is_quarter_turned(b)) b.angle = 0;
       });
     }},
    {{F::size_ratio, "size_ratio", "sizes of dynamic bodies that differ by a factor of 50 or more"},
     22,
     has_size_ratio,
     take_size_ratio},
    {{F::far_from_origin, "far_from_origin", "bodies 4 km from the origin or more"},
     12,
     [](const World& w) { return any_body(w.scene, is_far); },
     take_far},
}};

}  // namespace

std::span<const WorldFeatureInfo> world_features() {
  return features;
}

}  // namespace ticktrue::engine
