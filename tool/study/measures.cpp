// Measures a run: time of the steps, energy, momentum, overlaps, joint gaps.
// SPDX-License-Identifier: MIT
#include "tool/study/measures.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace ticktrue::tool {

using engine::BodyReport;
using engine::BodyType;
using engine::Joint;
using engine::Point;

double kinetic_energy(const Bodies& bodies) {
  double sum = 0;
  for (const BodyReport& body : bodies)
    sum += 0.5 * body.mass * (body.velocity.x * body.velocity.x + body.velocity.y * body.velocity.y) +
           0.5 * body.inertia * body.angular_velocity * body.angular_velocity;
  return sum;
}

double energy_of(const engine::Scene& scene, const Bodies& bodies) {
  double sum = kinetic_energy(bodies);
  for (const BodyReport& body : bodies) {
    const double scale = body.id < scene.bodies.size() ? scene.bodies[body.id].gravity_scale : 1;
    sum -= body.mass * scale * (scene.gravity.x * body.center.x + scene.gravity.y * body.center.y);
  }
  return sum;
}

Point momentum_of(const Bodies& bodies) {
  Point sum;
  for (const BodyReport& body : bodies) {
    sum.x += body.mass * body.velocity.x;
    sum.y += body.mass * body.velocity.y;
  }
  return sum;
}

double deepest_overlap(const std::vector<engine::ContactReport>& contacts) {
  double deepest = 0;
  for (const engine::ContactReport& contact : contacts)
    for (int i = 0; i < contact.point_count; ++i) deepest = std::max(deepest, -contact.separation[i]);
  return deepest;
}

double largest(const std::vector<double>& values) {
  double out = 0;
  for (const double value : values) out = std::max(out, value);
  return out;
}

int substeps_most(const engine::Engine& engine) {
  const StateView& view = engine.state();
  const auto table = view.schema->find_table("substeps");
  if (!table) return 0;
  std::uint32_t most = 0;
  const TableSchema& schema = view.schema->tables[*table];
  for (const Column& column : schema.columns) {
    if (column.name != "count") continue;
    for (std::size_t row = 0; row < view.tables[*table].row_count; ++row) {
      std::uint32_t value = 0;
      const std::uint8_t* at = view.tables[*table].data + row * schema.row_size + column.offset;
      std::copy(at, at + sizeof value, reinterpret_cast<std::uint8_t*>(&value));
      most = std::max(most, value);
    }
  }
  return static_cast<int>(most);
}

bool all_finite(const Bodies& bodies) {
  return std::all_of(bodies.begin(), bodies.end(), [](const BodyReport& body) {
    return std::isfinite(body.center.x) && std::isfinite(body.center.y) && std::isfinite(body.velocity.x) &&
           std::isfinite(body.velocity.y) && std::isfinite(body.angle) && std::isfinite(body.angular_velocity);
  });
}

double speed_of(const BodyReport& body) {
  return std::hypot(body.velocity.x, body.velocity.y);
}

double fastest(const Bodies& bodies) {
  double out = 0;
  for (const BodyReport& body : bodies)
    if (body.type == BodyType::dynamic_body) out = std::max(out, speed_of(body));
  return out;
}

Result<Run> Run::make(const engine::Scene& scene, const engine::EngineOptions& options) {
  auto made = engine::make_engine(scene, options);
  if (!made) return made.error();
  Run run;
  run.engine_ = std::move(*made);
  return run;
}

double computed_s() {
#if defined(CLOCK_THREAD_CPUTIME_ID)
  timespec now{};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now) == 0)
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
#endif
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Status Run::advance(std::uint64_t tick_count, double dt) {
  const TickInput input{dt > 0 ? dt : engine_->scene().settings.dt, {}};
  const double start = computed_s();
  for (std::uint64_t i = 0; i < tick_count; ++i)
    if (Status did = engine_->step(input, nullptr); !did) return did;
  step_time_s_ += computed_s() - start;
  return {};
}

Result<double> Run::step(const TickInput& input) {
  const double start = computed_s();
  if (const Status did = engine_->step(input, nullptr); !did) return did.error();
  const double seconds = computed_s() - start;
  step_time_s_ += seconds;
  return seconds;
}

SampleSpread spread_of(std::vector<double> samples) {
  std::sort(samples.begin(), samples.end());
  const auto at = [&](double share) {
    const double place = share * static_cast<double>(samples.size() - 1);
    const std::size_t below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, samples.size() - 1);
    return samples[below] + (place - static_cast<double>(below)) * (samples[above] - samples[below]);
  };
  return {samples.front(), at(0.5), at(0.75) - at(0.25)};
}

}  // namespace ticktrue::tool
