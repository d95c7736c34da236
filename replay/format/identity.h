// The identity of a session: equal for all its players, whatever each player stores.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "base/bytes.h"
#include "base/state/schema.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

/// Encodes the judged schema for the identity: in the layout of version 3, without ranges.
void encode_judged_schema(const StateSchema& schema, ByteWriter& out);

/// Computed from simulation, version, dt, judged columns and setup bytes. Title, detail, features, ranges, shown
/// columns and the format version do not count. docs/trace_format.md, "Session identity".
std::uint64_t session_identity(const TraceSetup& setup);

}  // namespace ticktrue::replay
