// The mouse joint: a 2 x 2 soft point constraint with a bounded force.
// SPDX-License-Identifier: MIT
// Source: Catto, "Soft Constraints", GDC 2011. C = p + r - target, effective mass = (J M^-1 J^T)^-1.
#include "engine/joints/mouse_joint.h"

#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

void apply(MovingBody& body, const MouseJoint& joint, Vec2 arm, Vec2 impulse) {
  body.velocity = body.velocity + joint.inv_mass * impulse;
  body.angular_velocity = body.angular_velocity + joint.inv_inertia * cross(arm, impulse);
}

}  // namespace

void prepare_mouse_joints(const SolvedSet& solved, std::vector<MouseJoint>& joints) {
  const Model& model = solved.model;
  const State& state = solved.state;
  const Real h = solved.set.h;
  joints.clear();
  for (std::uint32_t index = 0; index < state.pointers.size(); ++index) {
    const PointerRow& row = state.pointers[index];
    const PointerSettings& settings = *model.scene.pointer;
    MouseJoint joint;
    joint.pointer = index;
    joint.body = static_cast<std::uint32_t>(state.find_body(row.body));
    if (!solved.has_body(joint.body)) continue;
    const BodyRow& body = state.bodies[joint.body];
    const BodyModel& constants = model.bodies[body.source];
    joint.inv_mass = constants.inv_mass;
    joint.inv_inertia = constants.inv_inertia;
    joint.anchor = rotate(body.rotation, row.anchor);
    joint.offset = (body.position - row.target) + joint.anchor;
    joint.soft = make_soft(static_cast<Real>(settings.hertz), static_cast<Real>(settings.damping_ratio), h);
    joint.impulse_max = h * (static_cast<Real>(settings.force_max_per_kg) * constants.mass);
    joint.impulse = h * row.force;
    joints.push_back(joint);
  }
}

void warm_start_mouse_joints(const std::vector<MouseJoint>& joints, SolverBodies& bodies) {
  for (const MouseJoint& joint : joints) {
    MovingBody& body = bodies.records[joint.body];
    apply(body, joint, rotate(body.delta_rotation, joint.anchor), joint.impulse);
  }
}

void solve_mouse_joints(std::vector<MouseJoint>& joints, SolverBodies& bodies) {
  for (MouseJoint& joint : joints) {
    MovingBody& body = bodies.records[joint.body];
    const Vec2 arm = rotate(body.delta_rotation, joint.anchor);
    const Vec2 error = (joint.offset + body.delta_position) + (arm - joint.anchor);
    const Vec2 velocity = body.velocity + cross(body.angular_velocity, arm);
    // K = [k11 k12; k12 k22], solved by Cramer's rule.
    const Real k11 = joint.inv_mass + joint.inv_inertia * arm.y * arm.y;
    const Real k12 = -(joint.inv_inertia * arm.x * arm.y);
    const Real k22 = joint.inv_mass + joint.inv_inertia * arm.x * arm.x;
    const Real inv_determinant = 1 / (k11 * k22 - k12 * k12);
    const Vec2 wanted = velocity + joint.soft.bias_rate * error;
    const Vec2 solved{inv_determinant * (k22 * wanted.x - k12 * wanted.y),
                      inv_determinant * (k11 * wanted.y - k12 * wanted.x)};
    Vec2 total = (joint.impulse - joint.soft.mass_scale * solved) - joint.soft.impulse_scale * joint.impulse;
    const Real size = length(total);
    if (size > joint.impulse_max) total = (joint.impulse_max / size) * total;
    apply(body, joint, arm, total - joint.impulse);
    joint.impulse = total;
  }
}

void store_mouse_joints(const std::vector<MouseJoint>& joints, State& state, Real h) {
  const Real inv_h = 1 / h;
  for (const MouseJoint& joint : joints) state.pointers[joint.pointer].force = stored(inv_h * joint.impulse);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
