// Writes a picture as PNG.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"
#include "tool/play/picture/canvas.h"

namespace ticktrue::play {

/// The whole file: 8 bits each of red, green and blue.
Bytes png_of(const Canvas& canvas);

}  // namespace ticktrue::play
