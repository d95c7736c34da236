// A soak: random worlds, one after the other, each examined by the oracle; what fails is shrunk and written down.
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

namespace ticktrue::verifier::soak {

/// Where worlds come from: engine/random_worlds, or a test.
struct WorldSource {
  struct World {
    SoakCase soak_case;
    std::vector<std::string> choices;  // "joint/weld": choices that the world uses
  };
  std::function<World(std::uint64_t world_seed)> make;
  /// The world without a choice; nothing if there is no such world.
  std::function<std::optional<SoakCase>(std::uint64_t world_seed, const std::string& choice)> without;
  std::vector<std::string> choices;                                    // every choice, so that unused ones are reported
  std::function<bool(const std::string& choice)> choice_changes_bits;  // false: only its use is counted, not its effect
};
/// Those of engine/random_worlds.
WorldSource random_worlds();

struct SoakOptions {
  std::uint64_t seed = 1;
  std::uint64_t world_count = 1000;
  std::optional<std::uint64_t> only_world;  // this index alone; no progress is stored
  double time_s = 0;                        // begin no world later; 0: no limit
  unsigned thread_count = 1;                // over worlds
  bool resume = false;
  std::string folder;                     // for progress and failures; made where it is missing
  std::size_t failure_count_max = 8;      // worlds; then the soak ends
  double shrink_time_s = 30;              // of one failure
  std::uint64_t known_world_count = 0;    // count physics in so many first worlds
  std::uint64_t hits_expected_after = 0;  // worlds, after which every cached structure was hit; 0: not examined
  std::string checks_text;                // part of the identity of the progress
  OracleOptions oracle;
  WorldSource worlds;
  /// Called on any thread, never on two at once; false stops; may be empty.
  std::function<bool(const SoakCounters& counters, double seconds)> progress;
};

struct SoakReport {
  SoakCounters counters;
  double seconds = 0;            // of this run, not of those before it
  std::uint64_t new_worlds = 0;  // of this run
  bool is_whole = false;         // all worlds that were asked for are done
};

/// Generator seed of a world: SplitMix64 of the soak's seed and the index (mix).
std::uint64_t world_seed(std::uint64_t seed, std::uint64_t index);

/// Errors: io (folder, progress), corrupt and incompatible (progress), unsupported (check_float_behaviour).
Result<SoakReport> run_soak(const SoakOptions& options);

/// Worlds between two savings of the progress. Effects are counted from the state of the last saving, so that a resumed
/// soak counts the same as an uninterrupted one. A block ends when its slowest world does: smaller blocks leave
/// processors idle.
inline constexpr std::uint64_t worlds_per_block = 128;

}  // namespace ticktrue::verifier::soak
