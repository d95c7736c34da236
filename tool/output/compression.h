// Compresses bytes and pictures, by stb_image_write.
// SPDX-License-Identifier: MIT
#pragma once

#include "base/bytes.h"

namespace ticktrue {

/// A zlib stream (RFC 1950) of these bytes. Requires: fewer than 2^30 bytes.
Bytes zlib_of(Bytes bytes);

/// A PNG file, 8 bits each of red, green and blue. Requires: rgb holds 3 * width * height bytes, row by row from above.
Bytes png_of_rgb(const Bytes& rgb, int width, int height);

}  // namespace ticktrue
