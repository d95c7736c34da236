// How much energy the passes over a direct island may add.
// SPDX-License-Identifier: MIT
#include "engine/joints/direct/direct_energy.h"

#include <algorithm>

#include "engine/joints/direct/direct_system.h"

namespace ticktrue::engine {
namespace {

constexpr double driven_energy_share = 100;  // as own_energy_share, where a body drives others through levers
constexpr double gain_share_max = 0.005;     // of the kinetic energy, which joints may add in a substep

/// The speeds that rows require besides rest, m/s.
struct AskedSpeed {
  double sum = 0;
  bool is_driven = false;  // by a body that joints do not move
};

AskedSpeed asked_speed(const DirectIsland& island) {
  AskedSpeed asked;
  const auto consider = [&](std::uint32_t body, Place anchor) {
    if (body == no_direct_body || is_moving(island, body)) return;
    const Triple& v = island.bodies[body].velocity;
    const double speed = __builtin_sqrt(v[0] * v[0] + v[1] * v[1]) + magnitude(v[2]) * arm_of(anchor);
    asked.is_driven = asked.is_driven || speed > 0;
    if (speed > asked.sum) asked.sum = speed;
  };
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    consider(island.joints[i].body_a, island.shapes[i].anchor_a);
    consider(island.joints[i].body_b, island.shapes[i].anchor_b);
  }
  asked.sum += push_body_speed + resting_body_speed;
  for (const DirectDrive& drive : island.drives) {
    if (drive.has_spring) asked.sum += drive.pull * magnitude(drive.start_error);
    if (drive.has_motor) asked.sum += magnitude(drive.motor_speed);
    if (drive.has_limits) asked.sum += push_speed_max;
  }
  return asked;
}

/// The velocities that the bodies would have as one rigid body, without a change of momentum and angular momentum.
void find_rigid_motion(const DirectIsland& island, std::vector<Triple>& velocities) {
  velocities.assign(island.moving_count, Triple{});
  if (!island.is_free) return;  // something holds the island: it can stop
  double mass = 0;
  double inertia = 0;
  double spin = 0;  // angular momentum
  Place centre{};
  Triple mean{};
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const DirectBody& body = island.bodies[i];
    mass += body.mass;
    centre.x += body.mass * body.pose.position.x;
    centre.y += body.mass * body.pose.position.y;
    mean[0] += body.mass * body.velocity[0];
    mean[1] += body.mass * body.velocity[1];
  }
  centre = {centre.x / mass, centre.y / mass};
  mean = {mean[0] / mass, mean[1] / mass, 0};
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const DirectBody& body = island.bodies[i];
    const double x = body.pose.position.x - centre.x;
    const double y = body.pose.position.y - centre.y;
    inertia += body.inertia + body.mass * (x * x + y * y);
    spin += body.inertia * body.velocity[2] +
            body.mass * (x * (body.velocity[1] - mean[1]) - y * (body.velocity[0] - mean[0]));
  }
  const double turn = inertia > 0 ? spin / inertia : 0;
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const double x = island.bodies[i].pose.position.x - centre.x;
    const double y = island.bodies[i].pose.position.y - centre.y;
    velocities[i] = {mean[0] - turn * y, mean[1] + turn * x, turn};
  }
}

/// Whether springs, motors, moving bodies that joints do not move or spins that they do not change may add energy.
bool is_driven(const DirectIsland& island) {
  for (const DirectDrive& drive : island.drives)
    if (drive.has_spring || drive.has_motor) return true;
  const auto drives = [&island](std::uint32_t body) {
    if (body == no_direct_body) return false;
    const Triple& v = island.bodies[body].velocity;
    if (is_moving(island, body)) return !(island.bodies[body].inertia > 0) && v[2] != 0;  // nothing slows its spin
    return v[0] != 0 || v[1] != 0 || v[2] != 0;
  };
  return std::any_of(island.joints.begin(), island.joints.end(),
                     [&](const DirectJoint& joint) { return drives(joint.body_a) || drives(joint.body_b); });
}

/// Reduces twice the kinetic energy from `has` to `allowed`. The new velocities keep all rows that the present ones
/// keep, since rigid motions keep the rows of a free island.
void slow_down(DirectIsland& island, double has, double allowed) {
  std::vector<Triple>& rigid = island.saved.velocities;
  find_rigid_motion(island, rigid);
  double least = 0;
  for (std::size_t i = 0; i < island.moving_count; ++i) least += double_energy(island.bodies[i], rigid[i]);
  const double share = allowed > least && has > least ? __builtin_sqrt((allowed - least) / (has - least)) : 0;
  for (std::size_t i = 0; i < island.moving_count; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      double& now = island.bodies[i].velocity[k];
      now = rigid[i][k] + share * (now - rigid[i][k]);
    }
}

}  // namespace

void save(const DirectIsland& island, SavedIsland& saved) {
  saved.velocities.resize(island.moving_count);
  for (std::size_t i = 0; i < island.moving_count; ++i) saved.velocities[i] = island.bodies[i].velocity;
  saved.impulses.resize(island.joints.size());
  for (std::size_t i = 0; i < island.joints.size(); ++i) saved.impulses[i] = island.joints[i].impulses;
  saved.drives = island.drives;
}

void restore(DirectIsland& island, const SavedIsland& saved) {
  for (std::size_t i = 0; i < island.moving_count; ++i) island.bodies[i].velocity = saved.velocities[i];
  for (std::size_t i = 0; i < island.joints.size(); ++i) island.joints[i].impulses = saved.impulses[i];
  island.drives = saved.drives;
}

void scale_changes(DirectIsland& island, const SavedIsland& since, double share) {
  for (std::size_t i = 0; i < island.moving_count; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const double saved = since.velocities[i][k];
      double& now = island.bodies[i].velocity[k];
      now = saved + share * (now - saved);
    }
  for (std::size_t i = 0; i < island.joints.size(); ++i)
    for (std::size_t row = 0; row < 3; ++row) {
      const double saved = since.impulses[i][row];
      double& now = island.joints[i].impulses[row];
      now = saved + share * (now - saved);
    }
}

EnergyDemand energy_demand(const DirectIsland& island, const SavedIsland& since, double speed) {
  EnergyDemand demand;
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const DirectBody& body = island.bodies[i];
    const Triple& saved = since.velocities[i];
    demand.asked +=
        double_energy(body, {body.velocity[0] - saved[0], body.velocity[1] - saved[1], body.velocity[2] - saved[2]});
    demand.had += double_energy(body, saved) + body.mass * (speed * speed);
  }
  return demand;
}

KineticEnergy kinetic_energy(const DirectIsland& island, double speed) {
  KineticEnergy energy;
  for (std::size_t i = 0; i < island.moving_count; ++i) {
    const DirectBody& body = island.bodies[i];
    energy.at_start += double_energy(body, island.start.velocities[i]) + body.mass * (speed * speed);
    energy.now += double_energy(body, body.velocity);
  }
  return energy;
}

void bound_changes(DirectIsland& island, const SavedIsland& since) {
  const AskedSpeed speed = asked_speed(island);
  const EnergyDemand demand = energy_demand(island, since, speed.sum);
  const double allowed = (speed.is_driven ? driven_energy_share : own_energy_share) * demand.had;
  if (demand.asked > allowed) scale_changes(island, since, __builtin_sqrt(allowed / demand.asked));
}

void bound_gain(DirectIsland& island) {
  const KineticEnergy energy = kinetic_energy(island, 0);
  const double allowed = (1 + gain_share_max) * energy.at_start;
  if (energy.now > allowed && !is_driven(island)) slow_down(island, energy.now, allowed);
}

}  // namespace ticktrue::engine
