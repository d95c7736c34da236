// The pixels of a canvas as bytes of a PNG file.
// SPDX-License-Identifier: MIT
#include "tool/play/picture/png.h"

#include "tool/output/compression.h"

namespace ticktrue::play {

Bytes png_of(const Canvas& canvas) {
  Bytes rgb;
  rgb.reserve(3 * canvas.pixels().size());
  for (const std::uint32_t pixel : canvas.pixels())
    for (const int shift : {16, 8, 0}) rgb.push_back(static_cast<std::uint8_t>(pixel >> shift));
  return png_of_rgb(rgb, canvas.width(), canvas.height());
}

}  // namespace ticktrue::play
