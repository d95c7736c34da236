// Fuzzes files of frame times: each one returned is a length of time.
// SPDX-License-Identifier: MIT
#include "tests/fuzz/support/fuzz.h"
#include "tool/session/host_frames.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ticktrue;
  const fuzz::MemoryFile file({data, size});
  auto frames = tool::open_host(file.path(), 1);
  if (!frames) {
    fuzz::require_message(frames.error());
    return 0;
  }
  for (;;) {
    const auto frame = (*frames)->next();
    if (!frame) {
      fuzz::require_message(frame.error());
      return 0;
    }
    if (!frame->has_value()) return 0;
    fuzz::require(**frame > 0 && **frame < 1e9, "a frame is a length of time");
  }
}
