// Root hashes of random worlds, which are the same in every build and on every platform.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "engine/random_worlds/random_world.h"

namespace ticktrue::engine {

/// The options of the worlds in tests/worlds/hashes.tsv: small worlds, so that emulators can run them.
inline constexpr RandomWorldOptions hashed_worlds{60, 60};

/// A world, and the hash of its state after its last tick, or after the last tick without an error.
struct WorldHash {
  std::uint64_t seed = 0;
  std::uint64_t tick_count = 0;  // ticks done
  std::uint64_t hash = 0;
  bool operator==(const WorldHash&) const = default;
};
/// Runs random_world(seed, hashed_worlds). Adds the counts of its cached structures to `counts`.
WorldHash hash_world(std::uint64_t seed, CacheReport* counts = nullptr);

/// Lines "seed, ticks, hash" with tabs between; lines that begin with # are comments.
std::string print_world_hashes(const std::vector<WorldHash>& worlds);
/// Errors: corrupt, with `place` and the line.
Result<std::vector<WorldHash>> parse_world_hashes(const std::string& text, const std::string& place);

}  // namespace ticktrue::engine
