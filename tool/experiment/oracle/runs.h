// Runs of one world that are compared tick by tick with its base run.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/state/state_view.h"
#include "engine/engine.h"
#include "tool/experiment/oracle/checks.h"
#include "tool/experiment/soak_case.h"

namespace ticktrue::verifier::soak {

/// What all runs of one world share; must outlive them.
struct RunContext {
  const SoakCase& soak_case;
  const CaseInputs& inputs;
  const EngineMaker& make;
};

using CacheTally = std::array<std::uint64_t, engine::cache_kind_count>;

/// What the runs of a world did with cached structures.
struct RunTally {
  CacheTally while_hit{};  // ticks compared in which one run used the structure again and the base run did not, or
                           // the other way round
  engine::CacheReport caches{};  // of all runs but the base run
};

/// The world as its scene says, on one thread, with every cached structure in use.
struct BaseRun {
  StateSchema schema;
  std::uint64_t tick_count = 0;               // ticks done: all, or those before the work was used up or a tick failed
  std::vector<std::uint64_t> hashes;          // [tick] root hash
  std::vector<std::uint64_t> body_hashes;     // [tick] of the rows of the table of bodies
  std::vector<engine::CacheSet> hit;          // [tick] structures that were used again
  engine::CacheReport caches{};               // of the whole run
  std::map<std::uint64_t, Bytes> images;      // state before these ticks
  std::vector<Finding> findings;              // finite, zeros; a world that was refused
  std::vector<std::string> tables_with_rows;  // at the end of some tick
  std::uint64_t body_ticks = 0;
  std::uint64_t work = 0;  // estimate, ns
  // Why the run ended early, if so:
  bool ran_away = false;       // a body is farther or faster than a scene may state
  bool joints_failed = false;  // a value is not finite, in a world with joints
};
struct BaseOptions {
  std::uint64_t work_max = UINT64_MAX;     // ends the run; ns of estimated work
  std::vector<std::uint64_t> image_ticks;  // keep the state before these ticks
  CheckSelection checks = CheckSelection::all();
};
BaseRun run_base(const RunContext& context, const BaseOptions& options);

/// Where a run of another kind differs from the base run, if anywhere; adds to `tally`. For every check but finite,
/// zeros, process, trace and momentum.
std::optional<Finding> run_variant(const RunContext& context, const BaseRun& base, const Variant& variant,
                                   RunTally& tally);

/// Runs the tick and keeps what went wrong: inputs refused, or a tick that could not be done.
std::optional<Finding> step_tick(engine::Engine& engine, const TickInput& input, std::uint64_t tick,
                                 const Variant& variant);

/// The first difference of two states of one schema, for people. The names of rows are those of `engine`.
std::string difference_text(const engine::Engine& engine, const StateView& expected, const StateView& got);

/// About how long a tick took that ended in `state`, in ns on a machine of 2023. It depends on the state alone, so that
/// every machine makes the same runs.
std::uint64_t work_of_tick(const engine::Scene& scene, const StateView& state);

/// Hash of the rows of the table of bodies.
std::uint64_t hash_of_bodies(const StateView& state);

}  // namespace ticktrue::verifier::soak
