// A soak: the oracle examines one random world after another. Failing worlds are shrunk and written to files.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/experiment/oracle/oracle.h"
#include "tool/experiment/soak/counters.h"
#include "tool/experiment/soak_case.h"

namespace ticktrue::soak {

/// The source of worlds: engine/random_worlds, or a test.
struct WorldSource {
  struct World {
    SoakCase soak_case;
    std::vector<std::string> choices;  // choices that the world uses: "joint/weld"
  };
  std::function<World(std::uint64_t world_seed)> make;
  /// The world without a choice; absent if there is no such world.
  std::function<std::optional<SoakCase>(std::uint64_t world_seed, const std::string& choice)> without;
  std::vector<std::string> choices;  // all choices, so that unused choices are reported
  std::function<bool(const std::string& choice)> choice_changes_bits;  // false: only the use is counted, not its effect
};
/// The worlds of engine/random_worlds.
WorldSource random_worlds();

struct SoakOptions {
  std::uint64_t seed = 1;
  std::uint64_t world_count = 1000;
  std::optional<std::uint64_t> only_world;  // runs only the world of this index; stores no progress
  double time_s = 0;                        // no world begins later; 0: no limit
  unsigned thread_count = 1;                // worlds at the same time
  bool resume = false;
  std::string folder;                     // for progress and failures; created if missing
  std::size_t failure_count_max = 8;      // the soak ends after this many failing worlds
  double shrink_time_s = 30;              // limit for one failure
  std::uint64_t known_world_count = 0;    // number of first worlds in which physics is counted
  std::uint64_t hits_expected_after = 0;  // number of worlds after which every cache must have been hit; 0: not checked
  std::string checks_text;                // part of the identity of the progress
  OracleOptions oracle;
  WorldSource worlds;
  /// May be called from any thread, but never from two at once. False stops the soak. May be empty.
  std::function<bool(const SoakCounters& counters, double seconds)> progress;
};

struct SoakReport {
  SoakCounters counters;
  double seconds = 0;            // of this run, without earlier runs
  std::uint64_t new_worlds = 0;  // of this run
  bool is_whole = false;         // all requested worlds are done
};

/// Generator seed of a world: SplitMix64 of the soak's seed and the index (mix).
std::uint64_t world_seed(std::uint64_t seed, std::uint64_t index);

/// Errors: io (folder, progress), corrupt and incompatible (progress), unsupported (check_float_behaviour).
Result<SoakReport> run_soak(const SoakOptions& options);

/// Worlds between two saves of the progress. Effects are counted from the state of the last save, so that a resumed
/// soak counts the same as an uninterrupted soak. A block ends with its slowest world: smaller blocks leave processors
/// idle.
inline constexpr std::uint64_t worlds_per_block = 128;

}  // namespace ticktrue::soak
