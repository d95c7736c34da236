// The rows of the tables of choices that a world has, and worlds without one of these rows.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/world_features.h"
#include "engine/scene/hull.h"
#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

using World = RandomWorld;
using Names = std::vector<std::string_view>;

/// A table of choices: tests whether a world has a row, and removes a row from a world.
struct RowTable {
  std::string_view name;
  Names (*rows)();
  bool (*has)(const World& world, std::size_t row);
  /// False: no world without the row is known. The result may be illegal.
  bool (*take_away)(World& world, std::size_t row);
  bool changes_bits;
};

template <const auto& table>
Names names_of() {
  Names names;
  for (const auto& row : table) names.push_back(row.name);
  return names;
}

Names feature_names() {
  Names names;
  for (const WorldFeatureInfo& info : world_features()) names.push_back(info.name);
  return names;
}

// ---- Settings: one row of each table ----

/// Resets settings that are incompatible with the other choices.
void repair_settings(Settings& settings) {
  const SolverInfo& solver = info_of(solvers, settings.solver);
  if (!solver.chooses_joints) settings.joints = JointSolverKind::iterative;
  if (!solver.substeps) {
    settings.substeps = 1;
    settings.auto_substeps.reset();
  }
  if (!settings.auto_substeps) fix_substeps(settings);
}

bool has_joint_solver(const World& world, std::size_t row) {
  return !world.scene.joints.empty() && world.scene.settings.joints == joint_solvers[row].kind;
}

bool has_substep_loads(const World& world, std::size_t row) {
  return world.scene.settings.auto_substeps && world.scene.settings.substep_loads == substep_loads[row].kind;
}

Names budget_names() {
  return {"some"};
}

bool has_budget(const World& world, std::size_t) {
  return world.scene.settings.substep_budget > 0;
}

bool take_budget(World& world, std::size_t) {
  world.scene.settings.substep_budget = 0;
  return true;
}

template <const auto& table, auto Settings::*choice>
bool has_choice(const World& world, std::size_t row) {
  return world.scene.settings.*choice == table[row].kind;
}

template <const auto& table, auto Settings::*choice>
bool take_choice(World& world, std::size_t row) {
  std::vector<std::size_t> candidates{static_cast<std::size_t>(Settings{}.*choice)};
  for (std::size_t i = 0; i < table.size(); ++i) candidates.push_back(i);
  for (const std::size_t candidate : candidates) {
    if (candidate == row) continue;
    World other = world;
    other.scene.settings.*choice = table[candidate].kind;
    repair_settings(other.scene.settings);
    if (!check_scene(other.scene, "world")) continue;
    world = other;
    return true;
  }
  return false;
}

bool has_clock(const World& world, std::size_t row) {
  return static_cast<std::size_t>(world.scene.settings.clock.kind) == row;
}

bool take_clock(World& world, std::size_t row) {
  ClockSettings clock;
  if (static_cast<std::size_t>(clock.kind) == row) clock.kind = clock_kinds[(row + 1) % clock_kinds.size()].kind;
  world.scene.settings.clock = clock;
  return true;
}

// ---- Bodies and shapes ----

template <typename List, typename Predicate>
void erase_where(List& list, Predicate predicate) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!predicate(list[i])) list[kept++] = list[i];
  list.resize(kept);
}

template <typename Action>
void each_body(World& world, Action action) {
  for (std::vector<Body>* list : {&world.scene.bodies, &world.scene.prototypes})
    for (Body& body : *list) action(body);
}

bool has_body_type(const World& world, std::size_t row) {
  for (const std::vector<Body>* list : {&world.scene.bodies, &world.scene.prototypes})
    for (const Body& body : *list)
      if (static_cast<std::size_t>(body.type) == row) return true;
  return false;
}

/// Turns dynamic bodies into kinematic bodies, without joints.
void take_dynamic(World& world) {
  each_body(world, [](Body& body) {
    if (body.type != BodyType::dynamic_body) return;
    body.type = BodyType::kinematic_body;
    body.mass.reset();
  });
  world.scene.joints.clear();
  world.scene.forces.clear();
  erase_where(world.inputs, [](const Input& input) { return info_of(input_kinds, input.kind).has_joint; });
}

/// Turns kinematic bodies into static bodies, and static bodies into moving kinematic bodies. Prototypes of either type
/// become dynamic.
bool take_body_type(World& world, std::size_t row) {
  const BodyType type = body_types[row].kind;
  if (type == BodyType::dynamic_body) {
    take_dynamic(world);
    return true;
  }
  for (Body& prototype : world.scene.prototypes)
    if (prototype.type == type) prototype.type = BodyType::dynamic_body;
  for (Body& body : world.scene.bodies) {
    if (body.type != type) continue;
    body.type = type == BodyType::static_body ? BodyType::kinematic_body : BodyType::static_body;
    body.velocity = {type == BodyType::static_body ? 0.25 : 0, 0};
    body.angular_velocity = 0;
  }
  return true;
}

bool has_shape(const World& world, std::size_t row) {
  for (const std::vector<Body>* list : {&world.scene.bodies, &world.scene.prototypes})
    for (const Body& body : *list)
      for (const Shape& shape : body.shapes)
        if (static_cast<std::size_t>(shape.kind) == row) return true;
  return false;
}

/// Replaces a shape by a box around it, and a box by a circle.
void replace_shape(Shape& shape) {
  const std::vector<Point> core = core_of(shape);
  Point lower = core[0], upper = core[0];
  for (const Point& p : core) {
    lower = {p.x < lower.x ? p.x : lower.x, p.y < lower.y ? p.y : lower.y};
    upper = {p.x > upper.x ? p.x : upper.x, p.y > upper.y ? p.y : upper.y};
  }
  constexpr double least = 1.0 / 64;  // half a width: lines have no width
  const auto half = [&](double low, double high) { return (high - low) / 2 > least ? (high - low) / 2 : least; };
  const Point size{half(lower.x, upper.x), half(lower.y, upper.y)};
  const bool is_box = shape.kind == ShapeKind::box;
  shape.center = {(lower.x + upper.x) / 2, (lower.y + upper.y) / 2};
  shape.half_size = is_box ? Point{} : Point{size.x + shape.radius, size.y + shape.radius};
  shape.radius = is_box ? (size.x < size.y ? size.x : size.y) + shape.radius : 0;
  shape.kind = is_box ? ShapeKind::circle : ShapeKind::box;
  shape.angle = 0;
  shape.vertices.clear();
  shape.loop = false;
}

bool take_shape(World& world, std::size_t row) {
  each_body(world, [row](Body& body) {
    for (Shape& shape : body.shapes)
      if (static_cast<std::size_t>(shape.kind) == row) replace_shape(shape);
  });
  return true;
}

// ---- Joints, forces, inputs, features ----

bool has_joint(const World& world, std::size_t row) {
  for (const Joint& joint : world.scene.joints)
    if (static_cast<std::size_t>(joint.kind) == row) return true;
  return false;
}

bool take_joint(World& world, std::size_t row) {
  std::vector<std::uint8_t> is_kept;
  for (const Joint& joint : world.scene.joints) is_kept.push_back(static_cast<std::size_t>(joint.kind) == row ? 0 : 1);
  const std::vector<std::uint32_t> places = keep_joints(world.scene, is_kept);
  erase_where(world.inputs, [&](const Input& input) {
    return info_of(input_kinds, input.kind).has_joint && places[input.joint] == no_joint;
  });
  for (Input& input : world.inputs)
    if (info_of(input_kinds, input.kind).has_joint) input.joint = places[input.joint];
  return true;
}

bool has_force(const World& world, std::size_t row) {
  for (const Force& force : world.scene.forces)
    if (static_cast<std::size_t>(force.kind) == row) return true;
  return false;
}

bool take_force(World& world, std::size_t row) {
  erase_where(world.scene.forces, [row](const Force& force) { return static_cast<std::size_t>(force.kind) == row; });
  return true;
}

bool has_input(const World& world, std::size_t row) {
  for (const Input& input : world.inputs)
    if (static_cast<std::size_t>(input.kind) == row) return true;
  return false;
}

bool take_input(World& world, std::size_t row) {
  erase_where(world.inputs, [row](const Input& input) { return static_cast<std::size_t>(input.kind) == row; });
  return true;
}

bool has_feature(const World& world, std::size_t row) {
  return world_features()[row].is_on(world);
}

bool take_feature(World& world, std::size_t row) {
  if (world_features()[row].take_away == nullptr) return false;
  world_features()[row].take_away(world);
  return true;
}

const std::array<RowTable, 16> tables{{
    {"precision", names_of<precisions>, has_choice<precisions, &Settings::precision>,
     take_choice<precisions, &Settings::precision>, true},
    {"solver", names_of<solvers>, has_choice<solvers, &Settings::solver>, take_choice<solvers, &Settings::solver>,
     true},
    {"integrator", names_of<integrators>, has_choice<integrators, &Settings::integrator>,
     take_choice<integrators, &Settings::integrator>, true},
    {"broad_phase", names_of<broad_phases>, has_choice<broad_phases, &Settings::broad_phase>,
     take_choice<broad_phases, &Settings::broad_phase>, false},
    {"friction_mix", names_of<mix_rules>, has_choice<mix_rules, &Settings::friction_mix>,
     take_choice<mix_rules, &Settings::friction_mix>, true},
    {"restitution_mix", names_of<mix_rules>, has_choice<mix_rules, &Settings::restitution_mix>,
     take_choice<mix_rules, &Settings::restitution_mix>, true},
    {"clock", names_of<clock_kinds>, has_clock, take_clock, false},
    {"body", names_of<body_types>, has_body_type, take_body_type, true},
    {"shape", names_of<shape_kinds>, has_shape, take_shape, true},
    {"joint", names_of<joint_kinds>, has_joint, take_joint, true},
    {"joint_solver", names_of<joint_solvers>, has_joint_solver, take_choice<joint_solvers, &Settings::joints>, true},
    {"substep_loads", names_of<substep_loads>, has_substep_loads, take_choice<substep_loads, &Settings::substep_loads>,
     true},
    {"substep_budget", budget_names, has_budget, take_budget, true},
    {"force", names_of<force_kinds>, has_force, take_force, true},
    {"input", names_of<input_kinds>, has_input, take_input, true},
    {"feature", feature_names, has_feature, take_feature, true},
}};

std::string full_name(const RowTable& table, std::string_view row) {
  return std::string(table.name) + "/" + std::string(row);
}

/// Removes inputs to bodies that no earlier tick has made, and velocities of static bodies.
void drop_refused(World& world) {
  const auto first = static_cast<std::uint32_t>(world.scene.bodies.size());
  std::uint32_t issued = 0, in_tick = 0;  // spawned in earlier ticks, and in this one
  std::uint64_t tick = 0;
  erase_where(world.inputs, [&](const Input& input) {
    if (input.tick != tick) {
      issued += in_tick;
      in_tick = 0;
      tick = input.tick;
    }
    const InputInfo& info = info_of(input_kinds, input.kind);
    if (info.has_prototype) ++in_tick;
    if (!info.has_body) return false;
    if (input.body >= first) return input.body >= first + issued;
    return input.kind == InputKind::set_velocity && world.scene.bodies[input.body].type == BodyType::static_body;
  });
}

/// Removes inputs that the scene no longer accepts, and declarations of kinds that can no longer occur.
void repair_inputs(World& world) {
  bool some_motor = false;
  for (const Joint& joint : world.scene.joints) some_motor = some_motor || joint.motor;
  if (!some_motor) erase_where(world.scene.inputs, [](InputKind kind) { return info_of(input_kinds, kind).has_joint; });
  erase_where(world.inputs, [&](const Input& input) { return !check_input(world.scene, input, "input").has_value(); });
  drop_refused(world);
}

}  // namespace

std::vector<std::string> random_world_rows() {
  std::vector<std::string> rows;
  for (const RowTable& table : tables)
    for (const std::string_view row : table.rows()) rows.push_back(full_name(table, row));
  return rows;
}

std::vector<std::string> rows_of_world(const RandomWorld& world) {
  std::vector<std::string> rows;
  for (const RowTable& table : tables) {
    const Names names = table.rows();
    for (std::size_t i = 0; i < names.size(); ++i)
      if (table.has(world, i)) rows.push_back(full_name(table, names[i]));
  }
  return rows;
}

std::optional<RandomWorld> without_row(const RandomWorld& world, const std::string& row) {
  for (const RowTable& table : tables) {
    const Names names = table.rows();
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (full_name(table, names[i]) != row) continue;
      RandomWorld other = world;
      if (!table.has(world, i) || !table.take_away(other, i)) return std::nullopt;
      repair_inputs(other);
      if (!check_scene(other.scene, other.scene.name) || table.has(other, i)) return std::nullopt;
      other.rows = rows_of_world(other);
      return other;
    }
  }
  return std::nullopt;
}

bool row_changes_bits(const std::string& row) {
  if (row == "input/end") return false;
  // Where a solver without constraints is allowed, no constraints exist, and other solvers do the same.
  for (const SolverInfo& solver : solvers)
    if (!solver.solves_constraints && row == "solver/" + std::string(solver.name)) return false;
  for (const RowTable& table : tables)
    if (row.substr(0, table.name.size() + 1) == std::string(table.name) + "/") return table.changes_bits;
  return false;
}

}  // namespace ticktrue::engine
