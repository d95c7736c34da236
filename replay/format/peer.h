// The payload of a peer chunk: what a bundle says about another player.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/schema.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

TickInputs inputs_of(double dt, ByteView inputs);

/// Errors: limit.
Status check_peer(const PeerRecord& peer, const std::string& place);
/// Requires: check_peer.
void encode_peer(const PeerRecord& peer, ByteWriter& out);
/// `schema`: the judged schema of the trace. Errors: corrupt.
Result<PeerRecord> decode_peer(const StateSchema& schema, ByteView payload);

}  // namespace ticktrue::replay
