// Fuzzes what stands behind the checksums of a trace: every check is made right before the reader sees the bytes.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/support/trace_reading.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ticktrue::fuzz::read_in_every_way(ticktrue::fuzz::with_right_checks({data, size}));
  return 0;
}
