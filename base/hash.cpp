// The only file that includes xxhash.h.
// SPDX-License-Identifier: MIT
#include "base/hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace ticktrue {

std::uint64_t hash64(ByteView bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

namespace {
std::string hex(std::uint64_t value, int digit_count) {
  std::string text(static_cast<std::size_t>(digit_count), '0');
  for (int i = digit_count - 1; i >= 0; --i, value >>= 4)
    text[static_cast<std::size_t>(i)] = "0123456789abcdef"[value & 15];
  return text;
}
}  // namespace

std::string hex64(std::uint64_t value) {
  return hex(value, 16);
}
std::string hex32(std::uint32_t value) {
  return hex(value, 8);
}

}  // namespace ticktrue
