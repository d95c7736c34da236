// The direct joint solver in a solver set: input and output of its islands.
// SPDX-License-Identifier: MIT
#include "engine/joints/direct/direct_set.h"

#include "engine/integrators/flow.h"
#include "engine/integrators/integrator.h"
#include "engine/joints/direct/direct_energy.h"
#include "engine/joints/direct/direct_joints.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// Each pass that meets the positions multiplies the error by about the angle of a substep: slow joints take three.
constexpr int position_pass_max = 8;
/// Of positions over the length of a substep, m/s and rad/s: at 60 Hz 8e-8 m in f32.
constexpr double position_tolerance = sizeof(Real) == 4 ? 5e-6 : 5e-9;
/// An island that misses positions by more than this gets more substeps in the next tick, m.
constexpr double slow_miss = 1e-6;
/// Alternations of joints and contacts, before the move and after it, if something touches a jointed body of the set.
constexpr int turn_count_of_touched = 2;
/// The same if something overlaps a jointed body deeply. A contact pushes with the mobility of its two bodies, and the
/// joints then take back what they do not let move: of the push of a light link a turn keeps little.
constexpr int turn_count_of_deep = 8;
constexpr Real deep_overlap_share = Real(0.1);  // overlap over the size of the smaller shape
/// The same from this share on if the joints have a gap: their push may press into the contact, and of two turns the
/// contact's push keeps less than that.
constexpr Real pressed_overlap_share = Real(0.02);
constexpr double pressing_gap = 1e-3;  // m or rad

Twist twist_of(const Triple& v) {
  return {{static_cast<Real>(v[0]), static_cast<Real>(v[1])}, static_cast<Real>(v[2])};
}

template <typename Body>
[[gnu::noinline]] void for_some_islands(const SolvedSet& solved, DirectWorkspace& work, const Body& body) {
  const std::size_t count = work.set_components.size();
  solved.parallel().for_chunks(count, solved.parallel().chunk_size(count, 1, 1), [&](const Chunk& chunk) {
    for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
      const std::uint32_t component = work.set_components[i];
      body(work.components.components()[component], work.islands[component]);
    }
  });
}

/// Calls body(component, island) for the islands of the set. A set without islands costs almost nothing.
template <typename Body>
void for_islands(const SolvedSet& solved, DirectWorkspace& work, const Body& body) {
  if (!work.set_components.empty()) for_some_islands(solved, work, body);
}

void list_set_components(const SolvedSet& solved, DirectWorkspace& work) {
  work.set_components.clear();
  const std::span<const DirectComponent> components = work.components.components();
  for (std::uint32_t i = 0; i < components.size(); ++i)
    if (solved.has_body(components[i].bodies[0])) work.set_components.push_back(i);
}

void load_velocities(const SolvedSet& solved, const DirectComponent& component, DirectSetIsland& at) {
  at.loaded.clear();
  for (std::size_t i = 0; i < component.bodies.size(); ++i) {
    DirectBody& body = at.island.bodies[i];
    body.velocity = velocity_of(solved.bodies.records[solved.bodies.masses[component.bodies[i]].read]);
    body.lag = {};
    if (i < component.moving_count) at.loaded.push_back(body.velocity);
  }
}

void store_velocities_of(const SolvedSet& solved, const DirectComponent& component, const DirectSetIsland& at) {
  for (std::size_t i = 0; i < component.moving_count; ++i) {
    const Twist velocity = twist_of(at.island.bodies[i].velocity);
    MovingBody& record = solved.bodies.records[component.bodies[i]];
    record.velocity = velocity.linear;
    record.angular_velocity = velocity.angular;
  }
}

/// Loads velocities and lags (DirectBody::lag).
void load_before_move(const SolvedSet& solved, const MotionWorkspace& motion, const DirectComponent& component,
                      DirectSetIsland& at) {
  load_velocities(solved, component, at);
  if (motion.drift.joint_changes.empty()) return;
  const Real share = integrator(solved.model.scene.settings.integrator).drift_share;
  for (std::size_t i = 0; i < component.moving_count; ++i) {
    const std::uint32_t row = component.bodies[i];
    const MovingBody& record = solved.bodies.records[row];
    const Twist drift = drift_velocity(motion, row, record, share);
    at.island.bodies[i].lag =
        velocity_of({record.velocity - drift.linear, record.angular_velocity - drift.angular, {}, {}});
  }
}

/// Stores velocities. Adds to the changes that affect the move in full. `springs_act`: the impulses of
/// springs may have changed.
void store_before_move(const SolvedSet& solved, MotionWorkspace& motion, const DirectComponent& component,
                       DirectSetIsland& at, bool springs_act) {
  store_velocities_of(solved, component, at);
  if (motion.drift.joint_changes.empty()) return;
  const auto add_whole = [&](Real sign) {
    for (std::size_t i = 0; i < component.moving_count; ++i) {
      Triple whole{};
      for (std::size_t k = 0; k < whole.size(); ++k) whole[k] = at.changes[i][k] - at.forces[i][k];
      const Twist part = twist_of(whole);
      Twist& sum = motion.drift.joint_changes[component.bodies[i]];
      sum = {sum.linear + sign * part.linear, sum.angular + sign * part.angular};
    }
  };
  add_whole(-1);
  if (springs_act && at.island.has_drives) {
    at.forces.assign(component.moving_count, Triple{});
    add_force_like_changes(at.island, at.forces);
  }
  for (std::size_t i = 0; i < component.moving_count; ++i)
    for (std::size_t k = 0; k < at.changes[i].size(); ++k)
      at.changes[i][k] += at.island.bodies[i].velocity[k] - at.loaded[i][k];
  add_whole(1);
}

void load_poses(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island) {
  for (std::size_t i = 0; i < component.bodies.size(); ++i) {
    const std::uint32_t row = component.bodies[i];
    island.bodies[i].pose = pose_of(solved.state.bodies[row], solved.bodies.records[solved.bodies.masses[row].read]);
  }
}

/// Requires: the islands of the set are filled.
int find_turn_count(const SolvedSet& solved, const JointPlan& plan, const std::vector<MouseJoint>& mouse_joints,
                    const DirectWorkspace& work) {
  const auto is_direct = [&](std::uint32_t row) { return work.components.component_of(row) != DirectComponents::none; };
  const auto has_gap = [&](std::uint32_t row) {
    return is_direct(row) && largest_gap(work.islands[work.components.component_of(row)].island) > pressing_gap;
  };
  int turn_count = 1;
  for (const std::uint32_t contact : solved.contacts()) {
    const ContactPair& pair = solved.tick.contact_pairs[contact];
    if (!is_direct(pair.body_a) && !is_direct(pair.body_b)) continue;
    if (overlaps_by(pair, deep_overlap_share)) return turn_count_of_deep;
    if (overlaps_by(pair, pressed_overlap_share) && (has_gap(pair.body_a) || has_gap(pair.body_b)))
      return turn_count_of_deep;
    turn_count = turn_count_of_touched;
  }
  for (const JointPlace& place : plan.places())
    if (is_direct(place.body_a) || is_direct(place.body_b)) return turn_count_of_touched;
  for (const MouseJoint& joint : mouse_joints)
    if (is_direct(joint.body)) return turn_count_of_touched;
  return turn_count;
}

void fill_bodies(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island) {
  island.graph = component.graph;
  island.moving_count = component.moving_count;
  island.is_free = component.is_free;
  island.bodies.resize(component.bodies.size());
  for (std::size_t i = 0; i < component.bodies.size(); ++i) {
    const BodyMass& mass = solved.bodies.masses[component.bodies[i]];
    DirectBody& body = island.bodies[i];
    body = {};
    if (i >= component.moving_count) continue;
    body.mass = 1 / static_cast<double>(mass.inv_mass);
    body.inertia = mass.inv_inertia > 0 ? 1 / static_cast<double>(mass.inv_inertia) : 0;
  }
  load_poses(solved, component, island);
  fill_joints(solved, component, island);
}

void fill_island(const SolvedSet& solved, const DirectComponent& component, DirectSetIsland& at) {
  DirectIsland& island = at.island;
  island.worst_miss = 0;
  fill_bodies(solved, component, island);
  factor_island(island);
  fill_springs(solved, component, island);
  if (!has_impulses(island)) {
    load_velocities(solved, component, at);
    find_first_impulses(solved, component, island);
  }
  if (raise_inertias(island, static_cast<double>(solved.set.h))) {
    for (std::size_t i = 0; i < component.moving_count; ++i) {
      const double inertia = island.bodies[i].inertia;
      if (inertia > 0) solved.bodies.masses[component.bodies[i]].inv_inertia = static_cast<Real>(1 / inertia);
    }
    factor_island(island);
  }
  at.changes.assign(component.moving_count, Triple{});
  at.forces.assign(component.moving_count, Triple{});
}

/// Doubles the substeps of an island that turns too far in a substep for its positions to be met: a chain that cracks
/// will crack again.
void ask_for_substeps(const Model& model, const DirectComponent& component, State& state) {
  const auto most = static_cast<std::uint32_t>(model.scene.settings.auto_substeps->substeps_max);
  for (std::size_t i = 0; i < component.moving_count; ++i) {
    SubstepRow& row = state.substeps[component.bodies[i]];
    row.count = 2 * row.count < most ? 2 * row.count : most;
    row.idle_ticks = 0;
  }
}

}  // namespace

void find_direct_joints(const Model& model, const State& state, const TickLists& tick, DirectWorkspace& work) {
  work.set_components.clear();
  work.turn_count = 1;
  work.solves_joints = model.scene.settings.joints == JointSolverKind::direct && !state.joints.empty();
  if (state.joints.empty()) return work.components.clear();
  if (!work.solves_joints && tick.contact_pairs.empty() && tick.impacts.empty()) return;
  work.components.follow(model, state, work.places);
  if (work.islands.size() < work.components.components().size())
    work.islands.resize(work.components.components().size());
}

void prepare_direct(const SolvedSet& solved, const JointPlan& plan, const std::vector<MouseJoint>& mouse_joints,
                    DirectWorkspace& work) {
  work.turn_count = 1;
  if (!work.solves_joints) return;
  list_set_components(solved, work);
  if (work.set_components.empty()) return;
  for_islands(solved, work,
              [&](const DirectComponent& component, DirectSetIsland& at) { fill_island(solved, component, at); });
  work.turn_count = find_turn_count(solved, plan, mouse_joints, work);
}

void begin_direct_substep(const SolvedSet& solved, DirectWorkspace& work) {
  for_islands(solved, work, [&](const DirectComponent& component, DirectSetIsland& at) {
    if (at.island.has_drives) load_velocities(solved, component, at);
    begin_substep(at.island, static_cast<double>(solved.set.h));
  });
}

void start_direct(const SolvedSet& solved, MotionWorkspace& motion, DirectWorkspace& work) {
  for_islands(solved, work, [&](const DirectComponent& component, DirectSetIsland& at) {
    const bool changes_velocities = at.island.has_drives || !motion.drift.joint_changes.empty();
    if (changes_velocities) load_velocities(solved, component, at);
    at.changes.assign(component.moving_count, Triple{});
    if (!motion.drift.joint_changes.empty()) {
      at.forces.assign(component.moving_count, Triple{});
      for (std::size_t i = 0; i < component.moving_count; ++i) motion.drift.joint_changes[component.bodies[i]] = {};
    }
    start_impulses(at.island);
    if (changes_velocities) store_before_move(solved, motion, component, at, true);
  });
}

void solve_direct(const SolvedSet& solved, MotionWorkspace& motion, DirectWorkspace& work) {
  for_islands(solved, work, [&](const DirectComponent& component, DirectSetIsland& at) {
    load_before_move(solved, motion, component, at);
    solve_velocities(at.island, static_cast<double>(solved.set.h));
    store_before_move(solved, motion, component, at, true);
  });
}

void meet_direct(const SolvedSet& solved, MotionWorkspace& motion, DirectWorkspace& work) {
  if (!motion.drift.joint_changes.empty()) solve_direct(solved, motion, work);  // the drift depends on the springs
  for_islands(solved, work, [&](const DirectComponent& component, DirectSetIsland& at) {
    load_before_move(solved, motion, component, at);
    const auto h = static_cast<double>(solved.set.h);
    meet_positions(at.island, h, position_tolerance * h, position_pass_max);
    store_before_move(solved, motion, component, at, false);
  });
}

void end_direct_move(const SolvedSet& solved, DirectWorkspace& work) {
  for_islands(solved, work, [&](const DirectComponent& component, DirectSetIsland& at) {
    load_poses(solved, component, at.island);
    factor_island(at.island);
    if (at.island.push.empty()) return;
    load_velocities(solved, component, at);
    end_push(at.island);
    store_velocities_of(solved, component, at);
  });
}

void project_direct(const SolvedSet& solved, DirectWorkspace& work) {
  for_islands(solved, work, [&](const DirectComponent& component, DirectSetIsland& at) {
    load_velocities(solved, component, at);
    project_velocities(at.island);
    if (work.turn_count == 1) bound_gain(at.island);
    store_velocities_of(solved, component, at);
  });
}

void project_direct_again(const SolvedSet& solved, DirectWorkspace& work) {
  if (!work.solves_joints) return;
  list_set_components(solved, work);
  project_direct(solved, work);
}

void factor_for_impacts(const SolvedSet& solved, const DirectComponent& component, const DirectWorkspace& work,
                        DirectSetIsland& at) {
  if (!work.solves_joints) {
    fill_bodies(solved, component, at.island);
    factor_island(at.island);
  }
  factor_rigid_rows(at.island);
}

void end_impacts_of(const SolvedSet& solved, const DirectComponent& component, const DirectWorkspace& work,
                    DirectSetIsland& at) {
  if (!work.solves_joints) return;
  end_rigid_rows(at.island);
  load_poses(solved, component, at.island);
}

void project_for_impacts(const SolvedSet& solved, const DirectComponent& component, DirectSetIsland& at,
                         std::span<Triple> velocities) {
  load_velocities(solved, component, at);
  for (std::size_t i = 0; i < velocities.size(); ++i) at.island.bodies[i].velocity = velocities[i];
  project_velocities(at.island);
  for (std::size_t i = 0; i < velocities.size(); ++i) velocities[i] = at.island.bodies[i].velocity;
}

void store_direct(const SolvedSet& solved, const DirectWorkspace& work, State& state) {
  const Settings& settings = solved.model.scene.settings;
  const bool is_measured = settings.auto_substeps && settings.substep_loads == SubstepLoads::measured;
  for (const std::uint32_t number : work.set_components) {
    const DirectComponent& component = work.components.components()[number];
    const DirectIsland& island = work.islands[number].island;
    store_joint_forces(solved, component, island, state);
    if (is_measured && work.turn_count == 1 && !(island.worst_miss <= slow_miss))
      ask_for_substeps(solved.model, component, state);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
