// The parts of integration schemes.
// SPDX-License-Identifier: MIT
#include "engine/integrators/flow.h"

#include "engine/math/exponential.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// An impulse up to this many times as large as the velocity change by forces counts as a force. This is enough for the
// friction of a sliding body. An impact then moves a body at most this times g h^2 / 2 too far.
constexpr Real force_like = 4;

/// Of gravity, this tick's inputs and constant force elements. Requires: the body is dynamic.
[[gnu::always_inline]] inline Twist constant_acceleration(const Model& model, const State& state,
                                                          const Scratch& scratch, std::size_t row) {
  const std::uint32_t source = state.bodies[row].source;
  const BodyModel& body = model.bodies[source];
  Twist acceleration{body.gravity_scale * state.world.gravity, 0};
  if (!scratch.force.empty()) {
    acceleration.linear = acceleration.linear + body.inv_mass * scratch.force[row];
    acceleration.angular = body.inv_inertia * scratch.torque[row];
  }
  if (!model.body_forces.empty()) {
    acceleration.linear = acceleration.linear + model.body_forces[source].acceleration;
    acceleration.angular += model.body_forces[source].angular_acceleration;
  }
  return acceleration;
}

}  // namespace

void FreeMotionCache::rebuild(const Model& model, Real h) {
  rows_.clear();
  const double step = static_cast<double>(h < 0 ? -h : h);
  for (const BodyModel& body : model.bodies) {
    Decay linear = decay_over(step * static_cast<double>(body.linear_damping));
    Decay angular = decay_over(step * static_cast<double>(body.angular_damping));
    if (h < 0) {  // backwards in time damping is growth
      linear = {1 / linear.factor, linear.mean / linear.factor};
      angular = {1 / angular.factor, angular.mean / angular.factor};
    }
    rows_.push_back({static_cast<Real>(linear.factor), static_cast<Real>(linear.mean * static_cast<double>(h)),
                     static_cast<Real>(angular.factor), static_cast<Real>(angular.mean * static_cast<double>(h))});
  }
  h_ = h;
}

void FreeMotionCache::follow(const Model& model, Real h) {
  const bool is_hit = valid_for(h);
  count_use(is_hit);
  if (!is_hit) rebuild(model, h);
}

void prepare_velocity_steps(const Model& model, const State& state, Scratch& scratch, Real h) {
  scratch.caches.free_motion.follow(model, h);
  const auto step_of = [&](std::size_t row) -> VelocityStep {
    const BodyModel& body = model.bodies[state.bodies[row].source];
    if (body.type != BodyType::dynamic_body) return {{0, 0, 0, 0}, {1, 1, 1, 0}};
    const FreeMotion& motion = scratch.caches.free_motion[state.bodies[row].source];
    const Twist acceleration = constant_acceleration(model, state, scratch, row);
    const Vec2 gain = motion.linear_gain * acceleration.linear;
    return {{gain.x, gain.y, motion.angular_gain * acceleration.angular, 0},
            {motion.linear_decay, motion.linear_decay, motion.angular_decay, 0}};
  };
  scratch.caches.velocity_steps.follow({scratch.changes.body_generation, state.world.gravity, h},
                                       scratch.changes.is_known && scratch.force.empty(), scratch.parallel,
                                       state.bodies.size(), step_of);
}

void step_velocities(const Model& model, const State& state, Scratch& scratch) {
  if (scratch.moving_rows.empty()) return;  // without bodies there is no first row
  const std::size_t count = scratch.moving_rows.size();
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, 512), [&](const Chunk& chunk) {
    scratch.kernels->motion.step_velocities(&scratch.bodies.data()->velocity.x,
                                            scratch.caches.velocity_steps.rows()->gain,
                                            scratch.moving_rows.data() + chunk.begin, chunk.end - chunk.begin);
  });
  if (model.position_forces == nullptr) return;
  for (Twist& acceleration : scratch.accelerations) acceleration = {};
  model.position_forces(model, state, scratch);
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    const FreeMotion& motion = scratch.caches.free_motion[state.bodies[row].source];
    const Twist& acceleration = scratch.accelerations[row];
    body.velocity = body.velocity + motion.linear_gain * acceleration.linear;
    body.angular_velocity += motion.angular_gain * acceleration.angular;
  }
}

void move_bodies(Scratch& scratch, Real h) {
  const std::size_t count = scratch.moving_rows.size();
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, 256), [&](const Chunk& chunk) {
    scratch.kernels->motion.move_bodies(&scratch.bodies.data()->velocity.x, scratch.moving_rows.data() + chunk.begin,
                                        chunk.end - chunk.begin, dummy_body(scratch), dummy_sink(scratch, chunk.index),
                                        h);
  });
}

bool bodies_step_alone(const Model& model) {
  return model.scene.settings.integrator == IntegratorKind::semi_implicit_euler && model.position_forces == nullptr &&
         !model.has_velocity_forces;
}

void integrate_freely(Scratch& scratch, Real h, int substeps) {
  constexpr std::size_t block_size = 128;  // bodies: 12 KB in f32
  const std::size_t count = scratch.moving_rows.size();
  scratch.parallel.for_chunks(count, scratch.parallel.chunk_size(count, block_size), [&](const Chunk& chunk) {
    const MotionKernels& motion = scratch.kernels->motion;
    Real* bodies = &scratch.bodies.data()->velocity.x;
    for (std::size_t first = chunk.begin; first < chunk.end; first += block_size) {
      const std::uint32_t* rows = scratch.moving_rows.data() + first;
      const std::size_t row_count = chunk.end - first < block_size ? chunk.end - first : block_size;
      for (int substep = 0; substep < substeps; ++substep) {
        motion.step_velocities(bodies, scratch.caches.velocity_steps.rows()->gain, rows, row_count);
        motion.move_bodies(bodies, rows, row_count, dummy_body(scratch), dummy_sink(scratch, chunk.index), h);
      }
    }
  });
}

void prepare_constant_accelerations(const Model& model, const State& state, Scratch& scratch) {
  scratch.constant_accelerations.resize(state.bodies.size());
  for (std::size_t row = 0; row < state.bodies.size(); ++row) {
    const bool moves = model.bodies[state.bodies[row].source].type == BodyType::dynamic_body;
    scratch.constant_accelerations[row] = moves ? constant_acceleration(model, state, scratch, row) : Twist{};
  }
}

void total_accelerations(const Model& model, const State& state, Scratch& scratch, Real drag_rate_max) {
  for (Twist& acceleration : scratch.accelerations) acceleration = {};
  for (const std::uint32_t row : scratch.moving_rows) {
    const BodyModel& constants = model.bodies[state.bodies[row].source];
    if (constants.type != BodyType::dynamic_body) continue;
    const MovingBody& body = scratch.bodies[row];
    const Twist& constant = scratch.constant_accelerations[row];
    scratch.accelerations[row] = {constant.linear - constants.linear_damping * body.velocity,
                                  constant.angular - constants.angular_damping * body.angular_velocity};
  }
  if (model.position_forces != nullptr) model.position_forces(model, state, scratch);
  add_velocity_forces(model, state, scratch, drag_rate_max);
}

void save_start(const State& state, Scratch& scratch) {
  scratch.stages.resize(state.bodies.size());
  scratch.velocity_offsets.resize(state.bodies.size());
  scratch.predicted.resize(state.bodies.size());
  for (const std::uint32_t row : scratch.moving_rows) scratch.stages[row] = {scratch.bodies[row], {}, {}};
}

void move_bodies_by_drift(Scratch& scratch, Real h, Real share) {
  for (const std::uint32_t row : scratch.moving_rows) {
    MovingBody& body = scratch.bodies[row];
    const Twist& predicted = scratch.predicted[row];
    const Twist& offset = scratch.velocity_offsets[row];
    Vec2 changed = share * (body.velocity - predicted.linear);
    Real spun = share * (body.angular_velocity - predicted.angular);
    const Real size = length(changed);
    const Real limit = force_like * length(offset.linear);
    if (size > limit) changed = (limit / size) * changed;
    const Real spin_limit = force_like * absolute(offset.angular);
    spun = smaller(larger(spun, -spin_limit), spin_limit);
    body.delta_position = body.delta_position + h * ((body.velocity - offset.linear) - changed);
    body.delta_rotation = rotation_by(h * ((body.angular_velocity - offset.angular) - spun)) * body.delta_rotation;
  }
}

void drift_on_mean(const Model&, const State&, Scratch& scratch, Real h) {
  move_bodies_by_drift(scratch, h, Real(0.5));
}

void drift_on_start(const Model&, const State&, Scratch& scratch, Real h) {
  move_bodies_by_drift(scratch, h, Real(1));
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
