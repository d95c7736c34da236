// A bundle: a trace with what its recorder knows of the other players at the tick from which on their states differ.
// SPDX-License-Identifier: MIT
//
// Verified: sizes, order, and that the rows of a player give the root that this player told. Not verified: what other
// players told of themselves.
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

/// What a bundle says. Owns the states that the finding points to.
class Bundle {
 public:
  /// Nothing: the trace holds no other player. Reads the trace; then tail() of the reader is not that of its end.
  /// Errors: corrupt (rows that do not fit to the state of the recorder).
  static Result<std::optional<Bundle>> read(replay::TraceReader& reader);

  std::uint32_t recorder() const { return recorder_; }
  const DesyncFinding& finding() const { return finding_; }
  /// What does not fit together, a line each.
  const std::vector<std::string>& warnings() const { return warnings_; }
  /// "players 0, 1; recorded by player 0".
  std::string players_text() const;
  /// The report of the desync, and a line for each warning.
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
  std::vector<ImageTable> tables_;        // of the image; empty: not known
  std::vector<std::vector<Bytes>> rows_;  // [player][table]
};

/// The same from the setup alone, for a report about the trace: empty if it is no bundle.
std::string bundle_note(const replay::TraceSetup& setup, const std::string& file);
/// "players 0, 1; recorded by player 0" of the peers of a trace; empty without peers.
std::string players_text(std::span<const replay::PeerRecord> peers);

}  // namespace ticktrue::verifier
