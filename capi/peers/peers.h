// The other players of a live session: their roots, their hellos, and the exchange that locates a desync.
// SPDX-License-Identifier: MIT
//
// No transport and no clock: bytes come in and go out. Received bytes are checked. Invalid bytes are refused without a
// change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/cells.h"
#include "base/state/kept_state.h"
#include "capi/peers/exchange.h"
#include "capi/peers/hello.h"
#include "capi/peers/kept_ticks.h"
#include "capi/peers/root_table.h"
#include "capi/peers/sent_rows.h"
#include "verifier/peers/desync_report.h"

namespace ticktrue::capi {

using verifier::desync_json;
using verifier::desync_text;
using verifier::DesyncFinding;
using verifier::DesyncPlayer;

class Peers {
 public:
  /// `player`: the number of this player. `kept_size`: bytes for stored states.
  Peers(std::uint32_t player, std::size_t kept_size) : player_(player), kept_(kept_size) {}
  Peers(const Peers&) = delete;
  Peers& operator=(const Peers&) = delete;

  /// Sets the game of this player. To be called before each call about other players.
  void set_game(const replay::TraceSetup& setup, const replay::BuildFacts& facts);
  bool has_game() const { return game_ != nullptr; }
  std::uint32_t player() const { return player_; }

  // ---- Ticks ----

  /// Adds a confirmed tick of this player.
  void add(std::uint64_t tick, std::uint64_t root, double dt, ByteView inputs, const StateView& state);
  /// Stores the state before tick 0, if states are stored.
  void begin(const StateView& state) {
    if (keeps_states_) kept_.begin(state);
  }
  /// From now on, states of confirmed ticks are stored.
  void keep_states() { keeps_states_ = true; }
  const RootTable& roots() const { return roots_; }
  const KeptTicks& kept() const { return kept_; }

  // ---- Other players. Requires: has_game(), a player other than this one, at most player_max. ----

  Bytes hello() const { return encode_hello(*game_); }
  /// Errors: corrupt.
  Result<HelloDifferences> take_hello(std::uint32_t peer, ByteView bytes);
  void add_root(std::uint32_t peer, std::uint64_t tick, std::uint64_t root);
  bool has_desync() const { return roots_.differing().has_value(); }

  /// The next message for this player, of at most `size` bytes; empty: no message is due. Requires: `size` of at least
  /// message_size_min.
  Bytes next_message(std::uint32_t peer, std::size_t size);
  /// Errors: corrupt, incompatible (for another session or another player).
  Status receive(std::uint32_t peer, ByteView bytes);

  /// Valid until the next call. Requires: has_desync().
  DesyncFinding finding(const RowNamer& row_name);
  /// The records of the other players, for a bundle. Requires: `finding` is from the last call of finding().
  std::vector<replay::PeerRecord> records(const DesyncFinding& finding) const;
  /// This player's state after the differing tick; null: not stored.
  const KeptState* state_at_desync() const { return location_ && location_->state ? &*location_->state : nullptr; }
  /// "player 1: 598 ticks compared, the same up to tick 599"; one line per player.
  std::vector<std::string> lines() const;

 private:
  /// What is known about one player at the differing tick.
  struct Other {
    Exchange exchange;
    std::optional<CellsDocument> cells;
    std::optional<RowsDocument> sent;
    std::optional<OtherState> state;
    bool is_cut = false;  // some rows that may differ were not received
  };
  /// The differing tick, and the exchange about it.
  struct Location {
    std::uint64_t tick;                     // set when the exchange begins
    std::optional<std::uint32_t> named_by;  // the player whose message named the tick; nothing: the roots here did
    TickInputs inputs;
    std::optional<KeptState> state;
    Bytes cells_document;
    std::map<std::uint32_t, Other> others;
    Bytes buffer;  // storage for the state in a finding
  };

  void locate(std::uint64_t tick, std::optional<std::uint32_t> named_by);
  void update();
  Other& other(std::uint32_t peer);
  Status read_documents(std::uint32_t peer, Other& other);
  bool rows_are_due(const Other& other, std::uint32_t peer) const;
  Status read_cells(std::uint32_t peer, Other& other, ByteView bytes);
  const StateSchema& schema() const { return *schema_; }

  std::uint32_t player_;
  KeptTicks kept_;
  bool keeps_states_ = false;
  RootTable roots_;
  double time_s_ = 0;  // simulated time of confirmed ticks
  std::unique_ptr<Hello> game_;
  std::optional<StateSchema> schema_;
  std::unique_ptr<CellHasher> hasher_;
  std::map<std::uint32_t, Hello> hellos_;
  std::optional<Location> location_;
};

}  // namespace ticktrue::capi
