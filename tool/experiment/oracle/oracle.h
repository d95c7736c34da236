// The oracle: runs one world in every variant that may not change a bit, and compares every tick.
// SPDX-License-Identifier: MIT
//
// Verified: the root hash of every tick (of what both pipelines share, where one is full); verdicts of verify; finite
// values; zeros without a sign; momentum. Not verified: what all runs have in common, such as wrong physics.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tool/experiment/oracle/runs.h"
#include "tool/experiment/oracle/trace_checks.h"

namespace ticktrue::verifier::soak {

struct OracleOptions {
  EngineMaker make;
  CheckSelection checks = CheckSelection::all();
  TraceFiles files;
};

/// Estimated work of the base run of most worlds; one in sixteen gets eight times as much, so that large worlds run for
/// longer than a few ticks, too.
inline constexpr std::uint64_t work_max_usual = 40'000'000;  // ns
inline constexpr std::uint64_t work_max_large = 320'000'000;
/// All variants of a world together, those that every world gets apart.
inline constexpr std::uint64_t work_max_variants = 500'000'000;
/// Worlds up to this size forget everything before every tick.
inline constexpr std::size_t cold_body_count_max = 64;

struct WorldResult {
  BaseRun base;
  std::vector<Finding> findings;  // at most one of each check
  RunTally tally;
  std::array<std::uint64_t, check_table.size()> run_counts{};
};

/// Which ways a world is run in: those every world gets (forget, another broad phase, chunks, restore, cold where it
/// is small), and others as the seed draws them and as work allows.
std::vector<Variant> plan_variants(const SoakCase& soak_case, const BaseRun& base, std::uint64_t seed,
                                   const CheckSelection& checks);

WorldResult examine(const SoakCase& soak_case, std::uint64_t seed, const OracleOptions& options);

/// What one variant finds in a world, base run included. For shrinking.
std::optional<Finding> examine_variant(const SoakCase& soak_case, const Variant& variant, const OracleOptions& options);

}  // namespace ticktrue::verifier::soak
