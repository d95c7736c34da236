// The parts of integration schemes.
// SPDX-License-Identifier: MIT
#include "engine/integrators/flow.h"

#include "engine/math/exponential.h"
#include "engine/model/bodies.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

// An impulse counts as a force up to this multiple of the velocity change by forces. The friction of a sliding body
// stays below. An impact then moves a body at most this multiple of g h^2 / 2 too far.
constexpr Real force_like = 4;

/// The acceleration by gravity, this tick's inputs and constant force elements. Requires: the body is dynamic.
[[gnu::always_inline]] inline Twist constant_acceleration(const SolvedSet& solved, std::size_t row) {
  const std::uint32_t source = solved.state.bodies[row].source;
  const BodyModel& body = solved.model.bodies[source];
  Twist acceleration{body.gravity_scale * solved.state.world.gravity, 0};
  if (!solved.tick.force.empty()) {
    acceleration.linear = acceleration.linear + body.inv_mass * solved.tick.force[row];
    acceleration.angular = body.inv_inertia * solved.tick.torque[row];
  }
  if (!solved.model.body_forces.empty()) {
    acceleration.linear = acceleration.linear + solved.model.body_forces[source].acceleration;
    acceleration.angular += solved.model.body_forces[source].angular_acceleration;
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
    if (h < 0) {  // backwards in time, damping is growth
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

void begin_motion(const State& state, MotionWorkspace& work) {
  work.previous_accelerations.clear();
  for (const AccelerationRow& row : state.accelerations)
    work.previous_accelerations.push_back({row.linear, row.angular});
  work.drift.joint_changes.clear();
  work.unconverged = 0;
}

void store_motion(const MotionWorkspace& work, State& state) {
  for (std::size_t row = 0; row < state.accelerations.size(); ++row)
    state.accelerations[row] = {stored(work.previous_accelerations[row].linear),
                                stored(work.previous_accelerations[row].angular)};
  const std::uint32_t count_left = no_reference - state.integrator.unconverged;
  state.integrator.unconverged += work.unconverged < count_left ? work.unconverged : count_left;
}

void prepare_velocity_steps(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  work.free_motion.follow(solved.model, h);
  const auto step_of = [&](std::size_t row) -> VelocityStep {
    const BodyModel& body = solved.model.bodies[solved.state.bodies[row].source];
    if (body.type != BodyType::dynamic_body) return {{0, 0, 0, 0}, {1, 1, 1, 0}};
    const FreeMotion& motion = work.free_motion[solved.state.bodies[row].source];
    const Twist acceleration = constant_acceleration(solved, row);
    const Vec2 gain = motion.linear_gain * acceleration.linear;
    return {{gain.x, gain.y, motion.angular_gain * acceleration.angular, 0},
            {motion.linear_decay, motion.linear_decay, motion.angular_decay, 0}};
  };
  work.velocity_steps.follow({solved.tick.changes.body_generation, solved.state.world.gravity, h},
                             solved.tick.changes.is_known && solved.tick.force.empty(), solved.parallel(),
                             solved.state.bodies.size(), step_of);
}

void step_velocities(const SolvedSet& solved, MotionWorkspace& work) {
  if (solved.rows.empty()) return;  // without bodies there is no first row
  const std::size_t count = solved.rows.size();
  solved.parallel().for_chunks(count, solved.parallel().chunk_size(count, 512), [&](const Chunk& chunk) {
    solved.kernels().motion.step_velocities(solved.bodies.lanes(), work.velocity_steps.rows()->gain,
                                            solved.rows.data() + chunk.begin, chunk.end - chunk.begin);
  });
  if (solved.model.position_forces == nullptr) return;
  for (Twist& acceleration : work.accelerations) acceleration = {};
  solved.model.position_forces(solved, work);
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const FreeMotion& motion = work.free_motion[solved.state.bodies[row].source];
    const Twist& acceleration = work.accelerations[row];
    body.velocity = body.velocity + motion.linear_gain * acceleration.linear;
    body.angular_velocity += motion.angular_gain * acceleration.angular;
  }
}

void move_bodies(const SolvedSet& solved, Real h) {
  const std::size_t count = solved.rows.size();
  solved.parallel().for_chunks(count, solved.parallel().chunk_size(count, 256), [&](const Chunk& chunk) {
    solved.kernels().motion.move_bodies(solved.bodies.lanes(), solved.rows.data() + chunk.begin,
                                        chunk.end - chunk.begin, dummy_body(solved.bodies),
                                        dummy_sink(solved.bodies, chunk.index), h);
  });
}

bool bodies_step_alone(const Model& model) {
  return model.scene.settings.integrator == IntegratorKind::semi_implicit_euler && model.position_forces == nullptr &&
         !model.has_velocity_forces;
}

void integrate_freely(const SolvedSet& solved, const MotionWorkspace& work) {
  constexpr std::size_t block_size = 128;  // bodies: 12 KB in f32
  const std::size_t count = solved.rows.size();
  solved.parallel().for_chunks(count, solved.parallel().chunk_size(count, block_size), [&](const Chunk& chunk) {
    const MotionKernels& motion = solved.kernels().motion;
    Real* bodies = solved.bodies.lanes();
    for (std::size_t first = chunk.begin; first < chunk.end; first += block_size) {
      const std::uint32_t* rows = solved.rows.data() + first;
      const std::size_t row_count = chunk.end - first < block_size ? chunk.end - first : block_size;
      for (int substep = 0; substep < solved.set.substeps; ++substep) {
        motion.step_velocities(bodies, work.velocity_steps.rows()->gain, rows, row_count);
        motion.move_bodies(bodies, rows, row_count, dummy_body(solved.bodies), dummy_sink(solved.bodies, chunk.index),
                           solved.set.h);
      }
    }
  });
}

void prepare_constant_accelerations(const SolvedSet& solved, MotionWorkspace& work) {
  work.constant_accelerations.resize(solved.state.bodies.size());
  for (std::size_t row = 0; row < solved.state.bodies.size(); ++row) {
    const bool moves = solved.model.bodies[solved.state.bodies[row].source].type == BodyType::dynamic_body;
    work.constant_accelerations[row] = moves ? constant_acceleration(solved, row) : Twist{};
  }
}

void total_accelerations(const SolvedSet& solved, MotionWorkspace& work, Real drag_rate_max) {
  for (Twist& acceleration : work.accelerations) acceleration = {};
  for (const std::uint32_t row : solved.rows) {
    const BodyModel& constants = solved.model.bodies[solved.state.bodies[row].source];
    if (constants.type != BodyType::dynamic_body) continue;
    const MovingBody& body = solved.bodies.records[row];
    const Twist& constant = work.constant_accelerations[row];
    work.accelerations[row] = {constant.linear - constants.linear_damping * body.velocity,
                               constant.angular - constants.angular_damping * body.angular_velocity};
  }
  if (solved.model.position_forces != nullptr) solved.model.position_forces(solved, work);
  add_velocity_forces(solved, work, drag_rate_max);
}

void save_start(const SolvedSet& solved, MotionWorkspace& work) {
  work.stages.resize(solved.state.bodies.size());
  work.drift.offsets.resize(solved.state.bodies.size());
  work.drift.predicted.resize(solved.state.bodies.size());
  for (const std::uint32_t row : solved.rows) work.stages[row] = {solved.bodies.records[row], {}, {}};
}

Twist drift_velocity(const MotionWorkspace& work, std::size_t row, const MovingBody& body, Real share) {
  const Twist& predicted = work.drift.predicted[row];
  const Twist& offset = work.drift.offsets[row];
  Vec2 change = body.velocity - predicted.linear;
  Real spin_change = body.angular_velocity - predicted.angular;
  if (!work.drift.joint_changes.empty()) {
    change = change - work.drift.joint_changes[row].linear;
    spin_change -= work.drift.joint_changes[row].angular;
  }
  Vec2 changed = share * change;
  Real spun = share * spin_change;
  const Real size = length(changed);
  const Real limit = force_like * length(offset.linear);
  if (size > limit) changed = (limit / size) * changed;
  const Real spin_limit = force_like * absolute(offset.angular);
  spun = smaller(larger(spun, -spin_limit), spin_limit);
  return {(body.velocity - offset.linear) - changed, (body.angular_velocity - offset.angular) - spun};
}

void move_bodies_by_drift(const SolvedSet& solved, MotionWorkspace& work, Real h, Real share) {
  for (const std::uint32_t row : solved.rows) {
    MovingBody& body = solved.bodies.records[row];
    const Twist drift = drift_velocity(work, row, body, share);
    body.delta_position = body.delta_position + h * drift.linear;
    body.delta_rotation = rotation_by(h * drift.angular) * body.delta_rotation;
  }
}

void drift_on_mean(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  move_bodies_by_drift(solved, work, h, share_of_mean);
}

void drift_on_start(const SolvedSet& solved, MotionWorkspace& work, Real h) {
  move_bodies_by_drift(solved, work, h, share_of_start);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
