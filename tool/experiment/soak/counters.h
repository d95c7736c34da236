// The counters of a soak, stored in a file so that a soak can be resumed.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/engine.h"
#include "tool/experiment/oracle/checks.h"
#include "tool/experiment/oracle/physics_checks.h"
#include "tool/experiment/oracle/runs.h"

namespace ticktrue::soak {

/// A world in which a check found something.
struct FailedWorld {
  std::uint64_t index = 0;       // index of the world in the soak
  std::uint64_t world_seed = 0;  // seed of the generator
  std::string variant;           // variant_text
  std::uint64_t tick = 0;        // in the generated world
  std::string what;
  std::string folder;            // folder of the shrunk world; empty: not shrunk
  std::uint64_t body_count = 0;  // of the shrunk world
  std::uint64_t tick_count = 0;
  std::uint64_t test_count = 0;  // runs of the shrinker
};

struct ChoiceCoverage {
  std::uint64_t active = 0;    // worlds that use the choice
  std::uint64_t measured = 0;  // of the active worlds: run without the choice
  std::uint64_t effect = 0;    // of the measured worlds: states differ without the choice
};

/// A choice with an effect in this many worlds is no longer measured.
inline constexpr std::uint64_t effect_count_wanted = 500;

struct SoakCounters {
  std::uint64_t world_count = 0;  // worlds 0..world_count - 1 are done
  std::uint64_t tick_count = 0;   // of the base runs
  std::uint64_t body_ticks = 0;   // of the base runs
  std::array<std::uint64_t, check_table.size()> run_counts{};
  engine::CacheReport caches{};  // of the base runs and of their variants
  CacheTally while_hit{};
  std::map<std::string, ChoiceCoverage> choices;
  std::map<std::pair<std::string, std::string>, std::uint64_t> pairs;  // worlds that use both choices
  std::map<std::pair<std::string, std::string>, std::uint64_t> known;  // (cause, check): worlds
  std::uint64_t judged_count = 0;          // worlds that the rules of gaps and overlaps judged
  std::uint64_t unjudged_count = 0;        // worlds of a solver or integrator that is a baseline
  std::vector<std::string> physics_texts;  // of worlds that break a rule: "world 7, tgs_soft rk4 with joints: ..."
  std::uint64_t ran_away_count = 0;        // worlds whose base run ended with BaseRun::ran_away
  std::uint64_t joints_failed_count = 0;   // the same with BaseRun::joints_failed
  std::vector<FailedWorld> failures;
};

/// The identity of a soak. A soak resumes only its own counters.
struct SoakIdentity {
  std::uint64_t seed = 0;
  std::string checks;  // variants and names, separated by commas
  std::string commit;  // commit of the build
  bool operator==(const SoakIdentity&) const = default;
};

std::string print_progress(const SoakIdentity& identity, const SoakCounters& counters);
/// Messages begin with `place`. Errors: corrupt; incompatible (another soak).
Result<SoakCounters> parse_progress(const std::string& text, const SoakIdentity& identity, const std::string& place);

}  // namespace ticktrue::soak
