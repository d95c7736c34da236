// Gears: one row for the coordinates of two revolute or prismatic joints.
// SPDX-License-Identifier: MIT
// Source: Catto, Box2D 2.4.1, b2_gear_joint.cpp (constraint). Added here: bodies that both joints share, and turns that
// are counted although the state has no angles. Rows: joint_rows.h.
//
// c_a, c_b = coordinates of the joints: angles with all turns, or translations. r = ratio. C = c_a + r c_b - constant,
// u = u_a + r u_b. The gradient J is the sum of the gradients of both coordinates. A body that both joints share gets
// the sum of its two parts. Impulses include the reactions of the joints' rigid rows, so that these rows stay at rest,
// as for the motors of these joints: the impulse on the bodies is P, and K = J M^-1 P^T. All rows act with opposite
// impulses on two bodies, so momentum is conserved. linear.x = the force on c_a, linear.y = r linear.x, that on c_b.
#include "engine/joints/gears/gear_joints.h"

#include "engine/joints/joint_rows.h"
#include "engine/model/solved_set.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A direction of the velocities of a body, or of an impulse on it.
struct BodyDirection {
  Vec2 linear;
  Real angular;  // m, or 1
};

BodyDirection operator+(const BodyDirection& a, const BodyDirection& b) {
  return {a.linear + b.linear, a.angular + b.angular};
}
BodyDirection operator*(Real s, const BodyDirection& a) {
  return {s * a.linear, s * a.angular};
}

/// A body of a gear: the gradient of the error with respect to its pose, and its impulse.
struct GearBody {
  std::uint32_t record;
  Real inv_mass;
  Real inv_inertia;
  BodyDirection gradient;
  BodyDirection push;  // the gradient and the reactions of the joints
};

Real part_mobility(const GearBody& body, const BodyDirection& push) {
  return body.inv_mass * dot(body.gradient.linear, push.linear) +
         body.inv_inertia * body.gradient.angular * push.angular;
}

/// Parts of a shared body may cancel, as when two joints of the same two bodies turn them against each other. What is
/// left below this share of the parts' mobility is rounding.
constexpr Real mobility_share_least = Real(1e-8);

/// With P the gradient and the reactions, an impulse -u / (J M^-1 P^T) changes the kinetic energy by u^2 / (J M^-1 P^T)
/// times P M^-1 P^T / (2 J M^-1 P^T) - 1. The two products are equal if the joints share no moving body. Where they
/// share one, the reactions of one joint disturb the other joint, and the energy could grow below one half.
constexpr Real pushed_share_least = Real(0.75);

/// The bodies of a gear, each once.
struct GearRows {
  std::array<GearBody, 4> bodies;
  std::size_t count = 0;
  Real mobility = 0;  // 0: the row moves nothing
  Real of_parts = 0;  // the sum of the parts' mobilities

  void add(const GearBody& body) {
    of_parts += part_mobility(body, body.gradient);
    for (std::size_t i = 0; i < count; ++i)
      if (bodies[i].record == body.record) {
        bodies[i].gradient = bodies[i].gradient + body.gradient;
        bodies[i].push = bodies[i].push + body.push;
        return;
      }
    bodies[count++] = body;
  }
  /// Leaves out the reactions if they might add energy (pushed_share_least).
  void find_mobility() {
    Real pushed = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const GearBody& body = bodies[i];
      mobility += part_mobility(body, body.push);
      pushed +=
          body.inv_mass * length_squared(body.push.linear) + body.inv_inertia * body.push.angular * body.push.angular;
    }
    const Real least = mobility_share_least * of_parts;
    if (mobility > least && mobility >= pushed_share_least * pushed) return;
    mobility = 0;
    for (std::size_t i = 0; i < count; ++i) {
      bodies[i].push = bodies[i].gradient;
      mobility += part_mobility(bodies[i], bodies[i].push);
    }
    if (!(mobility > least)) mobility = 0;
  }
  Real speed(const MovingBody* records) const {
    Real sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const MovingBody& body = records[bodies[i].record];
      sum += dot(bodies[i].gradient.linear, body.velocity) + bodies[i].gradient.angular * body.angular_velocity;
    }
    return sum;
  }
  /// Bodies that joints do not move have no inverse mass: they are not written.
  void apply(MovingBody* records, Real impulse) const {
    for (std::size_t i = 0; i < count; ++i) {
      const GearBody& body = bodies[i];
      if (!(body.inv_mass > 0 || body.inv_inertia > 0)) continue;
      MovingBody& record = records[body.record];
      record.velocity = record.velocity + (body.inv_mass * impulse) * body.push.linear;
      record.angular_velocity += body.inv_inertia * body.push.angular * impulse;
    }
  }
};

bool is_turning_part(const JointWork& part) {
  return part.model->kind == JointKind::revolute;
}

/// The gradient of a joint's coordinate with respect to A and B, and the impulses on them: as of the joint's motor, so
/// that its rigid rows stay at rest.
struct GearPart {
  BodyDirection gradient_a, gradient_b;
  BodyDirection push_a, push_b;
  Vec2 arm_a, arm_b;  // to the point at which the impulses act, in any frame
};

GearPart turning_part(const JointWork& part, const JointBodies& pair) {
  GearPart out{{{0, 0}, -1}, {{0, 0}, 1}, {{0, 0}, -1}, {{0, 0}, 1}, {0, 0}, {0, 0}};
  const PointRow point = point_row(part, pair, ActsAt::middle);
  const ConstrainedAngleRow row = constrained_angle_row(part, point);
  if (!(row.mobility > 0)) return out;
  out.push_a = {-row.reaction, -row.torque_a};
  out.push_b = {row.reaction, row.torque_b};
  out.arm_a = point.arm_a;
  out.arm_b = point.arm_b;
  return out;
}

GearPart sliding_part(const JointWork& part, const JointBodies& pair) {
  const Slide slide = slide_of(part, pair);
  const auto of_a = [](const LineRow& row) -> BodyDirection { return {-row.axis, -row.lever_a}; };
  const auto of_b = [](const LineRow& row) -> BodyDirection { return {row.axis, row.lever_b}; };
  GearPart out{of_a(slide.along),
               of_b(slide.along),
               of_a(slide.along),
               of_b(slide.along),
               {slide.along.lever_a, slide.across.lever_a},
               {slide.along.lever_b, slide.across.lever_b}};
  if (!moves_something(part)) return out;
  const ConstrainedLineRow row = constrained_line_row(part, slide);
  out.push_a = (out.push_a + row.across * of_a(slide.across)) + BodyDirection{{0, 0}, -row.about_angle};
  out.push_b = (out.push_b + row.across * of_b(slide.across)) + BodyDirection{{0, 0}, row.about_angle};
  return out;
}

GearPart part_of(const JointWork& part, const MovingBody* records) {
  const JointBodies pair = load(part, records);
  return is_turning_part(part) ? turning_part(part, pair) : sliding_part(part, pair);
}

void add_part(const JointWork& part, const MovingBody* records, Real scale, GearRows& rows) {
  const GearPart of = part_of(part, records);
  rows.add({part.read_a, part.inv_mass_a, part.inv_inertia_a, scale * of.gradient_a, scale * of.push_a});
  rows.add({part.read_b, part.inv_mass_b, part.inv_inertia_b, scale * of.gradient_b, scale * of.push_b});
}

GearRows rows_of_gear(const GearJoint& gear, const MovingBody* records) {
  GearRows rows;
  add_part(gear.parts[0], records, Real(1), rows);
  add_part(gear.parts[1], records, gear.ratio, rows);
  rows.find_mobility();
  return rows;
}

// ---- Coordinates ----

/// The angle plus the whole turns that bring it closest to `expected`.
double nearest_turn(double angle, double expected) {
  constexpr double turns_max = 1e15;  // beyond, a double has no digits left for the angle
  const double turns = (expected - angle) / (2 * pi);
  if (!(turns < turns_max && turns > -turns_max)) return angle;
  const auto whole = static_cast<std::int64_t>(turns + (turns < 0 ? -0.5 : 0.5));
  return angle + 2 * pi * static_cast<double>(whole);
}

/// Finds the coordinates at the present poses. After a move of length h, turns are counted from the place to which the
/// velocities lead: a part may rotate by more than half a turn in a substep.
void find_coordinates(GearJoint& gear, const MovingBody* records, Real moved_h) {
  for (std::size_t i = 0; i < 2; ++i) {
    const JointWork& part = gear.parts[i];
    const JointBodies pair = load(part, records);
    if (!is_turning_part(part)) {
      gear.coordinates[i] = static_cast<double>(slide_of(part, pair).translation);
      continue;
    }
    const Real moved = moved_h * (pair.b.angular_velocity - pair.a.angular_velocity);
    gear.coordinates[i] =
        nearest_turn(wide_relative_angle(part, pair), gear.coordinates[i] + static_cast<double>(moved));
  }
}

std::uint32_t row_of_joint(const State& state, std::uint32_t joint) {
  const std::vector<JointRow>& joints = state.joints;
  if (joint < joints.size() && joints[joint].joint == joint) return joint;
  std::uint32_t low = 0;
  auto high = static_cast<std::uint32_t>(joints.size());
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (joints[middle].joint < joint)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/// Whether a gear belongs to the set: its bodies that joints move are all in the same set.
bool is_of_set(const SolvedSet& solved, const GearModel& gear) {
  for (const std::uint32_t id : gear.bodies) {
    const std::uint32_t row = row_of_body(solved.state, id);
    if (solved.bodies.masses[row].write == row) return solved.has_body(row);
  }
  return false;
}

JointWork make_part(const SolvedSet& solved, std::uint32_t joint, const Softness& soft) {
  JointPlace place{};
  place.row = row_of_joint(solved.state, joint);
  place.body_b = row_of_body(solved.state, solved.state.joints[place.row].body_b);
  return make_joint(solved, place, soft);
}

}  // namespace

void find_gear_torques(const SolvedSet& solved, std::vector<BodyTorque>& torques) {
  torques.clear();
  if (solved.state.gears.empty()) return;
  const State& state = solved.state;
  for (std::uint32_t i = 0; i < state.joints.size(); ++i) {
    const JointModel& joint = solved.model.joints[state.joints[i].joint];
    if (joint.gear == no_gear || !is_of_set(solved, solved.model.gears[joint.gear])) continue;
    const Vec2 forces = state.joints[i].linear_force;  // on the two coordinates
    for (std::size_t k = 0; k < 2; ++k) {
      const JointWork part = make_part(solved, solved.model.gears[joint.gear].joints[k], {});
      const GearPart of = part_of(part, solved.bodies.records.data());
      const Real force = absolute(k == 0 ? forces.x : forces.y) * length(of.push_a.linear);
      // Bodies that joints do not turn may be the dummy body, which has no torque.
      if (part.inv_inertia_b > 0) torques.push_back({part.read_b, force * length(of.arm_b)});
      if (part.inv_inertia_a > 0) torques.push_back({part.read_a, force * length(of.arm_a)});
    }
  }
}

void prepare_gears(const SolvedSet& solved, std::vector<GearJoint>& gears) {
  gears.clear();
  if (solved.state.gears.empty()) return;
  const Real h = solved.set.h;
  const Softness soft = make_soft(joint_hertz_times_h / h, joint_damping_ratio, h);
  const State& state = solved.state;
  std::uint32_t gear_row = 0;
  for (std::uint32_t i = 0; i < state.joints.size(); ++i) {
    const JointModel& joint = solved.model.joints[state.joints[i].joint];
    if (joint.gear == no_gear) continue;
    const GearRow& row = state.gears[gear_row++];
    const GearModel& model = solved.model.gears[joint.gear];
    if (!is_of_set(solved, model)) continue;
    GearJoint gear{};
    gear.row = i;
    gear.gear_row = gear_row - 1;
    gear.model = &model;
    gear.parts = {make_part(solved, model.joints[0], soft), make_part(solved, model.joints[1], soft)};
    gear.ratio = joint.ratio;
    gear.coordinates = {static_cast<double>(row.coordinate_a), static_cast<double>(row.coordinate_b)};
    gear.impulse = h * state.joints[i].linear_force.x;
    find_coordinates(gear, solved.bodies.records.data(), 0);
    gears.push_back(gear);
  }
}

void warm_start_all_gears(const SolvedSet& solved, const std::vector<GearJoint>& gears) {
  MovingBody* records = solved.bodies.records.data();
  for (const GearJoint& gear : gears) rows_of_gear(gear, records).apply(records, gear.impulse);
}

void solve_all_gears(const SolvedSet& solved, std::vector<GearJoint>& gears, Bias bias) {
  MovingBody* records = solved.bodies.records.data();
  for (GearJoint& gear : gears) {
    const bool has_moved = bias == Bias::off && gear.may_have_moved;
    find_coordinates(gear, records, has_moved ? solved.set.h : Real(0));
    gear.may_have_moved = corrects(bias);
    const GearRows rows = rows_of_gear(gear, records);
    if (!(rows.mobility > 0)) {
      gear.impulse = 0;
      continue;
    }
    const GearModel& model = *gear.model;
    const double error = (gear.coordinates[0] + model.ratio * gear.coordinates[1]) - model.constant;
    const Softness soft = softness(gear.parts[0], bias);
    const Real wanted =
        soft.mass_scale * (rows.speed(records) + soft.bias_rate * static_cast<Real>(error)) / rows.mobility;
    const Real change = -wanted - soft.impulse_scale * gear.impulse;
    gear.impulse += change;
    rows.apply(records, change);
  }
}

void store_gears(const SolvedSet& solved, std::vector<GearJoint>& gears, State& state) {
  const Real inv_h = 1 / solved.set.h;
  for (GearJoint& gear : gears) {
    // A solver without a relax pass has not seen the last move.
    if (gear.may_have_moved) find_coordinates(gear, solved.bodies.records.data(), solved.set.h);
    JointRow& row = state.joints[gear.row];
    const Real force = inv_h * gear.impulse;
    row.linear_force = stored(Vec2{force, gear.ratio * force});
    state.gears[gear.gear_row] = {stored(static_cast<Real>(gear.coordinates[0])),
                                  stored(static_cast<Real>(gear.coordinates[1]))};
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
