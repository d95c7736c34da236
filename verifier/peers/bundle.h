// A bundle: a trace with the recorder's knowledge about other players at the first tick with different states.
// SPDX-License-Identifier: MIT
//
// Verified: sizes, order, and that the rows of a player have the root that this player reported. Not verified:
// statements of other players about themselves.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "replay/trace_reader.h"
#include "verifier/peers/desync_report.h"

namespace ticktrue::verifier {

/// The content of a bundle. Owns the states to which the finding points.
class Bundle {
 public:
  /// Nothing: the trace has no other player. Reads the trace; afterwards tail() of the reader does not describe its
  /// end.
  /// Errors: corrupt (rows that do not fit the state of the recorder).
  static Result<std::optional<Bundle>> read(replay::TraceReader& reader);

  std::uint32_t recorder() const { return recorder_; }
  const DesyncFinding& finding() const { return finding_; }
  /// Contradictions in the bundle, one line each.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// "players 0, 1; recorded by player 0".
  std::string players_text() const;
  /// The report of the desync, with one line for each warning.
  std::string text(const StateSchema& schema) const;

 private:
  struct RecordedTicks;
  DesyncPlayer recorder_at(const replay::TraceReader& reader, const RecordedTicks& ticks);
  Result<DesyncPlayer> other_at(const StateSchema& schema, const replay::PeerRecord& peer);
  void find_agreed(const RecordedTicks& ticks, std::span<const replay::PeerRecord> peers);

  std::uint32_t recorder_ = 0;
  DesyncFinding finding_;
  std::vector<std::string> warnings_;
  Bytes image_;                           // of the recorder, after the tick
  std::vector<ImageTable> tables_;        // of the image; empty: unknown
  std::vector<std::vector<Bytes>> rows_;  // [player][table]
};

/// The players from the setup alone, for a report about the trace; empty: the trace is not a bundle.
std::string bundle_note(const replay::TraceSetup& setup, const std::string& file);
/// "players 0, 1; recorded by player 0", from the peers of a trace; empty without peers.
std::string players_text(std::span<const replay::PeerRecord> peers);

}  // namespace ticktrue::verifier
