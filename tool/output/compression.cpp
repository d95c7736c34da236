// The only file that sees stb_image_write.
// SPDX-License-Identifier: MIT
#include "tool/output/compression.h"

#include <cstdlib>

#include "base/assert.h"

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#include <stb/stb_image_write.h>

namespace ticktrue {
namespace {

constexpr int match_count = 32;  // of candidates for each match

void append(void* to, void* data, int size) {
  const auto* begin = static_cast<const std::uint8_t*>(data);
  static_cast<Bytes*>(to)->insert(static_cast<Bytes*>(to)->end(), begin, begin + size);
}

}  // namespace

Bytes zlib_of(Bytes bytes) {
  TICKTRUE_ASSERT(bytes.size() < std::size_t{1} << 30);
  if (bytes.empty())
    return {0x78, 0x01, 0x03, 0x00, 0x00, 0x00, 0x00, 0x01};  // stb_image_write leaves out its one block
  int size = 0;
  unsigned char* stream = stbi_zlib_compress(bytes.data(), static_cast<int>(bytes.size()), &size, match_count);
  TICKTRUE_ASSERT(stream != nullptr);
  Bytes out(stream, stream + size);
  std::free(stream);
  return out;
}

Bytes png_of_rgb(const Bytes& rgb, int width, int height) {
  TICKTRUE_ASSERT(rgb.size() == std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  Bytes file;
  const int written = stbi_write_png_to_func(append, &file, width, height, 3, rgb.data(), 3 * width);
  TICKTRUE_ASSERT(written != 0);
  return file;
}

}  // namespace ticktrue
