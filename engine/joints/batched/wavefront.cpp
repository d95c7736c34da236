// The wavefront sweep over joints.
// SPDX-License-Identifier: MIT
#include "engine/joints/batched/wavefront.h"

#include <algorithm>
#include <array>

#include "engine/integrators/flow.h"
#include "engine/model/bodies.h"
#include "engine/model/model.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A pass over all joints, with the step of all bodies that comes before it.
enum class Pass : std::uint8_t { save_velocities, warm_start, warm_start_again, solve, relax };

void step_bodies(Scratch& scratch, Pass pass, std::uint32_t level, Real h) {
  const LevelSchedule& schedule = scratch.caches.joints.schedule();
  const std::uint32_t* rows = schedule.body_rows.data() + schedule.level_bodies[level];
  const std::size_t count = schedule.level_bodies[level + 1] - schedule.level_bodies[level];
  if (count == 0) return;
  const MotionKernels& motion = scratch.kernels->motion;
  Real* bodies = &scratch.bodies.data()->velocity.x;
  if (pass == Pass::warm_start || pass == Pass::warm_start_again)
    motion.step_velocities(bodies, scratch.caches.velocity_steps.rows()->gain, rows, count);
  if (pass == Pass::relax) motion.move_bodies(bodies, rows, count, dummy_body(scratch), dummy_sink(scratch, level), h);
}

void do_level(Scratch& scratch, Pass pass, std::size_t front, std::uint32_t level, Real h) {
  step_bodies(scratch, pass, level, h);
  for (const JointRange& range : scratch.caches.joints.ranges_of_level(level)) {
    switch (pass) {
      case Pass::save_velocities:
        save_velocities_of(scratch, range);
        break;
      case Pass::warm_start:
        warm_start_range(scratch, range, Poses::moved, front);
        break;
      case Pass::warm_start_again:
        warm_start_range(scratch, range, Poses::unmoved, front);
        break;
      case Pass::solve:
        solve_range(scratch, range, h, Bias::on, front);
        break;
      case Pass::relax:
        solve_range(scratch, range, h, Bias::off, front);
        break;
    }
  }
}

/// Calls body(first, last) for the batches of plain revolute joints of a level.
template <typename Body>
void for_revolutes_of(const JointPlan& plan, std::uint32_t level, const Body& body) {
  for (const JointRange& range : plan.ranges_of_level(level))
    if (range.path == JointPath::revolute) body(range.first, range.last);
}

constexpr std::size_t front_count_max = 64;
constexpr std::size_t levels_per_chunk_least = 8;

/// The passes of all substeps.
struct Passes {
  bool has_springs = false;
  std::size_t per_substep;
  std::size_t count;

  Passes(const JointPlan& plan, int substeps) {
    for (const JointRange& range : plan.ranges()) has_springs |= range.springs;
    per_substep = has_springs ? 4 : 3;
    count = per_substep * static_cast<std::size_t>(substeps);
  }

  Pass at(std::size_t i) const {
    constexpr Pass order[] = {Pass::save_velocities, Pass::warm_start, Pass::solve, Pass::relax};
    const Pass pass = order[i % per_substep + (has_springs ? 0 : 1)];
    return pass == Pass::warm_start && i >= per_substep ? Pass::warm_start_again : pass;
  }

  /// The i-th pass in a front that begins at `first`: each front computes the constraints for itself.
  Pass of_front(std::size_t i, std::size_t first) const {
    if (at(i) != Pass::warm_start_again) return at(i);
    while (first < i && at(first) == Pass::save_velocities) ++first;
    return first == i ? Pass::warm_start : Pass::warm_start_again;
  }

  /// The approximate cost of a pass.
  std::size_t cost(std::size_t i) const {
    constexpr std::size_t costs[] = {1, 5, 2, 3, 5};
    return costs[static_cast<std::size_t>(at(i))];
  }
  /// The end of the passes from `first` on that have the cost of `share` of `share_count` equal shares.
  std::size_t up_to_share(std::size_t first, std::size_t share, std::size_t share_count) const {
    std::size_t total = 0;
    for (std::size_t i = 0; i < count; ++i) total += cost(i);
    std::size_t done = 0;
    std::size_t end = 0;
    while (end < count && (end < first || (2 * done + cost(end)) * share_count <= 2 * total * share))
      done += cost(end++);
    return end;
  }
};

}  // namespace

bool allows_wavefront(const Model& model) {
  return model.scene.settings.solver == SolverKind::tgs_soft && bodies_step_alone(model) && model.light_bodies.empty();
}

bool is_left_to_joints(const Scratch& scratch, const SolverSet& set) {
  return set.first_contact == set.contact_end && scratch.impacts.empty() && scratch.mouse_joints.empty() &&
         !scratch.injected;
}

std::size_t front_count(const Scratch& scratch) {
  const std::size_t width = scratch.parallel.runner == nullptr ? 1 : scratch.parallel.runner->width();
  return std::min(width, front_count_max);
}

void separate_level_sinks(Scratch& scratch) {
  const JointPlan& plan = scratch.caches.joints;
  const std::uint32_t needed = dummy_sink(scratch, plan.level_count());
  if (scratch.bodies.size() < needed) scratch.bodies.resize(needed);
  for (const JointRange& range : plan.ranges()) {
    if (range.path != JointPath::scalar) continue;
    for (std::uint32_t i = range.first; i < range.last; ++i) {
      JointWork& joint = scratch.joints[i];
      if (joint.write_a == dummy_sink(scratch)) joint.write_a = dummy_sink(scratch, range.level);
      if (joint.write_b == dummy_sink(scratch)) joint.write_b = dummy_sink(scratch, range.level);
    }
  }
}

void solve_wavefront(State& state, Scratch& scratch, const SolverSet& set) {
  const JointPlan& plan = scratch.caches.joints;
  const Passes passes(plan, set.substeps);
  const std::size_t distance = plan.schedule().distance;
  const std::size_t pass_front_count = front_count(scratch);
  std::array<std::size_t, front_count_max + 1> first{};  // the first pass of each front
  std::size_t longest = 0;
  for (std::size_t front = 1; front <= pass_front_count; ++front) {
    first[front] = passes.up_to_share(first[front - 1], front, pass_front_count);
    // A front does not begin with a pass that requires another one before it (revolute_lanes.h).
    if (first[front] < passes.count && passes.at(first[front]) == Pass::solve) ++first[front];
    longest = std::max(longest, first[front] - first[front - 1]);
  }
  if (longest == 0) return;
  const auto fill = [&](std::uint32_t level) {
    for_revolutes_of(plan, level,
                     [&](std::size_t begin, std::size_t end) { fill_revolutes(state, scratch, begin, end, set.h); });
  };
  const auto store = [&](std::uint32_t level) {
    for_revolutes_of(plan, level,
                     [&](std::size_t begin, std::size_t end) { store_revolutes(scratch, state, begin, end, set.h); });
  };
  const std::uint32_t filled_first = plan.level_count() / 2;
  scratch.parallel.for_chunks(filled_first, scratch.parallel.chunk_size(filled_first, levels_per_chunk_least, 1),
                              [&](const Chunk& chunk) {
                                for (std::size_t level = chunk.begin; level < chunk.end; ++level)
                                  fill(static_cast<std::uint32_t>(level));
                              });
  const Lines lines{pass_front_count + 2, plan.level_count() + distance * (longest - 1), distance * longest};
  scratch.parallel.for_lines(lines, [&](std::size_t front, std::size_t step) {
    const auto level = static_cast<std::uint32_t>(step);
    if (front == 0) {
      if (level >= filled_first && level < plan.level_count()) fill(level);
    } else if (front == lines.line_count - 1) {
      if (level < plan.level_count()) store(level);
    } else {
      for (std::size_t i = first[front - 1]; i < first[front]; ++i) {
        const std::size_t behind = (i - first[front - 1]) * distance;
        if (step < behind || step - behind >= plan.level_count()) continue;
        do_level(scratch, passes.of_front(i, first[front - 1]), front - 1, static_cast<std::uint32_t>(step - behind),
                 set.h);
      }
    }
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
