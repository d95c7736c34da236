// Cache hits and invalidations: a table in the repository, and its comparison.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/result.h"
#include "engine/engine.h"

namespace ticktrue::soak {

/// The counts are sums over the worlds of a file of hashes and over a few built-in scenes, on one thread. The counts
/// show a change in how often caches are rebuilt, even if no bit of a world differs.

/// Adds the counts of the built-in scenes, which are larger and rest longer than the worlds of hashes. Errors: those of
/// Engine::step.
Status add_counts_of_scenes(engine::CacheReport& counts);
/// A line "cache, hits, invalidations" for each cache, separated by tabs.
std::string print_cache_counts(const engine::CacheReport& counts);
/// Errors: corrupt, with `place` and the line; corrupt if a cache has no line.
Result<engine::CacheReport> parse_cache_counts(const std::string& text, const std::string& place);
/// Errors: inconsistent, with the first cache whose counts differ.
Status compare_cache_counts(const engine::CacheReport& expected, const engine::CacheReport& found,
                            const std::string& place);

}  // namespace ticktrue::soak
