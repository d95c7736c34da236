// What a build without SDL2 has instead of a window.
// SPDX-License-Identifier: MIT
#include "tool/play/window/host.h"

namespace ticktrue::play {

Result<std::unique_ptr<Host>> open_window(const std::string&, WindowSize) {
  return Error{ErrorCode::usage,
               "window: this build has none: found no SDL2 when it was configured, or it was left out",
               "install libsdl2-dev and configure with TICKTRUE_WITH_SDL2=ON, or play without a window: --headless"};
}

}  // namespace ticktrue::play
