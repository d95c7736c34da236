// The rows in which a player's state differs from the recorder's: found for a bundle, and applied when it is read.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "base/state/state_view.h"
#include "replay/format/trace.h"

namespace ticktrue::verifier {

/// Fills has_state, tables and is_cut: with at most as many rows as a trace may store of a player.
void set_peer_rows(const StateSchema& schema, std::span<const ImageTable> recorder, std::span<const ImageTable> player,
                   replay::PeerRecord& peer);

/// The rows of each table of the player. Errors: corrupt (rows that the recorder lacks).
Result<std::vector<Bytes>> rows_of_peer(const StateSchema& schema, std::span<const ImageTable> recorder,
                                        const replay::PeerRecord& peer);

/// Views of such rows.
std::vector<ImageTable> tables_of(const StateSchema& schema, const std::vector<Bytes>& rows);

/// The root hash of a state that consists of little-endian rows.
std::uint64_t root_of_tables(const StateSchema& schema, std::span<const ImageTable> tables);

}  // namespace ticktrue::verifier
