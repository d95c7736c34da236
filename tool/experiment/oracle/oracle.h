// The oracle runs one world in several variants that must not change a bit, and compares every tick.
// SPDX-License-Identifier: MIT
//
// Verified: the root hash of every tick (of the shared tables, if one run uses the full pipeline); verdicts of verify;
// finite values; zeros without a sign; momentum.
// Not verified: errors that all runs have in common, such as wrong physics.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tool/experiment/oracle/runs.h"
#include "tool/experiment/oracle/trace_checks.h"

namespace ticktrue::soak {

struct OracleOptions {
  EngineMaker make;
  CheckSelection checks = CheckSelection::all();
  TraceFiles files;
};

/// Estimated work of the base run of most worlds. One world in sixteen gets eight times as much, so that large worlds
/// also run for more than a few ticks.
inline constexpr std::uint64_t work_max_usual = 40'000'000;  // ns
inline constexpr std::uint64_t work_max_large = 320'000'000;
/// Estimated work of all optional variants of a world together, ns. Required variants are not limited.
inline constexpr std::uint64_t work_max_variants = 500'000'000;
/// Worlds of at most this size also run with all caches dropped before every tick.
inline constexpr std::size_t cold_body_count_max = 64;

struct WorldResult {
  BaseRun base;
  std::vector<Finding> findings;  // at most one per check
  RunTally tally;
  std::array<std::uint64_t, check_table.size()> run_counts{};
};

/// Plans the variants of a world. Every world gets forget, another broad phase, chunks and restore; a small world also
/// gets cold. The seed draws further variants, as far as work allows.
std::vector<Variant> plan_variants(const SoakCase& soak_case, const BaseRun& base, std::uint64_t seed,
                                   const CheckSelection& checks);

WorldResult examine(const SoakCase& soak_case, std::uint64_t seed, const OracleOptions& options);

/// Runs the base run and one variant of a world, and returns the finding of that variant. Used for shrinking.
std::optional<Finding> examine_variant(const SoakCase& soak_case, const Variant& variant, const OracleOptions& options);

}  // namespace ticktrue::soak
