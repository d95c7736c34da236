// The loads of what kinematic bodies and known forces push before them.
// SPDX-License-Identifier: MIT
//
// A plate that pushes a row over a floor loads the row. The load is the friction of all that is ahead, the known forces
// on it, and what brings it to the speed of the plate. Weights do not show these loads, and measured loads show them
// late: the first bodies overlap meanwhile, and the substeps that are added then push them apart. So it is with a row
// that a force presses against a wall or against another force.
#include "engine/islands/pushes.h"

#include <algorithm>

#include "engine/islands/supports.h"
#include "engine/math/trig.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::uint32_t not_pushed = 0xffffffff;
constexpr Real crushed_share = Real(0.5);  // of the power of kinematic bodies, in contacts that give way

bool is_pusher(const State& state, const IslandWork& work, std::uint32_t row) {
  const Vec2 velocity = state.bodies[row].velocity;
  return work.body_types[row] == BodyType::kinematic_body && (velocity.x != 0 || velocity.y != 0) &&
         !supports_of(work, row).empty();
}

/// The largest coefficient of friction at each body.
void find_frictions(const State& state, const TickLists& tick, IslandWork& work) {
  work.friction.assign(state.bodies.size(), 0);
  for (const std::uint32_t contact : work.awake_contacts) {
    const ContactPair& pair = tick.contact_pairs[contact];
    for (const std::uint32_t row : {pair.body_a, pair.body_b})
      work.friction[row] = larger(work.friction[row], pair.friction);
  }
}

/// Lists the bodies that a kinematic body pushes, and itself first: work.pushed, with work.pushed_by. A body pushes
/// what it touches within 45 degrees of the direction. No body is listed for two.
void list_pushed(const State& state, IslandWork& work, std::uint32_t pusher, Vec2 ahead) {
  work.pushed.assign(1, pusher);
  for (std::size_t i = 0; i < work.pushed.size(); ++i) {
    const std::uint32_t row = work.pushed[i];
    for (const Support& support : supports_of(work, row)) {
      if (!is_dynamic(work, support.other) || work.pushed_by[support.other] != not_pushed) continue;
      const Vec2 away = state.bodies[support.other].position - (state.bodies[row].position + support.middle);
      if (!(dot(away, ahead) > absolute(cross(away, ahead)))) continue;
      work.pushed_by[support.other] = row;
      work.pushed.push_back(support.other);
    }
  }
}

/// Adds up the loads from the farthest body to the pusher, and the errors from there on.
void add_loads(const Model& model, const State& state, IslandWork& work, std::uint32_t pusher, Real dt) {
  LoadEstimate& out = work.pushes;
  const Vec2 velocity = state.bodies[pusher].velocity;
  const Real speed = length(velocity);
  const Vec2 ahead = (1 / speed) * velocity;
  list_pushed(state, work, pusher, ahead);
  const Real weight = absolute(cross(ahead, state.world.gravity));  // N/kg, across the way
  for (std::size_t i = work.pushed.size(); i-- > 1;) {
    const std::uint32_t row = work.pushed[i];
    const Real slower = larger(speed - dot(state.bodies[row].velocity, ahead), 0);
    const Real mass = model.bodies[state.bodies[row].source].mass;
    out.load[row] += mass * (work.friction[row] * weight + slower / dt) + work.known_force[row];
    if (work.pushed_by[row] != pusher) out.load[work.pushed_by[row]] += out.load[row];
  }
  const auto size_of = [&](std::uint32_t row) { return model.bodies[state.bodies[row].source].size; };
  for (std::size_t i = 1; i < work.pushed.size(); ++i) {
    const std::uint32_t row = work.pushed[i];
    const std::uint32_t from = work.pushed_by[row];
    const Real size = from == pusher ? size_of(row) : smaller(size_of(row), size_of(from));
    for (const Support& support : supports_of(work, row)) {
      if (support.other != from) continue;
      const Real compression = 2 * out.load[row] * support.compliance;  // a sudden load swings twice as far
      out.position_error[row] = out.position_error[from] + compression;
      if (size > 0) out.local_error[row] = compression / size;
      break;
    }
  }
}

/// Calls `use` with each support of a body that is within 45 degrees of the direction.
template <typename Use>
void for_each_ahead(const IslandWork& work, std::uint32_t row, Vec2 ahead, Use use) {
  for (const Support& support : supports_of(work, row))
    if (dot(support.normal, ahead) > absolute(cross(support.normal, ahead))) use(support);
}

/// Lists the bodies whose known forces act within 45 degrees of the direction, and all bodies ahead of them, from the
/// hindmost to the foremost: work.pushed, with their own forces as loads.
void list_pressed(const State& state, IslandWork& work, std::uint32_t first, Vec2 ahead) {
  work.pushed_by.assign(state.bodies.size(), not_pushed);
  work.pushes.load.assign(state.bodies.size(), 0);
  work.pushed.clear();
  const auto add = [&](std::uint32_t row) {
    if (!is_dynamic(work, row) || work.pushed_by[row] != not_pushed) return;
    work.pushed_by[row] = row;
    work.pushed.push_back(row);
  };
  for (const std::uint32_t row : work.awake_rows) {
    const Vec2 press = work.directed.force[row];
    if (row < first || work.directed.is_done[row] != 0 || !(dot(press, ahead) > absolute(cross(press, ahead))))
      continue;
    work.directed.is_done[row] = 1;
    work.pushes.load[row] = dot(press, ahead);
    add(row);
  }
  for (std::size_t i = 0; i < work.pushed.size(); ++i)
    for_each_ahead(work, work.pushed[i], ahead, [&](const Support& support) { add(support.other); });
  // total order: by way, then row
  std::sort(work.pushed.begin(), work.pushed.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Real way_a = dot(state.bodies[a].position, ahead);
    const Real way_b = dot(state.bodies[b].position, ahead);
    return way_a < way_b || (way_a == way_b && a < b);
  });
}

/// Finds what each listed body can push back with: friction, weight, known forces, and what it takes to keep up with
/// the others. Immovable bodies push back with any force.
void find_resistances(const Model& model, const State& state, const TickLists& tick, IslandWork& work, Vec2 ahead) {
  work.directed.island_force.assign(state.bodies.size(), 0);
  work.directed.island_mass.assign(state.bodies.size(), 0);
  const auto mass_of = [&](std::uint32_t row) { return model.bodies[state.bodies[row].source].mass; };
  for (const std::uint32_t row : work.pushed) {
    work.directed.island_force[tick.island[row]] += work.pushes.load[row];
    work.directed.island_mass[tick.island[row]] += mass_of(row);
  }
  const Real down = dot(state.world.gravity, ahead);
  const Real across = absolute(cross(state.world.gravity, ahead));
  for (std::size_t i = work.pushed.size(); i-- > 0;) {
    const std::uint32_t row = work.pushed[i];
    const std::uint32_t root = tick.island[row];
    const Real acceleration = work.directed.island_force[root] / work.directed.island_mass[root];
    Real most = mass_of(row) * (acceleration + work.friction[row] * across + larger(-down, 0)) +
                larger(-dot(work.directed.force[row], ahead), 0);
    for_each_ahead(work, row, ahead, [&](const Support& support) {
      most +=
          is_dynamic(work, support.other) ? work.directed.resistance[support.other] : work.directed.island_force[root];
    });
    work.directed.resistance[row] = most;
  }
}

/// Passes the loads on from the hindmost body to the foremost, in equal shares, and adds up the errors.
void pass_loads(const Model& model, const State& state, IslandWork& work, Vec2 ahead) {
  LoadEstimate& out = work.pushes;
  std::vector<Real>& error = work.directed.error;
  error.assign(state.bodies.size(), 0);
  const auto size_of = [&](std::uint32_t row) { return model.bodies[state.bodies[row].source].size; };
  for (const std::uint32_t row : work.pushed) {
    int count = 0;
    for_each_ahead(work, row, ahead, [&](const Support&) { ++count; });
    for_each_ahead(work, row, ahead, [&](const Support& support) {
      const bool both_move = is_dynamic(work, support.other);
      const std::uint32_t to = both_move ? support.other : row;
      const Real share = out.load[row] / static_cast<Real>(count);
      const Real force = both_move ? smaller(share, work.directed.resistance[to]) : share;
      const Real compression = force * support.compliance;
      const Real size = both_move ? smaller(size_of(row), size_of(to)) : size_of(row);
      if (both_move) out.load[to] += force;
      if (both_move) error[to] = larger(error[to], error[row] + compression);
      out.position_error[to] = larger(out.position_error[to], error[row] + compression);
      if (size > 0) out.local_error[to] = larger(out.local_error[to], compression / size);
    });
  }
}

}  // namespace

bool estimate_directed_loads(const Model& model, const State& state, const TickLists& tick, IslandWork& work) {
  bool is_any = false;
  for (const std::uint32_t row : work.awake_rows) {
    const Vec2 press = work.directed.force[row];
    if (!(length(press) > 0) || supports_of(work, row).empty()) continue;
    if (!is_any) {
      find_frictions(state, tick, work);
      work.pushes.position_error.assign(state.bodies.size(), 0);
      work.pushes.local_error.assign(state.bodies.size(), 0);
      work.directed.is_done.assign(state.bodies.size(), 0);
      work.directed.resistance.assign(state.bodies.size(), 0);
      is_any = true;
    }
    if (work.directed.is_done[row] != 0) continue;
    const Vec2 ahead = (1 / length(press)) * press;
    list_pressed(state, work, row, ahead);
    find_resistances(model, state, tick, work, ahead);
    pass_loads(model, state, work, ahead);
  }
  return is_any;
}

bool estimate_pushes(const Model& model, const State& state, const TickLists& tick, IslandWork& work, Real dt) {
  bool is_any = false;
  const auto count = static_cast<std::uint32_t>(state.bodies.size());
  for (std::uint32_t row = 0; row < count; ++row) {
    if (!is_pusher(state, work, row)) continue;
    if (!is_any) {
      find_frictions(state, tick, work);
      for (std::vector<Real>* values : {&work.pushes.load, &work.pushes.position_error, &work.pushes.local_error})
        values->assign(count, 0);
      work.pushed_by.assign(count, not_pushed);
      is_any = true;
    }
    add_loads(model, state, work, row, dt);
  }
  return is_any;
}

void forget_crushed(const Model& model, const State& state, const TickLists& tick, IslandWork& work,
                    std::vector<std::uint32_t>& level) {
  const auto count = static_cast<std::uint32_t>(state.bodies.size());
  bool is_any = false;
  for (std::uint32_t row = 0; row < count; ++row) is_any |= is_pusher(state, work, row);
  if (!is_any) return;
  work.crush.assign(count, {0, 0});
  for (const std::uint32_t contact : work.awake_contacts) {
    const ContactPair& pair = tick.contact_pairs[contact];
    const BodyRow& a = state.bodies[pair.body_a];
    const BodyRow& b = state.bodies[pair.body_b];
    const bool a_moves = is_dynamic(work, pair.body_a);
    CrushPower& power = work.crush[tick.island[a_moves ? pair.body_a : pair.body_b]];
    for (int i = 0; i < pair.manifold.point_count; ++i) {
      const ManifoldPoint& point = pair.manifold.points[i];
      const Real force = state.contacts[contact].normal_force[i];
      const Real speed_a = dot(a.velocity + cross(a.angular_velocity, point.anchor_a), pair.manifold.normal);
      const Real speed_b = dot(b.velocity + cross(b.angular_velocity, point.anchor_b), pair.manifold.normal);
      power.stored += force * (speed_a - speed_b);
      if (!a_moves) power.supplied += force * speed_a;
      if (!is_dynamic(work, pair.body_b)) power.supplied -= force * speed_b;
    }
  }
  for (std::uint32_t row = 0; row < count; ++row) {
    const CrushPower& power = work.crush[row];
    if (power.supplied > 0 && power.stored > crushed_share * power.supplied)
      level[row] = static_cast<std::uint32_t>(model.scene.settings.substeps);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
