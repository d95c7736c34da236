// The wavefront sweep over joints.
// SPDX-License-Identifier: MIT
#include "engine/joints/batched/wavefront.h"

#include <algorithm>
#include <array>

#include "engine/integrators/flow.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {
namespace {

/// A pass over all joints, together with the preceding step of all bodies.
enum class Pass : std::uint8_t { save_velocities, warm_start, warm_start_again, solve, relax };

void step_bodies(const SolvedSet& solved, const LevelSchedule& schedule, const MotionWorkspace& steps, Pass pass,
                 std::uint32_t level) {
  const std::uint32_t* rows = schedule.body_rows.data() + schedule.level_bodies[level];
  const std::size_t count = schedule.level_bodies[level + 1] - schedule.level_bodies[level];
  if (count == 0) return;
  const MotionKernels& motion = solved.kernels().motion;
  Real* bodies = solved.bodies.lanes();
  if (pass == Pass::warm_start || pass == Pass::warm_start_again)
    motion.step_velocities(bodies, steps.velocity_steps.rows()->gain, rows, count);
  if (pass == Pass::relax)
    motion.move_bodies(bodies, rows, count, dummy_body(solved.bodies), dummy_sink(solved.bodies, level), solved.set.h);
}

void do_level(const SolvedSet& solved, JointWorkspace& work, const MotionWorkspace& steps, Pass pass, std::size_t front,
              std::uint32_t level) {
  step_bodies(solved, work.plan.schedule(), steps, pass, level);
  for (const JointRange& range : work.plan.ranges_of_level(level)) {
    switch (pass) {
      case Pass::save_velocities:
        save_velocities_of(solved, work, range);
        break;
      case Pass::warm_start:
        warm_start_range(solved, work, range, Poses::moved, front);
        break;
      case Pass::warm_start_again:
        warm_start_range(solved, work, range, Poses::unmoved, front);
        break;
      case Pass::solve:
        solve_range(solved, work, range, Bias::on, front);
        break;
      case Pass::relax:
        solve_range(solved, work, range, Bias::off, front);
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

  /// The i-th pass in a front that begins at `first`: each front computes its own constraints.
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
  /// The end of the passes from `first` on whose cost is share `share` of `share_count` equal shares.
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

bool is_left_to_joints(const SolvedSet& solved, const std::vector<MouseJoint>& mouse_joints) {
  return solved.contacts().empty() && solved.tick.impacts.empty() && mouse_joints.empty() && !solved.tick.injected;
}

std::size_t front_count(const Parallel& parallel) {
  const std::size_t width = parallel.runner == nullptr ? 1 : parallel.runner->width();
  return std::min(width, front_count_max);
}

void separate_level_sinks(const SolvedSet& solved, JointWorkspace& work) {
  const JointPlan& plan = work.plan;
  SolverBodies& bodies = solved.bodies;
  const std::uint32_t needed = dummy_sink(bodies, plan.level_count());
  if (bodies.records.size() < needed) bodies.records.resize(needed);
  for (const JointRange& range : plan.ranges()) {
    if (range.path != JointPath::scalar) continue;
    for (std::uint32_t i = range.first; i < range.last; ++i) {
      JointWork& joint = work.joints[i];
      if (joint.write_a == dummy_sink(bodies)) joint.write_a = dummy_sink(bodies, range.level);
      if (joint.write_b == dummy_sink(bodies)) joint.write_b = dummy_sink(bodies, range.level);
    }
  }
}

void solve_wavefront(const SolvedSet& solved, JointWorkspace& work, const MotionWorkspace& motion, State& state) {
  const JointPlan& plan = work.plan;
  const Passes passes(plan, solved.set.substeps);
  const std::size_t distance = plan.schedule().distance;
  const std::size_t pass_front_count = front_count(solved.parallel());
  std::array<std::size_t, front_count_max + 1> first{};  // the first pass of each front
  std::size_t longest = 0;
  for (std::size_t front = 1; front <= pass_front_count; ++front) {
    first[front] = passes.up_to_share(first[front - 1], front, pass_front_count);
    // A front does not begin with a pass that requires another pass before it (revolute_lanes.h).
    if (first[front] < passes.count && passes.at(first[front]) == Pass::solve) ++first[front];
    longest = std::max(longest, first[front] - first[front - 1]);
  }
  if (longest == 0) return;
  const auto fill = [&](std::uint32_t level) {
    for_revolutes_of(plan, level,
                     [&](std::size_t begin, std::size_t end) { fill_revolutes(solved, work, begin, end); });
  };
  const auto store = [&](std::uint32_t level) {
    for_revolutes_of(plan, level, [&](std::size_t begin, std::size_t end) {
      store_revolutes(work.revolutes, begin, end, solved.set.h, state);
    });
  };
  const std::uint32_t filled_first = plan.level_count() / 2;
  solved.parallel().for_chunks(filled_first, solved.parallel().chunk_size(filled_first, levels_per_chunk_least, 1),
                               [&](const Chunk& chunk) {
                                 for (std::size_t level = chunk.begin; level < chunk.end; ++level)
                                   fill(static_cast<std::uint32_t>(level));
                               });
  const Lines lines{pass_front_count + 2, plan.level_count() + distance * (longest - 1), distance * longest};
  solved.parallel().for_lines(lines, [&](std::size_t front, std::size_t step) {
    const auto level = static_cast<std::uint32_t>(step);
    if (front == 0) {
      if (level >= filled_first && level < plan.level_count()) fill(level);
    } else if (front == lines.line_count - 1) {
      if (level < plan.level_count()) store(level);
    } else {
      for (std::size_t i = first[front - 1]; i < first[front]; ++i) {
        const std::size_t behind = (i - first[front - 1]) * distance;
        if (step < behind || step - behind >= plan.level_count()) continue;
        do_level(solved, work, motion, passes.of_front(i, first[front - 1]), front - 1,
                 static_cast<std::uint32_t>(step - behind));
      }
    }
  });
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
