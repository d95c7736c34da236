// The needs of a scene for the pipeline, and choices that do not go together.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "engine/scene/scene_rules.h"

namespace ticktrue::engine {
namespace {

/// Whether the filter of some shape lets it touch anything. With an empty mask it cannot.
bool touches_something(const Body& body) {
  for (const Shape& shape : body.shapes)
    if (shape.filter.mask != 0 || shape.filter.group > 0) return true;
  return false;
}

/// "a, b or c" of the rows for which `wanted` is true.
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

double mixed_restitution(MixRule rule, double a, double b) {
  switch (rule) {
    case MixRule::geometric_mean:
      return __builtin_sqrt(a * b);
    case MixRule::maximum:
      return std::max(a, b);
    case MixRule::minimum:
      return std::min(a, b);
    case MixRule::average:
      break;
  }
  return (a + b) / 2;
}

}  // namespace

bool can_collide(const Scene& scene) {
  // The bodies that can exist: those of the scene, and any number of each prototype that inputs may spawn.
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

double largest_restitution(const Scene& scene) {
  if (!can_collide(scene)) return 0;
  double moving[2]{-1, -1};  // the two bodies that bounce most; below 0: there is none
  double fixed = -1;         // of those that do not move by themselves
  const auto add = [&](const Body& body) {
    double value = -1;
    for (const Shape& shape : body.shapes)
      if (!shape.sensor) value = std::max(value, shape.material.restitution);
    if (body.type != BodyType::dynamic_body) {
      fixed = std::max(fixed, value);
    } else {
      moving[1] = std::max(moving[1], std::min(value, moving[0]));
      moving[0] = std::max(moving[0], value);
    }
  };
  for (const Body& body : scene.bodies) add(body);
  for (const Body& body : scene.prototypes) {
    add(body);
    add(body);  // two of them may meet
  }
  double most = 0;
  for (const double other : {moving[1], fixed})
    if (moving[0] >= 0 && other >= 0)
      most = std::max(most, mixed_restitution(scene.settings.restitution_mix, moving[0], other));
  return most;
}

bool locates_bounces(const Scene& scene) {
  if (!(largest_restitution(scene) >= 1)) return false;
  Scene located = scene;
  located.settings.locate_impacts = true;
  return check_scene(located, scene.name).has_value();
}

bool SceneRules::check_choices() {
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
    return fail(ErrorCode::incompatible, "settings.sleep", name_of_solver + " has no islands: found sleep",
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
  if (!solver.chooses_joints && scene_.settings.joints != JointSolverKind::iterative)
    return fail(
        ErrorCode::incompatible, "settings.joints",
        name_of_solver + " solves joints one after the other, if at all: found " +
            std::string(info_of(joint_solvers, scene_.settings.joints).name) + ", expected iterative",
        "leave joints out, or use " + names_where(solvers, [](const SolverInfo& s) { return s.chooses_joints; }));
  if (!scene_.settings.auto_substeps && scene_.settings.substep_loads != SubstepLoads::weight)
    return fail(ErrorCode::incompatible, "settings.substep_loads",
                "loads choose automatic substeps: found " +
                    std::string(info_of(substep_loads, scene_.settings.substep_loads).name) + " and " +
                    std::to_string(scene_.settings.substeps) + " substeps",
                "use \"substeps\": \"auto\"");
  if (!scene_.settings.auto_substeps && scene_.settings.substep_budget != 0)
    return fail(ErrorCode::incompatible, "settings.substep_budget",
                "a budget bounds automatic substeps: found " + std::to_string(scene_.settings.substep_budget) +
                    " and " + std::to_string(scene_.settings.substeps) + " substeps",
                "use \"substeps\": \"auto\"");
  return true;
}

bool SceneRules::check_contact_needs(const SolverInfo& solver) {
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
            info_of(shape_kinds, shape.kind).is_plain && (shape.kind == ShapeKind::circle || shape.radius == 0);
        if (!is_plain) return cannot("settings.solver", "knows circles and sharp polygons only: found another shape");
        if (shape.filter != Filter{}) return cannot("settings.solver", "tests every pair: found a filter");
        if (shape.material.tangent_speed != 0 || shape.material.rolling_resistance != 0)
          return cannot("settings.solver", "knows friction and restitution only: found another material");
      }
  return true;
}

}  // namespace ticktrue::engine
