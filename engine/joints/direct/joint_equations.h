// The equations of a joint on the poses of its two bodies: errors of its rows and their gradients, in doubles.
// SPDX-License-Identifier: MIT
// Source: Catto, "Modeling and Solving Constraints", GDC 2009; pulley: Box2D 2.4.1, b2_pulley_joint.cpp.
//
// Gradients are those of the errors, with the angle of a body as its third coordinate. The solver meets the positions
// at the end of a substep, so an anchor's gap rotates with the body. With `meets_in_middle`, gradients are those of
// anchors without a gap. Rigid rows come first.
//
// | kind      | rigid rows             | rows of the degree of freedom, where something acts on it |
// |-----------|------------------------|------------------------------------------------------------|
// | revolute  | x, y of the point      | angle                                                      |
// | weld      | x, y of the point, angle |                                                          |
// | prismatic | across the axis, angle | along the axis                                             |
// | wheel     | across the axis        | along the axis; angle of the motor                         |
// | distance  | length                 | the same row, if a spring, limits or a motor act on it     |
// | pulley    | length of the rope     |                                                            |
#pragma once

#include "engine/joints/direct/block_ldl.h"
#include "engine/scene/joint_kinds.h"

namespace ticktrue::engine {

struct Place {
  double x = 0;
  double y = 0;
};

/// Centre of mass, m; cosine and sine of the angle.
struct Pose {
  Place position;
  double c = 1;
  double s = 0;
};

struct JointShape {
  JointKind kind = JointKind::revolute;
  Place anchor_a;  // from A's centre of mass in its frame, m; of the world: a point of the world
  Place anchor_b;
  Place axis{1, 0};        // unit, in A's frame
  double reference_c = 1;  // of B's angle relative to A's
  double reference_s = 0;
  double length = 0;  // m
  Place ground_a;     // pulley: points of the world, m
  Place ground_b;
  double ratio = 1;
  bool is_driven = false;        // a spring, limits or a motor act on the degree of freedom (wheel: along the axis)
  bool turns_driven = false;     // wheel: a motor acts on the angle
  bool meets_in_middle = false;  // point: impulses act between the anchors, which keeps angular momentum across a gap
};

struct JointEquations {
  std::uint32_t rigid_count = 0;
  std::uint32_t row_count = 0;
  Triple errors{};     // m or rad; of the wheel's motor 0
  Block gradient_a{};  // [row][x, y, angle]
  Block gradient_b{};
};

/// Whether the kind has equations here. Gears, and kinds that drive bodies with bounded forces, have none.
bool has_equations(JointKind kind);

/// A revolute joint without a drive has only the rows of a point, which have their own fast path.
inline bool is_point(const JointShape& shape) {
  return shape.kind == JointKind::revolute && !shape.is_driven;
}
/// From A's anchor to B's: the errors of a point.
inline Place point_gap(const JointShape& shape, const Pose& a, const Pose& b) {
  const auto rotate = [](const Pose& pose, Place arm) -> Place {
    return {pose.c * arm.x - pose.s * arm.y, pose.s * arm.x + pose.c * arm.y};
  };
  const Place arm_a = rotate(a, shape.anchor_a);
  const Place arm_b = rotate(b, shape.anchor_b);
  return {(b.position.x - a.position.x) + (arm_b.x - arm_a.x), (b.position.y - a.position.y) + (arm_b.y - arm_a.y)};
}

/// Revolute joints and welds: their first two rows are those of a point, the third that of the angle.
inline bool holds_point(const JointShape& shape) {
  return shape.kind == JointKind::revolute || shape.kind == JointKind::weld;
}
/// B's angle relative to A's, from the reference, rad.
double angle_error(const JointShape& shape, const Pose& a, const Pose& b);

/// Requires: has_equations(shape.kind). Pose of the world: Pose{}.
JointEquations equations_of(const JointShape& shape, const Pose& a, const Pose& b);
/// Same as equations_of. `equations`: of this shape at other poses, or new ones.
void find_equations(const JointShape& shape, const Pose& a, const Pose& b, JointEquations& equations);

}  // namespace ticktrue::engine
