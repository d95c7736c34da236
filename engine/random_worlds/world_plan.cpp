// Draws the plan of a random world, and drops choices that do not go together.
// SPDX-License-Identifier: MIT
#include "engine/random_worlds/world_plan.h"

#include <span>

namespace ticktrue::engine {
namespace {

/// Draws a row of a table by weight.
template <typename Table, typename Weight>
auto draw_row(Draw& draw, const Table& table, Weight weight_of) {
  std::uint32_t sum = 0;
  for (const auto& row : table) sum += static_cast<std::uint32_t>(weight_of(row));
  std::uint32_t at = draw.below(sum);
  for (const auto& row : table) {
    const auto weight = static_cast<std::uint32_t>(weight_of(row));
    if (at < weight) return row.kind;
    at -= weight;
  }
  return table[0].kind;
}

/// Draws each row with this chance.
template <typename Kind, typename Table, typename Predicate>
std::vector<Kind> draw_subset(Draw& draw, const Table& table, int percent, Predicate may_have) {
  std::vector<Kind> kinds;
  for (const auto& row : table)
    if (draw.chance(percent) && may_have(row.kind)) kinds.push_back(row.kind);
  return kinds;
}

void draw_choices(Draw& draw, WorldPlan& plan) {
  Settings& settings = plan.settings;
  const Settings defaults;
  settings.precision = draw_row(draw, precisions, [](const auto&) { return 1; });
  // The complete solver is most likely: the other solvers leave out most sources of errors.
  settings.solver = draw_row(draw, solvers, [](const SolverInfo& info) {
    return 9 + (info.solves_joints ? 9 : 0) + (info.solves_joints && info.substeps ? 46 : 0);
  });
  settings.integrator = draw_row(draw, integrators, [&](const IntegratorInfo& info) {
    if (!info.carries_constraints && plan.is_plain()) return 0;  // nothing could collide, but in plain scenes all does
    return info.kind == defaults.integrator ? 40 : 9;
  });
  settings.broad_phase =
      draw_row(draw, broad_phases, [&](const auto& info) { return info.kind == defaults.broad_phase ? 40 : 15; });
  settings.friction_mix = draw_row(draw, mix_rules, [](const auto&) { return 1; });
  settings.restitution_mix = draw_row(draw, mix_rules, [](const auto&) { return 1; });
  plan.collides = plan.carries_constraints();
}

void draw_clock(Draw& draw, ClockSettings& clock) {
  clock.kind = draw_row(draw, clock_kinds, [](const auto& info) { return info.kind == ClockKind::fixed ? 50 : 17; });
  const auto& fields = info_of(clock_kinds, clock.kind);
  const auto has = [&](ClockField field) { return !key_of(fields, field).empty(); };
  if (has(ClockField::ticks_per_frame_max)) clock.ticks_per_frame_max = draw.between(1, 8);
  if (has(ClockField::tolerance)) clock.tolerance = draw.power(-16, -8);
  if (has(ClockField::dt_max)) clock.dt_max = draw.power(-6, -3);
}

void draw_features(Draw& draw, WorldPlan& plan) {
  const auto infos = world_features();
  for (std::size_t i = 0; i < infos.size(); ++i) plan.features[i] = draw.chance(infos[i].percent);
  const auto take_back = [&](WorldFeature feature) { plan.features[static_cast<std::size_t>(feature)] = false; };
  if (!plan.solver().solves_joints) take_back(WorldFeature::sleeping);
  if (!plan.solver().substeps) take_back(WorldFeature::automatic_substeps);
  // Without a load, automatic substeps have nothing to choose.
  if (plan.has(WorldFeature::automatic_substeps) && draw.chance(60)) take_back(WorldFeature::zero_gravity);
  if (!plan.solver().reads_contacts)
    for (const WorldFeature feature : {WorldFeature::events, WorldFeature::sensors}) take_back(feature);
  if (plan.is_plain())
    for (const WorldFeature feature :
         {WorldFeature::category_filters, WorldFeature::group_filters, WorldFeature::tangent_speed,
          WorldFeature::rolling_resistance, WorldFeature::rounded_shapes})
      take_back(feature);
  if (plan.settings.integrator != IntegratorKind::semi_implicit_euler) take_back(WorldFeature::locate_impacts);
}

void apply_features(Draw& draw, WorldPlan& plan) {
  Settings& settings = plan.settings;
  settings.substeps = draw.chance(60) ? Settings{}.substeps : draw.between(2, 5);
  if (plan.has(WorldFeature::many_substeps)) settings.substeps = 8 << draw.below(2);
  if (plan.has(WorldFeature::one_substep) || !plan.solver().substeps) settings.substeps = 1;
  if (plan.has(WorldFeature::automatic_substeps)) {
    settings.auto_substeps.emplace();
    settings.auto_substeps->substeps_max = 16 << draw.below(3);
    if (plan.has(WorldFeature::tight_target_error))
      settings.auto_substeps->target_error = draw.half() ? 0.0005 : 0.001;
    else if (plan.has(WorldFeature::loose_target_error))
      settings.auto_substeps->target_error = 0.1;
  }
  if (plan.has(WorldFeature::sleeping))
    settings.sleep = SleepSettings{draw.part(0, 8, 16), draw.one_of({0.0, 0.015625, 0.05, 0.125, 0.5})};
  settings.iterations = draw.between(1, 12);
  settings.locate_impacts = plan.has(WorldFeature::locate_impacts);
  settings.continuous = !plan.has(WorldFeature::continuous_off);
  settings.events = plan.has(WorldFeature::events);
  if (plan.has(WorldFeature::no_restitution_threshold)) settings.restitution_threshold = 0;
  if (plan.has(WorldFeature::short_ticks))
    settings.dt = draw.one_of({1.0 / 64, 1.0 / 120, 1.0 / 240});
  else if (draw.chance(15))
    settings.dt = draw.one_of({1.0 / 32, 1.0 / 50});
  draw_clock(draw, settings.clock);
  plan.gravity = {0, -draw.one_of({10, 10, 10, 9.81, 4, 1, 0.0625})};
  if (plan.has(WorldFeature::zero_gravity))
    plan.gravity = {};
  else if (plan.has(WorldFeature::sideways_gravity))
    plan.gravity = {draw.one_of({-10, -1, 0.5, 5, 10}), draw.half() ? 0 : plan.gravity.y};
}

void add_once(std::vector<InputKind>& inputs, InputKind wanted) {
  for (const InputKind kind : inputs)
    if (kind == wanted) return;
  inputs.push_back(wanted);
}

void draw_kinds(Draw& draw, WorldPlan& plan) {
  const auto knows_shape = [&](ShapeKind kind) { return !plan.is_plain() || info_of(shape_kinds, kind).is_plain; };
  plan.shapes = draw_subset<ShapeKind>(draw, shape_kinds, 40, knows_shape);
  bool some_solid = false;
  for (const ShapeKind kind : plan.shapes) some_solid = some_solid || !is_line(kind);
  if (!some_solid) plan.shapes.push_back(draw.half() ? ShapeKind::circle : ShapeKind::box);
  const auto any = [](auto) { return true; };
  // Later kinds of joints have draws of their own (add_joints), so that worlds without them stay the same.
  const auto first_joint_kinds = std::span(joint_kinds).first<static_cast<std::size_t>(JointKind::pulley)>();
  if (plan.carries_joints() && draw.chance(60)) plan.joints = draw_subset<JointKind>(draw, first_joint_kinds, 32, any);
  if (draw.chance(50)) plan.forces = draw_subset<ForceKind>(draw, force_kinds, 35, any);
  const auto takes_input = [&](InputKind kind) {
    const InputInfo& info = info_of(input_kinds, kind);
    return kind != InputKind::end && (!info.has_joint || !plan.joints.empty()) &&
           (!info.is_of_pointer || plan.carries_constraints());
  };
  plan.inputs = draw_subset<InputKind>(draw, input_kinds, 40, takes_input);
  if (!plan.joints.empty() && plan.has(WorldFeature::joint_motors) && draw.half())
    add_once(plan.inputs, InputKind::set_motor);
  plan.has_end = draw.half();
}

/// The number of bodies: most worlds are small, a few have hundreds, one in a hundred has thousands.
std::uint32_t draw_body_count(Draw& draw, std::uint32_t count_max) {
  const std::uint32_t kind = draw.below(1000);
  const std::uint32_t count = kind < 8     ? 1000 + draw.below(2001)
                              : kind < 40  ? 100 + draw.below(500)
                              : kind < 280 ? 40 + draw.below(60)
                              : kind < 700 ? 12 + draw.below(30)
                                           : 2 + draw.below(12);
  return count < count_max ? count : count_max < 2 ? 2 : count_max;
}

/// The number of ticks from a budget of work: the cost of a tick grows with bodies, substeps and stages of the
/// integrator.
std::uint64_t draw_tick_count(Draw& draw, const WorldPlan& plan, std::uint32_t count_max) {
  const Settings& settings = plan.settings;
  int cost = 4 + settings.substeps;  // in units of one body and tick
  if (settings.auto_substeps) cost += settings.auto_substeps->substeps_max / 4;
  if (settings.locate_impacts) cost += 4;
  if (plan.integrator().order > 2) cost *= 2;
  if (!plan.integrator().carries_constraints) cost *= plan.forces.empty() ? 2 : 8;
  const bool is_quadratic =
      settings.broad_phase == BroadPhaseKind::brute_force || settings.broad_phase == BroadPhaseKind::bounding_circle;
  if (is_quadratic || plan.is_plain()) cost += static_cast<int>(plan.body_count / 32);
  const std::uint64_t budget = std::uint64_t{2000} << draw.below(6);
  const std::uint64_t work = std::uint64_t{plan.body_count + 6} * static_cast<std::uint64_t>(cost);
  const std::uint64_t count = 4 * budget / work;
  const std::uint64_t most = count_max < 1 ? 1 : count_max;
  const std::uint64_t least = most < 16 ? most : 16;
  return count < least ? least : count < most ? count : most - draw.below(static_cast<std::uint32_t>(most / 4 + 1));
}

bool is_round(ShapeKind kind) {
  return kind == ShapeKind::circle || kind == ShapeKind::capsule || kind == ShapeKind::polygon;
}

/// Most often removes what disturbs bodies at rest, and adds inputs that push them.
void draw_quiet(Draw& draw, WorldPlan& plan) {
  plan.is_quiet = plan.collides && plan.body_count >= 8 && draw.chance(45);
  if (!plan.is_quiet) return;
  if (draw.chance(75)) plan.gravity = {};
  if (draw.chance(75)) plan.forces.clear();
  if (draw.chance(50)) plan.joints.clear();
  bool some_round = false;
  for (const ShapeKind kind : plan.shapes) some_round = some_round || is_round(kind);
  if (!some_round) plan.shapes.push_back(ShapeKind::circle);
  const InputKind push = draw.chance(70) ? InputKind::set_velocity : InputKind::impulse;
  if (draw.chance(80)) add_once(plan.inputs, push);
}

/// Gives small islands a load, so that automatic substeps have something to choose. Large islands with many substeps
/// take seconds per tick, most of all with joints.
void fit_automatic_substeps(Draw& draw, WorldPlan& plan) {
  if (!plan.settings.auto_substeps) return;
  if (plan.body_count <= 24) {
    if (draw.half()) plan.gravity = {4 * plan.gravity.x, 4 * plan.gravity.y};
    return;
  }
  plan.settings.auto_substeps->substeps_max = 16;
  if (plan.body_count > 60) plan.joints.clear();
}

/// Islands are solved in blocks (engine/contacts/contact_blocks.h) only if contacts alone act between bodies.
void draw_contacts_alone(Draw& draw, WorldPlan& plan) {
  if (!plan.solver().substeps || !plan.carries_constraints() || !draw.chance(15)) return;
  for (const WorldFeature feature :
       {WorldFeature::restitution, WorldFeature::kinematic_movers, WorldFeature::locate_impacts})
    plan.features[static_cast<std::size_t>(feature)] = false;
  plan.settings.locate_impacts = false;
  plan.joints.clear();
  plan.forces.clear();
  std::erase_if(plan.inputs, [](InputKind kind) { return info_of(input_kinds, kind).is_of_pointer; });
}

}  // namespace

double Draw::power(int low, int high) {
  double value = 1;
  for (int exponent = between(low, high); exponent != 0; exponent += exponent < 0 ? 1 : -1)
    value = exponent < 0 ? value / 2 : value * 2;
  return value;
}

WorldPlan draw_plan(Draw& draw, const RandomWorldOptions& options) {
  WorldPlan plan;
  draw_choices(draw, plan);
  draw_features(draw, plan);
  apply_features(draw, plan);
  draw_kinds(draw, plan);
  plan.body_count = draw_body_count(draw, options.body_count_max);
  draw_quiet(draw, plan);
  draw_contacts_alone(draw, plan);
  fit_automatic_substeps(draw, plan);
  // Each impact of the largest body tests the pairs of all other bodies again.
  if (plan.has(WorldFeature::size_ratio) && plan.body_count > 60) plan.settings.locate_impacts = false;
  plan.tick_count = draw_tick_count(draw, plan, options.tick_count_max);
  return plan;
}

}  // namespace ticktrue::engine
