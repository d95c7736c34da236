// The known facts of a desync: the tick, the players, and the values of each player in differing columns and rows. As
// text and JSON.
// SPDX-License-Identifier: MIT
//
// The report names players, never "here" and "there": every player prints the same report.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/state/row_names.h"
#include "base/state/state_view.h"
#include "replay/format/trace.h"
#include "verifier/locate/locate_contents.h"

namespace ticktrue::verifier {

/// One player at the differing tick.
struct DesyncPlayer {
  std::uint32_t player = 0;
  std::optional<std::uint64_t> root;
  std::optional<replay::TickInputs> inputs;
  std::optional<std::vector<ImageTable>> tables;  // the state, where it is known; must outlive this
  bool lost_state = false;                        // the player no longer has this tick
  std::vector<std::string> hashed;                // where the state is not known: what differs by its hashes
  replay::BuildFacts facts;                       // empty: no hello came
};

/// One value that differs between players.
struct DesyncLane {
  StatePlace place;                                  // row: of the first player with this row
  std::optional<std::uint64_t> id;                   // of the row, if its table has ids
  std::string name;                                  // of the row
  std::string where;                                 // of an element of a list: "units[3].inventory[2]"; else empty
  std::vector<std::optional<std::uint64_t>> values;  // [player], bits; nothing: no such row, or no such state
};

/// A text or a string of bytes that is not the same for all.
struct DesyncContent {
  ContentDifference what;                         // its sides are moved to `sides`
  std::string name;                               // of the row at the begin of its place
  std::vector<std::optional<ContentSide>> sides;  // [player]; nothing: no such row, or no such state
};

struct DesyncFinding {
  std::string simulation;
  std::uint64_t tick = 0;
  std::optional<std::uint64_t> agreed;  // the last tick that was equal for all
  std::vector<DesyncPlayer> players;    // ascending
  std::vector<DesyncLane> lanes;        // in table, row, column, lane order; the first of them
  std::uint64_t lane_count = 0;         // of all, but those of texts and strings of bytes
  std::vector<DesyncContent> contents;  // in table and owner order; the first of them
  std::uint64_t content_count = 0;      // of all
  bool is_cut = false;                  // more may differ than was sent
  bool is_whole = false;                // the states of all players of which a root is known were compared
};

/// Fills lanes, contents and their counts from the states of the players.
void compare_players(const StateSchema& schema, const RowNamer& row_name, DesyncFinding& finding);

/// Players with the same root. The largest group is first; of equally large groups, the one with the lowest player.
std::vector<std::vector<std::size_t>> root_groups(const DesyncFinding& finding);

std::string desync_text(const StateSchema& schema, const DesyncFinding& finding);
/// One JSON object, without a line break at its end.
std::string desync_json(const StateSchema& schema, const DesyncFinding& finding);

}  // namespace ticktrue::verifier
