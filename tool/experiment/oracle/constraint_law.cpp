// The law of soft constraints: what a load presses in, what is pushed out, and how long that takes.
// SPDX-License-Identifier: MIT
#include "tool/experiment/oracle/constraint_law.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/math/trig.h"
#include "engine/scene/hull.h"
#include "tool/experiment/oracle/unmeetable.h"
#include "tool/study/table.h"

namespace ticktrue::soak {
namespace {

using engine::BodyReport;
using engine::ContactReport;
using engine::Joint;
using engine::JointKind;
using engine::Point;
using engine::Shape;
using Extent = ConstraintLaw::Extent;

// Of docs/physics.md.
constexpr double contact_hertz_h = 0.125;  // frequency times h; twice that against immovable bodies
constexpr double contact_damping_ratio = 10;
constexpr double joint_hertz_h = 0.25;
constexpr double joint_damping_ratio = 5;
constexpr double push_speed = 3;            // m/s, at which contacts part at most
constexpr double direct_push_rate = 48;     // 1/s, of the gap of a direct joint
constexpr double direct_push_speed = 0.1;   // m/s: a push has at most the energy of all bodies at that speed
constexpr double short_pulley_side = 0.01;  // of its length; the engine leaves out a side of half that length

// Of this rule.
constexpr double load_factor = 2;    // loads are sampled at the end of a tick
constexpr double seen_ticks = 3;     // until an overlap is a contact, is pushed, and is looked at
constexpr double jump_share = 0.25;  // of the smaller size: an overlap on another side
constexpr double same_way = 0.9;     // cosine of two normals along which a load presses both contacts in

struct SoftLaw {
  double omega = 0;      // 1/s: a load F yields F / (m omega^2)
  double bias_rate = 0;  // 1/s: of an error that is pushed out
};
SoftLaw soft_law(double hertz_h, double damping_ratio, double h) {
  const double omega = 2 * engine::pi * hertz_h / h;
  return {omega, omega / (2 * damping_ratio + h * omega)};
}

/// The time in which an error falls to `least`: at `speed_max`, then exponentially.
double settling_time(double error, double least, double rate, double speed_max) {
  const double corner = std::max(speed_max / rate, least);
  double time = 0;
  if (error > corner) time = (error - corner) / speed_max;
  return time + std::max(0.0, std::log(std::min(error, corner) / least)) / rate;
}

/// Twice the radius of the largest circle inside a shape, about the mean of its corners, m; 0 for lines.
double size_of_shape(const Shape& shape) {
  if (engine::is_line(shape.kind)) return 0;
  const std::vector<Point> core = engine::core_of(shape);
  if (core.size() < 3) return 2 * shape.radius;
  Point center;
  for (const Point& p : core) center = {center.x + p.x, center.y + p.y};
  const auto count = static_cast<double>(core.size());
  center = {center.x / count, center.y / count};
  double nearest = infinite;
  for (std::size_t i = 0; i < core.size(); ++i) {
    const Point& p = core[i];
    const Point& q = core[(i + 1) % core.size()];
    const Point edge{q.x - p.x, q.y - p.y};
    const double area = edge.x * (center.y - p.y) - edge.y * (center.x - p.x);
    nearest = std::min(nearest, std::fabs(area) / std::hypot(edge.x, edge.y));
  }
  return 2 * (nearest + shape.radius);
}

Point rotated(double angle, const Point& p) {
  const engine::SinCos turn = engine::sin_cos(angle);
  return {turn.cos * p.x - turn.sin * p.y, turn.sin * p.x + turn.cos * p.y};
}

Extent extent_of(const BodyReport& body) {
  Extent extent;
  const Point center = rotated(-body.angle, {body.center.x - body.origin.x, body.center.y - body.origin.y});
  for (const Shape& shape : *body.shapes) {
    extent.size = std::max(extent.size, size_of_shape(shape));
    for (const Point& p : engine::core_of(shape))
      extent.reach = std::max(extent.reach, std::hypot(p.x - center.x, p.y - center.y) + shape.radius);
  }
  if (extent.size == 0) extent.size = infinite;
  return extent;
}

double inverse_of(double value) {
  return value > 0 ? 1 / value : 0;
}
/// A contact point or a joint whose error is above its tolerance.
struct Offence {
  std::pair<std::uint32_t, std::uint32_t> key;
  std::uint32_t body_a = 0;  // index in the reports
  std::uint32_t body_b = 0;
  Breach breach;
  double push = 0;      // m/s, of the bias
  double settling = 0;  // s
  double least = 0;     // m: what does not matter
  double rate = 0;      // 1/s, of the bias
  double jump = 0;      // m: beyond this growth in a tick, the overlap is a new one
  Point normal;         // of a contact
  bool is_explained = false;
};

/// The length of a substep of each body. A budget may give fewer substeps than the state names, at least the scene's.
std::vector<double> substeps_of(const engine::Scene& scene, const StateView& state, double dt,
                                const std::map<std::uint32_t, std::uint32_t>& index) {
  std::vector<double> h(index.size(), dt / scene.settings.substeps);
  if (scene.settings.substep_budget > 0) return h;
  const tool::NamedTable rows(state, "substeps");
  for (std::uint32_t i = 0; i < rows.row_count(); ++i)
    if (const auto found = index.find(rows.whole(i, "body")); found != index.end())
      h[found->second] = dt / rows.whole(i, "count");
  return h;
}

std::vector<std::uint8_t> find_asleep(const StateView& state, const std::map<std::uint32_t, std::uint32_t>& index) {
  std::vector<std::uint8_t> is_asleep(index.size());
  const tool::NamedTable rows(state, "sleep");
  for (std::uint32_t i = 0; i < rows.row_count(); ++i)
    if (const auto found = index.find(rows.whole(i, "body")); found != index.end())
      is_asleep[found->second] = rows.whole(i, "asleep") != 0 ? 1 : 0;
  return is_asleep;
}

/// How far the angle is off that a joint holds without a spring, rad.
double angle_off(const Joint& joint, const BodyReport& a, const BodyReport& b) {
  const bool is_held = joint.kind == JointKind::prismatic || (joint.kind == JointKind::weld && !joint.spring);
  return is_held ? std::fabs(std::remainder(b.angle - a.angle - joint.reference_angle, 2 * engine::pi)) : 0;
}

/// Whether a pulley has a side without a direction, or is asked for one: what an immovable end leaves of the rope.
bool has_short_side(const Joint& joint, double side_a, double side_b, bool a_moves, bool b_moves) {
  if (!a_moves) side_b = std::min(side_b, (joint.length - side_a) / joint.ratio);
  if (!b_moves) side_a = std::min(side_a, joint.length - joint.ratio * side_b);
  return std::min(side_a, side_b) < short_pulley_side * joint.length;
}

/// Joints that are off, the speed at which joints pull each body, and the energy that joints store.
std::vector<Offence> joint_offences(const TickView& view, std::vector<double>& pulled, double& stored) {
  std::vector<Offence> list;
  const std::vector<double> gaps = tool::joint_gaps(view.scene, view.bodies);
  const bool is_direct = view.scene.settings.joints == engine::JointSolverKind::direct;
  for (std::uint32_t i = 0; i < view.joints.row_count(); ++i) {
    const std::uint32_t number = view.joints.whole(i, "joint");
    const Joint& joint = view.scene.joints[number];
    const double gap = gaps[number];
    if (!engine::has_body_a(joint.kind)) continue;
    const std::uint32_t ends[2] = {view.index.at(joint.body_a), view.index.at(joint.body_b)};
    if (view.is_fixed(ends[0], ends[1])) continue;
    const BodyReport* pair[2] = {&view.bodies[ends[0]], &view.bodies[ends[1]]};
    const double h = view.substep_of(ends[0], ends[1]);
    const SoftLaw law = soft_law(joint_hertz_h, joint_damping_ratio, h);
    // A joint that turns its bodies to the angle that it holds moves their points, too.
    const double turning = law.bias_rate * angle_off(joint, *pair[0], *pair[1]);
    for (const std::uint32_t end : ends) pulled[end] = std::max(pulled[end], turning * view.extents[end].reach);
    if (!(gap > 0)) continue;
    const Point arms[2] = {rotated(pair[0]->angle, joint.anchor_a), rotated(pair[1]->angle, joint.anchor_b)};
    const Point places[2] = {{pair[0]->origin.x + arms[0].x, pair[0]->origin.y + arms[0].y},
                             {pair[1]->origin.x + arms[1].x, pair[1]->origin.y + arms[1].y}};
    double mobility = 0, mobility_of_torque = 0, turned_away = 0;
    const bool is_pulley = joint.kind == JointKind::pulley;
    const double ratio_b = is_pulley ? joint.ratio : 1;
    for (int k = 0; k < 2; ++k) {
      const double ratio = k == 0 ? 1 : ratio_b;
      // The forces of sliders act at B's anchor.
      const Point& at = places[engine::has_field(joint.kind, engine::JointField::axis) ? 1 : k];
      const double arm = std::hypot(at.x - pair[k]->center.x, at.y - pair[k]->center.y) + gap;
      if (is_dynamic(*pair[k])) {
        mobility += ratio * ratio * (inverse_of(pair[k]->mass) + inverse_of(pair[k]->inertia) * arm * arm);
        mobility_of_torque += inverse_of(pair[k]->inertia) * arm;
      }
      turned_away += ratio * arm * std::pow(pair[k]->angular_velocity * h, 2);
    }
    if (is_pulley) {
      const double side_a = std::hypot(places[0].x - joint.ground_anchor_a.x, places[0].y - joint.ground_anchor_a.y);
      const double side_b = std::hypot(places[1].x - joint.ground_anchor_b.x, places[1].y - joint.ground_anchor_b.y);
      if (has_short_side(joint, side_a, side_b, is_dynamic(*pair[0]), is_dynamic(*pair[1]))) continue;
    }
    // Of a pulley: the forces on A and on B.
    const double force_x = view.joints.value(i, "linear_force", 0);
    const double force = is_pulley ? std::fabs(force_x) : std::hypot(force_x, view.joints.value(i, "linear_force", 1));
    const double torque = std::fabs(view.joints.value(i, "torque"));
    const double rate = std::min(law.bias_rate, is_direct ? direct_push_rate : infinite);
    const double slack = std::max(view.slack_of(ends[0], ends[1]), view.target_error_of(ends[0], ends[1]));
    const double least = slack + view.asleep_slack_of(ends[0], ends[1], rate);
    const double tolerance = least + turned_away;
    if (mobility > 0) stored += 0.5 * law.omega * law.omega / mobility * gap * gap;
    Offence offence;
    offence.push = law.bias_rate * gap;
    for (const std::uint32_t end : ends) pulled[end] = std::max(pulled[end], offence.push);
    if (gap <= tolerance) continue;
    offence.key = {number, 0};
    offence.body_a = ends[0];
    offence.body_b = ends[1];
    offence.breach.first = number;
    offence.breach.error = gap;
    offence.breach.tolerance = tolerance;
    offence.breach.yielded = load_factor * (force * mobility + torque * mobility_of_torque) / (law.omega * law.omega);
    // With m_a v_a^2 + m_b v_b^2 = (m_a + m_b) c^2 a row changes by v_a + r v_b = c sqrt((m_a + m_b) (1 / m_a + r^2 /
    // m_b)) at best, which is c (1 + r) or more for any masses. r = 1 but for pulleys.
    const double direct_speed =
        direct_push_speed * ((is_dynamic(*pair[0]) ? 1 : 0) + (is_dynamic(*pair[1]) ? ratio_b : 0));
    const double speed_max = is_direct ? direct_speed : push_speed;
    // What turns may stop. Then the slack alone is allowed.
    offence.settling = settling_time(gap, least, rate, speed_max) / view.push_share;
    offence.least = least;
    offence.rate = rate;
    // Far from the origin, the moves of every tick may be rounded by more than a push closes.
    const double closed = std::min(rate * gap, speed_max) * view.push_share * view.dt;
    offence.is_explained = 0.5 * view.rounding_of(ends[0], ends[1]) >= closed;
    list.push_back(offence);
  }
  return list;
}

bool has_chain(const BodyReport& body) {
  return std::any_of(body.shapes->begin(), body.shapes->end(),
                     [](const Shape& shape) { return shape.kind == engine::ShapeKind::chain; });
}

/// The tangent of the angle between two faces that touch in two points; 0 with one point.
double tilt_of(const ContactReport& contact) {
  if (contact.point_count < 2) return 0;
  const double width = std::hypot(contact.point[1].x - contact.point[0].x, contact.point[1].y - contact.point[0].y);
  return std::min(1.0, std::fabs(contact.separation[1] - contact.separation[0]) / width);
}

/// Overlap that arises within a tick because a contact's normal and points stay: by sliding, and by rolling.
double moved_within(const TickView& view, const ContactReport& contact, int point, std::uint32_t a, std::uint32_t b,
                    double bias_rate) {
  const Point va = velocity_at(view.bodies[a], contact.point[point]);
  const Point vb = velocity_at(view.bodies[b], contact.point[point]);
  const double slid = std::fabs((vb.x - va.x) * contact.normal.y - (vb.y - va.y) * contact.normal.x) * view.dt;
  const double turn =
      (std::fabs(view.bodies[a].angular_velocity) + std::fabs(view.bodies[b].angular_velocity)) * view.dt;
  // Each tick adds the versine of the turn, and takes a share of what is there. An edge of a chain keeps its own normal
  // to its ends: what slides over an end at an angle is deeper there in each tick.
  const double taken = 1 - std::exp(-bias_rate * view.dt);
  const double most = 0.5 * std::min(view.extents[a].size, view.extents[b].size);
  const double rolled = 0.5 * turn * turn * std::min(view.extents[a].reach, view.extents[b].reach) / taken;
  const bool keeps_normal = has_chain(view.bodies[a]) || has_chain(view.bodies[b]);
  const double at_end = keeps_normal ? slid * tilt_of(contact) / taken : 0;
  return std::max(slid, std::min(at_end, most)) + std::min(rolled, most);
}

bool is_explained_by_load(const Offence& offence) {
  return offence.breach.error <= offence.breach.tolerance + offence.breach.yielded ||
         offence.breach.yielded >= push_speed / offence.rate;
}

/// The deepest point of two bodies carries the load, and may leave none to the other ones. What the load explains there
/// explains points that are less deep the same way.
void explain_by_deepest(std::vector<Offence>& list) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, const Offence*> deepest;
  for (const Offence& offence : list) {
    if (!is_explained_by_load(offence)) continue;
    const Offence*& most = deepest[offence.key];
    if (!most || offence.breach.error > most->breach.error) most = &offence;
  }
  for (Offence& offence : list) {
    const auto found = deepest.find(offence.key);
    if (found == deepest.end() || found->second->breach.error < offence.breach.error) continue;
    const Point& normal = found->second->normal;
    offence.is_explained |= normal.x * offence.normal.x + normal.y * offence.normal.y > same_way;
  }
}

/// Contact points that are off, and the speed at which contacts push each body.
std::vector<Offence> contact_offences(const TickView& view, const std::vector<std::uint8_t>& is_crushed,
                                      std::vector<double>& pushed) {
  std::vector<Offence> list;
  const auto welded = find_welded(view);
  const auto pinned = find_pinned(view);
  for (const ContactReport& contact : view.contacts) {
    const std::uint32_t a = view.index.at(contact.body_a), b = view.index.at(contact.body_b);
    if (welded.contains(std::minmax(contact.body_a, contact.body_b))) continue;
    if (view.is_fixed(a, b)) continue;
    const bool are_moving = is_dynamic(view.bodies[a]) && is_dynamic(view.bodies[b]);
    const SoftLaw law =
        soft_law(are_moving ? contact_hertz_h : 2 * contact_hertz_h, contact_damping_ratio, view.substep_of(a, b));
    const auto pin = pinned.find(std::minmax(contact.body_a, contact.body_b));
    const double asked_for = pin != pinned.end() ? pin->second : 0;
    for (int i = 0; i < contact.point_count; ++i) {
      const double overlap = -contact.separation[i];
      const double least = asked_for + view.slack_of(a, b) + view.asleep_slack_of(a, b, law.bias_rate);
      const double tolerance = least + moved_within(view, contact, i, a, b, law.bias_rate);
      if (overlap <= tolerance) continue;
      double mobility = 0;
      for (const std::uint32_t end : {a, b}) {
        const BodyReport& body = view.bodies[end];
        if (!is_dynamic(body)) continue;
        const double lever = (contact.point[i].x - body.center.x) * contact.normal.y -
                             (contact.point[i].y - body.center.y) * contact.normal.x;
        mobility += inverse_of(body.mass) + inverse_of(body.inertia) * lever * lever;
      }
      Offence offence;
      offence.key = {contact.body_a, contact.body_b};
      offence.body_a = a;
      offence.body_b = b;
      offence.breach.first = contact.body_a;
      offence.breach.second = contact.body_b;
      offence.breach.error = overlap;
      offence.breach.tolerance = tolerance;
      offence.breach.yielded = load_factor * contact.normal_force[i] * mobility / (law.omega * law.omega);
      offence.normal = contact.normal;
      offence.push = std::min(law.bias_rate * overlap, push_speed);
      // A contact that pushes as hard as it can yields without bound. One that nothing could meet pushes all the same:
      // on joints, and it has its way among what is pushed out together.
      offence.is_explained =
          offence.breach.yielded >= push_speed / law.bias_rate || is_crushed[a] != 0 || is_crushed[b] != 0;
      // A contact that slides may stop. Then the slack alone is allowed.
      offence.settling = settling_time(overlap, least, law.bias_rate, push_speed) / view.push_share;
      offence.least = least;
      offence.rate = law.bias_rate;
      offence.jump = view.moved[a] + view.moved[b] + jump_share * std::min(view.extents[a].size, view.extents[b].size);
      for (const std::uint32_t end : {a, b}) pushed[end] = std::max(pushed[end], offence.push);
      list.push_back(offence);
    }
  }
  explain_by_deepest(list);
  return list;
}

/// [body] the largest of `speeds` among the bodies that joints with gaps connect to it, m/s. A push on one of them
/// drags the others along.
std::vector<double> spread_over(const TickView& view, const std::vector<Offence>& joints,
                                const std::vector<double>& speeds) {
  Groups groups(speeds.size());
  for (const Offence& joint : joints)
    if (is_dynamic(view.bodies[joint.body_a]) && is_dynamic(view.bodies[joint.body_b]))
      groups.tie(joint.body_a, joint.body_b);
  std::vector<double> most(speeds.size()), spread(speeds.size());
  for (std::uint32_t i = 0; i < speeds.size(); ++i) most[groups.of(i)] = std::max(most[groups.of(i)], speeds[i]);
  for (std::uint32_t i = 0; i < speeds.size(); ++i) spread[i] = most[groups.of(i)];
  return spread;
}

/// Of two constraints that contradict each other, the one with the slower push gives way. `other`: [body], m/s.
void explain(std::vector<Offence>& list, const std::vector<double>& other) {
  for (Offence& offence : list)
    offence.is_explained |= offence.breach.error <= offence.breach.tolerance + offence.breach.yielded ||
                            std::max(other[offence.body_a], other[offence.body_b]) > offence.push;
}

/// How long an error may last among those that are corrected together with it.
struct ClusterTime {
  double allowed_s = 0;
  double others_s = 0;  // the settling time of the slowest other one
};

/// Errors of connected bodies are corrected together. What is pushed out of one body is pushed into the next: while the
/// slowest settles, an overlap may grow to the ways of all, which then are pushed out at its own rate. Joints connect
/// bodies, and so do shapes that overlap or press on each other, since pushes pass through them.
std::vector<ClusterTime> times_of_clusters(const TickView& view, const std::vector<const Offence*>& offences,
                                           Groups& clusters) {
  const auto cluster_of = [&](const Offence& offence) {
    return clusters.of(is_dynamic(view.bodies[offence.body_a]) ? offence.body_a : offence.body_b);
  };
  const auto tie = [&](std::uint32_t a, std::uint32_t b) { clusters.tie(a, b); };
  tie_joined(view, tie);
  tie_touching(view, tie);
  for (const ContactReport& contact : view.contacts) {
    const std::uint32_t a = view.index.at(contact.body_a), b = view.index.at(contact.body_b);
    const bool presses = contact.normal_force[0] > 0 || (contact.point_count == 2 && contact.normal_force[1] > 0);
    if (presses && is_dynamic(view.bodies[a]) && is_dynamic(view.bodies[b])) tie(a, b);
  }
  struct Cluster {
    double way = 0;                    // m, of all
    const Offence* slowest = nullptr;  // to settle
    double others = 0;                 // s, the settling time of the slowest one with another key
  };
  std::vector<Cluster> all(view.bodies.size());
  for (const Offence* offence : offences) {
    Cluster& cluster = all[cluster_of(*offence)];
    cluster.way += offence->breach.error;
    const bool is_slowest = !cluster.slowest || offence->settling > cluster.slowest->settling;
    const Offence* faster = is_slowest ? cluster.slowest : offence;
    if (is_slowest) cluster.slowest = offence;
    if (faster && faster->key != cluster.slowest->key) cluster.others = std::max(cluster.others, faster->settling);
  }
  std::vector<ClusterTime> times;
  for (const Offence* offence : offences) {
    const Cluster& cluster = all[cluster_of(*offence)];
    const double after = cluster.others > 0 ? settling_time(cluster.way, offence->least, offence->rate, push_speed)
                                            : cluster.way / push_speed;
    times.push_back({seen_ticks * view.dt + cluster.slowest->settling + after / view.push_share,
                     offence->key == cluster.slowest->key ? cluster.others : cluster.slowest->settling});
  }
  return times;
}

/// Runs the clocks of what is off without a reason. A clock runs back while there is a reason.
template <typename Clocks>
void run_clocks(const std::vector<Offence>& list, const ClusterTime* times, double dt, std::uint64_t tick,
                Clocks& clocks, std::optional<Breach>& broken) {
  for (auto& [key, clock] : clocks) clock.is_running = false;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i].is_explained) continue;
    auto& clock = clocks[list[i].key];
    const double error = list[i].breach.error;
    // A body has come to another side, such as the front of a chain's edge: another overlap than before.
    if (clock.lasted_s > 0 && list[i].jump > 0 && error > clock.error_max + list[i].jump) clock = {};
    // What takes longer has come into touch, and is pushed into this pair from now on.
    const double others_s = times[i].others_s;
    if (others_s > std::max(list[i].settling, 2 * clock.others_s)) clock = {};
    clock.others_s = std::max(clock.others_s, others_s);
    clock.error_max = std::max(clock.error_max, error);
    // What grows later is not pushed out.
    if (clock.lasted_s <= seen_ticks * dt) clock.allowed_s = std::max(clock.allowed_s, times[i].allowed_s);
    if (!clock.is_running) clock.lasted_s += dt;
    clock.is_running = true;
    if (clock.lasted_s <= clock.allowed_s || broken) continue;
    broken = list[i].breach;
    broken->tick = tick;
    broken->lasted_s = clock.lasted_s;
    broken->allowed_s = clock.allowed_s;
  }
  for (auto at = clocks.begin(); at != clocks.end();) {
    if (!at->second.is_running) at->second.lasted_s -= dt;
    at = at->second.lasted_s <= 0 ? clocks.erase(at) : std::next(at);
  }
}

std::string breach_text(const Breach& breach, const std::string& what) {
  return what + " by " + tool::short_number(breach.error) + " m at tick " + std::to_string(breach.tick) +
         ": expected " + tool::short_number(breach.tolerance) + " m and " + tool::short_number(breach.yielded) +
         " m by the load after " + tool::short_number(breach.allowed_s) + " s";
}

}  // namespace

std::string overlap_text(const Breach& breach) {
  return breach_text(breach,
                     "bodies " + std::to_string(breach.first) + " and " + std::to_string(breach.second) + " overlap");
}

std::string gap_text(const Breach& breach) {
  return breach_text(breach, "joint " + std::to_string(breach.first) + " is off");
}

bool promises_accuracy(const engine::Settings& settings) {
  return !info_of(engine::solvers, settings.solver).is_baseline &&
         !info_of(engine::integrators, settings.integrator).is_baseline;
}

void ConstraintLaw::look(const engine::Engine& engine, double dt) {
  const StateView& state = engine.state();
  // One pass moves what touches several bodies by half of a push at worst. Schemes that take half of a force take half
  // of a push that is no larger than a force.
  const bool takes_all = scene_.settings.integrator == engine::IntegratorKind::semi_implicit_euler;
  TickView view{scene_, dt, engine.bodies(),       engine.contacts(), tool::NamedTable(state, "joints"), {}, {}, {},
                {},     {}, takes_all ? 0.5 : 0.25};
  for (std::uint32_t i = 0; i < view.bodies.size(); ++i) {
    const BodyReport& body = view.bodies[i];
    view.index[body.id] = i;
    const auto known = extents_.find(body.id);
    view.extents.push_back(known != extents_.end() ? known->second
                                                   : extents_.emplace(body.id, extent_of(body)).first->second);
    const auto last = poses_.find(body.id);
    view.moved.push_back(
        last == poses_.end()
            ? infinite
            : std::hypot(body.center.x - last->second.center.x, body.center.y - last->second.center.y) +
                  std::fabs(std::remainder(body.angle - last->second.angle, 2 * engine::pi)) *
                      view.extents.back().reach);
    poses_[body.id] = {body.center, body.angle};
  }
  view.h = substeps_of(scene_, state, dt, view.index);
  view.is_asleep = find_asleep(state, view.index);
  std::vector<std::uint8_t> is_driven(view.bodies.size());
  find_driven(view, is_driven);
  std::vector<std::uint8_t> is_crushed = is_driven;
  find_squeezed(view, is_crushed);

  std::vector<double> pulled(view.bodies.size()), pushed(view.bodies.size());
  stored_energy_ = 0;
  std::vector<Offence> joints = joint_offences(view, pulled, stored_energy_);
  std::vector<Offence> contacts = contact_offences(view, is_crushed, pushed);
  explain(contacts, pulled);
  explain(joints, spread_over(view, joints, pushed));
  for (Offence& joint : joints)  // between a driver and a wall, joints can be met as little as contacts
    if (is_driven[joint.body_a] != 0 || is_driven[joint.body_b] != 0) joint.is_explained = true;
  std::vector<const Offence*> all;
  for (const Offence& offence : contacts) all.push_back(&offence);
  for (const Offence& offence : joints) all.push_back(&offence);
  Groups clusters(view.bodies.size());
  const std::vector<ClusterTime> times = times_of_clusters(view, all, clusters);
  run_clocks(contacts, times.data(), dt, engine.tick() - 1, contact_clocks_, overlap_);
  run_clocks(joints, times.data() + contacts.size(), dt, engine.tick() - 1, joint_clocks_, gap_);
}

}  // namespace ticktrue::soak
