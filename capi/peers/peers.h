// The other players of a live session: their roots, their hellos, and the exchange that locates a desync.
// SPDX-License-Identifier: MIT
//
// It knows no transport and no clock: bytes come in and go out. Whatever comes in is checked, and refused without a
// change where it is not what it should be.
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
  /// `player`: own number. `kept_size`: bytes of states that are kept.
  Peers(std::uint32_t player, std::size_t kept_size) : player_(player), kept_(kept_size) {}
  Peers(const Peers&) = delete;
  Peers& operator=(const Peers&) = delete;

  /// What this player's game is. Before any call about other players.
  void set_game(const replay::TraceSetup& setup, const replay::BuildFacts& facts);
  bool has_game() const { return game_ != nullptr; }
  std::uint32_t player() const { return player_; }

  // ---- Ticks ----

  /// A confirmed tick of this player.
  void add(std::uint64_t tick, std::uint64_t root, double dt, ByteView inputs, const StateView& state);
  /// The state before tick 0, where states are kept.
  void begin(const StateView& state) {
    if (keeps_states_) kept_.begin(state);
  }
  /// From now on, states of confirmed ticks are kept.
  void keep_states() { keeps_states_ = true; }
  const RootTable& roots() const { return roots_; }
  const KeptTicks& kept() const { return kept_; }

  // ---- Other players. Requires: has_game(), a player other than this one, at most player_max. ----

  Bytes hello() const { return encode_hello(*game_); }
  /// Errors: corrupt.
  Result<HelloDifferences> take_hello(std::uint32_t peer, ByteView bytes);
  void add_root(std::uint32_t peer, std::uint64_t tick, std::uint64_t root);
  bool has_desync() const { return roots_.differing().has_value(); }

  /// The next message for that player, of at most `size` bytes; empty: none is due. Requires: message_size_min.
  Bytes next_message(std::uint32_t peer, std::size_t size);
  /// Errors: corrupt, incompatible (of another session, for another player).
  Status receive(std::uint32_t peer, ByteView bytes);

  /// Valid until the next call. Requires: has_desync().
  DesyncFinding finding(const RowNamer& row_name);
  /// The records of the other players, for a bundle. Requires: `finding` is the one that was made last.
  std::vector<replay::PeerRecord> records(const DesyncFinding& finding) const;
  /// This player's state after the tick that differs; null: not kept.
  const KeptState* state_at_desync() const { return location_ && location_->state ? &*location_->state : nullptr; }
  /// "player 1: 598 ticks compared, the same up to tick 599", a line each.
  std::vector<std::string> lines() const;

 private:
  /// What is known of one player at the tick that differs.
  struct Other {
    Exchange exchange;
    std::optional<CellsDocument> cells;
    std::optional<RowsDocument> sent;
    std::optional<OtherState> state;
    bool is_cut = false;  // not all rows that can differ came
  };
  /// The tick that the exchange is about.
  struct Location {
    std::uint64_t tick;                     // set where one begins
    std::optional<std::uint32_t> named_by;  // the player whose message named the tick; nothing: roots here did
    TickInputs inputs;
    std::optional<KeptState> state;
    Bytes cells_document;
    std::map<std::uint32_t, Other> others;
    Bytes buffer;  // for a finding
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
  double time_s_ = 0;  // simulated in confirmed ticks
  std::unique_ptr<Hello> game_;
  std::optional<StateSchema> schema_;
  std::unique_ptr<CellHasher> hasher_;
  std::map<std::uint32_t, Hello> hellos_;
  std::optional<Location> location_;
};

}  // namespace ticktrue::capi
