// How often cached structures are used again: a table in the repository, and what differs from it.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/result.h"
#include "engine/engine.h"

namespace ticktrue::verifier::soak {

/// What the cached structures of the worlds of a file of hashes and of a few built-in scenes counted together, on one
/// thread. A change that makes a structure anew more or less often shows here, though no bit of a world differs.

/// Adds the counts of the built-in scenes, which are larger and rest longer than the worlds of hashes. Errors: those of
/// Engine::step.
Status add_counts_of_scenes(engine::CacheReport& counts);
/// A line "cache, hits, invalidations" for each cached structure, with tabs between.
std::string print_cache_counts(const engine::CacheReport& counts);
/// Errors: corrupt, with `place` and the line; a structure without a line.
Result<engine::CacheReport> parse_cache_counts(const std::string& text, const std::string& place);
/// Errors: inconsistent, with the first structure whose counts differ.
Status compare_cache_counts(const engine::CacheReport& expected, const engine::CacheReport& found,
                            const std::string& place);

}  // namespace ticktrue::verifier::soak
