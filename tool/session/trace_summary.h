// A summary of a trace from one read, without simulating.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene/input.h"
#include "engine/scene/scene.h"
#include "replay/trace_reader.h"

namespace ticktrue::tool {

/// Converts the inputs of a trace back to the lines from which the inputs were recorded.
class InputListing {
 public:
  explicit InputListing(const replay::TraceSetup& setup);

  /// False if the trace is from another simulation, or from a scene that this build cannot read. text() then gives
  /// bytes.
  bool is_readable() const { return scene_.has_value(); }
  /// JSON Lines of the inputs of one tick. Inputs that cannot be read become one object with their bytes in
  /// hexadecimal.
  std::string text(std::uint64_t tick, ByteView inputs);
  /// The line that ends a session before this tick.
  std::string end_text(std::uint64_t tick) const;
  /// Adds the inputs of a tick to the counts per kind; false if the inputs cannot be read.
  bool count(ByteView inputs, std::vector<std::uint64_t>& count_of_kind);

 private:
  std::optional<engine::Scene> scene_;
  std::vector<engine::Input> inputs_;
};

struct CheckpointSummary {
  std::uint64_t tick = 0;
  std::uint64_t root_hash = 0;
  std::uint64_t image_size = 0;                           // bytes of the state
  std::uint64_t stored_size = 0;                          // bytes in the file
  std::optional<std::uint64_t> save_size = std::nullopt;  // bytes of its save; absent: no intact save
};

struct TraceSummary {
  replay::TraceTail tail;
  std::optional<std::uint64_t> salvaged_from;  // as in verifier::TraceEnd
  std::uint64_t tick_count = 0;
  double time_s = 0;
  std::uint64_t input_tick_count = 0;                // ticks that have inputs
  std::uint64_t input_size = 0;                      // bytes
  std::optional<std::vector<std::uint64_t>> inputs;  // count per engine::InputKind; absent: the inputs cannot be read
  std::uint64_t last_root_hash = 0;
  std::vector<CheckpointSummary> checkpoints;
  // The bytes of the file by content:
  std::uint64_t setup_size = 0;  // before the first record: header, setup, build facts
  std::uint64_t checkpoint_size = 0;
  std::uint64_t tick_size = 0;  // inputs, hashes, states in full
  std::uint64_t rest_size = 0;  // end, index, and unreadable bytes
};

/// Reads the trace from its start. `progress` (bytes done, bytes in total) may be empty.
TraceSummary summarize(replay::TraceReader& trace, const std::function<void(std::uint64_t, std::uint64_t)>& progress);

}  // namespace ticktrue::tool
