// Impulses of rows and the columns of a joint's forces, drives and springs.
// SPDX-License-Identifier: MIT
//
// The columns have the meaning of the iterative solver (engine/joints/joint_*.cpp), so that both solvers read a state.
#include "engine/joints/direct/direct_joints.h"

#include "engine/joints/joint_spring.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

double wide(Real value) {
  return static_cast<double>(value);
}

/// Whether the torque of a joint is the impulse of this rigid row.
bool is_torque(JointKind kind, std::size_t row) {
  return (kind == JointKind::weld && row == 2) || (kind == JointKind::prismatic && row == 1);
}

/// On a wheel with two driven rows, springs and limits act on the first one and the motor on the last one.
bool takes_motor(const JointShape& shape, std::size_t drive) {
  return shape.kind != JointKind::wheel || drive == (shape.is_driven ? 1u : 0u);
}
bool takes_spring(const JointShape& shape, std::size_t drive) {
  return drive == 0 && shape.is_driven;
}

std::size_t drive_count(const DirectJoint& joint) {
  return joint.equations.row_count - joint.equations.rigid_count;
}

DirectDrive make_drive(const JointModel& model, const JointShape& shape, const JointRow& row, std::size_t index,
                       double h) {
  DirectDrive drive;
  if (takes_spring(shape, index)) {
    drive.has_spring = model.spring.exists;
    drive.has_limits = model.has_limits;
    const double zero = shape.kind == JointKind::distance ? shape.length : 0;  // the origin of the limits
    drive.lower = wide(model.lower) - zero;
    drive.upper = wide(model.upper) - zero;
  }
  if (takes_motor(shape, index)) {
    drive.has_motor = model.has_motor && row.motor_force_max > 0;
    drive.motor_speed = wide(row.motor_speed);
    drive.motor_impulse_max = h * wide(row.motor_force_max);
  }
  if (drive.has_motor) {
    drive.state = DriveState::motor;
    if (row.motor_force >= row.motor_force_max) drive.state = DriveState::motor_at_most;
    if (row.motor_force <= -row.motor_force_max) drive.state = DriveState::motor_at_least;
  }
  if (drive.has_limits && row.lower_force > 0) drive.state = DriveState::at_lower;
  if (drive.has_limits && row.upper_force > 0) drive.state = DriveState::at_upper;
  return drive;
}

void fill_impulses(const JointShape& shape, const JointRow& row, double h, DirectJoint& joint) {
  const std::size_t rigid = joint.equations.rigid_count;
  const double linear[2] = {wide(row.linear_force.x), wide(row.linear_force.y)};
  joint.impulses = {};
  std::size_t line = 0;
  for (std::size_t i = 0; i < rigid; ++i)
    joint.impulses[i] = h * (is_torque(shape.kind, i) ? wide(row.torque) : linear[line++]);
  for (std::size_t i = 0; i < drive_count(joint); ++i) {
    double force = 0;
    if (takes_spring(shape, i)) force = wide(row.spring_force) + (wide(row.lower_force) - wide(row.upper_force));
    if (takes_motor(shape, i)) force += wide(row.motor_force);
    joint.impulses[rigid + i] = h * force;
  }
}

/// A weld with an angular spring stores the spring's torque in the column of a weld's torque.
bool keeps_spring_as_torque(const JointModel& model) {
  return model.kind == JointKind::weld;
}

}  // namespace

Pose pose_of(const BodyRow& at_start, const MovingBody& moved) {
  const double c = wide(moved.delta_rotation.c);
  const double s = wide(moved.delta_rotation.s);
  const double start_c = wide(at_start.rotation.c);
  const double start_s = wide(at_start.rotation.s);
  return {{wide(at_start.position.x) + wide(moved.delta_position.x),
           wide(at_start.position.y) + wide(moved.delta_position.y)},
          c * start_c - s * start_s,
          s * start_c + c * start_s};
}

void fill_joints(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island) {
  const double h = wide(solved.set.h);
  island.joints = component.ends;
  island.shapes = component.shapes;
  island.drives.assign(component.drive_count, DirectDrive{});
  island.has_drives = false;
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    DirectJoint& joint = island.joints[i];
    const JointShape& shape = island.shapes[i];
    JointRow row = solved.state.joints[component.joints[i]];
    const JointModel& model = solved.model.joints[row.joint];
    if (keeps_spring_as_torque(model) && shape.kind == JointKind::revolute) row.spring_force = row.torque;
    fill_impulses(shape, row, h, joint);
    for (std::size_t k = 0; k < drive_count(joint); ++k) {
      DirectDrive& drive = island.drives[joint.first_drive + k];
      drive = make_drive(model, shape, row, k, h);
      island.has_drives = island.has_drives || exists(drive);
    }
  }
}

void fill_springs(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island) {
  if (!island.has_drives) return;
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const DirectJoint& joint = island.joints[i];
    if (drive_count(joint) == 0) continue;
    DirectDrive& drive = island.drives[joint.first_drive];
    if (!drive.has_spring) continue;
    const SpringModel& spring = solved.model.joints[solved.state.joints[component.joints[i]].joint].spring;
    drive.mobility = drive_mobility(island, i, joint.equations.rigid_count);
    drive.has_spring = drive.mobility > 0;
    if (!drive.has_spring) continue;
    const double per_mass = spring.absolute ? drive.mobility : 1;
    const SpringStep step =
        make_spring_step(spring.stiffness * per_mass, spring.damping * per_mass, wide(solved.set.h));
    drive.loss = wide(step.velocity_gain);
    drive.pull = wide(step.position_gain);
    drive.give = wide(step.change_gain);
    drive.has_spring = drive.give > 0;
  }
}

void find_first_impulses(const SolvedSet& solved, const DirectComponent& component, DirectIsland& island) {
  const double h = wide(solved.set.h);
  const Vec2 gravity = solved.state.world.gravity;
  begin_substep(island, h);
  for (std::size_t i = 0; i < component.moving_count; ++i) {
    const double share = wide(solved.model.bodies[solved.state.bodies[component.bodies[i]].source].gravity_scale);
    island.bodies[i].velocity[0] += h * share * wide(gravity.x);
    island.bodies[i].velocity[1] += h * share * wide(gravity.y);
  }
  solve_velocities(island, h);
}

void store_joint_forces(const SolvedSet& solved, const DirectComponent& component, const DirectIsland& island,
                        State& state) {
  const double inv_h = 1 / wide(solved.set.h);
  for (std::size_t i = 0; i < island.joints.size(); ++i) {
    const DirectJoint& joint = island.joints[i];
    const JointShape& shape = island.shapes[i];
    JointRow& row = state.joints[component.joints[i]];
    const JointModel& model = solved.model.joints[row.joint];
    const auto force = [inv_h](double impulse) { return stored(static_cast<Real>(inv_h * impulse)); };
    row.linear_force = {0, 0};
    row.torque = row.spring_force = row.lower_force = row.upper_force = row.motor_force = 0;
    Real* const linear[2] = {&row.linear_force.x, &row.linear_force.y};
    std::size_t line = 0;
    const std::size_t rigid = joint.equations.rigid_count;
    for (std::size_t k = 0; k < rigid; ++k)
      *(is_torque(shape.kind, k) ? &row.torque : linear[line++]) = force(joint.impulses[k]);
    if (shape.kind == JointKind::pulley) row.linear_force.y = model.ratio * row.linear_force.x;
    for (std::size_t k = 0; k < drive_count(joint); ++k) {
      const DirectDrive& drive = island.drives[joint.first_drive + k];
      const double impulse = joint.impulses[rigid + k];
      if (drive.state == DriveState::at_lower) {
        row.lower_force = force(impulse > 0 ? impulse : 0);
        continue;
      }
      if (drive.state == DriveState::at_upper) {
        row.upper_force = force(impulse < 0 ? -impulse : 0);
        continue;
      }
      const double motor = motor_impulse(drive, drive.mobility, impulse);
      if (drive.has_motor) row.motor_force = force(motor);
      if (drive.state == DriveState::motor_at_most) row.motor_force = row.motor_force_max;
      if (drive.state == DriveState::motor_at_least) row.motor_force = -row.motor_force_max;
      if (drive.has_spring) row.spring_force = force(impulse - motor);
    }
    if (keeps_spring_as_torque(model) && shape.kind == JointKind::revolute) {
      row.torque = row.spring_force;
      row.spring_force = 0;
    }
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
