// Time of impact by conservative advancement; impulses by Newton's law of restitution and Coulomb's law of friction.
// SPDX-License-Identifier: MIT
// Source: Mirtich, "Impulse-based Dynamic Simulation of Rigid Body Systems", 1996, chapters 2 and 3 (conservative
// advancement: no pair can close its gap sooner than gap / greatest closing speed; impacts in order of time).
#include "engine/impacts/impacts.h"

#include "engine/impacts/impact_impulses.h"
#include "engine/integrators/motion_rows.h"
#include "engine/math/trig.h"
#include "engine/model/margins.h"
#include "engine/model/solved_set.h"
#include "engine/narrow_phase/distance.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr Real no_impact = Real(1e30);
constexpr int advance_count_max = 48;
constexpr Real slow_share = Real(0.05);    // of the smaller shape in a tick: the contact solver has slower pairs
constexpr Real rotation_max = Real(0.25);  // rad in a tick, likewise: the solver keeps the normal constant
constexpr Real close_share = Real(0.005);  // of the smaller shape: the contact solver has closer slow pairs
// The limit of impacts in a substep grows with the number of pairs. Beyond the limit, bodies stop where they are hit.
constexpr std::size_t impact_count_least = 32;
constexpr std::size_t impacts_per_pair = 2;
// The limit of searches for a next impact in a substep: each impact of a large body searches all pairs of this body.
constexpr std::size_t search_count_least = 2048;
constexpr std::size_t searches_per_pair = 64;

/// Whether the integrator fills DriftVelocities.
bool has_offsets(const Model& model) {
  return model.scene.settings.integrator != IntegratorKind::semi_implicit_euler;
}

const BodyModel& body_model(const Model& model, const State& state, std::uint32_t row) {
  return model.bodies[state.bodies[row].source];
}

Vec2 velocity_at(const ImpactPath& path, Real time) {
  return path.velocity + (time - path.time) * path.acceleration;
}

Vec2 delta_position_at(const ImpactPath& path, Real time) {
  const Real t = time - path.time;
  return path.delta_position + t * (path.velocity + (Real(0.5) * t) * path.acceleration);
}

Rotation delta_rotation_at(const ImpactPath& path, Real time) {
  return rotation_by((time - path.time) * path.angular_velocity) * path.delta_rotation;
}

Placement pose_at(const State& state, const ImpactPath& path, std::uint32_t row, Real time) {
  return {state.bodies[row].position + delta_position_at(path, time),
          delta_rotation_at(path, time) * state.bodies[row].rotation};
}

/// Velocity of B's surface relative to A's at a point.
Vec2 relative_velocity(const Placement& a, const Placement& b, const ImpactPath& path_a, const ImpactPath& path_b,
                       Vec2 point, Real time) {
  return (velocity_at(path_b, time) + cross(path_b.angular_velocity, point - b.position)) -
         (velocity_at(path_a, time) + cross(path_a.angular_velocity, point - a.position));
}

/// The separation up to which shapes touch: the rounding of coordinates, or a small share of the shapes' size.
Real touch_tolerance(Real size, Vec2 a, Vec2 b) {
  const Real far = larger(larger(absolute(a.x), absolute(a.y)), larger(absolute(b.x), absolute(b.y)));
  return larger(Real(1e-6) * size, 8 * epsilon * far);
}

/// The largest approach speed of a shape by rotation, m/s. A disc that rotates about its middle has none.
Real rotation_speed(const BodyModel& body, const ShapeModel& shape, const ImpactPath& path) {
  const Real arm = shape.family == ShapeFamily::circle ? length(shape.center) : body.extent;
  return absolute(path.angular_velocity) * arm;
}

/// Whether the bounding circles of two shapes stay apart for `time_left`. The pair then needs no exact distance.
bool stay_separated(const Placement& a, const Placement& b, const ShapeModel& shape_a, const ShapeModel& shape_b,
                    Real closing_max, Real time_left) {
  const Vec2 offset =
      (b.position + rotate(b.rotation, shape_b.center)) - (a.position + rotate(a.rotation, shape_a.center));
  const Real distance_max = (shape_a.bounding_radius + shape_b.bounding_radius) + closing_max * time_left;
  return length_squared(offset) > Real(1.01) * (distance_max * distance_max);
}

/// The normal, from A to B, along which an edge of a chain may act on the other shape of a pair. Other shapes act along
/// any normal.
EdgeNormal edge_normal_of_pair(const Model& model, const ShapeModel& shape_a, const Placement& a,
                               const ShapeModel& shape_b, const Placement& b, const Distance& gap) {
  const auto normal_of = [&](const ShapeModel& edge, const Placement& at, const ShapeModel& other,
                             const Placement& other_at, Vec2 normal) {
    const Vec2 center = (other_at.position - at.position) + rotate(other_at.rotation, other.center);
    EdgeNormal direction = edge_normal(model, edge, rotate_back(at.rotation, normal), rotate_back(at.rotation, center));
    direction.normal = rotate(at.rotation, direction.normal);
    return direction;
  };
  if (shape_a.family == ShapeFamily::chain_edge) return normal_of(shape_a, a, shape_b, b, gap.normal);
  if (shape_b.family != ShapeFamily::chain_edge) return {true, true, true, gap.normal};
  EdgeNormal direction = normal_of(shape_b, b, shape_a, a, -gap.normal);
  direction.normal = -direction.normal;
  return direction;
}

/// Sets the pair's next impact at or after `start`.
void find_impact(const SolvedSet& solved, const ImpactWorkspace& work, ImpactPair& pair, Real start) {
  const Model& model = solved.model;
  const State& state = solved.state;
  const Real h = solved.set.h;
  pair.time = no_impact;
  if (pair.is_done) return;
  const ImpactPath& path_a = work.paths[pair.body_a];
  const ImpactPath& path_b = work.paths[pair.body_b];
  const ShapeModel& shape_a = model.shapes[pair.shape_a];
  const ShapeModel& shape_b = model.shapes[pair.shape_b];
  const BodyModel& model_a = body_model(model, state, pair.body_a);
  const BodyModel& model_b = body_model(model, state, pair.body_b);
  const Real spin = rotation_speed(model_a, shape_a, path_a) + rotation_speed(model_b, shape_b, path_b);
  const Real acceleration = length(path_b.acceleration - path_a.acceleration);
  const Real threshold = static_cast<Real>(model.restitution_threshold);
  const Real size = pair_size(shape_a, shape_b);
  // slow = slow_share size / dt, which gives dt.
  const Real angular_speed = absolute(path_a.angular_velocity) + absolute(path_b.angular_velocity);
  const bool has_contact = pair.slow >= 0 && angular_speed * (slow_share * size) <= rotation_max * pair.slow;
  Real time = start;
  for (int i = 0; i < advance_count_max; ++i) {
    const Placement a = pose_at(state, path_a, pair.body_a, time);
    const Placement b = pose_at(state, path_b, pair.body_b, time);
    if (i == 0) {
      const Vec2 relative = velocity_at(path_b, time) - velocity_at(path_a, time);
      if (stay_separated(a, b, shape_a, shape_b, (length(relative) + acceleration * (h - time)) + spin, h - time))
        return;
    }
    Distance gap = distance(model, shape_a, a, shape_b, b);
    const EdgeNormal direction = edge_normal_of_pair(model, shape_a, a, shape_b, b, gap);
    const Real tolerance = touch_tolerance(size, a.position, b.position);
    // Along a normal that the chain edge excludes, the shape may come closer until it touches. The edge's own normal
    // then applies.
    if (!direction.is_allowed && gap.separation <= tolerance) {
      if (!direction.in_front) return;
      gap.normal = direction.normal;
    }
    const Real close_distance = has_contact && direction.is_allowed ? larger(tolerance, close_share * size) : tolerance;
    if (gap.separation <= close_distance) {
      const Real closing = -dot(relative_velocity(a, b, path_a, path_b, gap.point, time), gap.normal);
      const bool bounces = pair.restitution > 0 && closing > threshold;
      // The contact solver has slow pairs without restitution that cannot pass through. As impacts, the two ends of a
      // body that slides between a floor and a wall would hit in turn without end. At a corner of a chain, the edge
      // below the shape has the contact, with friction; this edge stops only fast shapes.
      if (!direction.is_allowed && !bounces && closing * h <= slow_share * size) return;
      // A corner belongs to the edge that ends there: that pair has the contact. This edge stops only fast shapes.
      const bool is_others = !direction.is_owned && !bounces && closing * h <= slow_share * size;
      // What the forces of this substep have added to the closing speed is a load, which the contact carries. An impact
      // would take the load from the contact, and the contact would not push. Bounces that are not located are the
      // solver's.
      const Real by_forces = -dot(path_b.acceleration - path_a.acceleration, gap.normal) * (Real(0.5) * h + time);
      const bool is_located = bounces && model.scene.settings.locate_impacts;
      const bool is_slow = !is_located && closing - larger(by_forces, 0) <= pair.slow;
      const bool is_solvers = is_others || (has_contact && is_slow);
      const bool touches = gap.separation <= tolerance;
      // There is also no impact if the rest of the substep is too short for the remaining gap.
      if (is_solvers || (touches && !(closing * (h - time) > tolerance))) {
        // Another part of a spinning body may still hit. The search continues after a rotation that is small for the
        // thinner shape, unless no other part can reach the middle of the thinner shape.
        if (!pair.is_fast || !((spin + acceleration * (h - time)) * (h - time) > Real(0.1) * size)) return;
        time += Real(0.05) * size / (spin + acceleration * (h - time));
        if (!(time < h)) return;
        if (i + 1 == advance_count_max) {
          pair.time = time;
          pair.normal = gap.normal;
          pair.point = gap.point;
          pair.is_located = false;
        }
        continue;
      }
      if (touches) {
        pair.time = time;
        pair.normal = gap.normal;
        pair.point = gap.point;
        pair.is_located = true;
        return;
      }
    }
    const Real along = -dot(velocity_at(path_b, time) - velocity_at(path_a, time), gap.normal);
    const Real closing_max = (along + acceleration * (h - time)) + spin;
    if (!(closing_max > 0) || !(gap.separation < closing_max * (h - time))) return;
    time += gap.separation / closing_max;
    if (i + 1 < advance_count_max || !pair.is_fast || !direction.is_allowed) continue;
    if (!direction.is_owned && closing_max * h <= slow_share * size) return;
    // A grazing or spinning pair without an exact time of impact is stopped, so that it cannot pass through.
    pair.time = time;
    pair.normal = gap.normal;
    pair.point = gap.point;
    pair.is_located = false;
  }
}

/// Changes the velocity of a body at `time`. The path of the body then starts there.
void change_velocity(ImpactPath& path, Real time, Vec2 change, Real spin_change) {
  path.is_hit = true;
  if (path.is_stopped) {
    path.saved_velocity = path.saved_velocity + change;
    path.saved_spin += spin_change;
    return;
  }
  path.delta_position = delta_position_at(path, time);
  path.velocity = velocity_at(path, time) + change;
  path.delta_rotation = delta_rotation_at(path, time);
  path.angle += (time - path.time) * path.angular_velocity;
  path.angular_velocity += spin_change;
  path.time = time;
}

/// Stops a body at `time` for the rest of the substep: in the world, or relative to the kinematic body `carrier`. Along
/// `tangent` it moves on, until it is stopped once more: it keeps its velocity, and what it is joined to moves on, too.
/// `tangent`: of an immovable body, or 0. Returns whether the path changes.
bool stop(const State& state, std::uint32_t row, ImpactPath& path, Real time, Real h, Vec2 tangent,
          const ImpactPath* carrier, std::uint32_t carrier_row) {
  if (path.is_stopped && !path.slides) return false;
  const bool slid = path.is_stopped;
  path.is_stopped = false;
  change_velocity(path, time, {0, 0}, 0);
  path.is_stopped = true;
  path.slides = !slid && length_squared(tangent) > 0;
  if (!slid) {
    path.saved_velocity = path.velocity;
    path.saved_spin = path.angular_velocity;
    path.saved_acceleration = path.acceleration;
  }
  path.velocity = {0, 0};
  path.angular_velocity = 0;
  if (carrier != nullptr) {
    const Vec2 arm = pose_at(state, path, row, time).position - pose_at(state, *carrier, carrier_row, time).position;
    path.velocity = velocity_at(*carrier, time) + cross(carrier->angular_velocity, arm);
    path.angular_velocity = carrier->angular_velocity;
  }
  path.acceleration = {0, 0};
  if (!path.slides) return true;
  path.velocity = path.velocity + dot(path.saved_velocity - path.velocity, tangent) * tangent;
  path.acceleration = dot(path.saved_acceleration, tangent) * tangent;
  path.saved_velocity = path.saved_velocity + (h - time) * path.acceleration;
  return true;
}

/// Changes the velocities of all bodies that the impulses move.
void apply_to_islands(ImpactWorkspace& work, const IslandImpact& impact, Real time, const Impulses& impulses) {
  const ImpactIslands& islands = work.islands;
  std::size_t next = 0;
  for (const ImpactBodies& part : impact.ends.parts)
    for (std::uint32_t i = 0; i < part.count; ++i, ++next) {
      const Triple& by_normal = islands.responses[impact.normal.response + next];
      const Triple& by_tangent = islands.responses[impact.tangent.response + next];
      const auto change = [&](std::size_t k) {
        return static_cast<Real>(static_cast<double>(impulses.normal) * by_normal[k] +
                                 static_cast<double>(impulses.tangent) * by_tangent[k]);
      };
      change_velocity(work.paths[islands.rows[part.first + i]], time, {change(0), change(1)}, change(2));
    }
}

/// Bodies of iterative joints get velocities that keep the rigid rows. Otherwise an impact might add energy.
void project_paths(const SolvedSet& solved, const DirectComponent& component, DirectSetIsland& at, Real time,
                   ImpactWorkspace& work) {
  const auto velocity_in = [time](const ImpactPath& path) {
    return velocity_of({velocity_at(path, time), path.angular_velocity, {}, {}});
  };
  work.velocities.clear();
  for (std::size_t i = 0; i < component.moving_count; ++i)
    work.velocities.push_back(velocity_in(work.paths[component.bodies[i]]));
  project_for_impacts(solved, component, at, work.velocities);
  for (std::size_t i = 0; i < component.moving_count; ++i) {
    ImpactPath& path = work.paths[component.bodies[i]];
    const Triple before = velocity_in(path);
    const Triple& after = work.velocities[i];
    const auto change = [&](std::size_t k) { return static_cast<Real>(after[k] - before[k]); };
    change_velocity(path, time, {change(0), change(1)}, change(2));
  }
}

/// Prepares the islands of the first impact in a substep that meets them.
void enter_islands(const SolvedSet& solved, DirectWorkspace& direct, ImpactWorkspace& work, const ImpactEnds& ends,
                   Real time) {
  for (const ImpactBodies& part : ends.parts) {
    if (part.component == DirectComponents::none || work.islands.is_factored[part.component] != 0) continue;
    work.islands.is_factored[part.component] = 1;
    const DirectComponent& component = direct.components.components()[part.component];
    DirectSetIsland& at = direct.islands[part.component];
    factor_for_impacts(solved, component, direct, at);
    if (!direct.solves_joints) project_paths(solved, component, at, time, work);
  }
}

/// Gives the bodies of a pair their impulses. Returns the islands that have new velocities, if any.
ImpactEnds resolve(const SolvedSet& solved, DirectWorkspace& direct, ImpactWorkspace& work, const ImpactPair& pair) {
  const Model& model = solved.model;
  const State& state = solved.state;
  ImpactPath& path_a = work.paths[pair.body_a];
  ImpactPath& path_b = work.paths[pair.body_b];
  const BodyModel& model_a = body_model(model, state, pair.body_a);
  const BodyModel& model_b = body_model(model, state, pair.body_b);
  const Placement a = pose_at(state, path_a, pair.body_a, pair.time);
  const Placement b = pose_at(state, path_b, pair.body_b, pair.time);
  const Vec2 arm_a = pair.point - a.position;
  const Vec2 arm_b = pair.point - b.position;
  IslandImpact impact;
  const bool meets_islands = find_islands(solved, direct, pair, work.islands, impact.ends);
  if (meets_islands) enter_islands(solved, direct, work, impact.ends, pair.time);
  const Vec2 relative = relative_velocity(a, b, path_a, path_b, pair.point, pair.time);
  const Vec2 tangent = right_turn(pair.normal);
  const Real closing = -dot(relative, pair.normal);
  const Real e = closing > static_cast<Real>(model.restitution_threshold) ? pair.restitution : Real(0);
  const ImpactSpeeds speeds = {closing, dot(relative, tangent), pair.friction, e};
  if (meets_islands) find_responses(solved, direct, pair.normal, arm_a, arm_b, work.islands, impact);
  if (impact.normal.mobility > 0) {
    apply_to_islands(work, impact, pair.time, impulses_on_islands(mobility_of(impact, work.islands), speeds));
    return impact.ends;
  }
  const auto mobility_along = [&](Vec2 direction) {
    const Real lever_a = cross(arm_a, direction);
    const Real lever_b = cross(arm_b, direction);
    return ((model_a.inv_mass + model_b.inv_mass) + model_a.inv_inertia * lever_a * lever_a) +
           model_b.inv_inertia * lever_b * lever_b;
  };
  const Real coupling = model_a.inv_inertia * cross(arm_a, tangent) * cross(arm_a, pair.normal) +
                        model_b.inv_inertia * cross(arm_b, tangent) * cross(arm_b, pair.normal);
  const Impulses impulses = impulses_alone({mobility_along(pair.normal), mobility_along(tangent), coupling}, speeds);
  const Vec2 impulse = impulses.normal * pair.normal + impulses.tangent * tangent;
  change_velocity(path_a, pair.time, -model_a.inv_mass * impulse, -model_a.inv_inertia * cross(arm_a, impulse));
  change_velocity(path_b, pair.time, model_b.inv_mass * impulse, model_b.inv_inertia * cross(arm_b, impulse));
  return impact.ends;
}

/// Starts the path of a body without impacts, from the integrator's prediction.
void begin_path(const SolvedSet& solved, const DriftVelocities& drift, ImpactWorkspace& work, std::uint32_t row) {
  const Model& model = solved.model;
  const State& state = solved.state;
  const Real h = solved.set.h;
  ImpactPath& path = work.paths[row];
  const MovingBody& body = solved.bodies.records[row];
  const bool is_static = model.bodies[state.bodies[row].source].type == BodyType::static_body;
  path.delta_position = body.delta_position;
  path.delta_rotation = body.delta_rotation;
  path.time = 0;
  path.angle = 0;
  path.is_hit = false;
  path.is_stopped = false;
  path.slides = false;
  if (is_static) {
    path.velocity = path.acceleration = {0, 0};
    path.angular_velocity = 0;
    return;
  }
  const Twist offset_now = has_offsets(model) ? drift.offsets[row] : Twist{};
  const Vec2 offset = offset_now.linear;
  const Real spin_offset = offset_now.angular;
  path.acceleration = (1 / h) * (body.velocity - path.start_velocity);
  path.velocity = (body.velocity - offset) - (Real(0.5) * h) * path.acceleration;
  path.angular_velocity = body.angular_velocity - spin_offset;
}

/// Sets velocity and corrections of a body that was hit. The integrator's drift then brings the body to the end of its
/// path.
void end_path(const SolvedSet& solved, DriftVelocities& drift, ImpactWorkspace& work, std::uint32_t row) {
  const Model& model = solved.model;
  const State& state = solved.state;
  const Real h = solved.set.h;
  ImpactPath& path = work.paths[row];
  if (!path.is_hit) return;
  MovingBody& body = solved.bodies.records[row];
  if (model.bodies[state.bodies[row].source].type != BodyType::dynamic_body) return;
  const Twist offset_now = has_offsets(model) ? drift.offsets[row] : Twist{};
  const Vec2 offset = offset_now.linear;
  const Real spin_offset = offset_now.angular;
  const Vec2 delta_position = delta_position_at(path, h);
  const Real angle = path.angle + (h - path.time) * path.angular_velocity;
  // The velocity that a scheme stores at the end of a substep differs from the true one by `offset - h a / 2`.
  const Vec2 true_end = path.is_stopped ? path.saved_velocity : velocity_at(path, h);
  const Vec2 acceleration = path.is_stopped ? path.saved_acceleration : path.acceleration;
  const Vec2 velocity = (true_end + offset) - (Real(0.5) * h) * acceleration;
  const Real spin = (path.is_stopped ? path.saved_spin : path.angular_velocity) + spin_offset;
  if (has_offsets(model) && model.position_forces == nullptr && !model.has_velocity_forces) {
    drift.predicted[row].linear = drift.predicted[row].linear + (velocity - body.velocity);
    drift.predicted[row].angular += spin - body.angular_velocity;
  }
  path.correction = (delta_position - body.delta_position) - h * (velocity - offset);
  path.rotation_correction = angle - h * (spin - spin_offset);
  work.hit_rows.push_back(row);
  body.velocity = velocity;
  body.angular_velocity = spin;
}

// ---- The order of impacts: a heap, earliest first, equal times by the order of the pairs ----

bool comes_before(const ImpactEvent& a, const ImpactEvent& b) {
  return a.time != b.time ? a.time < b.time : a.pair < b.pair;
}

void push_event(std::vector<ImpactEvent>& heap, const ImpactEvent& event) {
  std::size_t at = heap.size();
  heap.push_back(event);
  for (; at > 0 && comes_before(event, heap[(at - 1) / 2]); at = (at - 1) / 2) heap[at] = heap[(at - 1) / 2];
  heap[at] = event;
}

ImpactEvent pop_event(std::vector<ImpactEvent>& heap) {
  const ImpactEvent first = heap[0];
  const ImpactEvent last = heap.back();
  heap.pop_back();
  if (heap.empty()) return first;
  std::size_t at = 0;
  for (;;) {
    std::size_t child = 2 * at + 1;
    if (child >= heap.size()) break;
    if (child + 1 < heap.size() && comes_before(heap[child + 1], heap[child])) ++child;
    if (!comes_before(heap[child], last)) break;
    heap[at] = heap[child];
    at = child;
  }
  heap[at] = last;
  return first;
}

bool is_dynamic(const Model& model, const State& state, std::uint32_t row) {
  return body_model(model, state, row).type == BodyType::dynamic_body;
}

/// Makes the path of a body the move from the end of its path to its present pose, at constant velocities.
void follow_move(const SolvedSet& solved, ImpactPath& path, std::uint32_t row) {
  const Real h = solved.set.h;
  const MovingBody& body = solved.bodies.records[row];
  path.delta_position = delta_position_at(path, h);
  path.delta_rotation = delta_rotation_at(path, h);
  path.time = 0;
  path.velocity = (1 / h) * (body.delta_position - path.delta_position);
  path.acceleration = {0, 0};
  const Rotation turn = between(path.delta_rotation, body.delta_rotation);
  path.angular_velocity = static_cast<Real>(arc_tangent(static_cast<double>(turn.s), static_cast<double>(turn.c))) / h;
}

/// Finds the next impact of a pair and adds it to the heap.
void expect_impact(const SolvedSet& solved, std::vector<ImpactPair>& impacts, ImpactWorkspace& work,
                   std::uint32_t index, Real start) {
  ImpactPair& pair = impacts[index];
  find_impact(solved, work, pair, start);
  if (pair.time < solved.set.h) push_event(work.events, {pair.time, index});
}

/// Lists the islands that active pairs may hit.
void list_islands(const SolvedSet& solved, const std::vector<ImpactPair>& impacts, const DirectWorkspace& direct,
                  ImpactWorkspace& work) {
  ImpactIslands& islands = work.islands;
  clear_islands(solved, direct, islands);
  const std::size_t count = direct.components.components().size();
  if (count == 0) return;
  for (const std::uint32_t i : work.active) count_points(direct, impacts[i].body_a, impacts[i].body_b, 1, islands);
  for (const std::uint32_t i : work.active) {
    const ImpactPair& pair = impacts[i];
    if (meets_island(direct, pair.body_a, islands) || meets_island(direct, pair.body_b, islands))
      find_ends(solved, direct, pair.body_a, pair.body_b, islands);
  }
  islands.is_factored.assign(count, 0);
}

/// Lists the active pairs of each dynamic body.
void list_pairs_of_bodies(const SolvedSet& solved, const std::vector<ImpactPair>& impacts, ImpactWorkspace& work) {
  std::vector<std::uint32_t>& start = work.starts;
  start.assign(solved.state.bodies.size() + 2, 0);
  const auto for_each = [&](auto use) {
    for (const std::uint32_t i : work.active)
      for (const std::uint32_t row : {impacts[i].body_a, impacts[i].body_b})
        if (is_dynamic(solved.model, solved.state, row)) use(row, i);
  };
  for_each([&](std::uint32_t row, std::uint32_t) { ++start[row + 2]; });
  for (std::size_t i = 2; i < start.size(); ++i) start[i] += start[i - 1];
  work.of_bodies.resize(start.back());
  for_each([&](std::uint32_t row, std::uint32_t i) { work.of_bodies[start[row + 1]++] = i; });
}

// No impact pushes shapes apart: the solver has contacts that overlap by more than this share of their size.
constexpr Real overlap_share = Real(0.02);

}  // namespace

Real slow_closing(const Model& model, const State& state, const TickLists& tick, const ImpactPair& pair,
                  std::uint32_t contact, Real dt) {
  if (contact == state.contacts.size() || is_left_to_impacts(model, state, tick, contact)) return -1;
  return pair.is_fast ? slow_share * pair_size(model.shapes[pair.shape_a], model.shapes[pair.shape_b]) / dt : no_impact;
}

bool is_left_to_impacts(const Model& model, const State& state, const TickLists& tick, std::uint32_t contact) {
  const ContactPair& pair = tick.contact_pairs[contact];
  const ContactRow& row = state.contacts[contact];
  if (!model.scene.settings.locate_impacts || !(pair.restitution > 0)) return false;
  if (row.normal_force[0] > 0 || row.normal_force[1] > 0) return false;
  const BodyRow& a = state.bodies[pair.body_a];
  const BodyRow& b = state.bodies[pair.body_b];
  const Real threshold = static_cast<Real>(model.restitution_threshold);
  const Real tolerance = touch_tolerance(pair.size, a.position, b.position);
  const Real gravity_displacement = gravity_displacement_of_tick(model, state);
  const bool has_forces = !model.body_forces.empty() || !tick.force.empty() || !state.pointers.empty();
  for (int i = 0; i < pair.manifold.point_count; ++i) {
    const ManifoldPoint& point = pair.manifold.points[i];
    if (point.separation > tolerance) continue;  // closing this gap in the tick is an impact
    const Vec2 velocity = (b.velocity + cross(b.angular_velocity, point.anchor_b)) -
                          (a.velocity + cross(a.angular_velocity, point.anchor_a));
    const Real closing = -dot(velocity, pair.manifold.normal);
    if (closing >= 0 && closing <= threshold) return false;
    // A bounce at a speed that gravity gives within a tick may end within a substep. Nothing carries the load then. The
    // same holds for other forces where the bodies are too slow to part within the tick.
    const Real overlap = -point.separation;
    const Real slow_way = has_forces ? larger(gravity_displacement, overlap) : gravity_displacement;
    const bool is_slow = absolute(closing) * static_cast<Real>(model.scene.settings.dt) <= slow_way;
    if (overlap > (is_slow ? linear_slop(pair.size) : overlap_share * pair.size)) return false;
  }
  return true;
}

void begin_impacts(const SolvedSet& solved, const std::vector<ImpactPair>& impacts, const DirectWorkspace& direct,
                   ImpactWorkspace& work) {
  work.hit_rows.clear();
  work.active.clear();
  if (impacts.empty()) return;
  const State& state = solved.state;
  work.paths.resize(state.bodies.size());
  for (std::uint32_t i = 0; i < impacts.size(); ++i) {
    const ImpactPair& pair = impacts[i];
    if (!solved.has_body(is_dynamic(solved.model, state, pair.body_a) ? pair.body_a : pair.body_b)) continue;
    work.active.push_back(i);
    for (const std::uint32_t row : {pair.body_a, pair.body_b})
      work.paths[row].start_velocity = solved.bodies.records[row].velocity;
  }
  list_islands(solved, impacts, direct, work);
  for (const std::uint32_t row : work.islands.rows)
    work.paths[row].start_velocity = solved.bodies.records[row].velocity;
}

void finish_impacts(const SolvedSet& solved, const ImpactWorkspace& work) {
  for (const std::uint32_t row : work.hit_rows) {
    MovingBody& body = solved.bodies.records[row];
    body.delta_position = body.delta_position + work.paths[row].correction;
    body.delta_rotation = rotation_by(work.paths[row].rotation_correction) * body.delta_rotation;
  }
}

void stop_at_walls(const SolvedSet& solved, const std::vector<ImpactPair>& impacts, const DirectWorkspace& direct,
                   ImpactWorkspace& work) {
  if (work.active.empty()) return;
  const Model& model = solved.model;
  const State& state = solved.state;
  const Real h = solved.set.h;
  const auto mover_of = [&](const ImpactPair& pair) {
    const bool a_moves = is_dynamic(model, state, pair.body_a), b_moves = is_dynamic(model, state, pair.body_b);
    const std::uint32_t mover = a_moves ? pair.body_a : pair.body_b;
    const bool is_held = direct.components.component_of(mover) != DirectComponents::none;
    return pair.is_fast && a_moves != b_moves && is_held ? mover : no_impact_place;
  };
  const auto follow = [&](std::uint32_t row) {
    if (work.paths[row].is_hit) return;
    follow_move(solved, work.paths[row], row);
    work.paths[row].is_hit = true;  // a body may be in several pairs
  };
  for (const std::uint32_t i : work.active) {
    const std::uint32_t row = mover_of(impacts[i]);
    if (row == no_impact_place) continue;
    follow(impacts[i].body_a);
    follow(impacts[i].body_b);
    // A move by less than this share of the shapes along the normal is the contact solver's.
    ImpactPair pair = impacts[i];
    pair.slow = slow_share * pair_size(model.shapes[pair.shape_a], model.shapes[pair.shape_b]) / h;
    pair.restitution = 0;
    pair.is_done = false;
    find_impact(solved, work, pair, 0);
    if (!(pair.time < h)) continue;
    ImpactPath& path = work.paths[row];
    const Real share = pair.time / h;
    path.velocity = share * path.velocity;
    path.angular_velocity *= share;
    MovingBody& body = solved.bodies.records[row];
    body.delta_position = delta_position_at(path, h);
    body.delta_rotation = delta_rotation_at(path, h);
  }
}

void apply_impacts(const SolvedSet& solved, std::vector<ImpactPair>& impacts, DriftVelocities& drift,
                   DirectWorkspace& direct, ImpactWorkspace& work) {
  if (work.active.empty()) return;
  const Model& model = solved.model;
  const State& state = solved.state;
  const std::vector<std::uint32_t>& active = work.active;
  ImpactIslands& islands = work.islands;
  for (const std::uint32_t i : active) {
    begin_path(solved, drift, work, impacts[i].body_a);
    begin_path(solved, drift, work, impacts[i].body_b);
  }
  for (const std::uint32_t row : islands.rows) begin_path(solved, drift, work, row);
  list_pairs_of_bodies(solved, impacts, work);
  work.events.clear();
  for (const std::uint32_t i : active) {
    impacts[i].is_done = false;
    expect_impact(solved, impacts, work, i, 0);
  }

  std::size_t left = impact_count_least + impacts_per_pair * active.size();
  std::size_t searches_left = search_count_least + searches_per_pair * active.size();
  while (!work.events.empty()) {
    const ImpactEvent event = pop_event(work.events);
    ImpactPair& first = impacts[event.pair];
    if (first.time != event.time) continue;  // outdated
    const ImpactPair hit = first;
    // The path of a stopped body does not change again.
    const auto may_change = [&](std::uint32_t row) {
      return is_dynamic(model, state, row) && (!work.paths[row].is_stopped || work.paths[row].slides);
    };
    const bool a_changes = may_change(hit.body_a), b_changes = may_change(hit.body_b);
    const ImpactEnds ends = hit.is_located ? resolve(solved, direct, work, hit) : ImpactEnds{};
    // Impulses change no path of a stopped body. A body that slides into something immovable is stopped once more.
    const auto takes_impulses = [&](std::uint32_t row) {
      return is_dynamic(model, state, row) && !work.paths[row].is_stopped;
    };
    const bool is_resolved = hit.is_located && (takes_impulses(hit.body_a) || takes_impulses(hit.body_b));
    if (left > 0 && searches_left > 0 && is_resolved) {
      --left;
    } else {
      // Each iteration stops a body, or is the last iteration of its pair.
      bool stopped = false;
      for (const std::uint32_t row : {hit.body_a, hit.body_b}) {
        if (!is_dynamic(model, state, row)) continue;
        const std::uint32_t other = row == hit.body_a ? hit.body_b : hit.body_a;
        const bool is_carried = body_model(model, state, other).type == BodyType::kinematic_body;
        const Vec2 tangent = is_dynamic(model, state, other) ? Vec2{0, 0} : right_turn(hit.normal);
        stopped |= stop(state, row, work.paths[row], hit.time, solved.set.h, tangent,
                        is_carried ? &work.paths[other] : nullptr, other);
      }
      first.is_done = !stopped;
    }
    const auto search_again = [&](std::uint32_t row) {
      for (std::uint32_t k = work.starts[row]; k<work.starts[row + 1]; ++k, searches_left -= searches_left> 0)
        expect_impact(solved, impacts, work, work.of_bodies[k], hit.time);
    };
    if (a_changes) search_again(hit.body_a);
    if (b_changes) search_again(hit.body_b);
    for (const ImpactBodies& part : ends.parts)
      for (std::uint32_t i = 0; i < part.count; ++i) {
        const std::uint32_t row = islands.rows[part.first + i];
        if (row != hit.body_a && row != hit.body_b && may_change(row)) search_again(row);
      }
    if (!a_changes && !b_changes) expect_impact(solved, impacts, work, event.pair, hit.time);
  }
  const auto end = [&](std::uint32_t row) {
    end_path(solved, drift, work, row);
    work.paths[row].is_hit = false;  // a body may be in several pairs
  };
  for (const std::uint32_t i : active) {
    end(impacts[i].body_a);
    end(impacts[i].body_b);
  }
  for (const std::uint32_t row : islands.rows) end(row);
  if (islands.components.empty()) return;
  finish_impacts(solved, work);  // joints then see where their bodies start
  work.hit_rows.clear();
  for (const std::uint32_t component : islands.components)
    if (islands.is_factored[component] != 0)
      end_impacts_of(solved, direct.components.components()[component], direct, direct.islands[component]);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
