// Copies items from a reader to a writer, for recovery.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/result.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"

namespace ticktrue::replay {

/// Copies a tick or a checkpoint with all its records. The first checkpoint may be at any tick.
Status copy_item(const TraceReader::Item& item, TraceWriter& writer);

/// Copies the incomplete tick, and ends the trace as the tail does; a tail without an end record gives `recovered`.
Status finish_copy(const TraceTail& tail, TraceWriter& writer);

}  // namespace ticktrue::replay
