// Runs a scene in both engines over an ensemble of jittered starts, on all threads, and judges the outcome.
// SPDX-License-Identifier: MIT
#include "tool/crosscheck/crosscheck.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

#include "base/limits.h"
#include "base/parallel/jobs.h"
#include "tool/box2d/box2d_peer.h"

namespace ticktrue::tool {
namespace {

using engine::Scene;
using engine::SolverKind;

constexpr double jitter_per_size = 0.001;
constexpr double contact_window_s = 1;       // contacts are averaged over the last second,
constexpr std::uint64_t contact_stride = 4;  // at every fourth tick
// Smaller steps distinguish a difference of physics from missing convergence. In Box2D, smaller steps help far more
// than iterations.
constexpr std::array<int, 2> finer_steps_per_tick{4, 16};
constexpr std::array<int, 2> own_substep_factors{2, 4};  // the same for this engine
constexpr std::size_t finest_body_count_max = 500;       // limits the run time of the finest steps

// A number in [-1, 1) for a place in the sequence of a seed: one round of splitmix64.
// Source: Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014.
double jitter_of(std::uint32_t seed, std::uint64_t place) {
  std::uint64_t z = (static_cast<std::uint64_t>(seed) << 32) + place;
  z = (z + 1) * 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-52 - 1;
}

// One run: of the engine with a solver, or of the peer.
struct Job {
  Scene scene;
  bool is_peer = false;
  int steps_per_tick = 1;   // more: smaller steps, but the same ticks
  bool match_skin = false;  // of the peer
};

struct Outcome {
  CrosscheckRun run;
  std::size_t clamped_tick = 0;  // of Box2D
  double length_scale = 1;
  double skin = 0;
  std::size_t thin_shape_count = 0;
};

class Runner {
 public:
  Runner(const CrosscheckLayout& layout, std::uint64_t tick_count, const CrosscheckOptions& options)
      : layout_(layout), tick_count_(tick_count), options_(options) {}

  void expect_jobs(std::size_t count) { total_ += count * tick_count_; }

  /// The outcome of each job, in order. If jobs fail, the first error in that order.
  Result<std::vector<Outcome>> run(const std::vector<Job>& jobs) {
    std::vector<std::optional<Result<Outcome>>> results(jobs.size());
    const Status ran =
        run_jobs(jobs.size(), options_.thread_count, [&](std::size_t i) { results[i] = run_job(jobs[i]); });
    if (!ran) return ran.error();

    std::vector<Outcome> outcomes;
    for (std::optional<Result<Outcome>>& result : results) {
      if (!*result) return result->error();
      outcomes.push_back(std::move(**result));
    }
    return outcomes;
  }

 private:
  Result<Outcome> run_job(const Job& job) {
    const engine::Settings& settings = job.scene.settings;
    Outcome outcome;
    if (job.is_peer) {
      const PeerInfo& info = engine::info_of(peers, options_.peer);
      const PeerRun run{job.steps_per_tick, options_.match_skin || job.match_skin, tick_count_, window_of(settings.dt),
                        contact_stride};
      Result<std::unique_ptr<Box2dPeer>> peer = info.make(job.scene, run);
      if (!peer) return peer.error();
      outcome.skin = (*peer)->skin();
      outcome.length_scale = (*peer)->length_scale();
      outcome.thin_shape_count = (*peer)->thin_shape_count();
      CrosscheckMeasure measure(layout_, info.contact_hertz(settings.dt / job.steps_per_tick), outcome.skin);
      watch(**peer, settings.dt, measure, [&] {
        (*peer)->step();
        return true;
      });
      outcome.clamped_tick = (*peer)->clamped_tick();
      outcome.run = measure.finish();
      return outcome;
    }
    Scene scene = job.scene;
    scene.settings.dt /= job.steps_per_tick;
    Result<std::unique_ptr<engine::Engine>> made = engine::make_engine(scene);
    if (!made) return made.error();
    engine::Engine& engine = **made;
    CrosscheckMeasure measure(layout_, contact_hertz(scene.settings), 0);
    const TickInput input{scene.settings.dt, {}};
    Status did;
    watch(engine, settings.dt, measure, [&] {
      for (int i = 0; i < job.steps_per_tick; ++i) {
        did = engine.accept(input);
        if (did) did = engine.step(input, nullptr);
        if (!did) return false;
      }
      return true;
    });
    if (!did) return did.error();
    outcome.run = measure.finish();
    return outcome;
  }

  // Ticks before the end in which contacts are averaged.
  static std::uint64_t window_of(double dt) {
    return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(contact_window_s / dt));
  }

  // Steps the world and measures it: bodies after every tick, contacts at intervals in the last second.
  template <typename World, typename Step>
  void watch(const World& world, double dt, CrosscheckMeasure& measure, Step step) {
    const std::uint64_t window = window_of(dt);
    for (std::uint64_t tick = 1; tick <= tick_count_; ++tick) {
      if (!step()) return;
      const std::uint64_t left = tick_count_ - tick;
      const double time_s = static_cast<double>(tick) * dt;
      if (left < window && left % contact_stride == 0) {
        const std::vector<engine::ContactReport> contacts = world.contacts();
        measure.add(time_s, world.bodies(), &contacts);
      } else {
        measure.add(time_s, world.bodies(), nullptr);
      }
      count_tick();
    }
  }

  void count_tick() {
    const std::uint64_t done = done_.fetch_add(1) + 1;
    if (!options_.progress || done % 64 != 0) return;
    if (is_reporting_.exchange(1) != 0) return;  // another thread is reporting the progress
    options_.progress(done, total_);
    is_reporting_ = 0;
  }

  // docs/physics.md, "tgs_soft": contact stiffness rises with the substep rate.
  static double contact_hertz(const engine::Settings& settings) {
    return settings.solver == SolverKind::tgs_soft ? 0.125 * settings.substeps / settings.dt : 0;
  }

  const CrosscheckLayout& layout_;
  std::uint64_t tick_count_;
  const CrosscheckOptions& options_;
  std::uint64_t total_ = 0;
  std::atomic<std::uint64_t> done_{0};
  std::atomic<std::uint32_t> is_reporting_{0};  // a 32-bit word: RISC-V has no atomic exchange of bytes
};

std::vector<CrosscheckRun> runs_of(const std::vector<Outcome>& outcomes, std::size_t first, std::size_t count) {
  std::vector<CrosscheckRun> runs;
  for (std::size_t i = first; i < first + count; ++i) runs.push_back(outcomes[i].run);
  return runs;
}

std::size_t stood_count(const std::vector<CrosscheckRun>& runs) {
  return static_cast<std::size_t>(std::count_if(runs.begin(), runs.end(), [](const auto& run) { return run.stood; }));
}

bool has_difference(const std::vector<CriterionResult>& rows) {
  return std::any_of(rows.begin(), rows.end(), [](const auto& row) { return row.verdict == Agreement::differ; });
}

bool is_of_bodies(const CriterionResult& row) {
  return row.criterion == place_criterion || row.criterion == distance_criterion;
}

/// The outcome of an ensemble under a criterion, as a verb and its object.
std::string outcome_text(const CriterionResult& row, const std::vector<double>& values) {
  if (row.criterion == stands_criterion)
    return fmt::format("stands in {} of {} seeds", std::count(values.begin(), values.end(), 1), values.size());
  return fmt::format("comes to {:.4g}{}{}", mean_of(values), row.unit.empty() ? "" : " ", row.unit);
}

/// Whether our value lies between Box2D's values with plain steps and with the finest steps.
bool is_between(const CriterionResult& row, const CriterionResult& finest) {
  const auto [least, most] = std::minmax({mean_of(row.box2d), mean_of(finest.box2d)});
  const double ours = mean_of(row.ours);
  return least <= ours && ours <= most;
}

/// Adds the outcome of the engine with smaller substeps to each row that also has an outcome of Box2D with smaller
/// steps.
void tell_own_convergence(std::vector<CriterionResult>& rows, const std::vector<CriterionResult>& own_finest,
                          std::string_view how) {
  for (std::size_t i = 0; i < rows.size() && i < own_finest.size(); ++i) {
    CriterionResult& row = rows[i];
    if (is_of_bodies(row) || row.criterion != own_finest[i].criterion) continue;
    row.ours_finest = own_finest[i].ours;
    if (row.verdict != Agreement::differ && row.verdict != Agreement::expected) continue;
    if (row.box2d_finest.empty() || row.ours_finest.empty()) continue;
    row.reason +=
        fmt::format("{}ours with {} {}", row.reason.empty() ? "" : "; ", how, outcome_text(row, row.ours_finest));
  }
}

const CriterionResult* find_row(const std::vector<CriterionResult>& rows, std::string_view criterion) {
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row.criterion == criterion; });
  return found == rows.end() ? nullptr : &*found;
}

bool agrees(const CriterionResult* row) {
  return row && (row->verdict == Agreement::agree || row->verdict == Agreement::expected);
}

/// Where the bodies of a structure are as a whole.
bool is_of_extent(const CriterionResult& row) {
  return row.criterion == top_criterion || row.criterion == travel_criterion;
}

/// Whether a placed body has toppled in every run.
bool topples(const std::vector<CrosscheckRun>& runs) {
  return std::all_of(runs.begin(), runs.end(), [](const auto& run) { return run.toppled; });
}

CrosscheckSolver summarize(const CrosscheckReport& report, const std::string& name,
                           const std::vector<CriterionResult>& rows, std::size_t stood) {
  CrosscheckSolver solver;
  solver.solver = name;
  solver.stood = stood;
  for (const CriterionResult& row : rows) {
    if (row.verdict == Agreement::agree) ++solver.passed;
    if (row.verdict == Agreement::differ) ++solver.failed;
    if (row.verdict == Agreement::expected) ++solver.expected;
    if (row.verdict == Agreement::not_applicable) ++solver.not_applicable;
  }
  const int judged = solver.passed + solver.failed + solver.expected;
  solver.summary = solver.failed == 0 ? fmt::format("{:<10} agrees with Box2D {} on {} of {} criteria", name,
                                                    report.box2d_version, solver.passed + solver.expected, judged)
                                      : fmt::format("{:<10} differs from Box2D {} on {} of {} criteria", name,
                                                    report.box2d_version, solver.failed, judged);
  if (solver.expected > 0) solver.summary += fmt::format(" ({} expected)", solver.expected);
  if (report.is_structure)
    solver.summary += fmt::format(": stood {} of {} (Box2D {} of {})", stood, report.seed_count, report.box2d_stood,
                                  report.seed_count);
  return solver;
}

// Adds a solver to the report whose only row says why nothing can be compared.
void add_not_applicable(CrosscheckReport& report, SolverKind kind, const std::string& reason) {
  CriterionResult row;
  row.solver = engine::info_of(engine::solvers, kind).name;
  row.criterion = "scene";
  row.reason = reason;
  CrosscheckSolver solver;
  solver.solver = row.solver;
  solver.not_applicable = 1;
  solver.summary = fmt::format("{:<10} not comparable with Box2D {}: {}", row.solver, report.box2d_version, reason);
  report.solvers.push_back(std::move(solver));
  report.rows.push_back(std::move(row));
}

CrosscheckReport report_not_applicable(CrosscheckReport report, const std::vector<SolverKind>& solvers,
                                       const std::string& reason) {
  for (const SolverKind kind : solvers) add_not_applicable(report, kind, reason);
  return report;
}

/// Ensembles of one scene. Ensembles with smaller steps, of Box2D or of the engine, run when they are first needed.
class Comparison {
 public:
  Comparison(const CrosscheckLayout& layout, const std::vector<Scene>& starts, Runner& runner)
      : layout_(layout), starts_(starts), runner_(runner) {}

  /// The rows of a solver. `ours`, `box2d`: the ensembles with the settings of the scene.
  Result<std::vector<CriterionResult>> judge(SolverKind solver, const std::vector<CrosscheckRun>& ours,
                                             const std::vector<CrosscheckRun>& box2d, double skin) {
    std::vector<CriterionResult> rows = compare_runs(layout_, ours, box2d, skin);
    if (!has_difference(rows) && !layout_.is_structure && !layout_.jointed) return rows;
    const std::size_t level_count = layout_.dynamic_count > finest_body_count_max ? 1 : finer_.size();
    const Result<const std::vector<CrosscheckRun>*> finest = box2d_finer(level_count - 1);
    if (!finest) return finest.error();
    const int finest_steps = finer_steps_per_tick[level_count - 1];
    judge_by_finest(rows, compare_runs(layout_, ours, **finest, skin), finest_steps);
    if (const Status judged = judge_bodies(rows, solver, ours, box2d, skin, level_count); !judged)
      return judged.error();
    const bool fell = layout_.is_structure && stood_count(ours) < ours.size();
    const bool asks_ours = fell || std::any_of(rows.begin(), rows.end(), [](const CriterionResult& row) {
                             return !is_of_bodies(row) && !row.box2d_finest.empty() &&
                                    (row.verdict == Agreement::differ || row.verdict == Agreement::expected);
                           });
    if (asks_ours && can_refine(solver)) {
      const Result<const std::vector<CrosscheckRun>*> own = ours_finer(solver, own_finer_.size() - 1);
      if (!own) return own.error();
      const std::string how = starts_.front().settings.auto_substeps
                                  ? fmt::format("a {}th of its target error", own_factor() * own_factor())
                                  : fmt::format("{} times the substeps", own_factor());
      tell_own_convergence(rows, compare_runs(layout_, **own, **finest, skin), how);
      if (layout_.is_structure) judge_by_rest(rows, ours, **own, how);
    }
    if (const Status judged = judge_by_matched_skin(rows, ours, skin, finest_steps); !judged) return judged.error();
    const bool collapses = layout_.is_structure && topples(ours) && topples(box2d) && topples(**finest);
    if (collapses && can_refine(solver))
      if (const Status judged = run_collapse(rows, solver, ours, box2d, **finest, skin); !judged) return judged.error();
    return rows;
  }

 private:
  static int own_factor() { return own_substep_factors.back(); }
  bool can_refine(SolverKind solver) const {
    return engine::info_of(engine::solvers, solver).substeps && layout_.dynamic_count <= finest_body_count_max;
  }

  /// Judges single bodies. A body differs only if smaller steps of both engines leave it in its place.
  Status judge_bodies(std::vector<CriterionResult>& rows, SolverKind solver, const std::vector<CrosscheckRun>& ours,
                      const std::vector<CrosscheckRun>& box2d, double skin, std::size_t level_count) {
    const auto differs = [&](std::string_view criterion) {
      return std::any_of(rows.begin(), rows.end(), [&](const CriterionResult& row) {
        return row.verdict == Agreement::differ && row.criterion == criterion;
      });
    };
    const auto judge_again = [&](const std::vector<std::vector<CrosscheckRun>>& finer,
                                 const std::vector<std::vector<CrosscheckRun>>& own_finer) {
      for (const CriterionResult& again : compare_bodies(layout_, ours, box2d, finer, own_finer, skin))
        for (CriterionResult& row : rows)
          if (row.criterion == again.criterion && row.verdict == Agreement::differ) row = again;
    };
    std::vector<std::vector<CrosscheckRun>> finer, own_finer;
    for (std::size_t level = 0; level < level_count; ++level) {
      if (!differs(place_criterion) && !differs(distance_criterion)) return {};
      const Result<const std::vector<CrosscheckRun>*> runs = box2d_finer(level);
      if (!runs) return runs.error();
      finer.push_back(**runs);
      judge_again(finer, {});
    }
    if (!differs(place_criterion) || !can_refine(solver)) return {};
    for (std::size_t level = 0; level < own_finer_.size(); ++level) {
      const Result<const std::vector<CrosscheckRun>*> runs = ours_finer(solver, level);
      if (!runs) return runs.error();
      own_finer.push_back(**runs);
    }
    judge_again(finer, own_finer);
    return {};
  }

  /// The skin is the cause of a difference that is gone where Box2D's polygons rest with their geometry in contact.
  Status judge_by_matched_skin(std::vector<CriterionResult>& rows, const std::vector<CrosscheckRun>& ours, double skin,
                               int finest_steps) {
    const auto is_asked = [](const CriterionResult& row) {
      return row.verdict == Agreement::differ && (is_of_extent(row) || is_of_bodies(row));
    };
    for (const int steps : {1, finest_steps}) {
      if (!std::any_of(rows.begin(), rows.end(), is_asked)) return {};
      std::vector<Job> jobs;
      for (const Scene& start : starts_) jobs.push_back({start, true, steps, true});
      runner_.expect_jobs(jobs.size());
      const Result<std::vector<Outcome>> outcomes = runner_.run(jobs);
      if (!outcomes) return outcomes.error();
      const double matched_skin = outcomes->front().skin;
      if (matched_skin >= skin) return {};
      const std::vector<CriterionResult> matched =
          compare_runs(layout_, ours, runs_of(*outcomes, 0, outcomes->size()), matched_skin);
      for (CriterionResult& row : rows) {
        const CriterionResult* without = find_row(matched, row.criterion);
        // The scatter of other seeds must not allow more than that of the scene as it is.
        const bool is_gone =
            agrees(without) && (without->verdict == Agreement::expected || without->difference <= row.tolerance);
        if (!is_asked(row) || !is_gone) continue;
        row.verdict = Agreement::expected;
        row.reason =
            fmt::format("Box2D's skin is the cause: with --match-skin{} {}",
                        steps > 1 ? fmt::format(" and {} steps a tick", steps) : "",
                        without->verdict == Agreement::agree ? fmt::format("{:.4g} m apart", without->difference)
                                                             : "the rest is expected: " + without->reason);
      }
    }
    return {};
  }

  /// Where a collapse ends is known only if smaller steps of both engines leave it there. `finest`: of Box2D.
  Status run_collapse(std::vector<CriterionResult>& rows, SolverKind solver, const std::vector<CrosscheckRun>& ours,
                      const std::vector<CrosscheckRun>& box2d, const std::vector<CrosscheckRun>& finest, double skin) {
    const auto is_asked = [](const CriterionResult& row) {
      return row.verdict == Agreement::differ && is_of_extent(row);
    };
    if (std::none_of(rows.begin(), rows.end(), is_asked)) return {};
    const std::vector<CriterionResult> theirs_moved = compare_runs(layout_, finest, box2d, skin);
    for (const int steps : finer_steps_per_tick) {
      std::vector<Job> jobs;
      for (const Scene& start : starts_) jobs.push_back({scene_with_solver(start, solver), false, steps});
      runner_.expect_jobs(jobs.size());
      const Result<std::vector<Outcome>> outcomes = runner_.run(jobs);
      if (!outcomes) return outcomes.error();
      const std::vector<CrosscheckRun> finer = runs_of(*outcomes, 0, outcomes->size());
      const std::vector<CriterionResult> with_finer = compare_runs(layout_, finer, finest, skin);
      const std::vector<CriterionResult> moved = compare_runs(layout_, finer, ours, 0);
      judge_collapse(rows, with_finer, moved, theirs_moved, steps);
    }
    return {};
  }

  Result<const std::vector<CrosscheckRun>*> box2d_finer(std::size_t level) {
    std::vector<Job> jobs;
    for (const Scene& start : starts_) jobs.push_back({start, true, finer_steps_per_tick[level]});
    return run_once(jobs, finer_[level]);
  }

  Result<const std::vector<CrosscheckRun>*> ours_finer(SolverKind solver, std::size_t level) {
    if (solver != own_finer_of_)
      for (std::vector<CrosscheckRun>& runs : own_finer_) runs.clear();
    own_finer_of_ = solver;
    const int factor = own_substep_factors[level];
    std::vector<Job> jobs;
    for (const Scene& start : starts_) {
      jobs.push_back({scene_with_solver(start, solver)});
      engine::Settings& settings = jobs.back().scene.settings;
      settings.substeps = std::min(factor * settings.substeps, limits::substep_count_max);
      if (settings.auto_substeps)  // errors fall with the square of the substeps
        settings.auto_substeps->target_error = std::max(settings.auto_substeps->target_error / (factor * factor), 1e-6);
    }
    return run_once(jobs, own_finer_[level]);
  }

  Result<const std::vector<CrosscheckRun>*> run_once(const std::vector<Job>& jobs, std::vector<CrosscheckRun>& runs) {
    if (runs.empty()) {
      runner_.expect_jobs(jobs.size());
      const Result<std::vector<Outcome>> outcomes = runner_.run(jobs);
      if (!outcomes) return outcomes.error();
      runs = runs_of(*outcomes, 0, outcomes->size());
    }
    return &runs;
  }

  const CrosscheckLayout& layout_;
  const std::vector<Scene>& starts_;
  Runner& runner_;
  std::array<std::vector<CrosscheckRun>, finer_steps_per_tick.size()> finer_;     // empty: not run yet
  std::array<std::vector<CrosscheckRun>, own_substep_factors.size()> own_finer_;  // of the solver `own_finer_of_`
  std::optional<SolverKind> own_finer_of_;
};

}  // namespace

void judge_by_finest(std::vector<CriterionResult>& rows, const std::vector<CriterionResult>& finest,
                     int steps_per_tick) {
  for (std::size_t i = 0; i < rows.size() && i < finest.size(); ++i) {
    CriterionResult& row = rows[i];
    const CriterionResult& fine = finest[i];
    if (is_of_bodies(row) || row.criterion != fine.criterion) continue;
    row.box2d_finest = fine.box2d;
    if (row.verdict == Agreement::differ && (fine.verdict == Agreement::agree || fine.verdict == Agreement::expected)) {
      row.verdict = Agreement::expected;
      row.reason = fmt::format("Box2D has not converged: with {} steps a tick it {}", steps_per_tick,
                               outcome_text(row, fine.box2d));
      if (fine.verdict == Agreement::agree)
        row.reason += ", too";
      else
        row.reason += "; the rest is expected: " + fine.reason;
    } else if (row.verdict == Agreement::differ && row.criterion != stands_criterion && is_between(row, fine)) {
      row.verdict = Agreement::expected;
      row.reason = fmt::format("Box2D has not converged: with {} steps a tick it {}, and ours lies between",
                               steps_per_tick, outcome_text(row, fine.box2d));
    } else if ((row.criterion == stands_criterion || row.criterion == joints_criterion) &&
               row.verdict == Agreement::agree && fine.verdict == Agreement::differ) {
      row.verdict = Agreement::differ;
      row.difference = fine.difference;
      row.tolerance = fine.tolerance;
      row.reason = fmt::format("Box2D has not converged: with {} steps a tick it {}", steps_per_tick,
                               outcome_text(row, fine.box2d));
    }
  }
}

void judge_collapse(std::vector<CriterionResult>& rows, const std::vector<CriterionResult>& with_finer,
                    const std::vector<CriterionResult>& ours_moved, const std::vector<CriterionResult>& theirs_moved,
                    int steps_per_tick) {
  for (CriterionResult& row : rows) {
    const CriterionResult* fine = find_row(with_finer, row.criterion);
    if (row.verdict != Agreement::differ || !is_of_extent(row) || !fine) continue;
    const bool is_known = agrees(find_row(ours_moved, row.criterion)) && agrees(find_row(theirs_moved, row.criterion));
    if (!agrees(fine) && is_known) continue;
    row.verdict = agrees(fine) ? Agreement::expected : Agreement::not_applicable;
    const std::string outcome = fmt::format("with {} steps a tick ours {}, Box2D's {:.4g}", steps_per_tick,
                                            outcome_text(row, fine->ours), mean_of(fine->box2d));
    row.reason = agrees(fine) ? fmt::format("how it falls depends on the step: {}", outcome)
                              : fmt::format("not judged: smaller steps end the fall elsewhere; {}", outcome);
  }
}

void judge_by_rest(std::vector<CriterionResult>& rows, const std::vector<CrosscheckRun>& ours,
                   const std::vector<CrosscheckRun>& own_finest, std::string_view how) {
  const auto rests = [](const CrosscheckRun& run) { return run.stood && std::isfinite(run.settle_s); };
  const auto can_stand = [&](const CrosscheckRun& run) { return rests(run) && run.balances; };
  if (!std::all_of(own_finest.begin(), own_finest.end(), can_stand)) return;
  for (CriterionResult& row : rows) {
    if (row.criterion != stands_criterion || row.verdict == Agreement::not_applicable || row.box2d_finest.empty())
      continue;
    const double finest = mean_of(row.box2d_finest);
    if (mean_of(row.ours) < 1 - row.tolerance) {
      if (row.verdict == Agreement::differ) {
        row.reason += ": raise \"substeps\", or set it to \"auto\"";
        return;
      }
      row.verdict = Agreement::differ;
      row.difference = 1 - mean_of(row.ours);
      row.reason = fmt::format(
          "it can stand: statics balances it where it stands at rest with {} of ours, though Box2D {} with its finest "
          "steps; raise "
          "\"substeps\", or set it to \"auto\"",
          how, outcome_text(row, row.box2d_finest));
      return;
    }
    if (row.verdict != Agreement::differ || finest >= 1 - row.tolerance) return;
    if (!std::all_of(ours.begin(), ours.end(), rests)) return;
    row.verdict = Agreement::expected;
    row.reason = fmt::format(
        "it can stand: statics balances it where ours stands at rest, also with {}; Box2D has not converged: with its "
        "finest steps it {}",
        how, outcome_text(row, row.box2d_finest));
    for (CriterionResult& other : rows) {
      if (other.verdict != Agreement::differ || other.criterion == joints_criterion) continue;
      other.verdict = Agreement::expected;
      other.reason = "Box2D falls, and the structure can stand (stands or falls)";
    }
    return;
  }
}

Scene jittered_scene(const Scene& scene, const CrosscheckLayout& layout, std::uint32_t seed) {
  Scene jittered = scene;
  if (seed == 0) return jittered;
  for (std::size_t i = 0; i < jittered.bodies.size(); ++i) {
    const CrosscheckBody& body = layout.bodies[i];
    if (!body.is_dynamic) continue;
    const double reach = jitter_per_size * std::min(body.width, body.height);
    const double across = jitter_of(seed, 2 * i) * reach;
    // Without gravity no direction is special. A shift along a single direction could then keep a symmetry of the
    // scene.
    const double up = layout.gravity > 0 ? 0 : jitter_of(seed, 2 * i + 1) * reach;
    jittered.bodies[i].position.x += across * layout.right.x + up * layout.up.x;
    jittered.bodies[i].position.y += across * layout.right.y + up * layout.up.y;
  }
  return jittered;
}

Scene scene_with_solver(const Scene& scene, SolverKind solver) {
  Scene changed = scene;
  if (solver == scene.settings.solver) return changed;
  changed.settings.solver = solver;
  const bool substeps = engine::info_of(engine::solvers, solver).substeps;
  const bool substepped = engine::info_of(engine::solvers, scene.settings.solver).substeps;
  if (!substeps) {
    changed.settings.substeps = 1;
    engine::fix_substeps(changed.settings);
  }
  if (!engine::info_of(engine::solvers, solver).chooses_joints)
    changed.settings.joints = engine::JointSolverKind::iterative;
  if (substeps && !substepped) changed.settings.substeps = engine::Settings{}.substeps;
  return changed;
}

Result<CrosscheckReport> crosscheck(const Scene& scene, const CrosscheckOptions& options) {
  const PeerInfo& peer = engine::info_of(peers, options.peer);
  const Result<std::string> version = peer.version();
  if (!version) return version.error();
  if (options.seed_count < 1 || options.seed_count > 1000)
    return Error{ErrorCode::usage, fmt::format("seeds: found {}, expected 1 to 1000", options.seed_count), {}};
  const double ticks = std::ceil(options.seconds / scene.settings.dt - 1e-9);
  if (!(ticks >= 1 && ticks <= 1e8))
    return Error{
        ErrorCode::usage,
        fmt::format("seconds: found {:g}, expected 1 to 1e8 ticks of {:g} s", options.seconds, scene.settings.dt),
        {}};

  std::vector<SolverKind> solvers = options.solvers;
  if (solvers.empty()) solvers.push_back(scene.settings.solver);
  CrosscheckReport report;
  report.scene = scene.name;
  report.peer = options.peer;
  report.box2d_version = *version;
  if (options.peer == PeerKind::box2d2) {
    report.velocity_iterations = Box2dOptions{}.velocity_iterations;
    report.position_iterations = Box2dOptions{}.position_iterations;
  }
  report.match_skin = options.match_skin;
  report.seed_count = options.seed_count;
  report.tick_count = static_cast<std::uint64_t>(ticks);
  report.seconds = ticks * scene.settings.dt;

  const CrosscheckLayout layout = make_layout(scene);
  if (layout.dynamic_count == 0)
    return report_not_applicable(report, solvers, "the scene starts without moving bodies, and no inputs are given");
  std::vector<SolverKind> fitting;
  for (const SolverKind kind : solvers) {
    const Result<std::unique_ptr<engine::Engine>> made = engine::make_engine(scene_with_solver(scene, kind));
    if (made)
      fitting.push_back(kind);
    else if (made.error().code == ErrorCode::incompatible && solvers.size() > 1)
      add_not_applicable(report, kind, made.error().message);
    else
      return made.error();
  }
  solvers = std::move(fitting);
  if (Result<std::unique_ptr<Box2dPeer>> made = peer.make(scene, {}); !made) {
    if (made.error().code != ErrorCode::unsupported) return made.error();
    return report_not_applicable(report, solvers, made.error().message);
  }

  std::vector<Scene> starts;
  for (std::uint32_t seed = 0; seed < options.seed_count; ++seed) starts.push_back(jittered_scene(scene, layout, seed));
  std::vector<Job> jobs;
  for (const Scene& start : starts) jobs.push_back({start, true});
  for (const SolverKind kind : solvers)
    for (const Scene& start : starts) jobs.push_back({scene_with_solver(start, kind)});
  Runner runner(layout, report.tick_count, options);
  runner.expect_jobs(jobs.size());
  Result<std::vector<Outcome>> outcomes = runner.run(jobs);
  if (!outcomes) return outcomes.error();

  report.length_scale = outcomes->front().length_scale;
  report.thin_shape_count = options.match_skin ? 0 : outcomes->front().thin_shape_count;
  const double skin = outcomes->front().skin;
  std::size_t clamped_tick = std::numeric_limits<std::size_t>::max();
  for (const Outcome& outcome : *outcomes)
    if (outcome.clamped_tick > 0) clamped_tick = std::min(clamped_tick, outcome.clamped_tick);
  if (clamped_tick != std::numeric_limits<std::size_t>::max())
    return report_not_applicable(report, solvers,
                                 fmt::format("Box2D cuts movements of over {}, first at {:.2f} s", peer.cut,
                                             static_cast<double>(clamped_tick) * scene.settings.dt));

  const std::vector<CrosscheckRun> box2d = runs_of(*outcomes, 0, starts.size());
  report.is_structure = layout.is_structure;
  report.box2d_stood = stood_count(box2d);
  Comparison comparison(layout, starts, runner);
  for (std::size_t i = 0; i < solvers.size(); ++i) {
    const std::string name{engine::info_of(engine::solvers, solvers[i]).name};
    const std::vector<CrosscheckRun> ours = runs_of(*outcomes, (i + 1) * starts.size(), starts.size());
    Result<std::vector<CriterionResult>> judged = comparison.judge(solvers[i], ours, box2d, skin);
    if (!judged) return judged.error();
    std::vector<CriterionResult>& rows = *judged;
    report.solvers.push_back(summarize(report, name, rows, stood_count(ours)));
    for (CriterionResult& row : rows) {
      row.solver = name;
      report.rows.push_back(std::move(row));
    }
  }
  return report;
}

}  // namespace ticktrue::tool
