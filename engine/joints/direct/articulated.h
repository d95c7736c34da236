// Bodies that one joint of a point connects to the rest: eliminated by their articulated inertia.
// SPDX-License-Identifier: MIT
// Source: Featherstone, "Rigid Body Dynamics Algorithms", 2008, 7.1 (articulated-body inertia). The angle with a
// compliance is derived here.
//
// A body D v = f + S^T (P, t) hangs on a parent by the impulse P at an anchor and the angular impulse t. With the
// velocity u of the anchor and the spin w as coordinates, (P, t) = K (u, w') - g, where w' is the spin that the parent
// asks for, and K is the articulated inertia. The joint requires that u and w' follow from the parent's velocity. This
// takes one division; the block elimination of the body and the joint takes five, each of which waits for the one
// before.
#pragma once

#include <array>

namespace ticktrue::engine {

using Block = std::array<double, 9>;   // row by row
using Triple = std::array<double, 3>;  // of a body: x, y, angle; of a joint: its rows

/// The input of a joint of a point. An arm leads from a body's centre of mass to the anchor, m. It is 0 if the body
/// does not rotate.
struct ArticulatedArms {
  double sign = 1;  // 1: the child is body B of the joint; -1: body A
  double child_x = 0;
  double child_y = 0;
  double parent_x = 0;
  double parent_y = 0;
  bool has_angle = false;       // the third row is in the system
  double angle_compliance = 0;  // 1/(kg m^2)
};

struct ArticulatedJoint {
  ArticulatedArms arms;
  // The rest is filled by factor.
  double k00 = 0;  // K of the anchor's velocity, kg
  double k10 = 0;
  double k11 = 0;
  double d0 = 0;  // the body's inertia between the anchor's velocity and the spin, kg m
  double d1 = 0;
  double spin = 0;   // the body's inertia about the anchor, kg m^2
  double hold = 0;   // the share of w' in the spin: 0 of a free angle, 1 of a rigid one
  double yield = 0;  // spin of the body per angular impulse, 1/(kg m^2)
};

/// Factors the joint. `body`: the child's block with all that hangs on the child; its lower half is read. Adds the
/// articulated inertia to the lower half of the parent's block.
inline void factor(ArticulatedJoint& joint, const Block& body, Block* parent) {
  const ArticulatedArms& arms = joint.arms;
  const double d0 = (body[0] * arms.child_y - body[3] * arms.child_x) + body[6];
  const double d1 = (body[3] * arms.child_y - body[4] * arms.child_x) + body[7];
  const double d2 = (body[6] * arms.child_y - body[7] * arms.child_x) + body[8];
  const double spin = (d0 * arms.child_y - d1 * arms.child_x) + d2;
  joint.hold = 0;
  if (arms.has_angle) {
    joint.hold = 1 / (1 + spin * arms.angle_compliance);
    joint.yield = arms.angle_compliance * joint.hold;
  } else {
    joint.yield = 1 / spin;
  }
  joint.d0 = d0;
  joint.d1 = d1;
  joint.spin = spin;
  joint.k00 = body[0] - joint.yield * d0 * d0;
  joint.k10 = body[3] - joint.yield * d0 * d1;
  joint.k11 = body[4] - joint.yield * d1 * d1;
  if (parent == nullptr) return;
  Block& sum = *parent;
  double q0 = joint.k10 * arms.parent_x - joint.k00 * arms.parent_y;
  double q1 = joint.k11 * arms.parent_x - joint.k10 * arms.parent_y;
  double q2 = 0;
  if (arms.has_angle) {
    q0 += joint.hold * d0;
    q1 += joint.hold * d1;
    q2 = joint.hold * ((d1 * arms.parent_x - d0 * arms.parent_y) + spin);
  }
  sum[0] += joint.k00;
  sum[3] += joint.k10;
  sum[4] += joint.k11;
  sum[6] += q0;
  sum[7] += q1;
  sum[8] += (q1 * arms.parent_x - q0 * arms.parent_y) + q2;
}

/// `rows`: the required changes of the rows' speeds. `body`: impulses on the child; becomes g and the turning part.
/// Subtracts from `parent` what the joint passes on.
inline void eliminate(const ArticulatedJoint& joint, const Triple& rows, Triple& body, Triple* parent) {
  const ArticulatedArms& arms = joint.arms;
  const double turning = (body[0] * arms.child_y - body[1] * arms.child_x) + body[2];
  body[0] -= joint.d0 * (joint.yield * turning);
  body[1] -= joint.d1 * (joint.yield * turning);
  body[2] = turning;
  if (parent == nullptr) return;
  const double r0 = arms.sign * rows[0];
  const double r1 = arms.sign * rows[1];
  double q0 = (joint.k00 * r0 + joint.k10 * r1) - body[0];
  double q1 = (joint.k10 * r0 + joint.k11 * r1) - body[1];
  double q2 = 0;
  if (arms.has_angle) {
    const double r2 = arms.sign * rows[2];
    q0 += joint.hold * (joint.d0 * r2);
    q1 += joint.hold * (joint.d1 * r2);
    q2 = joint.hold * ((joint.d0 * r0 + joint.d1 * r1) + (joint.spin * r2 - turning));
  }
  (*parent)[0] -= q0;
  (*parent)[1] -= q1;
  (*parent)[2] -= (q1 * arms.parent_x - q0 * arms.parent_y) + q2;
}

/// Computes the velocity of the child, and the impulses of the joint with the opposite sign in `rows`. `parent`: the
/// solved velocity, or null.
inline void substitute(const ArticulatedJoint& joint, Triple& rows, Triple& body, const Triple* parent) {
  const ArticulatedArms& arms = joint.arms;
  double u0 = arms.sign * rows[0];
  double u1 = arms.sign * rows[1];
  double wanted = arms.sign * rows[2];
  if (parent != nullptr) {
    u0 += (*parent)[0] - (*parent)[2] * arms.parent_y;
    u1 += (*parent)[1] + (*parent)[2] * arms.parent_x;
    wanted += (*parent)[2];
  }
  double p0 = (joint.k00 * u0 + joint.k10 * u1) - body[0];
  double p1 = (joint.k10 * u0 + joint.k11 * u1) - body[1];
  double p2 = 0;
  const double turning = body[2] - (joint.d0 * u0 + joint.d1 * u1);
  double spin = joint.yield * turning;
  if (arms.has_angle) {
    spin += joint.hold * wanted;
    p0 += joint.hold * (joint.d0 * wanted);
    p1 += joint.hold * (joint.d1 * wanted);
    p2 = joint.hold * (joint.spin * wanted - turning);
  }
  body = {u0 + spin * arms.child_y, u1 - spin * arms.child_x, spin};
  rows = {-arms.sign * p0, -arms.sign * p1, -arms.sign * p2};
}

}  // namespace ticktrue::engine
