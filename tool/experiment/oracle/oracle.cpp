// Chooses the variants of a world, runs them, and collects their findings.
// SPDX-License-Identifier: MIT
#include "tool/experiment/oracle/oracle.h"

#include <algorithm>
#include <utility>

#include "base/random.h"
#include "tool/experiment/oracle/physics_checks.h"

namespace ticktrue::soak {
namespace {

struct PlannedVariant {
  Variant variant;
  double cost = 1;  // in multiples of the base run
  bool is_required = false;
};

class Plan {
 public:
  Plan(const SoakCase& soak_case, const BaseRun& base, std::uint64_t seed)
      : soak_case_(soak_case), base_(base), random_(seed), body_count_(soak_case.scene.bodies.size()) {}

  std::vector<PlannedVariant> all() {
    if (body_count_ <= cold_body_count_max) add({CheckKind::cold}, 3, true);
    add_forgets();
    add_broad_phases();
    add_chunks();
    add_restores();
    add({CheckKind::full_pipeline}, 2, false);
    for (const engine::InstructionSetInfo& info : engine::instruction_sets)
      if (engine::can_use(info.kind) && info.kind != engine::instruction_set_in_use())
        add({CheckKind::instruction_set, static_cast<std::uint64_t>(info.kind)}, 1.5, false);
    for (int i = 0; i < repeat_count; ++i) add({CheckKind::trace, random_.below(1u << 20)}, 4, false);
    if (random_.below(3) == 0) add({CheckKind::threads, (body_count_ > 400 ? 0 : 40) + thread_count()}, 3, false);
    if (random_.below(24) == 0) add({CheckKind::process, random_.below(1u << 20)}, 6, false);
    if (random_.below(4) == 0) add({CheckKind::momentum}, 2, false);
    if (body_count_ <= pair_count_body_max && random_.below(3) == 0)
      add({CheckKind::pair_limit, random_.below(engine::broad_phases.size())}, 4, false);
    return std::move(planned_);
  }

 private:
  void add(const Variant& variant, double cost, bool is_required) { planned_.push_back({variant, cost, is_required}); }
  static constexpr int repeat_count = 4;  // variants of a check with drawn numbers
  static constexpr std::size_t pair_count_body_max = 400;

  std::uint64_t thread_count() { return random_.below(2) == 0 ? 2 : 4; }

  /// The first variant uses the scene's broad phase. The others use a random broad phase that is not quadratic.
  void add_forgets() {
    constexpr std::uint64_t scene_phase = engine::broad_phases.size();
    add({CheckKind::forget, 6 * random_.below(1u << 20) + scene_phase}, 1.5, true);
    for (int i = 1; i < repeat_count; ++i)
      add({CheckKind::forget, 6 * random_.below(1u << 20) + 2 + random_.below(scene_phase - 2)}, 1.5, false);
  }

  /// brute_force and bounding_circle examine every pair, so large worlds rarely run them.
  void add_broad_phases() {
    std::vector<PlannedVariant> others;
    for (const auto& info : engine::broad_phases) {
      if (info.kind == soak_case_.scene.settings.broad_phase) continue;
      const bool is_quadratic =
          info.kind == engine::BroadPhaseKind::brute_force || info.kind == engine::BroadPhaseKind::bounding_circle;
      const double pairs = 0.5 * static_cast<double>(body_count_) * static_cast<double>(body_count_);
      const double tick_work =
          static_cast<double>(base_.work) / static_cast<double>(std::max<std::uint64_t>(1, base_.tick_count));
      const double cost = 1.2 + (is_quadratic ? 2 * pairs / (1 + tick_work) : 0);
      others.push_back({{CheckKind::broad_phase, static_cast<std::uint64_t>(info.kind)}, cost, false});
    }
    std::size_t required = random_.below(others.size());
    while (others[required].cost > 3) required = (required + 1) % others.size();
    others[required].is_required = true;
    for (PlannedVariant& other : others)
      if (other.is_required || other.cost < 4 || random_.below(16) == 0) planned_.push_back(other);
  }

  void add_chunks() {
    constexpr std::uint64_t sizes[] = {1, 2, 3, 5, 8, 16, 64};
    const std::uint64_t size = body_count_ > 600 ? 8 + random_.below(57) : sizes[random_.below(7)];
    const std::uint64_t order = random_.below(2);
    add({CheckKind::chunks, 10 * size + order}, 2, true);
    for (int i = 1; i < repeat_count; ++i)
      add({CheckKind::chunks, 10 * (1 + random_.below(64)) + random_.below(2)}, 2, false);
  }

  void add_restores() {
    bool is_required = true;
    for (const auto& [tick, image] : base_.images) {
      add({CheckKind::restore, tick}, 1, is_required);
      is_required = false;
    }
  }

  const SoakCase& soak_case_;
  const BaseRun& base_;
  Random random_;
  std::size_t body_count_;
  std::vector<PlannedVariant> planned_;
};

BaseOptions base_options(const SoakCase& soak_case, std::uint64_t seed, const CheckSelection& checks) {
  BaseOptions options;
  options.work_max = mix(seed, 1) % 16 == 0 ? work_max_large : work_max_usual;
  options.checks = checks;
  Random random(mix(seed, 2));
  const std::uint64_t tick_count = std::max<std::uint64_t>(1, soak_case.tick_count);
  options.image_ticks.push_back(1 + random.below(std::min<std::uint64_t>(tick_count, 16)));
  for (int i = 0; i < 7; ++i) options.image_ticks.push_back(random.below(tick_count));
  return options;
}

std::optional<Finding> run_any(const RunContext& context, const BaseRun& base, const Variant& variant,
                               const OracleOptions& options, RunTally& tally) {
  switch (variant.check) {
    case CheckKind::finite:
    case CheckKind::zeros:
      for (const Finding& finding : base.findings)
        if (finding.variant.check == variant.check) return finding;
      return std::nullopt;
    case CheckKind::trace:
    case CheckKind::process:
      return run_trace_variant(context, base, variant, options.files);
    case CheckKind::momentum:
      return check_momentum(context, base);
    default:
      return run_variant(context, base, variant, tally);
  }
}

}  // namespace

std::vector<Variant> plan_variants(const SoakCase& soak_case, const BaseRun& base, std::uint64_t seed,
                                   const CheckSelection& checks) {
  std::vector<Variant> chosen;
  if (base.tick_count == 0) return chosen;
  std::vector<PlannedVariant> optional;
  for (const PlannedVariant& planned : Plan(soak_case, base, mix(seed, 3)).all()) {
    const auto has_check = [&](const Variant& variant) { return variant.check == planned.variant.check; };
    if (!checks.has(planned.variant.check) || std::any_of(checks.only.begin(), checks.only.end(), has_check)) continue;
    if (planned.is_required)
      chosen.push_back(planned.variant);
    else
      optional.push_back(planned);
  }
  Random random(mix(seed, 4));
  for (std::size_t i = optional.size(); i > 1; --i) std::swap(optional[i - 1], optional[random.below(i)]);
  double work = 0;
  for (const PlannedVariant& planned : optional) {
    const double cost = planned.cost * static_cast<double>(base.work);
    if (work + cost > static_cast<double>(work_max_variants)) continue;
    work += cost;
    chosen.push_back(planned.variant);
  }
  chosen.insert(chosen.end(), checks.only.begin(), checks.only.end());
  return chosen;
}

WorldResult examine(const SoakCase& soak_case, std::uint64_t seed, const OracleOptions& options) {
  const CaseInputs inputs(soak_case);
  const RunContext context{soak_case, inputs, options.make};
  WorldResult result;
  result.base = run_base(context, base_options(soak_case, seed, options.checks));
  const auto found_already = [&](const Finding& finding) {
    return std::any_of(result.findings.begin(), result.findings.end(),
                       [&](const Finding& other) { return other.variant.check == finding.variant.check; });
  };
  for (const CheckKind kind : {CheckKind::finite, CheckKind::zeros})
    if (options.checks.has(kind)) ++result.run_counts[static_cast<std::size_t>(kind)];
  for (const Finding& finding : result.base.findings)
    if (options.checks.has(finding.variant.check) || finding.is_refused) result.findings.push_back(finding);
  for (const Variant& variant : plan_variants(soak_case, result.base, seed, options.checks)) {
    ++result.run_counts[static_cast<std::size_t>(variant.check)];
    auto found = run_any(context, result.base, variant, options, result.tally);
    if (found && !found_already(*found)) result.findings.push_back(*std::move(found));
  }
  return result;
}

std::optional<Finding> examine_variant(const SoakCase& soak_case, const Variant& variant,
                                       const OracleOptions& options) {
  const CaseInputs inputs(soak_case);
  const RunContext context{soak_case, inputs, options.make};
  BaseOptions base_options;
  if (variant.check == CheckKind::restore) base_options.image_ticks.push_back(variant.value);
  const BaseRun base = run_base(context, base_options);
  RunTally tally;
  return run_any(context, base, variant, options, tally);
}

}  // namespace ticktrue::soak
