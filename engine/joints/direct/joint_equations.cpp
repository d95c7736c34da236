// The rows of joints: points, angles, lines and ropes.
// SPDX-License-Identifier: MIT
// Source: as joint_equations.h.
#include "engine/joints/direct/joint_equations.h"

#include "base/assert.h"
#include "engine/math/trig.h"

namespace ticktrue::engine {
namespace {

Place operator+(Place a, Place b) {
  return {a.x + b.x, a.y + b.y};
}
Place operator-(Place a, Place b) {
  return {a.x - b.x, a.y - b.y};
}
Place operator*(double s, Place a) {
  return {s * a.x, s * a.y};
}
double dot(Place a, Place b) {
  return a.x * b.x + a.y * b.y;
}
double cross(Place a, Place b) {
  return a.x * b.y - a.y * b.x;
}
Place left_turn(Place a) {
  return {-a.y, a.x};
}
double length_of(Place a) {
  return __builtin_sqrt(dot(a, a));
}
Place rotate(const Pose& pose, Place a) {
  return {pose.c * a.x - pose.s * a.y, pose.s * a.x + pose.c * a.y};
}

/// The share of a gap by which arms are lengthened to meet: one half while the gap is small. If the gap is wider than
/// the longer arm, the share is less, so that a wide gap is no lever.
double middle_share(Place arm_a, Place arm_b, Place d) {
  const double of_a = dot(arm_a, arm_a);
  const double of_b = dot(arm_b, arm_b);
  const double arm2 = of_a > of_b ? of_a : of_b;
  const double gap2 = 0.25 * dot(d, d);
  return arm2 > 0 && gap2 > arm2 ? 0.5 * (arm2 / gap2) : 0.5;
}

/// Writes the first two rows, those of a point. The other entries of their gradients are 0.
void write_point(const JointShape& shape, const Pose& a, const Pose& b, JointEquations& equations) {
  Place arm_a = rotate(a, shape.anchor_a);
  Place arm_b = rotate(b, shape.anchor_b);
  const Place d = point_gap(shape, a, b);
  if (shape.meets_in_middle) {
    const double share = middle_share(arm_a, arm_b, d);
    arm_a = arm_a + share * d;
    arm_b = arm_b - share * d;
  }
  equations.errors[0] = d.x;
  equations.errors[1] = d.y;
  equations.gradient_a[0] = equations.gradient_a[4] = -1;
  equations.gradient_a[2] = arm_a.y;
  equations.gradient_a[5] = -arm_a.x;
  equations.gradient_b[0] = equations.gradient_b[4] = 1;
  equations.gradient_b[2] = -arm_b.y;
  equations.gradient_b[5] = arm_b.x;
}

/// Writes rows one at a time.
class Rows {
 public:
  Rows(const JointShape& shape, const Pose& a, const Pose& b)
      : shape_(shape), a_(a), b_(b), arm_a_(rotate(a, shape.anchor_a)), arm_b_(rotate(b, shape.anchor_b)) {}

  /// From A's anchor to B's. Positions are subtracted first: far from the origin, their difference is exact.
  Place gap() const { return point_gap(shape_, a_, b_); }

  /// Requires: no row has been written.
  void point() {
    write_point(shape_, a_, b_, equations_);
    equations_.row_count = 2;
  }
  void angle() { turn(angle_error(shape_, a_, b_)); }
  void turn(double error) { add(error, {0, 0}, -1, {0, 0}, 1); }
  /// A row along an axis that rotates with A.
  void along(Place axis) {
    const Place d = gap();
    add(dot(axis, d), -1.0 * axis, -cross(arm_a_ + d, axis), axis, cross(arm_b_, axis));
  }
  void line() {
    const Place d = gap();
    const double length = length_of(d);
    const Place axis = length > 0 ? Place{d.x / length, d.y / length} : Place{1, 0};
    add(length - shape_.length, -1.0 * axis, -cross(arm_a_, axis), axis, cross(arm_b_, axis));
  }
  void rope() {
    const Place side_a = (a_.position - shape_.ground_a) + arm_a_;
    const Place side_b = (b_.position - shape_.ground_b) + arm_b_;
    const Place axis_a = direction_of(side_a);
    const Place axis_b = shape_.ratio * direction_of(side_b);
    add((length_of(side_a) + shape_.ratio * length_of(side_b)) - shape_.length, axis_a, cross(arm_a_, axis_a), axis_b,
        cross(arm_b_, axis_b));
  }

  void end_of_rigid() { equations_.rigid_count = equations_.row_count; }
  const JointEquations& equations() const { return equations_; }
  Place axis() const { return rotate(a_, shape_.axis); }

 private:
  static constexpr double side_share_least = 1.0 / 200;  // of the rope; the direction of shorter sides is undefined

  Place direction_of(Place side) const {
    const double length = length_of(side);
    return length > side_share_least * shape_.length ? Place{side.x / length, side.y / length} : Place{0, 0};
  }
  void add(double error, Place of_a, double turn_of_a, Place of_b, double turn_of_b) {
    const std::size_t row = equations_.row_count++;
    equations_.errors[row] = error;
    const Triple a{of_a.x, of_a.y, turn_of_a};
    const Triple b{of_b.x, of_b.y, turn_of_b};
    for (std::size_t i = 0; i < 3; ++i) {
      equations_.gradient_a[3 * row + i] = a[i];
      equations_.gradient_b[3 * row + i] = b[i];
    }
  }

  const JointShape& shape_;
  const Pose& a_;
  const Pose& b_;
  Place arm_a_;
  Place arm_b_;
  JointEquations equations_;
};

void revolute_rows(const JointShape& shape, Rows& rows) {
  rows.point();
  rows.end_of_rigid();
  if (shape.is_driven) rows.angle();
}
void weld_rows(const JointShape&, Rows& rows) {
  rows.point();
  rows.angle();
  rows.end_of_rigid();
}
void prismatic_rows(const JointShape& shape, Rows& rows) {
  rows.along(left_turn(rows.axis()));
  rows.angle();
  rows.end_of_rigid();
  if (shape.is_driven) rows.along(rows.axis());
}
void wheel_rows(const JointShape& shape, Rows& rows) {
  rows.along(left_turn(rows.axis()));
  rows.end_of_rigid();
  if (shape.is_driven) rows.along(rows.axis());
  if (shape.turns_driven) rows.turn(0);
}
void distance_rows(const JointShape& shape, Rows& rows) {
  rows.line();
  if (!shape.is_driven) rows.end_of_rigid();
}
void pulley_rows(const JointShape&, Rows& rows) {
  rows.rope();
  rows.end_of_rigid();
}

struct EquationsRow {
  JointKind kind;
  void (*write)(const JointShape& shape, Rows& rows);  // null: bounded forces alone, or rows on more than two bodies
};
constexpr std::array<EquationsRow, joint_kinds.size()> joint_equations{{
    {JointKind::revolute, revolute_rows},
    {JointKind::prismatic, prismatic_rows},
    {JointKind::distance, distance_rows},
    {JointKind::weld, weld_rows},
    {JointKind::wheel, wheel_rows},
    {JointKind::motor, nullptr},
    {JointKind::friction, nullptr},
    {JointKind::target, nullptr},
    {JointKind::pulley, pulley_rows},
    {JointKind::gear, nullptr},
}};
static_assert(rows_are_in_order(joint_equations));

}  // namespace

double angle_error(const JointShape& shape, const Pose& a, const Pose& b) {
  const double c = a.c * b.c + a.s * b.s;
  const double s = a.c * b.s - a.s * b.c;
  return arc_tangent(s * shape.reference_c - c * shape.reference_s, c * shape.reference_c + s * shape.reference_s);
}

bool has_equations(JointKind kind) {
  return info_of(joint_equations, kind).write != nullptr;
}

JointEquations equations_of(const JointShape& shape, const Pose& a, const Pose& b) {
  TICKTRUE_ASSERT(has_equations(shape.kind));
  Rows rows(shape, a, b);
  info_of(joint_equations, shape.kind).write(shape, rows);
  return rows.equations();
}

void find_equations(const JointShape& shape, const Pose& a, const Pose& b, JointEquations& equations) {
  if (!is_point(shape)) {
    equations = equations_of(shape, a, b);
    return;
  }
  write_point(shape, a, b, equations);
  equations.rigid_count = equations.row_count = 2;
}

}  // namespace ticktrue::engine
