// Runs of one world that are compared with its base run, tick by tick.
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

namespace ticktrue::soak {

/// Data that all runs of one world share. Must outlive the runs.
struct RunContext {
  const SoakCase& soak_case;
  const CaseInputs& inputs;
  const EngineMaker& make;
};

using CacheTally = std::array<std::uint64_t, engine::cache_kind_count>;

/// Cache statistics of the variants of a world.
struct RunTally {
  CacheTally while_hit{};  // ticks compared in which one run used the structure again and the base run did not, or
                           // the other way round
  engine::CacheReport caches{};  // of all runs except the base run
};

/// The run of a world with the settings of its scene, on one thread, with every cache in use.
struct BaseRun {
  StateSchema schema;
  std::uint64_t tick_count = 0;               // ticks done; fewer than asked if work ran out or a tick failed
  std::vector<std::uint64_t> hashes;          // [tick] root hash
  std::vector<std::uint64_t> body_hashes;     // [tick] of the rows in the table of bodies
  std::vector<engine::CacheSet> hit;          // [tick] caches that were hit
  engine::CacheReport caches{};               // of the whole run
  std::map<std::uint64_t, Bytes> images;      // state before these ticks
  std::vector<Finding> findings;              // of finite and zeros, or a refused world
  std::vector<std::string> tables_with_rows;  // tables that have rows at the end of any tick
  std::uint64_t body_ticks = 0;
  std::uint64_t work = 0;  // estimate, ns
  // Reasons for an early end of the run:
  bool ran_away = false;       // the position or speed of a body exceeds the limits of a scene
  bool joints_failed = false;  // a value is not finite, in a world with joints
};
struct BaseOptions {
  std::uint64_t work_max = UINT64_MAX;     // the run ends at this estimate, ns
  std::vector<std::uint64_t> image_ticks;  // the state before these ticks is stored
  CheckSelection checks = CheckSelection::all();
};
BaseRun run_base(const RunContext& context, const BaseOptions& options);

/// The first difference between a variant and the base run, if any; adds to `tally`. Requires: any check except finite,
/// zeros, process, trace and momentum.
std::optional<Finding> run_variant(const RunContext& context, const BaseRun& base, const Variant& variant,
                                   RunTally& tally);

/// Runs the tick and returns its failure: refused inputs, or a failed tick.
std::optional<Finding> step_tick(engine::Engine& engine, const TickInput& input, std::uint64_t tick,
                                 const Variant& variant);

/// The first difference of two states with one schema, as text. `engine` provides the names of state rows.
std::string difference_text(const engine::Engine& engine, const StateView& expected, const StateView& got);

/// Estimated duration of the tick that ended in `state`, ns on a machine of 2023. The estimate depends on the state
/// alone, so every machine makes the same runs.
std::uint64_t work_of_tick(const engine::Scene& scene, const StateView& state);

/// Hash of the rows of the table of bodies.
std::uint64_t hash_of_bodies(const StateView& state);

}  // namespace ticktrue::soak
