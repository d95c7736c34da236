// Gears: one row for the coordinates of two revolute or prismatic joints.
// SPDX-License-Identifier: MIT
// Source: Catto, Box2D 2.4.1, b2_gear_joint.cpp (constraint). Added here: bodies that both joints share, and turns that
// are counted although the state has no angles. Rows: joint_rows.h.
//
// c_a, c_b = coordinates of the joints: angles with all turns, or translations. r = ratio. C = c_a + r c_b - constant,
// u = u_a + r u_b. The gradient J is the sum of the gradients of both coordinates. A body that both joints share gets
// the sum of its two parts. An impulse includes the reactions of all rigid rows of both joints, so that these rows stay
// at rest: it acts along P, which is J less its part along the rigid rows. P is the gradient of the row as well: u = P
// v, K = P M^-1 P^T, and C less the same part of the errors of the rigid rows. Other joints may have moved the rigid
// rows since their own joint was solved. u = J v and K = J M^-1 P^T would then ask for impulses that add energy. All
// rows act with opposite impulses on two bodies, so momentum is conserved. linear.x = the force on c_a, linear.y = r
// linear.x, that on c_b.
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

/// A gear has five rows: two rigid ones of each joint, and its own, which is the last.
constexpr std::size_t row_count = 5;

/// A body of a gear: the gradients of the rows with respect to its pose.
struct GearBody {
  std::uint32_t record;
  Real inv_mass;
  Real inv_inertia;
  Real arm;  // to the point at which the impulses act, m
  std::array<BodyDirection, row_count> gradients;
  BodyDirection push;  // the gear's gradient less its part along the rigid rows

  bool can_move() const { return inv_mass > 0 || inv_inertia > 0; }
};

/// A row of which less is left than this share of its mobility follows from the rows before it. What is left is
/// rounding, also where parts of a shared body cancel.
constexpr double independent_share_least = 1e-12;

/// The bodies of a gear, each once.
struct GearRows {
  std::array<GearBody, 4> bodies;
  std::size_t count = 0;
  std::array<double, row_count> errors{};
  Real mobility = 0;    // 0: the row moves nothing
  double of_parts = 0;  // the sum of the parts' mobilities

  void add(const GearBody& body) {
    const BodyDirection& part = body.gradients.back();
    of_parts += static_cast<double>(body.inv_mass * length_squared(part.linear) +
                                    body.inv_inertia * part.angular * part.angular);
    for (std::size_t i = 0; i < count; ++i)
      if (bodies[i].record == body.record) {
        bodies[i].arm = larger(bodies[i].arm, body.arm);
        for (std::size_t r = 0; r < row_count; ++r) bodies[i].gradients[r] = bodies[i].gradients[r] + body.gradients[r];
        return;
      }
    bodies[count++] = body;
  }
  /// Takes from each row its part along the rows before it: modified Gram-Schmidt in the metric of the inverse masses,
  /// in doubles, since far anchors cancel almost whole.
  void find_push() {
    using Wide = std::array<double, 13>;  // x, y, angle of each body; the error
    Wide inverse{};
    std::array<Wide, row_count> rows{};
    for (std::size_t i = 0; i < count; ++i) {
      inverse[3 * i] = inverse[3 * i + 1] = static_cast<double>(bodies[i].inv_mass);
      inverse[3 * i + 2] = static_cast<double>(bodies[i].inv_inertia);
      for (std::size_t r = 0; r < row_count; ++r) {
        const BodyDirection& gradient = bodies[i].gradients[r];
        rows[r][3 * i] = static_cast<double>(gradient.linear.x);
        rows[r][3 * i + 1] = static_cast<double>(gradient.linear.y);
        rows[r][3 * i + 2] = static_cast<double>(gradient.angular);
      }
    }
    const auto product = [&](const Wide& a, const Wide& b) {
      double sum = 0;
      for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * inverse[k] * b[k];
      return sum;
    };
    std::array<double, row_count> left{};
    for (std::size_t r = 0; r < row_count; ++r) {
      rows[r].back() = errors[r];
      const double whole = r + 1 < row_count ? product(rows[r], rows[r]) : of_parts;
      for (std::size_t before = 0; before < r; ++before) {
        if (!(left[before] > 0)) continue;
        const double share = product(rows[r], rows[before]) / left[before];
        for (std::size_t k = 0; k < rows[r].size(); ++k) rows[r][k] -= share * rows[before][k];
      }
      left[r] = product(rows[r], rows[r]);
      if (!(left[r] > independent_share_least * whole)) left[r] = 0;
    }
    const Wide& push = rows.back();
    mobility = static_cast<Real>(left.back());
    errors.back() = push.back();
    for (std::size_t i = 0; i < count; ++i)
      bodies[i].push = {{static_cast<Real>(push[3 * i]), static_cast<Real>(push[3 * i + 1])},
                        static_cast<Real>(push[3 * i + 2])};
  }
  Real speed(const MovingBody* records) const {
    Real sum = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const MovingBody& body = records[bodies[i].record];
      sum += dot(bodies[i].push.linear, body.velocity) + bodies[i].push.angular * body.angular_velocity;
    }
    return sum;
  }
  /// Bodies that joints do not move have no inverse mass: they are not written.
  void apply(MovingBody* records, Real impulse) const {
    for (std::size_t i = 0; i < count; ++i) {
      const GearBody& body = bodies[i];
      if (!body.can_move()) continue;
      MovingBody& record = records[body.record];
      record.velocity = record.velocity + (body.inv_mass * impulse) * body.push.linear;
      record.angular_velocity += body.inv_inertia * body.push.angular * impulse;
    }
  }
};

bool is_turning_part(const JointWork& part) {
  return part.model->kind == JointKind::revolute;
}

/// A joint of a gear. Gradients are those of its rigid rows and of its coordinate, with respect to A and B.
struct GearPart {
  std::array<BodyDirection, 3> of_a, of_b;
  std::array<double, 2> errors;  // of the rigid rows
  Real arm_a, arm_b;             // to the point at which the impulses act, m
};

GearPart turning_part(const JointWork& part, const JointBodies& pair) {
  const PointRow point = point_row(part, pair, ActsAt::middle);
  const Vec2 a = point.arm_a, b = point.arm_b;
  return {{{{{-1, 0}, a.y}, {{0, -1}, -a.x}, {{0, 0}, -1}}},
          {{{{1, 0}, -b.y}, {{0, 1}, b.x}, {{0, 0}, 1}}},
          {static_cast<double>(point.error.x), static_cast<double>(point.error.y)},
          length(a),
          length(b)};
}

GearPart sliding_part(const JointWork& part, const JointBodies& pair) {
  const Slide slide = slide_of(part, pair);
  const auto of_a = [](const LineRow& row) -> BodyDirection { return {-row.axis, -row.lever_a}; };
  const auto of_b = [](const LineRow& row) -> BodyDirection { return {row.axis, row.lever_b}; };
  return {{of_a(slide.across), {{0, 0}, -1}, of_a(slide.along)},
          {of_b(slide.across), {{0, 0}, 1}, of_b(slide.along)},
          {static_cast<double>(slide.deviation), wide_relative_angle(part, pair)},
          length(Vec2{slide.along.lever_a, slide.across.lever_a}),
          length(Vec2{slide.along.lever_b, slide.across.lever_b})};
}

/// Adds part 0 or 1.
void add_part(const JointWork& part, std::size_t index, const MovingBody* records, Real scale, GearRows& rows) {
  const JointBodies pair = load(part, records);
  const GearPart of = is_turning_part(part) ? turning_part(part, pair) : sliding_part(part, pair);
  GearBody a{part.read_a, part.inv_mass_a, part.inv_inertia_a, of.arm_a, {}, {}};
  GearBody b{part.read_b, part.inv_mass_b, part.inv_inertia_b, of.arm_b, {}, {}};
  for (std::size_t k = 0; k < 2; ++k) {
    a.gradients[2 * index + k] = of.of_a[k];
    b.gradients[2 * index + k] = of.of_b[k];
    rows.errors[2 * index + k] = of.errors[k];
  }
  a.gradients.back() = scale * of.of_a.back();
  b.gradients.back() = scale * of.of_b.back();
  rows.add(a);
  rows.add(b);
}

GearRows rows_of_gear(const GearJoint& gear, const MovingBody* records) {
  GearRows rows;
  rows.errors.back() = (gear.coordinates[0] + gear.model->ratio * gear.coordinates[1]) - gear.model->constant;
  add_part(gear.parts[0], 0, records, Real(1), rows);
  add_part(gear.parts[1], 1, records, gear.ratio, rows);
  rows.find_push();
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
    GearJoint gear{};
    gear.model = &solved.model.gears[joint.gear];
    gear.parts = {make_part(solved, gear.model->joints[0], {}), make_part(solved, gear.model->joints[1], {})};
    gear.ratio = joint.ratio;
    const GearRows rows = rows_of_gear(gear, solved.bodies.records.data());
    const Real force = absolute(state.joints[i].linear_force.x);
    for (std::size_t k = 0; k < rows.count; ++k) {
      const GearBody& body = rows.bodies[k];
      // Bodies that joints do not turn may be the dummy body, which has no torque.
      if (body.inv_inertia > 0) torques.push_back({body.record, force * length(body.push.linear) * body.arm});
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
    const Softness soft = softness(gear.parts[0], bias);
    const Real wanted = soft.mass_scale *
                        (rows.speed(records) + soft.bias_rate * static_cast<Real>(rows.errors.back())) / rows.mobility;
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
