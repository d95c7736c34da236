// Little-endian encoding of values of varying size.
// SPDX-License-Identifier: MIT
#include "base/bytes.h"

#include <algorithm>

namespace ticktrue {

void reverse_scalar_bytes(std::uint8_t* bytes, std::size_t scalar_size, std::size_t scalar_count) {
  for (std::size_t i = 0; i < scalar_count; ++i, bytes += scalar_size) std::reverse(bytes, bytes + scalar_size);
}

void ByteWriter::text(std::string_view value) {
  u32(static_cast<std::uint32_t>(value.size()));
  bytes_.insert(bytes_.end(), value.begin(), value.end());
}

void ByteWriter::varint(std::uint64_t value) {
  while (value >= 0x80) {
    bytes_.push_back(static_cast<std::uint8_t>(value | 0x80));
    value >>= 7;
  }
  bytes_.push_back(static_cast<std::uint8_t>(value));
}

ByteView ByteReader::bytes(std::size_t size) {
  if (!ok_ || size > bytes_.size() - offset_) {
    ok_ = false;
    return {};
  }
  const ByteView part = bytes_.subspan(offset_, size);
  offset_ += size;
  return part;
}

std::string ByteReader::text(std::size_t size_max) {
  const std::size_t size = u32();
  if (size > size_max) ok_ = false;
  const ByteView part = bytes(size);
  return std::string(part.begin(), part.end());
}

std::uint64_t ByteReader::varint() {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 70; shift += 7) {
    const std::uint8_t byte = u8();
    if (!ok_) return 0;
    if (shift == 63 && byte > 1) break;
    value |= static_cast<std::uint64_t>(byte & 0x7f) << shift;
    if ((byte & 0x80) == 0) {
      if (byte == 0 && shift > 0) break;
      return value;
    }
  }
  ok_ = false;
  return 0;
}

}  // namespace ticktrue
