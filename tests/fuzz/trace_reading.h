// Reads a trace in every way there is and checks what must hold of any bytes.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"

namespace ticktrue::fuzz {

/// Opens, reads to the end, seeks, recovers; where the trace is one of the toy, verifies it.
void read_in_every_way(ByteView bytes);

}  // namespace ticktrue::fuzz
