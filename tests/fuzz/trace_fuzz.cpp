// Fuzzes traces as they are: nearly every change meets a checksum.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/support/trace_reading.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ticktrue::fuzz::read_in_every_way({data, size});
  return 0;
}
