// Reads a trace in every way there is and checks what must hold of any bytes.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"

namespace ticktrue::fuzz {

/// Opens, reads to the end, seeks, recovers; where the trace is one of the toy, verifies it.
void read_in_every_way(ByteView bytes);

/// The trace with the sequence, ticks, chain and checks that a writer would give it; all else as it is.
Bytes with_right_checks(ByteView bytes);

}  // namespace ticktrue::fuzz
