// Inelastic impacts on islands of direct joints.
// SPDX-License-Identifier: MIT
// Source: as jointed_impacts.h.
#include "engine/impacts/jointed_impacts.h"

#include <algorithm>
#include <cmath>

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr double noticed_speed = 0.02;    // m/s: contacts that close more slowly are left to the solver
constexpr double speed_tolerance = 2e-4;  // m/s
constexpr int sweep_max = 50;

double lane_of(const ContactLanes& lanes, std::uint32_t lane) {
  return static_cast<double>(lanes.at[lane]);
}

double larger_magnitude(double a, double b) {
  const double absolute = b < 0 ? -b : b;
  return a < absolute ? absolute : a;
}

/// Loads the islands of the points, and forgets the impulses.
void load_islands(const SolvedSet& solved, DirectWorkspace& direct, JointedImpacts& work) {
  work.velocities.clear();
  for (const std::uint32_t row : work.islands.rows) work.velocities.push_back(velocity_of(solved.bodies.records[row]));
  for (const std::uint32_t number : work.islands.components) {
    const DirectComponent& component = direct.components.components()[number];
    DirectSetIsland& at = direct.islands[number];
    factor_for_impacts(solved, component, direct, at);
    if (direct.solves_joints) continue;
    const std::span<Triple> velocities = work.velocities;
    const std::uint32_t first = work.islands.places[component.bodies[0]];
    project_for_impacts(solved, component, at, velocities.subspan(first, component.moving_count));
  }
  work.islands.responses.clear();
  for (ImpactPoint& point : work.points)
    for (ImpactRow* row : {&point.normal, &point.tangent}) {
      row->impulse = 0;
      row->mobility = -1;
    }
  for (ImpactPoint& point : work.points) point.impulse_max = HUGE_VAL;
}

/// The speed of a row for the bodies' records.
double speed_of(const ImpactPoint& point, const ImpactRow& row, const SolverBodies& bodies) {
  return dot_product(row.along[0], velocity_of(bodies.records[point.records[0]])) +
         dot_product(row.along[1], velocity_of(bodies.records[point.records[1]]));
}

double present_speed(const ImpactPoint& point, const ImpactRow& row, const SolverBodies& bodies,
                     const JointedImpacts& work) {
  double speed = 0;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::uint32_t place = point.ends.places[side];
    speed += dot_product(row.along[side], place != no_impact_place ? work.velocities[place]
                                                                   : velocity_of(bodies.records[point.records[side]]));
  }
  return speed;
}

void apply(const ImpactPoint& point, ImpactRow& row, double impulse, JointedImpacts& work) {
  const double change = impulse - row.impulse;
  row.impulse = impulse;
  std::size_t next = row.response;
  for (const ImpactBodies& part : point.ends.parts)
    for (std::uint32_t i = 0; i < part.count; ++i, ++next)
      for (std::size_t k = 0; k < 3; ++k)
        work.velocities[part.first + i][k] += change * work.islands.responses[next][k];
}

/// Moves the normal speed of a point into the range from the least speed to rest, as far as its impulse pushes, and
/// stops slip within Coulomb's bound. Each change takes kinetic energy, except for bounces. Returns the change of the
/// normal speed, m/s.
double solve_point(const SolvedSet& solved, DirectWorkspace& direct, ImpactPoint& point, JointedImpacts& work) {
  ImpactRow& normal = point.normal;
  const double speed = present_speed(point, normal, solved.bodies, work);
  const double most_speed = point.least_speed > 0 ? point.least_speed : 0;
  double change = 0;
  if (speed < point.least_speed) change = point.least_speed - speed;
  if (speed > most_speed && normal.impulse > 0) change = most_speed - speed;
  if (change != 0) {
    if (normal.mobility < 0) find_response(solved, direct, point.ends, normal, work.islands);
    if (normal.mobility > 0) {
      const double before = normal.impulse;
      const double wanted = before + change / normal.mobility;
      const double at_most = wanted < point.impulse_max ? wanted : point.impulse_max;
      apply(point, normal, at_most > 0 ? at_most : 0, work);
      change = (normal.impulse - before) * normal.mobility;
    }
  }
  ImpactRow& tangent = point.tangent;
  const double limit = point.friction * normal.impulse;
  if (limit > 0) {
    if (tangent.mobility < 0) find_response(solved, direct, point.ends, tangent, work.islands);
    if (tangent.mobility > 0) {
      const double slip = present_speed(point, tangent, solved.bodies, work) + point.tangent_speed;
      const double wanted = tangent.impulse - slip / tangent.mobility;
      const double bound = larger_magnitude(limit, tangent.impulse);
      apply(point, tangent, wanted > bound ? bound : wanted < -bound ? -bound : wanted, work);
    }
  }
  return change < 0 ? -change : change;
}

/// Lists the contact points of jointed bodies.
void list_points(const SolvedSet& solved, const DirectWorkspace& direct, const ContactBatches& contacts,
                 JointedImpacts& out) {
  out.points.clear();
  clear_islands(solved, direct, out.islands);
  if (direct.components.components().empty()) return;
  for (const std::uint32_t contact : solved.contacts()) {
    const ContactPair& pair = solved.tick.contact_pairs[contact];
    count_points(direct, pair.body_a, pair.body_b, static_cast<std::uint32_t>(pair.manifold.point_count), out.islands);
  }
  const auto is_jointed = [&](std::uint32_t row) { return meets_island(direct, row, out.islands); };
  for (std::uint32_t i = solved.set.first_batch; i < solved.set.batch_end; ++i) {
    const ContactBatch& batch = contacts.batches[i];
    for (std::uint32_t lane = 0; lane < static_cast<std::uint32_t>(batch.count); ++lane) {
      const ContactPair& pair = solved.tick.contact_pairs[batch.contact[lane]];
      if (!is_jointed(pair.body_a) && !is_jointed(pair.body_b)) continue;
      ImpactPoint at;
      at.batch = i;
      at.lane = lane;
      at.friction = lane_of(batch.friction, lane);
      at.records = {solved.bodies.masses[pair.body_a].read, solved.bodies.masses[pair.body_b].read};
      at.ends = find_ends(solved, direct, pair.body_a, pair.body_b, out.islands);
      if (!contacts.surfaces.empty()) at.tangent_speed = lane_of(contacts.surfaces[i].tangent_speed, lane);
      const double nx = lane_of(batch.normal_x, lane);
      const double ny = lane_of(batch.normal_y, lane);
      for (std::uint32_t p = 0; p < 2; ++p) {
        const ContactPointLanes& point = batch.points[p];
        if (!(point.normal_mass.at[lane] > 0)) continue;
        at.point = p;
        at.normal.along = {
            {{-nx, -ny, -lane_of(point.normal_arm_a, lane)}, {nx, ny, lane_of(point.normal_arm_b, lane)}}};
        at.tangent.along = {
            {{-ny, nx, -lane_of(point.tangent_arm_a, lane)}, {ny, -nx, lane_of(point.tangent_arm_b, lane)}}};
        out.points.push_back(at);
      }
    }
  }
}

/// Finds the least speed of each point, and whether needs_work(point, speed) holds for some.
template <typename Needs>
bool find_least_speeds(const SolvedSet& solved, const ContactBatches& contacts, JointedImpacts& work,
                       const Needs& needs_work) {
  const double inv_h = 1 / static_cast<double>(solved.set.h);
  bool any = false;
  for (ImpactPoint& point : work.points) {
    const double separation = lane_of(contacts.batches[point.batch].points[point.point].present_separation, point.lane);
    point.least_speed = separation > 0 ? -separation * inv_h : 0;
    if (needs_work(point, speed_of(point, point.normal, solved.bodies))) any = true;
  }
  return any;
}

void solve_points(const SolvedSet& solved, DirectWorkspace& direct, JointedImpacts& work) {
  for (int sweep = 0; sweep < sweep_max; ++sweep) {
    double most = 0;
    for (ImpactPoint& point : work.points) most = std::max(most, solve_point(solved, direct, point, work));
    if (!(most > speed_tolerance)) break;
  }
}

/// Ends load_islands for passes that follow in the substep.
void factor_again(const SolvedSet& solved, DirectWorkspace& direct, const JointedImpacts& work) {
  for (const std::uint32_t component : work.islands.components)
    end_impacts_of(solved, direct.components.components()[component], direct, direct.islands[component]);
}

void store_velocities(const SolvedSet& solved, const JointedImpacts& work) {
  for (std::size_t i = 0; i < work.islands.rows.size(); ++i) {
    MovingBody& record = solved.bodies.records[work.islands.rows[i]];
    const Triple& velocity = work.velocities[i];
    record.velocity = {static_cast<Real>(velocity[0]), static_cast<Real>(velocity[1])};
    record.angular_velocity = static_cast<Real>(velocity[2]);
  }
}

/// Twice the kinetic energy of two motions of a place together, J.
double double_energy(const BodyMass& mass, const Triple& v, const Triple& w) {
  const double inertia = mass.inv_inertia > 0 ? v[2] * w[2] / static_cast<double>(mass.inv_inertia) : 0;
  return (v[0] * w[0] + v[1] * w[1]) / static_cast<double>(mass.inv_mass) + inertia;
}

/// Stores the kinetic energies of the listed bodies: without bound if a body that impulses do not move drives a point
/// of their island.
void store_start_energies(const SolvedSet& solved, JointedImpacts& work) {
  const SolverBodies& bodies = solved.bodies;
  work.start_energies.resize(bodies.masses.size());
  for (const std::uint32_t row : work.islands.rows) {
    const Triple velocity = velocity_of(bodies.records[row]);
    work.start_energies[row] = 0.5 * double_energy(bodies.masses[row], velocity, velocity);
  }
  for (const ImpactPoint& point : work.points)
    for (std::size_t side = 0; side < 2; ++side) {
      const Triple velocity = velocity_of(bodies.records[point.records[side]]);
      const ImpactBodies& other = point.ends.parts[1 - side];
      if (point.ends.places[side] != no_impact_place || !(dot_product(velocity, velocity) > 0)) continue;
      for (std::uint32_t i = 0; i < other.count; ++i)
        work.start_energies[work.islands.rows[other.first + i]] = HUGE_VAL;
    }
}

/// Scales the bounce, if the bodies that it moves have more kinetic energy than at the tick's start: several points
/// bounce with the speeds of that time.
void bound_bounce(const SolvedSet& solved, JointedImpacts& work) {
  double allowed = 0;
  double linear = 0;  // the energy grows by share * linear + share^2 * square
  double square = 0;
  for (std::size_t i = 0; i < work.islands.rows.size(); ++i) {
    const BodyMass& mass = solved.bodies.masses[work.islands.rows[i]];
    const Triple& v = work.stopped[i];
    const Triple& after = work.velocities[i];
    const Triple change = {after[0] - v[0], after[1] - v[1], after[2] - v[2]};
    if (!(dot_product(change, change) > 0)) continue;
    allowed += work.start_energies[work.islands.rows[i]] - 0.5 * double_energy(mass, v, v);
    linear += double_energy(mass, v, change);
    square += 0.5 * double_energy(mass, change, change);
  }
  if (allowed < 0) allowed = 0;
  if (linear + square <= allowed || !(square > 0)) return;
  const double share = (__builtin_sqrt(linear * linear + 4 * square * allowed) - linear) / (2 * square);
  for (std::size_t i = 0; i < work.islands.rows.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      work.velocities[i][k] = work.stopped[i][k] + share * (work.velocities[i][k] - work.stopped[i][k]);
}

}  // namespace

void prepare_jointed_contacts(const SolvedSet& solved, const DirectWorkspace& direct, ContactBatches& contacts,
                              JointedImpacts& out) {
  list_points(solved, direct, contacts, out);
  if (!contacts.bounces.empty()) store_start_energies(solved, out);
  if (!direct.solves_joints) return;
  for (const ImpactPoint& point : out.points) {
    const ContactRow& row = solved.state.contacts[contacts.batches[point.batch].contact[point.lane]];
    const bool is_lasting = row.normal_force[0] > 0 || row.normal_force[1] > 0;
    if (!is_lasting) take_push_back_of(contacts, point.batch, point.lane);
  }
}

void stop_jointed_contacts(const SolvedSet& solved, DirectWorkspace& direct, ContactBatches& contacts,
                           JointedImpacts& work) {
  if (!find_least_speeds(solved, contacts, work, [](const ImpactPoint& point, double speed) {
        return speed < point.least_speed - noticed_speed;
      }))
    return;
  load_islands(solved, direct, work);
  solve_points(solved, direct, work);
  store_velocities(solved, work);
  if (contacts.bounces.empty()) return;
  for (const ImpactPoint& point : work.points) {
    Real& most = contacts.bounces[point.batch].impulse_max[point.point].at[point.lane];
    most = larger(most, static_cast<Real>(point.normal.impulse));
  }
}

bool bounce_jointed_contacts(const SolvedSet& solved, Real threshold, DirectWorkspace& direct, ContactBatches& contacts,
                             JointedImpacts& work) {
  if (contacts.bounces.empty()) return false;
  list_points(solved, direct, contacts, work);
  bool any = false;
  for (ImpactPoint& point : work.points) {
    const BounceLanes& bounces = contacts.bounces[point.batch];
    Real& most = contacts.bounces[point.batch].impulse_max[point.point].at[point.lane];
    const Real restitution = bounces.restitution.at[point.lane];
    const Real approach = bounces.approach[point.point].at[point.lane];
    point.least_speed = 0;
    if (!(restitution > 0) || !(approach <= -threshold) || !(most > 0)) continue;
    point.least_speed = -static_cast<double>(restitution * approach);
    most = 0;
    any = true;
  }
  if (!any) return false;
  load_islands(solved, direct, work);
  work.stopped = work.velocities;
  solve_points(solved, direct, work);
  bound_bounce(solved, work);
  store_velocities(solved, work);
  factor_again(solved, direct, work);
  return true;
}

void relax_jointed_contacts(const SolvedSet& solved, DirectWorkspace& direct, ContactBatches& contacts,
                            JointedImpacts& work) {
  if (!direct.solves_joints) return;
  const auto lanes_of = [&contacts](const ImpactPoint& point) -> ContactPointLanes& {
    return contacts.batches[point.batch].points[point.point];
  };
  if (!find_least_speeds(solved, contacts, work, [&](const ImpactPoint& point, double speed) {
        return lanes_of(point).normal_impulse.at[point.lane] > 0 && speed > noticed_speed;
      }))
    return;
  load_islands(solved, direct, work);
  for (ImpactPoint& point : work.points) {
    point.normal.impulse = point.impulse_max = lane_of(lanes_of(point).normal_impulse, point.lane);
    point.tangent.impulse = lane_of(lanes_of(point).tangent_impulse, point.lane);
  }
  solve_points(solved, direct, work);
  store_velocities(solved, work);
  for (const ImpactPoint& point : work.points) {
    lanes_of(point).normal_impulse.at[point.lane] = static_cast<Real>(point.normal.impulse);
    // solve_point lowers no friction, since that gives energy back. The next substep starts within the cone.
    const double limit = point.friction * point.normal.impulse;
    const double tangent = point.tangent.impulse;
    lanes_of(point).tangent_impulse.at[point.lane] = static_cast<Real>(tangent > limit    ? limit
                                                                       : tangent < -limit ? -limit
                                                                                          : tangent);
  }
  factor_again(solved, direct, work);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
