// The supports of each body, and their compliances.
// SPDX-License-Identifier: MIT
#include "engine/islands/supports.h"

#include "engine/contacts/contact_stiffness.h"
#include "engine/joints/joint.h"
#include "engine/model/margins.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// 1 / (effective mass of a contact point along the normal).
Real inv_effective_mass(const Model& model, const State& state, const ContactPair& pair, const ManifoldPoint& point) {
  const BodyModel& a = model.bodies[state.bodies[pair.body_a].source];
  const BodyModel& b = model.bodies[state.bodies[pair.body_b].source];
  const Real arm_a = cross(point.anchor_a, pair.manifold.normal);
  const Real arm_b = cross(point.anchor_b, pair.manifold.normal);
  return ((a.inv_mass + b.inv_mass) + a.inv_inertia * arm_a * arm_a) + b.inv_inertia * arm_b * arm_b;
}

/// Compliance of a contact at the reference number of substeps, m/N.
Real contact_compliance(const Model& model, const State& state, const IslandWork& work, const ContactPair& pair,
                        Real h) {
  Real stiffness = 0;  // N/m
  for (int i = 0; i < pair.manifold.point_count; ++i) {
    const Real inv_mass = inv_effective_mass(model, state, pair, pair.manifold.points[i]);
    if (inv_mass > 0) stiffness += soft_contact_stiffness(h) / inv_mass;
  }
  const bool immovable = !is_dynamic(work, pair.body_a) || !is_dynamic(work, pair.body_b);
  if (immovable) stiffness *= 4;  // twice the frequency
  return stiffness > 0 ? 1 / stiffness : Real(0);
}

/// Compliance of a joint at the reference number of substeps, m/N. Chains swing and need twice the substeps of their
/// weight, hence the factor of four.
Real joint_compliance(const Model& model, const State& state, std::uint32_t a, std::uint32_t b, Real h) {
  const Real inv_mass = model.bodies[state.bodies[a].source].inv_mass + model.bodies[state.bodies[b].source].inv_mass;
  return 4 * inv_mass / joint_stiffness(h);
}

/// Angular compliance of a rigid weld at the reference number of substeps, rad/(N m); 0 of other joints.
Real joint_angular_compliance(const Model& model, const State& state, const JointModel& joint, std::uint32_t a,
                              std::uint32_t b, Real h) {
  if (!joint.rigid_angle) return 0;
  const Real inv_inertia =
      model.bodies[state.bodies[a].source].inv_inertia + model.bodies[state.bodies[b].source].inv_inertia;
  return inv_inertia / joint_stiffness(h);
}

/// Whether the bodies rest on each other, or soon will. A speculative contact supports nothing.
bool carries(const ContactPair& pair) {
  Real least = pair.manifold.points[0].separation;
  if (pair.manifold.point_count == 2) least = smaller(least, pair.manifold.points[1].separation);
  return least <= resting_margin(pair.size);
}

/// Whether a joint may carry a body. A gear does not: the joints that it couples hold its bodies. A motor along an axis
/// does not, if loads are measured: the measurement has its force.
bool supports(const JointRow& joint, bool is_measured) {
  if (joint.body_a == no_reference || joint.kind == static_cast<std::uint32_t>(JointKind::gear)) return false;
  return !is_measured || !slides(joint) || !(joint.motor_force_max > 0);
}

}  // namespace

void list_supports(const Model& model, const State& state, TickLists& tick, IslandWork& work, Real h) {
  const bool is_measured = model.scene.settings.substep_loads == SubstepLoads::measured;
  std::vector<std::uint32_t>& start = work.support_start;
  start.assign(state.bodies.size() + 2, 0);
  const auto is_joint_listed = [&](const JointRow& joint) {
    return supports(joint, is_measured) &&
           (is_awake(tick, work, row_of(state, joint.body_a)) || is_awake(tick, work, row_of(state, joint.body_b)));
  };
  for (const std::uint32_t i : work.awake_contacts) {
    const ContactPair& pair = tick.contact_pairs[i];
    if (!carries(pair)) continue;
    ++start[pair.body_a + 2];
    ++start[pair.body_b + 2];
  }
  for (const JointRow& joint : state.joints) {
    if (!is_joint_listed(joint)) continue;
    ++start[row_of(state, joint.body_a) + 2];
    ++start[row_of(state, joint.body_b) + 2];
  }
  for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
  work.supports.resize(start.back());
  for (const std::uint32_t i : work.awake_contacts) {
    const ContactPair& pair = tick.contact_pairs[i];
    if (!carries(pair)) continue;
    const ContactRow& contact = state.contacts[i];
    const Real force = is_measured ? contact.normal_force[0] + contact.normal_force[1] : Real(0);
    const Real compliance = contact_compliance(model, state, work, pair, h);
    const ManifoldPoint& p = pair.manifold.points[0];
    const ManifoldPoint& q = pair.manifold.points[pair.manifold.point_count - 1];
    const Real half_width2 = length_squared(Real(0.5) * (q.anchor_a - p.anchor_a));
    const Real angular_compliance = half_width2 > 0 ? compliance / half_width2 : Real(0);
    work.supports[start[pair.body_a + 1]++] = {
        pair.body_b, compliance,        force, 0, 0, pair.manifold.normal, Real(0.5) * (p.anchor_a + q.anchor_a),
        half_width2, angular_compliance};
    work.supports[start[pair.body_b + 1]++] = {
        pair.body_a, compliance,        force, 0, 0, -pair.manifold.normal, Real(0.5) * (p.anchor_b + q.anchor_b),
        half_width2, angular_compliance};
  }
  for (std::size_t i = 0; i < state.joints.size(); ++i) {
    const JointRow& joint = state.joints[i];
    if (!is_joint_listed(joint)) continue;
    const bool is_direct = i < work.direct.is_direct.size() && work.direct.is_direct[i] != 0;
    const std::uint32_t a = row_of(state, joint.body_a);
    const std::uint32_t b = row_of(state, joint.body_b);
    const Real compliance = is_direct ? Real(0) : joint_compliance(model, state, a, b, h);
    const JointModel& constants = model.joints[joint.joint];
    const Real force = is_measured ? length(joint.linear_force) : Real(0);
    const Real arm_a = length(constants.anchor_a);
    const Real arm_b = length(constants.anchor_b);
    const Vec2 anchor_a = rotate(state.bodies[a].rotation, constants.anchor_a);
    const Vec2 anchor_b = rotate(state.bodies[b].rotation, constants.anchor_b);
    const Real angular_compliance = is_direct ? Real(0) : joint_angular_compliance(model, state, constants, a, b, h);
    const Vec2 between = state.bodies[b].position - state.bodies[a].position;
    work.supports[start[a + 1]++] = {b, compliance, force, arm_a, arm_b, between, anchor_a, 0, angular_compliance};
    work.supports[start[b + 1]++] = {a, compliance, force, arm_b, arm_a, -between, anchor_b, 0, angular_compliance};
  }
}

namespace {

/// Gives depths to the bodies that listed bodies carry, breadth first, from support_order[next] on.
void spread_depths(IslandWork& work, std::size_t next) {
  for (; next < work.support_order.size(); ++next) {
    const std::uint32_t row = work.support_order[next];
    for (const Support& support : supports_of(work, row)) {
      if (work.support_depth[support.other] != not_carried) continue;
      work.support_depth[support.other] = work.support_depth[row] + 1;
      work.support_order.push_back(support.other);
    }
  }
}

/// Finds the depths of connected bodies without an immovable support, from the heaviest body of each group. Of equal
/// masses the first row counts.
void find_floating_depths(const Model& model, const State& state, IslandWork& work) {
  work.is_floating.assign(state.bodies.size(), 0);
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row) {
    if (work.support_depth[row] != not_carried || supports_of(work, row).empty()) continue;
    const std::size_t first = work.support_order.size();
    work.support_depth[row] = 0;
    work.support_order.push_back(row);
    spread_depths(work, first);
    const auto mass_of = [&](std::uint32_t of) { return model.bodies[state.bodies[of].source].mass; };
    std::uint32_t heaviest = row;
    for (std::size_t i = first; i < work.support_order.size(); ++i) {
      const std::uint32_t other = work.support_order[i];
      work.is_floating[other] = 1;
      work.support_depth[other] = not_carried;
      const bool is_heavier = mass_of(other) > mass_of(heaviest);
      if (is_heavier || (mass_of(other) == mass_of(heaviest) && other < heaviest)) heaviest = other;
    }
    work.support_order.resize(first);
    work.support_depth[heaviest] = 0;
    work.support_order.push_back(heaviest);
    spread_depths(work, first);
  }
}

}  // namespace

void find_depths(const Model& model, const State& state, IslandWork& work) {
  work.support_depth.assign(state.bodies.size(), not_carried);
  work.support_order.clear();
  for (std::uint32_t row = 0; row < state.bodies.size(); ++row)
    if (!is_dynamic(work, row)) {
      work.support_depth[row] = 0;
      work.support_order.push_back(row);
    }
  spread_depths(work, 0);
  if (model.scene.settings.substep_loads == SubstepLoads::measured) find_floating_depths(model, state, work);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
