// The base run of a world, and runs of variants that must give the same bits.
// SPDX-License-Identifier: MIT
#include "tool/experiment/oracle/runs.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <utility>

#include "base/hash.h"
#include "base/limits.h"
#include "base/parallel/chunk_order.h"
#include "base/state/non_finite.h"
#include "verifier/locate/locate.h"

namespace ticktrue::soak {
namespace {

using engine::CacheReport;
using engine::CacheSet;
using engine::Engine;

std::uint32_t rows_of(const StateView& state, std::string_view table) {
  const auto found = state.schema->find_table(table);
  return found ? state.tables[*found].row_count : 0;
}

/// The number of substeps of all bodies, summed over bodies.
std::uint64_t body_substeps(const engine::Scene& scene, const StateView& state) {
  const auto table = state.schema->find_table("substeps");
  if (!table) return std::uint64_t{rows_of(state, "bodies")} * static_cast<std::uint64_t>(scene.settings.substeps);
  const TableSchema& schema = state.schema->tables[*table];
  std::uint64_t sum = 0;
  for (std::uint32_t row = 0; row < state.tables[*table].row_count; ++row) {
    std::uint32_t count = 0;
    std::memcpy(&count, state.tables[*table].data + std::size_t{row} * schema.row_size + schema.columns[1].offset, 4);
    sum += count;
  }
  return sum;
}

}  // namespace

std::uint64_t work_of_tick(const engine::Scene& scene, const StateView& state) {
  const std::uint64_t bodies = rows_of(state, "bodies");
  const std::uint64_t contacts = rows_of(state, "contacts");
  const std::uint64_t joints = rows_of(state, "joints");
  const std::uint64_t substeps = body_substeps(scene, state);
  const std::uint64_t mean_substeps = bodies == 0 ? 1 : 1 + substeps / bodies;
  const bool iterates = scene.settings.solver == engine::SolverKind::pgs;
  const std::uint64_t passes = iterates ? static_cast<std::uint64_t>(scene.settings.iterations) : 2 * mean_substeps;
  const std::uint64_t stages = scene.settings.integrator == engine::IntegratorKind::semi_implicit_euler ? 1 : 4;
  const std::uint64_t forces = scene.forces.size();
  return 4000 + 150 * bodies + 250 * contacts + substeps * stages * (20 + 20 * forces) + passes * 30 * contacts +
         passes * 60 * joints;
}

namespace {

/// Caches that were hit between two reports.
CacheSet hit_between(const CacheReport& before, const CacheReport& after) {
  CacheSet set = 0;
  for (const engine::CacheInfo& info : engine::cache_kinds) {
    const auto i = static_cast<std::size_t>(info.kind);
    if (after[i].hits > before[i].hits) set |= engine::cache_bit(info.kind);
  }
  return set;
}

Finding make_failure(const Variant& variant, std::uint64_t tick, std::string what, bool is_refused) {
  Finding finding;
  finding.variant = variant;
  finding.tick = tick;
  finding.what = std::move(what);
  finding.is_refused = is_refused;
  return finding;
}

std::string place_of_tick_text(const Engine& engine, const StateView& state, const StatePlace& place) {
  const TableSchema& table = state.schema->tables[place.table];
  const std::string name = engine.row_name(place.table, place.row);
  return "table " + table.name + ", column " + table.columns[place.column].name + ", row " + std::to_string(place.row) +
         (name.empty() ? "" : " (" + name + ")") + ", lane " + std::to_string(place.lane);
}

/// The tables of `state` that are also in `schema`, in the order of `schema`: the tables that two pipelines share.
/// Absent if a table is missing or differs.
std::optional<StateView> shared_tables(const StateView& state, const StateSchema& schema) {
  StateView shared{&schema, {}};
  for (const TableSchema& table : schema.tables) {
    const auto found = state.schema->find_table(table.name);
    if (!found || state.schema->tables[*found] != table) return std::nullopt;
    shared.tables.push_back(state.tables[*found]);
  }
  return shared;
}

/// Forces that grow with distance, and prismatic joints on rotating bodies, can drive bodies beyond every limit. The
/// following ticks show only rounding and overflow.
bool has_run_away(const Engine& engine) {
  const auto is_beyond = [](const engine::Point& point, double most) {
    return !(std::abs(point.x) <= most && std::abs(point.y) <= most);
  };
  for (const engine::BodyReport& body : engine.bodies())
    if (is_beyond(body.center, limits::coordinate_max_m) || is_beyond(body.velocity, limits::speed_max) ||
        !(std::abs(body.angular_velocity) <= limits::speed_max))
      return true;
  return false;
}

class BaseWalk {
 public:
  BaseWalk(const RunContext& context, const BaseOptions& options) : context_(context), options_(options) {}

  BaseRun run() {
    auto made = context_.make(context_.soak_case.scene, {});
    if (!made) {
      run_.findings.push_back(make_failure({CheckKind::finite}, 0, made.error().message, true));
      return std::move(run_);
    }
    engine_ = *std::move(made);
    run_.schema = *engine_->state().schema;
    for (std::uint64_t tick = 0; tick < context_.soak_case.tick_count && run_.work < options_.work_max; ++tick)
      if (!run_tick(tick)) break;
    run_.tables_with_rows.assign(tables_.begin(), tables_.end());
    run_.caches = engine_->cache_report();
    return std::move(run_);
  }

 private:
  bool run_tick(std::uint64_t tick) {
    const auto& wanted = options_.image_ticks;
    if (std::find(wanted.begin(), wanted.end(), tick) != wanted.end())
      encode_image(engine_->state(), run_.images[tick]);
    const CacheReport before = engine_->cache_report();
    if (auto failed = step_tick(*engine_, context_.inputs.at(tick), tick, {CheckKind::finite})) {
      // A tick that exceeds the limits ends the world, and is no fault.
      if (!failed->is_beyond) run_.findings.push_back(*std::move(failed));
      run_.images.erase(tick);
      return false;
    }
    const StateView& state = engine_->state();
    if (!check_values(state, tick)) return false;
    run_.ran_away = has_run_away(*engine_);
    if (run_.ran_away) {
      run_.images.erase(tick);
      return false;
    }
    run_.hashes.push_back(root_hash(state));
    run_.body_hashes.push_back(hash_of_bodies(state));
    run_.hit.push_back(hit_between(before, engine_->cache_report()));
    run_.body_ticks += rows_of(state, "bodies");
    run_.work += work_of_tick(context_.soak_case.scene, state);
    for (std::size_t t = 0; t < state.tables.size(); ++t)
      if (state.tables[t].row_count > 0) tables_.insert(state.schema->tables[t].name);
    run_.tick_count = tick + 1;
    return true;
  }

  /// False: a value is not finite, so later ticks are meaningless.
  bool check_values(const StateView& state, std::uint64_t tick) {
    if (const auto found = find_non_finite_of(*engine_, tick)) {
      run_.joints_failed = !context_.soak_case.scene.joints.empty();
      if (!run_.joints_failed)
        run_.findings.push_back(make_failure({CheckKind::finite}, tick, non_finite_text(*found), false));
      run_.images.erase(tick);
      return false;
    }
    if (!options_.checks.has(CheckKind::zeros) || saw_negative_zero_) return true;
    if (const auto place = find_negative_zero(state)) {
      saw_negative_zero_ = true;
      run_.findings.push_back(make_failure(
          {CheckKind::zeros}, tick, place_of_tick_text(*engine_, state, *place) + ": found -0, expected 0", false));
    }
    return true;
  }

  const RunContext& context_;
  const BaseOptions& options_;
  std::unique_ptr<Engine> engine_;
  std::set<std::string> tables_;
  bool saw_negative_zero_ = false;
  BaseRun run_;
};

/// Runs a variant of the world.
class VariantWalk {
 public:
  VariantWalk(const RunContext& context, const BaseRun& base, const Variant& variant, RunTally& tally)
      : context_(context), base_(base), variant_(variant), tally_(tally), order_(variant.value % 10 == 0) {}

  std::optional<Finding> run() {
    engine::EngineOptions options = engine_options();
    if (variant_.check == CheckKind::pair_limit) options.pair_count_max = most_pairs();
    auto made = context_.make(context_.soak_case.scene, options);
    if (!made) return make_failure(variant_, 0, made.error().message, false);
    engine_ = *std::move(made);
    std::uint64_t tick = 0;
    if (variant_.check == CheckKind::restore) {
      tick = variant_.value;
      if (tick >= base_.tick_count) return std::nullopt;
      const Bytes image = image_before(tick);
      // The engine runs a tick before the load, because no earlier tick may influence the loaded state.
      if (auto failed = step_tick(*engine_, context_.inputs.at(0), 0, variant_)) return failed;
      if (const Status loaded = engine_->load(image); !loaded)
        return make_failure(variant_, tick, "load: " + loaded.error().message, false);
    }
    std::optional<Finding> found;
    for (; tick < base_.tick_count && !found && !is_beyond_; ++tick) found = run_tick(tick);
    engine::add_counts(tally_.caches, engine_->cache_report());
    return found;
  }

 private:
  engine::EngineOptions engine_options() {
    engine::EngineOptions options;
    switch (variant_.check) {
      case CheckKind::forget:  // the five broad phases, or the scene's own
        if (variant_.value % (engine::broad_phases.size() + 1) < engine::broad_phases.size())
          options.broad_phase = engine::broad_phases[variant_.value % (engine::broad_phases.size() + 1)].kind;
        // Without a runner, the chunk size only sets the size of contact blocks.
        if (variant_.value / 8 % 8 != 0) options.parallel.chunk_size_forced = 1 + variant_.value / 64 % 12;
        break;
      case CheckKind::broad_phase:
      case CheckKind::pair_limit:
        options.broad_phase = engine::broad_phases[variant_.value % engine::broad_phases.size()].kind;
        break;
      case CheckKind::chunks:
        options.parallel = {&order_, static_cast<std::size_t>(std::max<std::uint64_t>(1, variant_.value / 10))};
        break;
      case CheckKind::threads:
        options.thread_count = static_cast<unsigned>(std::max<std::uint64_t>(1, variant_.value % 10));
        options.parallel.chunk_size_forced = static_cast<std::size_t>(variant_.value / 10);
        break;
      case CheckKind::instruction_set:
        options.instruction_set = engine::instruction_sets[variant_.value % engine::instruction_sets.size()].kind;
        break;
      case CheckKind::full_pipeline:
        options.full_pipeline = true;
        break;
      default:
        break;
    }
    return options;
  }

  /// Whether a tick may need more pairs than it has at its beginning. Inputs move bodies, and a tick of several steps
  /// lists pairs in each step.
  bool may_list_more(std::uint64_t tick) const {
    const engine::Settings& settings = context_.soak_case.scene.settings;
    return !context_.inputs.at(tick).inputs.empty() || settings.locate_impacts || settings.auto_substeps;
  }

  /// The largest number of pairs at the beginning of a tick.
  std::size_t most_pairs() const {
    std::size_t most = 0;
    engine::Scene scene = context_.soak_case.scene;
    scene.settings.broad_phase = engine::BroadPhaseKind::brute_force;  // bounding_circle lists fewer pairs
    const auto made = context_.make(scene, {});
    if (!made) return most;
    for (std::uint64_t tick = 0; tick < base_.tick_count; ++tick) {
      most = std::max(most, (*made)->broad_phase().pairs.size());
      if (step_tick(**made, context_.inputs.at(tick), tick, variant_)) break;
    }
    return most;
  }

  CacheSet forgotten_at(std::uint64_t tick) const {
    if (variant_.check == CheckKind::cold) return engine::all_caches;
    if (variant_.check != CheckKind::forget) return 0;
    const std::uint64_t draw = mix(variant_.value, tick);
    return draw % 4 == 0 ? static_cast<CacheSet>(draw >> 32) & engine::all_caches : 0;
  }

  std::optional<Finding> run_tick(std::uint64_t tick) {
    if (const CacheSet set = forgotten_at(tick); set != 0) engine_->forget_caches(set);
    const CacheReport before = engine_->cache_report();
    if (auto failed = step_tick(*engine_, context_.inputs.at(tick), tick, variant_)) {
      if (variant_.check != CheckKind::pair_limit || !failed->is_beyond || !may_list_more(tick)) return failed;
      is_beyond_ = true;
      return std::nullopt;
    }
    const CacheSet hit_once = base_.hit[tick] ^ hit_between(before, engine_->cache_report());
    for (const engine::CacheInfo& info : engine::cache_kinds)
      if (hit_once & engine::cache_bit(info.kind)) ++tally_.while_hit[static_cast<std::size_t>(info.kind)];
    if (variant_.check != CheckKind::full_pipeline) {
      if (root_hash(engine_->state()) == base_.hashes[tick]) return std::nullopt;
      return differs_at(tick, engine_->state());
    }
    const auto shared = shared_tables(engine_->state(), base_.schema);
    if (!shared) return make_failure(variant_, tick, "the full pipeline lacks a table of the composed one", false);
    if (root_hash(*shared) == base_.hashes[tick]) return std::nullopt;
    return differs_at(tick, *shared);
  }

  Finding differs_at(std::uint64_t tick, const StateView& got) const {
    const auto engine = base_engine_before(tick);
    if (engine == nullptr) return make_failure(variant_, tick, "the base run does not come here again", false);
    if (auto failed = step_tick(*engine, context_.inputs.at(tick), tick, variant_)) return *failed;
    if (root_hash(engine->state()) != base_.hashes[tick])
      return make_failure(variant_, tick, "two base runs differ: " + difference_text(*engine, engine->state(), got),
                          false);
    return make_failure(variant_, tick, difference_text(*engine, engine->state(), got), false);
  }

  std::unique_ptr<Engine> base_engine_before(std::uint64_t tick) const {
    auto made = context_.make(context_.soak_case.scene, {});
    if (!made) return nullptr;
    for (std::uint64_t t = 0; t < tick; ++t)
      if (step_tick(**made, context_.inputs.at(t), t, variant_)) return nullptr;
    return *std::move(made);
  }

  Bytes image_before(std::uint64_t tick) const {
    const auto kept = base_.images.find(tick);
    if (kept != base_.images.end()) return kept->second;
    Bytes image;
    if (const auto engine = base_engine_before(tick)) encode_image(engine->state(), image);
    return image;
  }

  const RunContext& context_;
  const BaseRun& base_;
  Variant variant_;
  RunTally& tally_;
  ChunkOrder order_;
  bool is_beyond_ = false;  // a tick exceeded its limits
  std::unique_ptr<Engine> engine_;
};

}  // namespace

BaseRun run_base(const RunContext& context, const BaseOptions& options) {
  return BaseWalk(context, options).run();
}

std::optional<Finding> run_variant(const RunContext& context, const BaseRun& base, const Variant& variant,
                                   RunTally& tally) {
  return VariantWalk(context, base, variant, tally).run();
}

std::optional<Finding> step_tick(Engine& engine, const TickInput& input, std::uint64_t tick, const Variant& variant) {
  if (const Status accepted = engine.accept(input); !accepted)
    return make_failure(variant, tick, "inputs refused: " + accepted.error().message, true);
  const Status did = engine.step(input, nullptr);
  if (did) return std::nullopt;
  Finding finding = make_failure(variant, tick, did.error().message, false);
  finding.is_beyond = did.error().code == ErrorCode::limit;
  return finding;
}

std::string difference_text(const Engine& engine, const StateView& expected, const StateView& got) {
  Bytes image_expected, image_got;
  encode_image(expected, image_expected);
  encode_image(got, image_got);
  verifier::Divergence divergence;
  const Status located = locate_lanes(
      *expected.schema, image_expected, image_got,
      [&](std::size_t table, std::size_t row) { return engine.row_name(table, row); }, 1, divergence);
  if (!located) return located.error().message;
  if (divergence.rows.empty()) return "hashes differ, and no lane does";
  const verifier::LaneReport& lane = divergence.rows.front();
  const auto text = [&](const std::optional<std::uint64_t>& bits) {
    return bits ? lane_text(lane.type, *bits) + " (" + lane_hex(lane.type, *bits) + ")" : std::string("no such row");
  };
  return "table " + lane.table + ", column " + lane.column + ", row " + std::to_string(lane.row) +
         (lane.name.empty() ? "" : " (" + lane.name + ")") + ", lane " + std::to_string(lane.lane) + ": expected " +
         text(lane.expected) + ", got " + text(lane.got) + "; " + std::to_string(divergence.lane_count) +
         (divergence.lane_count == 1 ? " lane differs" : " lanes differ");
}

std::uint64_t hash_of_bodies(const StateView& state) {
  const auto table = state.schema->find_table("bodies");
  if (!table) return 0;
  const std::size_t size = std::size_t{state.tables[*table].row_count} * state.schema->tables[*table].row_size;
  return hash64(ByteView(state.tables[*table].data, size));
}

}  // namespace ticktrue::soak
