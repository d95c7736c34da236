// The identity of a session: what all its players must have in common, whatever each of them stores.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include "base/bytes.h"
#include "base/state/schema.h"
#include "replay/format/trace.h"

namespace ticktrue::replay {

/// The judged schema as the identity has it: in the layout of version 3, with no ranges.
void encode_judged_schema(const StateSchema& schema, ByteWriter& out);

/// Of simulation, version, dt, judged columns and setup bytes; title, detail, features, ranges, shown columns and the
/// format version do not count. docs/trace_format.md, "Session identity".
std::uint64_t session_identity(const TraceSetup& setup);

}  // namespace ticktrue::replay
