// Reads a trace in every way there is and checks what must hold of any bytes.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"

namespace ticktrue::fuzz {

/// Opens the trace, reads it to the end, seeks and recovers. A trace of the toy is verified, too.
void read_in_every_way(ByteView bytes);

/// The trace with the sequence, ticks, chain and checks that a writer would give it. No other byte changes.
Bytes with_right_checks(ByteView bytes);

}  // namespace ticktrue::fuzz
