// Selects the pairs whose impacts are located in time.
// SPDX-License-Identifier: MIT
#include "engine/constraints/impacts.h"

#include "engine/constraints/joint_model.h"
#include "engine/narrow_phase/distance.h"
#include "engine/pipeline.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void find_impacts(const Model& model, State& state, Scratch& scratch, Real dt) {
  const Settings& settings = model.scene.settings;
  scratch.impacts.clear();
  scratch.offsets_in_use = settings.integrator != IntegratorKind::semi_implicit_euler;
  bool any = settings.locate_impacts;
  for (std::uint32_t row = 0; row < state.bodies.size() && !any; ++row) any = is_fast(model, state, row, dt);
  if (!any) return;
  const Real farthest = farthest_reach(model, state, dt);
  for (const Pair& candidate : scratch.pairs) {
    const Proxy& a = scratch.proxies[candidate.first];
    const Proxy& b = scratch.proxies[candidate.second];
    if (a.is_sensor || b.is_sensor) continue;
    const ShapeModel& shape_a = model.shapes[a.shape];
    const ShapeModel& shape_b = model.shapes[b.shape];
    const Real restitution = mix(settings.restitution_mix, shape_a.restitution, shape_b.restitution);
    const bool bounces = settings.locate_impacts && restitution > 0;
    const bool between_moving = a.is_dynamic && b.is_dynamic;
    const bool guarded = !between_moving || model.bodies[state.bodies[a.body].source].is_bullet ||
                         model.bodies[state.bodies[b.body].source].is_bullet;
    const bool fast =
        settings.continuous && guarded && (is_fast(model, state, a.body, dt) || is_fast(model, state, b.body, dt));
    if (!bounces && !fast) continue;
    const Real near = a.radius + b.radius;  // with the ways of both
    if (length_squared(b.center - a.center) > Real(1.01) * (near * near)) continue;
    const BodyRow& body_a = state.bodies[a.body];
    const BodyRow& body_b = state.bodies[b.body];
    if (!model.separated.empty() && are_separated(model.separated, body_a.id, body_b.id)) continue;
    const Distance gap =
        distance(model, shape_a, {body_a.position, body_a.rotation}, shape_b, {body_b.position, body_b.rotation});
    const Real sweep = sweep_of(model, state, a.body, dt, farthest) + sweep_of(model, state, b.body, dt, farthest);
    if (gap.separation > sweep) continue;
    // Beyond the middle the way out is on the other side: that overlap is the contact solver's to undo.
    if (gap.separation < Real(-0.5) * pair_size(shape_a, shape_b)) continue;
    ImpactPair pair{};
    pair.body_a = a.body;
    pair.body_b = b.body;
    pair.shape_a = a.shape;
    pair.shape_b = b.shape;
    pair.friction = mix(settings.friction_mix, shape_a.friction, shape_b.friction);
    pair.restitution = restitution;
    pair.is_fast = fast;
    scratch.impacts.push_back(pair);
  }
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
