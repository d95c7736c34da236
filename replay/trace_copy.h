// Copies what a reader gives into a writer: for recovery.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/result.h"
#include "replay/trace_reader.h"
#include "replay/trace_writer.h"

namespace ticktrue::replay {

/// A tick or a checkpoint with all that belongs to it. The first checkpoint may stand at any tick.
Status copy_item(const TraceReader::Item& item, TraceWriter& writer);

/// The tick in flight and the end: that of the tail, or `recovered`.
Status finish_copy(const TraceTail& tail, TraceWriter& writer);

}  // namespace ticktrue::replay
