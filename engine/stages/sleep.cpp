// Measures the idle time of each body.
// SPDX-License-Identifier: MIT
#include "engine/stages/stages.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

void measure_idle_time(const Model& model, State& state, TickLists& tick, Real dt) {
  const Real speed_max = static_cast<Real>(model.scene.settings.sleep->speed_max);
  const std::size_t count = state.bodies.size();
  tick.parallel.for_chunks(count, tick.parallel.chunk_size(count, 256), [&](const Chunk& chunk) {
    for (std::size_t row = chunk.begin; row < chunk.end; ++row) {
      const BodyRow& body = state.bodies[row];
      const BodyModel& constants = model.bodies[body.source];
      SleepRow& sleep = state.sleep[row];
      if (constants.type != BodyType::dynamic_body || sleep.asleep != 0) continue;
      // Upper bounds for all points of the body. Overlaps are pushed out without a lasting velocity.
      const Real speed = length(body.velocity) + magnitude(body.angular_velocity) * constants.extent;
      const bool is_calm = speed <= speed_max && tick.travel[row] <= speed_max * dt;
      sleep.calm = constants.can_sleep && is_calm ? sleep.calm + dt : Real(0);
    }
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
