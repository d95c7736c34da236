// The passes of the direct joint solver.
// SPDX-License-Identifier: MIT
// Source: as direct_island.h.
#include "engine/joints/direct/direct_island.h"

#include <utility>

#include "engine/joints/direct/direct_energy.h"
#include "engine/joints/direct/direct_system.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
namespace {

constexpr double push_rate = 48;          // 1/s, of a gap: a substep of 1/240 s closes a fifth
constexpr double push_share_max = 0.2;    // of a gap in a substep
constexpr double gap_of_rounding = 1e-6;  // m: corrected without this bound

/// The limit of h^2 F r, relative to the inertia.
constexpr double turning_limit = 2;

constexpr double hard_energy_share = 0.1;  // of the kinetic energy
constexpr double miss_least = 1e-3;        // m
constexpr double converging_share = 0.6;   // of the miss, which a pass leaves at most
constexpr int early_pass_count = 4;        // passes that meet the positions where a substep is short enough

double row_product(const Block& gradient, std::size_t row, const Triple& v) {
  return (gradient[3 * row] * v[0] + gradient[3 * row + 1] * v[1]) + gradient[3 * row + 2] * v[2];
}

/// sin_cos, faster for small angles.
SinCos turn_by(double angle) {
  if (!(magnitude(angle) < 0.125)) return sin_cos(angle);
  const double z = angle * angle;  // the terms left out are below 1e-18
  const double sine = (((1.0 / 362880 * z - 1.0 / 5040) * z + 1.0 / 120) * z - 1.0 / 6) * z;
  const double cosine = ((((-1.0 / 3628800 * z + 1.0 / 40320) * z - 1.0 / 720) * z + 1.0 / 24) * z - 0.5) * z;
  return {angle + angle * sine, 1 + cosine};
}

void find_moved_poses(DirectIsland& island, double h) {
  island.moved_poses.resize(island.bodies.size());
  for (std::size_t i = 0; i < island.bodies.size(); ++i) island.moved_poses[i] = moved(island.bodies[i], h);
}

double row_speed(const DirectIsland& island, const DirectJoint& joint, std::size_t row) {
  double speed = 0;
  if (joint.body_a != no_direct_body)
    speed += row_product(joint.equations.gradient_a, row, island.bodies[joint.body_a].velocity);
  if (joint.body_b != no_direct_body)
    speed += row_product(joint.equations.gradient_b, row, island.bodies[joint.body_b].velocity);
  return speed;
}

/// The speed of a row for the velocities with which bodies move.
double row_drift(const DirectIsland& island, const DirectJoint& joint, std::size_t row) {
  double speed = row_speed(island, joint, row);
  if (is_moving(island, joint.body_a))
    speed -= row_product(joint.equations.gradient_a, row, island.bodies[joint.body_a].lag);
  if (is_moving(island, joint.body_b))
    speed -= row_product(joint.equations.gradient_b, row, island.bodies[joint.body_b].lag);
  return speed;
}

void apply_impulse(DirectBody& body, const Block& gradient, std::size_t row, double impulse) {
  const double* g = gradient.data() + 3 * row;
  body.velocity[0] += g[0] * impulse * body.inv_mass;
  body.velocity[1] += g[1] * impulse * body.inv_mass;
  body.velocity[2] += g[2] * impulse * body.inv_inertia;
}

/// The largest number of state changes in a pass. Most substeps have none.
constexpr int state_change_max = 3;

/// The correction of a gap in a substep, m.
double taken_back(double error, double h) {
  const double most = push_speed_max * h;
  const double share = push_rate * h;
  const double wanted = (share < push_share_max ? share : push_share_max) * error;
  if (wanted > most) return most;
  return wanted < -most ? -most : wanted;
}

/// The target of a row's error after the substep.
double target_of(const DirectIsland& island, double error, double h) {
  return error - island.push_share * taken_back(error, h);
}

/// Removes the momentum of the solution: subtracts the same velocity from all bodies, which joints between bodies do
/// not notice. The elimination leaves some momentum by rounding, more if masses differ more.
void remove_momentum(DirectIsland& island) {
  double mass = 0;
  double x = 0;
  double y = 0;
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const Triple& change = island.system.values[island.graph->body_nodes[i]];
    mass += island.bodies[i].mass;
    x += island.bodies[i].mass * change[0];
    y += island.bodies[i].mass * change[1];
  }
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    Triple& change = island.system.values[island.graph->body_nodes[i]];
    change[0] -= x / mass;
    change[1] -= y / mass;
  }
}

/// Solves for system.values.
void solve_system(DirectIsland& island) {
  solve(*island.graph, island.system);
  if (island.is_free) remove_momentum(island);
}

/// Solves for system.values and adds the solution to velocities.
void add_velocities(DirectIsland& island) {
  solve_system(island);
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const Triple& change = island.system.values[island.graph->body_nodes[i]];
    for (std::size_t k = 0; k < 3; ++k) island.bodies[i].velocity[k] += change[k];
  }
}

/// Solves for system.values and adds the solution to velocities and impulses.
void add_solution(DirectIsland& island) {
  add_velocities(island);
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const Triple& change = island.system.values[island.graph->joint_nodes[i]];
    for (std::size_t row = 0; row < island.joints[i].equations.row_count; ++row)
      island.joints[i].impulses[row] -= change[row];
  }
}

/// Sets the right-hand side. residual(joint, row): the error of a row's speed.
template <typename Residual>
void set_residuals(DirectIsland& island, const Residual& residual) {
  for (Triple& value : island.system.values) value = {};
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const DirectJoint& joint = island.joints[i];
    Triple& value = island.system.values[island.graph->joint_nodes[i]];
    for (std::size_t row = 0; row < joint.equations.row_count; ++row)
      if (joint.can_move[row]) value[row] = -residual(joint, row);
  }
}

/// The error of a row's speed before the move. `then`: the row's position error after the move.
double residual_of(const DirectIsland& island, const DirectJoint& joint, std::size_t row, double then, double h) {
  const double soft = joint.compliances[row] * joint.impulses[row];
  if (row < joint.equations.rigid_count) return (then - joint.targets[row]) / h + soft;
  const DirectDrive& drive = drive_of(island, joint, row);
  if (!drive.law.is_in_system) return 0;
  if (!is_at_limit(drive)) {
    const double speed = acts_like_force(drive) ? row_speed(island, joint, row) : row_drift(island, joint, row);
    return (speed - drive.law.speed) + soft;
  }
  const double limit = drive.state == DriveState::at_lower ? drive.lower : drive.upper;
  const double over = drive.start_error - limit;
  const bool is_beyond = drive.state == DriveState::at_lower ? over < 0 : over > 0;
  return (then - (is_beyond ? limit + target_of(island, over, h) : limit)) / h + soft;
}

/// One pass in which the errors after the move follow from the speeds, to first order.
void pass_to_speeds(DirectIsland& island, double h) {
  set_residuals(island, [&island, h](const DirectJoint& joint, std::size_t row) {
    const double then = joint.equations.errors[row] + h * row_drift(island, joint, row);
    return residual_of(island, joint, row, then, h);
  });
  add_solution(island);
}

/// The errors that residual_of asks for.
Triple errors_after_move(const DirectIsland& island, const DirectJoint& joint, const JointShape& shape, const Pose& a,
                         const Pose& b) {
  if (!holds_point(shape)) return equations_of(shape, a, b).errors;
  const Place gap = point_gap(shape, a, b);
  const bool needs_angle = joint.equations.rigid_count == 3 || is_at_limit(drive_of(island, joint, 2));
  return {gap.x, gap.y, needs_angle ? angle_error(shape, a, b) : 0};
}

/// Sets the right-hand side from the errors after the move. Returns the largest distance of a rigid row from its
/// target, m or rad.
double set_position_residuals(DirectIsland& island, double h) {
  constexpr Pose world;
  find_moved_poses(island, h);
  for (const std::uint32_t node : island.graph->body_nodes) island.system.values[node] = {};
  double most = 0;
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const DirectJoint& joint = island.joints[i];
    const JointShape& shape = island.shapes[i];
    const Pose& a = joint.body_a == no_direct_body ? world : island.moved_poses[joint.body_a];
    const Pose& b = joint.body_b == no_direct_body ? world : island.moved_poses[joint.body_b];
    Triple& value = island.system.values[island.graph->joint_nodes[i]];
    if (is_point(shape)) {
      const Place gap = point_gap(shape, a, b);
      const double miss_x = gap.x - joint.targets[0];
      const double miss_y = gap.y - joint.targets[1];
      value = {-(miss_x / h + joint.compliances[0] * joint.impulses[0]),
               -(miss_y / h + joint.compliances[1] * joint.impulses[1]), 0};
      if (!(magnitude(miss_x) <= most)) most = magnitude(miss_x);
      if (!(magnitude(miss_y) <= most)) most = magnitude(miss_y);
      continue;
    }
    const Triple then = errors_after_move(island, joint, shape, a, b);
    value = {};
    for (std::size_t row = 0; row < joint.equations.row_count; ++row) {
      if (!joint.can_move[row]) continue;  // whatever is asked of it, it misses
      value[row] = -residual_of(island, joint, row, then[row], h);
      if (row >= joint.equations.rigid_count) continue;
      const double miss = magnitude(then[row] - joint.targets[row]);
      if (!(miss <= most)) most = miss;
    }
  }
  return most;
}

void pass_to_positions(DirectIsland& island, double h) {
  set_position_residuals(island, h);
  add_solution(island);
}

/// Calls body(joint, row, drive, mobility) for each row with a drive.
template <typename Body>
void for_drives(DirectIsland& island, const Body& body) {
  if (!island.has_drives) return;
  for (DirectJoint& joint : island.joints)
    for (std::size_t row = joint.equations.rigid_count; row < joint.equations.row_count; ++row) {
      DirectDrive& drive = drive_of(island, joint, row);
      const double k = exists(drive) ? mobility(island, joint, row) : 0;
      if (k > 0) body(joint, row, drive, drive.mobility > 0 ? drive.mobility : k);
    }
}

void apply_row(DirectIsland& island, const DirectJoint& joint, std::size_t row, double impulse) {
  if (is_moving(island, joint.body_a))
    apply_impulse(island.bodies[joint.body_a], joint.equations.gradient_a, row, impulse);
  if (is_moving(island, joint.body_b))
    apply_impulse(island.bodies[joint.body_b], joint.equations.gradient_b, row, impulse);
}

/// Updates the states of drives after a pass. True: a state has changed, and the system is factored again.
bool change_states(DirectIsland& island, double h) {
  bool is_changed = false;
  for_drives(island, [&](const DirectJoint& joint, std::size_t row, DirectDrive& drive, double k) {
    if (update_state(drive, k, joint.impulses[row], row_drift(island, joint, row), h)) is_changed = true;
  });
  if (!is_changed) return false;
  for_drives(island, [&](DirectJoint& joint, std::size_t row, DirectDrive& drive, double k) {
    drive.law = law_of(drive, k);
    if (drive.law.is_in_system) return;
    apply_row(island, joint, row, drive.law.impulse - joint.impulses[row]);
    joint.impulses[row] = drive.law.impulse;
  });
  factor_laws(island);
  return true;
}

/// Repeats a pass while states of drives change.
template <typename Pass>
void settle(DirectIsland& island, double h, const Pass& pass) {
  if (!island.has_drives) return;
  for (int change = 0; change < state_change_max && change_states(island, h); ++change) pass(island, h);
}

/// One pass from the right-hand side that set_position_residuals has set.
void pass_from_residuals(DirectIsland& island, double h) {
  add_solution(island);
  settle(island, h, pass_to_positions);
}

}  // namespace

Pose moved(const DirectBody& body, double h) {
  const Triple& v = body.velocity;
  const SinCos turn = turn_by(h * (v[2] - body.lag[2]));
  return {{body.pose.position.x + h * (v[0] - body.lag[0]), body.pose.position.y + h * (v[1] - body.lag[1])},
          turn.cos * body.pose.c - turn.sin * body.pose.s,
          turn.sin * body.pose.c + turn.cos * body.pose.s};
}

GraphJoint graph_joint(const JointShape& shape, const DirectJoint& joint, std::size_t moving_count, bool a_turns,
                       bool b_turns) {
  GraphJoint row;
  const bool a_moves = joint.body_a < moving_count;
  const bool b_moves = joint.body_b < moving_count;
  if (a_moves) row.bodies[row.body_count++] = joint.body_a;
  if (b_moves) row.bodies[row.body_count++] = joint.body_b;
  row.is_to_world = !a_moves || !b_moves;
  row.is_last = shape.kind == JointKind::pulley;  // the direction of a short side is undefined
  const JointEquations equations = equations_of(shape, Pose{}, Pose{});
  for (std::uint32_t i = 0; i < equations.row_count; ++i) {
    const auto acts = [i](const Block& gradient, bool moves, bool turns) {
      return moves && (gradient[3 * i] != 0 || gradient[3 * i + 1] != 0 || (turns && gradient[3 * i + 2] != 0));
    };
    const bool acts_on_a = acts(equations.gradient_a, a_moves, a_turns);
    const bool acts_on_b = acts(equations.gradient_b, b_moves, b_turns);
    if (acts_on_a || acts_on_b) ++row.row_count;
    if (a_moves && b_moves && acts_on_a != acts_on_b) row.is_last = true;
  }
  row.dimension = equations.row_count > 0 ? equations.row_count : 1;
  row.holds_point =
      holds_point(shape) && (equations.row_count == 2 || ((!a_moves || a_turns) && (!b_moves || b_turns)));
  if (row.row_count == 0) row.row_count = 1;
  return row;
}

bool is_internal(const JointShape& shape, const DirectJoint& joint, std::size_t moving_count) {
  return joint.body_a < moving_count && joint.body_b < moving_count && traits_of(shape.kind).conserves_momentum;
}

void order_island(DirectIsland& island) {
  island.moving_count = island.bodies.size();
  island.has_drives = false;
  island.is_free = true;
  std::vector<GraphJoint> joints;
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const auto body_turns = [&](std::uint32_t body) {
      return body < island.moving_count && island.bodies[body].inertia > 0;
    };
    const DirectJoint& joint = island.joints[i];
    joints.push_back(
        graph_joint(island.shapes[i], joint, island.moving_count, body_turns(joint.body_a), body_turns(joint.body_b)));
    island.is_free = island.is_free && is_internal(island.shapes[i], island.joints[i], island.moving_count);
  }
  for (const DirectDrive& drive : island.drives) island.has_drives = island.has_drives || exists(drive);
  island.graph =
      std::make_shared<const JointGraph>(make_joint_graph(static_cast<std::uint32_t>(island.moving_count), joints));
}

void factor_island(DirectIsland& island) {
  for (DirectBody& body : island.bodies) {
    body.inv_mass = 1 / body.mass;
    body.inv_inertia = body.inertia > 0 ? 1 / body.inertia : 0;
  }
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    DirectJoint& joint = island.joints[i];
    constexpr Pose world;
    const Pose& a = joint.body_a == no_direct_body ? world : island.bodies[joint.body_a].pose;
    const Pose& b = joint.body_b == no_direct_body ? world : island.bodies[joint.body_b].pose;
    find_equations(island.shapes[i], a, b, joint.equations);
    for (std::size_t row = 0; row < joint.equations.row_count; ++row)
      joint.can_move[row] = mobility(island, joint, row) > 0;
  }
  for (DirectDrive& drive : island.drives) drive.law = {};
  for_drives(island, [](const DirectJoint& joint, std::size_t row, DirectDrive& drive, double) {
    drive.law = law_after_move(drive, joint.impulses[row]);
  });
  factor_laws(island);
}

double drive_mobility(const DirectIsland& island, std::size_t index, std::size_t row) {
  const DirectJoint& joint = island.joints[index];
  const double k = mobility(island, joint, row);
  const std::uint32_t rigid_count = joint.equations.rigid_count;
  // The springs of wheels ignore the row across the axis.
  if (rigid_count == 0 || island.shapes[index].kind == JointKind::wheel) return k;
  const double k00 = mobility(island, joint, 0);
  const double k0 = coupling(island, joint, row, 0);
  if (rigid_count == 1) return k00 > 0 ? k - k0 * k0 / k00 : k;
  const double k11 = mobility(island, joint, 1);
  const double k01 = coupling(island, joint, 0, 1);
  const double k1 = coupling(island, joint, row, 1);
  const double determinant = k00 * k11 - k01 * k01;
  if (determinant > 0) return k - ((k11 * k0 - k01 * k1) * k0 + (k00 * k1 - k01 * k0) * k1) / determinant;
  return k00 > 0 ? k - k0 * k0 / k00 : k;
}

bool has_impulses(const DirectIsland& island) {
  for (const DirectJoint& joint : island.joints)
    for (const double impulse : joint.impulses)
      if (impulse != 0) return true;
  return false;
}

double largest_gap(const DirectIsland& island) {
  double most = 0;
  for (const DirectJoint& joint : island.joints)
    for (std::size_t row = 0; row < joint.equations.rigid_count; ++row)
      if (joint.can_move[row] && magnitude(joint.equations.errors[row]) > most)
        most = magnitude(joint.equations.errors[row]);
  return most;
}

bool raise_inertias(DirectIsland& island, double h) {
  std::vector<double>& angular_impulses = island.angular_impulses;
  angular_impulses.assign(island.moving_count, 0);
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const DirectJoint& joint = island.joints[i];
    const JointShape& shape = island.shapes[i];
    const double across = holds_point(shape) ? joint.impulses[1] : 0;
    const double impulse = __builtin_sqrt(joint.impulses[0] * joint.impulses[0] + across * across);
    const double ratio = shape.kind == JointKind::pulley ? shape.ratio : 1;
    if (is_moving(island, joint.body_a)) angular_impulses[joint.body_a] += impulse * arm_of(shape.anchor_a);
    if (is_moving(island, joint.body_b)) angular_impulses[joint.body_b] += ratio * impulse * arm_of(shape.anchor_b);
  }
  bool any = false;
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const double least = h * angular_impulses[i] / turning_limit;
    double& inertia = island.bodies[i].inertia;
    if (!(inertia > 0) || !(least > inertia)) continue;
    inertia = least;
    any = true;
  }
  return any;
}

void add_force_like_changes(const DirectIsland& island, std::vector<Triple>& changes) {
  for (const DirectJoint& joint : island.joints)
    for (std::size_t row = joint.equations.rigid_count; row < joint.equations.row_count; ++row) {
      if (!acts_like_force(drive_of(island, joint, row))) continue;
      const double impulse = joint.impulses[row];
      for (const auto& [body, gradient] : {std::pair{joint.body_a, &joint.equations.gradient_a},
                                           std::pair{joint.body_b, &joint.equations.gradient_b}}) {
        if (!is_moving(island, body)) continue;
        const double* g = gradient->data() + 3 * row;
        changes[body][0] += g[0] * impulse * island.bodies[body].inv_mass;
        changes[body][1] += g[1] * impulse * island.bodies[body].inv_mass;
        changes[body][2] += g[2] * impulse * island.bodies[body].inv_inertia;
      }
    }
}

namespace {

void choose_push(DirectIsland& island, double h) {
  island.push.clear();
  island.push_share = 1;
  if (largest_gap(island) <= gap_of_rounding) return;
  set_residuals(island, [h](const DirectJoint& joint, std::size_t row) {
    return row < joint.equations.rigid_count ? taken_back(joint.equations.errors[row], h) / h : 0;
  });
  solve_system(island);
  double asked = 0;
  double allowed = 0;
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    island.push.push_back(island.system.values[island.graph->body_nodes[i]]);
    asked += double_energy(island.bodies[i], island.push[i]);
    allowed += island.bodies[i].mass * (push_body_speed * push_body_speed);
  }
  if (asked > allowed) island.push_share = __builtin_sqrt(allowed / asked);
  for (Triple& velocity : island.push)
    for (double& component : velocity) component *= island.push_share;
  island.push_impulses.resize(island.joints.size());
  for (std::size_t i = 0; i < island.joints.size(); ++i)
    for (std::size_t row = 0; row < 3; ++row)
      island.push_impulses[i][row] = -island.push_share * island.system.values[island.graph->joint_nodes[i]][row];
}

}  // namespace

void begin_substep(DirectIsland& island, double h) {
  if (island.has_drives) {
    for_drives(island, [&island](const DirectJoint& joint, std::size_t row, DirectDrive& drive, double k) {
      drive.start_error = joint.equations.errors[row];
      drive.start_speed = row_speed(island, joint, row);
      if (drive.state == DriveState::free && drive.has_motor) drive.state = DriveState::motor;
      drive.law = law_of(drive, k);
    });
    factor_laws(island);
  }
  choose_push(island, h);
  for (DirectJoint& joint : island.joints)
    for (std::size_t row = 0; row < joint.equations.rigid_count; ++row)
      joint.targets[row] = target_of(island, joint.equations.errors[row], h);
}

void start_impulses(DirectIsland& island) {
  for (DirectJoint& joint : island.joints) {
    joint.impulses = {};
    for (std::size_t row = joint.equations.rigid_count; row < joint.equations.row_count; ++row) {
      const RowLaw law = drive_of(island, joint, row).law;
      if (law.is_in_system || law.impulse == 0) continue;
      joint.impulses[row] = law.impulse;
      apply_row(island, joint, row, law.impulse);
    }
  }
}

void solve_velocities(DirectIsland& island, double h) {
  save(island, island.saved);
  pass_to_speeds(island, h);
  settle(island, h, pass_to_speeds);
  bound_changes(island, island.saved);
}

namespace {

/// Limits and springs push the first pass from prediction off its way; in loops rows contradict each other.
bool is_tree_without_drives(const DirectIsland& island) {
  return island.joints.size() <= island.moving_count && !island.has_drives;
}

/// The first pass from the predicted velocities. False: bodies turn too far for it, and nothing has changed. Requires:
/// the island was saved as `start`.
bool begin_with_prediction(DirectIsland& island, double h) {
  set_position_residuals(island, h);
  add_solution(island);
  const KineticEnergy energy = kinetic_energy(island, resting_body_speed);
  if (!(energy.now > (1 + hard_energy_share) * energy.at_start)) return true;
  restore(island, island.start);
  return false;
}

}  // namespace

PositionOutcome meet_positions(DirectIsland& island, double h, double tolerance, int pass_max) {
  save(island, island.start);
  const bool is_begun = is_tree_without_drives(island) && begin_with_prediction(island, h);
  if (!is_begun) solve_velocities(island, h);
  save(island, island.saved);
  double miss = set_position_residuals(island, h);
  double early_miss = miss;
  for (int pass = is_begun ? 1 : 0; pass < pass_max && !(miss <= tolerance); ++pass) {
    const double before = miss;
    pass_from_residuals(island, h);
    miss = set_position_residuals(island, h);
    if (pass < early_pass_count) early_miss = miss;
    const bool may_rise = island.has_drives && pass < early_pass_count;  // a limit that begins to act moves its target
    if (!may_rise && !(miss <= converging_share * before)) break;        // further passes would diverge
  }
  if (!(early_miss <= island.worst_miss)) island.worst_miss = early_miss;
  if (!(miss <= miss_least)) {
    restore(island, island.start);
    if (island.has_drives) factor_laws(island);
    solve_velocities(island, h);
    return PositionOutcome::missed;
  }
  const EnergyDemand demand = energy_demand(island, island.saved, resting_body_speed);
  const double asked = demand.asked;
  const double had = demand.had;
  const double allowed = hard_energy_share * had;
  if (!(asked > allowed)) return PositionOutcome::met;
  scale_changes(island, island.saved, __builtin_sqrt(allowed / asked));
  return PositionOutcome::scaled;
}

void end_push(DirectIsland& island) {
  if (island.push.empty()) return;
  save(island, island.saved);
  double pushed = 0;
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const DirectBody& body = island.bodies[i];
    pushed += double_energy(body, island.push[i]) + body.mass * (push_body_speed * push_body_speed);
  }
  // Free islands keep their angular momentum: the impulses are taken off at the new poses. Where something holds an
  // island, that would feed its sway, since a pull on a chain turns with the chain: a taut bridge was thrown upwards.
  if (island.is_free)
    for (std::size_t i = 0; i < island.joints.size(); ++i)
      for (std::size_t row = 0; row < island.joints[i].equations.row_count; ++row)
        apply_row(island, island.joints[i], row, -island.push_impulses[i][row]);
  // Rows that contradict each other have impulses without bound, which cancel at the old poses alone.
  if (!island.is_free || !(energy_demand(island, island.saved, 0).asked <= own_energy_share * pushed))
    for (std::size_t i = 0; i < island.moving_count; ++i)
      for (std::size_t k = 0; k < 3; ++k)
        island.bodies[i].velocity[k] = island.saved.velocities[i][k] - island.push[i][k];
  island.push.clear();
}

void project_velocities(DirectIsland& island) {
  save(island, island.saved);
  set_residuals(island, [&island](const DirectJoint& joint, std::size_t row) {
    const RowLaw law = law_of(island, joint, row);
    return law.is_in_system ? row_speed(island, joint, row) - law.speed : 0;
  });
  add_velocities(island);
  bound_changes(island, island.saved);
}

void factor_rigid_rows(DirectIsland& island) {
  if (!island.has_drives) return;
  island.saved.drives = island.drives;
  for (DirectDrive& drive : island.drives) drive.law = {};
  factor_laws(island);
}

void end_rigid_rows(DirectIsland& island) {
  if (!island.has_drives) return;
  island.drives = island.saved.drives;
  factor_laws(island);
}

void clear_body_impulses(DirectIsland& island) {
  for (Triple& value : island.system.values) value = {};
}

void add_body_impulse(DirectIsland& island, std::uint32_t body, const Triple& impulse) {
  Triple& value = island.system.values[island.graph->body_nodes[body]];
  for (std::size_t k = 0; k < 2; ++k) value[k] += impulse[k];
  if (island.bodies[body].inv_inertia > 0) value[2] += impulse[2];
}

void solve_body_impulses(DirectIsland& island) {
  solve(*island.graph, island.system);
}

const Triple& velocity_change(const DirectIsland& island, std::uint32_t body) {
  return island.system.values[island.graph->body_nodes[body]];
}

}  // namespace ticktrue::engine
