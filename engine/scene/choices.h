// The named choices of a scene, one enumeration and one table each. Parser, printer, command line, dispatch and
// parametrised tests iterate these tables; there is no other list. Kinds of joints: joint_kinds.h.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "engine/math/precision.h"
#include "engine/scene/field_keys.h"

namespace ticktrue::engine {

enum class SolverKind : std::uint8_t { free_flight, impulse, tgs_soft, pgs };
enum class IntegratorKind : std::uint8_t {
  semi_implicit_euler,
  explicit_euler,
  velocity_verlet,
  position_verlet,
  rk4,
  yoshida4,
  implicit_midpoint,
  thesis_verlet,
  thesis_rk4
};
enum class BroadPhaseKind : std::uint8_t { brute_force, bounding_circle, sweep_and_prune, uniform_grid, aabb_tree };
/// The method that solves joints. Some solvers allow only `iterative`.
enum class JointSolverKind : std::uint8_t { iterative, direct };
enum class SubstepLoads : std::uint8_t { weight, measured };
enum class MixRule : std::uint8_t { geometric_mean, maximum, minimum, average };
enum class BodyType : std::uint8_t { static_body, kinematic_body, dynamic_body };
enum class ShapeKind : std::uint8_t { circle, box, polygon, capsule, segment, chain };
enum class ForceKind : std::uint8_t { constant, central, spring, wind, linear_drag, quadratic_drag };
enum class ClockKind : std::uint8_t { fixed, semi_fixed, variable, adaptive };

template <typename Kind>
struct Choice {
  Kind kind;
  std::string_view name;     // spelling in scenes, traces, command line, tests
  std::string_view summary;  // one line for help and documentation
};

inline constexpr std::array<Choice<Precision>, 2> precisions{{
    {Precision::f32, "f32", "32-bit floats"},
    {Precision::f64, "f64", "64-bit floats"},
}};

struct SolverInfo : Choice<SolverKind> {
  bool solves_constraints;  // false: a scene whose shapes may collide, or with a pointer, is refused
  bool solves_joints;       // false: a scene with joints is refused
  bool substeps;            // false: settings.substeps must be 1
  bool chooses_joints;      // false: settings.joints must be `iterative`
  bool reads_contacts;      // false: every shape but circle and sharp polygon, filters, sensors, events are refused
  bool is_baseline;         // true: to be compared with; nothing bounds its overlaps and gaps
};
inline constexpr std::array<SolverInfo, 4> solvers{{
    {{SolverKind::free_flight, "free_flight", "integrates; nothing collides"}, false, false, true, false, false, false},
    {{SolverKind::impulse, "impulse", "the thesis' single-point, single-pass impulses"},
     true,
     false,
     false,
     false,
     false,
     true},
    {{SolverKind::tgs_soft, "tgs_soft", "substeps, soft constraints, warm starting, relax"},
     true,
     true,
     true,
     true,
     true,
     false},
    {{SolverKind::pgs, "pgs", "sequential impulses: iterations, warm starting, Baumgarte"},
     true,
     true,
     false,
     false,
     true,
     true},
}};

inline constexpr double always_stable = std::numeric_limits<double>::infinity();

struct IntegratorInfo : Choice<IntegratorKind> {
  int order;
  double stability_limit;     // largest w h at which an undamped oscillation does not grow; 0: it always grows
  bool carries_constraints;   // false: a scene with contacts or joints is refused
  std::string_view why_free;  // the reason, if it carries none
  bool is_baseline = false;   // true: to be compared with; nothing bounds its overlaps and gaps
};
inline constexpr std::array<IntegratorInfo, 9> integrators{{
    {{IntegratorKind::semi_implicit_euler, "semi_implicit_euler", "symplectic, stable for w h < 2"}, 1, 2, true, ""},
    {{IntegratorKind::explicit_euler, "explicit_euler", "oscillations grow at every step"}, 1, 0, true, "", true},
    {{IntegratorKind::velocity_verlet, "velocity_verlet", "kick, drift, kick; symplectic"}, 2, 2, true, ""},
    {{IntegratorKind::position_verlet, "position_verlet", "drift, kick, drift; symplectic"}, 2, 2, true, ""},
    {{IntegratorKind::rk4, "rk4", "the classical Runge-Kutta scheme"}, 4, 2.8284271247461903, true, ""},
    {{IntegratorKind::yoshida4, "yoshida4", "three Verlet steps; symplectic"},
     4,
     1.5734,
     false,
     "its middle stage runs backwards in time"},
    {{IntegratorKind::implicit_midpoint, "implicit_midpoint", "implicit, symplectic, stable for every step"},
     2,
     always_stable,
     false,
     "its Newton iteration knows no contact impulses"},
    {{IntegratorKind::thesis_verlet, "thesis_verlet", "as printed in the thesis"}, 1, 0, true, "", true},
    {{IntegratorKind::thesis_rk4, "thesis_rk4", "as printed in the thesis"}, 1, 0, true, "", true},
}};

inline constexpr std::array<Choice<BroadPhaseKind>, 5> broad_phases{{
    {BroadPhaseKind::brute_force, "brute_force", "every pair of boxes"},
    {BroadPhaseKind::bounding_circle, "bounding_circle", "every pair of bounding circles, as in the thesis"},
    {BroadPhaseKind::sweep_and_prune, "sweep_and_prune", "boxes sorted along one axis"},
    {BroadPhaseKind::uniform_grid, "uniform_grid", "boxes in equal square cells; large ones apart"},
    {BroadPhaseKind::aabb_tree, "aabb_tree", "a tree of boxes over the shapes, sorted along a curve through space"},
}};

inline constexpr std::array<Choice<MixRule>, 4> mix_rules{{
    {MixRule::geometric_mean, "sqrt", "sqrt(a * b)"},
    {MixRule::maximum, "max", "the larger"},
    {MixRule::minimum, "min", "the smaller, as in the thesis"},
    {MixRule::average, "average", "(a + b) / 2"},
}};

inline constexpr std::array<Choice<JointSolverKind>, 2> joint_solvers{{
    {JointSolverKind::iterative, "iterative", "one joint after the other, as soft rows"},
    {JointSolverKind::direct, "direct", "bodies that joints connect are solved as one, unless they have many loops"},
}};

inline constexpr std::array<Choice<SubstepLoads>, 2> substep_loads{{
    {SubstepLoads::weight, "weight", "what stands on a body, and what whirls about a fixed one"},
    {SubstepLoads::measured, "measured", "the forces of the last two ticks, too, and what whirls without a fixed body"},
}};

inline constexpr std::array<Choice<BodyType>, 3> body_types{{
    {BodyType::static_body, "static", "never moves"},
    {BodyType::kinematic_body, "kinematic", "moves with its velocity, is not pushed"},
    {BodyType::dynamic_body, "dynamic", "moves and is pushed"},
}};

/// Fields of Shape that only some kinds have.
enum class ShapeField : std::uint8_t { center, angle, half_size, vertices, radius, loop };

struct ShapeKindInfo : Choice<ShapeKind> {
  std::array<FieldKey<ShapeField>, 5> keys;  // in the order of the printer
  bool has_area = true;                      // false: a line, which has no mass
  bool is_plain = false;                     // supported by solvers that read no contacts, if not rounded
};
inline constexpr FieldRange chain_length{2, limits::chain_vertex_count_max};
inline constexpr std::array<ShapeKindInfo, 6> shape_kinds{{
    {{ShapeKind::circle, "circle", "centre and radius"},
     {{{ShapeField::radius, "radius", true, ranges::size}, {ShapeField::center, "center"}}},
     true,
     true},
    {{ShapeKind::box, "box", "half extents, turned by an angle; may be rounded by a radius"},
     {{{ShapeField::half_size, "half_size", true},
       {ShapeField::center, "center"},
       {ShapeField::angle, "angle"},
       {ShapeField::radius, "radius"}}},
     true,
     true},
    {{ShapeKind::polygon, "polygon", "convex, 3..16 vertices; may be rounded by a radius"},
     {{{ShapeField::vertices, "vertices", true}, {ShapeField::radius, "radius"}}},
     true,
     true},
    {{ShapeKind::capsule, "capsule", "two centres and a radius"},
     {{{ShapeField::vertices, "points", true}, {ShapeField::radius, "radius", true, ranges::size}}}},
    {{ShapeKind::segment, "segment", "a line between two points, of both sides; has no mass"},
     {{{ShapeField::vertices, "points", true}}},
     false},
    {{ShapeKind::chain, "chain", "a line through points, of its right side; no bumps at its corners; has no mass"},
     {{{ShapeField::vertices, "points", true, chain_length}, {ShapeField::loop, "loop"}}},
     false},
}};

/// Fields of Force, except name and kind.
enum class ForceField : std::uint8_t {
  body,
  other,
  anchor,
  point,
  vector,
  torque,
  coefficient,
  angular_coefficient,
  exponent,
  stiffness,
  damping,
  rest_length,
};

struct ForceKindInfo : Choice<ForceKind> {
  std::array<FieldKey<ForceField>, 8> keys;  // in the order of the printer
};
inline constexpr FieldRange attraction{-stiffness_max, stiffness_max};
inline constexpr std::array<ForceKindInfo, 6> force_kinds{{
    {{ForceKind::constant, "constant", "a constant force (world axes, at the centre of mass) and torque"},
     {{{ForceField::body, "body"}, {ForceField::vector, "force"}, {ForceField::torque, "torque"}}}},
    {{ForceKind::central, "central", "m k |r|^p towards a point of the world"},
     {{{ForceField::body, "body"},
       {ForceField::point, "center"},
       {ForceField::coefficient, "coefficient", true, attraction},
       {ForceField::exponent, "exponent"}}}},
    {{ForceKind::spring, "spring", "spring and damper between an anchor and another body's anchor or a point"},
     {{{ForceField::body, "body", true},
       {ForceField::other, "other"},
       {ForceField::anchor, "anchor"},
       {ForceField::point, "point"},
       {ForceField::stiffness, "stiffness", true},
       {ForceField::damping, "damping"},
       {ForceField::rest_length, "rest_length"}}}},
    {{ForceKind::wind, "wind", "moves the air that drags refer to"},
     {{{ForceField::vector, "velocity", true, ranges::speed}}}},
    {{ForceKind::linear_drag, "linear_drag", "-c (v - wind), and a torque -c_r w"},
     {{{ForceField::body, "body"},
       {ForceField::coefficient, "coefficient", true},
       {ForceField::angular_coefficient, "angular_coefficient"}}}},
    {{ForceKind::quadratic_drag, "quadratic_drag", "-c |v - wind| (v - wind), and a torque -c_r |w| w"},
     {{{ForceField::body, "body"},
       {ForceField::coefficient, "coefficient", true},
       {ForceField::angular_coefficient, "angular_coefficient"}}}},
}};

/// Fields of ClockSettings, except kind.
enum class ClockField : std::uint8_t { ticks_per_frame_max, tolerance, dt_min, dt_max };

struct ClockKindInfo : Choice<ClockKind> {
  std::array<FieldKey<ClockField>, 4> keys;
};
inline constexpr std::array<ClockKindInfo, 4> clock_kinds{{
    {{ClockKind::fixed, "fixed", "ticks of dt; frame time that is left over is kept"}, {}},
    {{ClockKind::semi_fixed, "semi_fixed", "ticks of dt, at most so many a frame; time beyond is dropped and reported"},
     {{{ClockField::ticks_per_frame_max, "ticks_per_frame_max"}}}},
    {{ClockKind::variable, "variable", "one tick per frame, as long as the frame"}, {{{ClockField::dt_max, "dt_max"}}}},
    {{ClockKind::adaptive, "adaptive", "as many ticks as keep the error of each below a tolerance"},
     {{{ClockField::tolerance, "tolerance"}, {ClockField::dt_min, "dt_min"}, {ClockField::dt_max, "dt_max"}}}},
}};

/// The table of a choice that is a field of every scene or body.
struct Tables {
  static constexpr const auto& of(Precision) { return precisions; }
  static constexpr const auto& of(SolverKind) { return solvers; }
  static constexpr const auto& of(IntegratorKind) { return integrators; }
  static constexpr const auto& of(BroadPhaseKind) { return broad_phases; }
  static constexpr const auto& of(JointSolverKind) { return joint_solvers; }
  static constexpr const auto& of(SubstepLoads) { return substep_loads; }
  static constexpr const auto& of(MixRule) { return mix_rules; }
  static constexpr const auto& of(BodyType) { return body_types; }
};

/// The row of a table with this kind. Requires: the table has one (each table lists its whole enumeration).
template <typename Table, typename Kind>
constexpr const auto& info_of(const Table& table, Kind kind) {
  return table[static_cast<std::size_t>(kind)];
}

/// Whether info_of finds each row of a table.
template <typename Table>
constexpr bool rows_are_in_order(const Table& table) {
  for (std::size_t i = 0; i < table.size(); ++i)
    if (static_cast<std::size_t>(table[i].kind) != i) return false;
  return true;
}

static_assert(rows_are_in_order(shape_kinds) && rows_are_in_order(force_kinds) && rows_are_in_order(clock_kinds));

constexpr bool is_line(ShapeKind kind) {
  return !info_of(shape_kinds, kind).has_area;
}

/// The row with this name, or null.
template <typename Table>
constexpr auto find_choice(const Table& table, std::string_view name) -> const typename Table::value_type* {
  for (const auto& row : table)
    if (row.name == name) return &row;
  return nullptr;
}

/// "a, b or c", for error messages.
template <typename Table>
std::string choice_names(const Table& table) {
  std::string text;
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (i > 0) text += i + 1 == table.size() ? " or " : ", ";
    text += table[i].name;
  }
  return text;
}

}  // namespace ticktrue::engine
