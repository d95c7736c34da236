// The loads of what kinematic bodies push before them.
// SPDX-License-Identifier: MIT
//
// A plate that pushes a row over a floor loads the row. The load is the friction of all that is ahead, the known forces
// on it, and what brings it to the speed of the plate. Weights do not show these loads, and measured loads show them
// late: the first bodies overlap meanwhile, and the substeps that are added then push them apart.
#include "engine/islands/pushes.h"

#include "engine/islands/supports.h"
#include "engine/math/trig.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

constexpr std::uint32_t not_pushed = 0xffffffff;

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

}  // namespace

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

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
