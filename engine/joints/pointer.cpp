// Target joint: 2 x 2 soft point constraint with a bounded force.
// SPDX-License-Identifier: MIT
// Source: Catto, "Soft Constraints", GDC 2011. C = p + r - target, effective mass = (J M^-1 J^T)^-1.
#include "engine/joints/pointer.h"

#include "engine/model/scratch.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

void apply(MovingBody& body, const PointerPull& pull, Vec2 arm, Vec2 impulse) {
  body.velocity = body.velocity + pull.inv_mass * impulse;
  body.angular_velocity = body.angular_velocity + pull.inv_inertia * cross(arm, impulse);
}

}  // namespace

void prepare_pulls(const Model& model, const State& state, Scratch& scratch, const SolverSet& set) {
  const Real h = set.h;
  scratch.pulls.clear();
  for (std::uint32_t index = 0; index < state.pointers.size(); ++index) {
    const PointerRow& row = state.pointers[index];
    const PointerSettings& settings = *model.scene.pointer;
    PointerPull pull;
    pull.pointer = index;
    pull.body = static_cast<std::uint32_t>(state.find_body(row.body));
    if (scratch.body_solver_set[pull.body] != scratch.set_index) continue;
    const BodyRow& body = state.bodies[pull.body];
    const BodyModel& constants = model.bodies[body.source];
    pull.inv_mass = constants.inv_mass;
    pull.inv_inertia = constants.inv_inertia;
    pull.anchor = rotate(body.rotation, row.anchor);
    pull.offset = (body.position - row.target) + pull.anchor;
    pull.soft = make_soft(static_cast<Real>(settings.hertz), static_cast<Real>(settings.damping_ratio), h);
    pull.impulse_max = h * (static_cast<Real>(settings.force_max_per_kg) * constants.mass);
    pull.impulse = h * row.force;
    scratch.pulls.push_back(pull);
  }
}

void warm_start_pulls(Scratch& scratch) {
  for (const PointerPull& pull : scratch.pulls) {
    MovingBody& body = scratch.bodies[pull.body];
    apply(body, pull, rotate(body.delta_rotation, pull.anchor), pull.impulse);
  }
}

void solve_pulls(Scratch& scratch) {
  for (PointerPull& pull : scratch.pulls) {
    MovingBody& body = scratch.bodies[pull.body];
    const Vec2 arm = rotate(body.delta_rotation, pull.anchor);
    const Vec2 error = (pull.offset + body.delta_position) + (arm - pull.anchor);
    const Vec2 velocity = body.velocity + cross(body.angular_velocity, arm);
    // K = [k11 k12; k12 k22], solved by Cramer's rule.
    const Real k11 = pull.inv_mass + pull.inv_inertia * arm.y * arm.y;
    const Real k12 = -(pull.inv_inertia * arm.x * arm.y);
    const Real k22 = pull.inv_mass + pull.inv_inertia * arm.x * arm.x;
    const Real inv_determinant = 1 / (k11 * k22 - k12 * k12);
    const Vec2 wanted = velocity + pull.soft.bias_rate * error;
    const Vec2 solved{inv_determinant * (k22 * wanted.x - k12 * wanted.y),
                      inv_determinant * (k11 * wanted.y - k12 * wanted.x)};
    Vec2 total = (pull.impulse - pull.soft.mass_scale * solved) - pull.soft.impulse_scale * pull.impulse;
    const Real size = length(total);
    if (size > pull.impulse_max) total = (pull.impulse_max / size) * total;
    apply(body, pull, arm, total - pull.impulse);
    pull.impulse = total;
  }
}

void store_pulls(const Scratch& scratch, State& state, Real h) {
  const Real inv_h = 1 / h;
  for (const PointerPull& pull : scratch.pulls) state.pointers[pull.pointer].force = stored(inv_h * pull.impulse);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
