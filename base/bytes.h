// Byte buffers and little-endian encoding. Only this header and base/state/ know the byte order of the machine.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/float_rules.h"

namespace ticktrue {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

inline constexpr bool machine_is_little_endian = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;

/// Reverses the bytes of scalars in place. `scalar_size` is 1, 2, 4 or 8.
void reverse_scalar_bytes(std::uint8_t* bytes, std::size_t scalar_size, std::size_t scalar_count);

/// The unsigned integer with the same bits as a float.
inline std::uint32_t bits_of(float value) {
  return __builtin_bit_cast(std::uint32_t, value);
}
inline std::uint64_t bits_of(double value) {
  return __builtin_bit_cast(std::uint64_t, value);
}
inline float float_of_bits(std::uint32_t bits) {
  return __builtin_bit_cast(float, bits);
}
inline double double_of_bits(std::uint64_t bits) {
  return __builtin_bit_cast(double, bits);
}

/// Appends little-endian values to its own buffer.
class ByteWriter {
 public:
  void u8(std::uint8_t value) { bytes_.push_back(value); }
  void u16(std::uint16_t value) { scalar(value); }
  void u32(std::uint32_t value) { scalar(value); }
  void u64(std::uint64_t value) { scalar(value); }
  void i32(std::int32_t value) { scalar(static_cast<std::uint32_t>(value)); }
  void f64(double value) { scalar(bits_of(value)); }
  /// u32 length, then the bytes of the text.
  void text(std::string_view value);
  void bytes(ByteView value) { bytes_.insert(bytes_.end(), value.begin(), value.end()); }
  /// LEB128: 7 bits per byte, low bits first, top bit set on all bytes but the last.
  void varint(std::uint64_t value);

  std::size_t size() const { return bytes_.size(); }
  void clear() { bytes_.clear(); }
  ByteView view() const { return bytes_; }
  Bytes take() { return std::move(bytes_); }

 private:
  template <typename U>
  void scalar(U value) {
    for (std::size_t i = 0; i < sizeof(U); ++i) bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  Bytes bytes_;
};

/// Reads little-endian values from a view. Past the end, or after any failed read, every read gives zero and ok() stays
/// false. Check ok() once at the end of a group, and before a count is used to allocate.
class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : bytes_(bytes) {}

  std::uint8_t u8() { return scalar<std::uint8_t>(); }
  std::uint16_t u16() { return scalar<std::uint16_t>(); }
  std::uint32_t u32() { return scalar<std::uint32_t>(); }
  std::uint64_t u64() { return scalar<std::uint64_t>(); }
  std::int32_t i32() { return static_cast<std::int32_t>(scalar<std::uint32_t>()); }
  double f64() { return double_of_bits(scalar<std::uint64_t>()); }
  /// A text of at most `size_max` bytes; a longer text fails.
  std::string text(std::size_t size_max);
  ByteView bytes(std::size_t size);
  /// Fails on more than 10 bytes, on overflow and on a padded (non-shortest) form.
  std::uint64_t varint();

  bool ok() const { return ok_; }
  void fail() { ok_ = false; }
  std::size_t offset() const { return offset_; }
  std::size_t remaining() const { return ok_ ? bytes_.size() - offset_ : 0; }
  bool at_end() const { return remaining() == 0; }

 private:
  template <typename U>
  U scalar() {
    const ByteView part = bytes(sizeof(U));
    if (part.empty()) return 0;
    U value = 0;
    for (std::size_t i = 0; i < sizeof(U); ++i) value = static_cast<U>(value | (static_cast<U>(part[i]) << (8 * i)));
    return value;
  }
  ByteView bytes_;
  std::size_t offset_ = 0;
  bool ok_ = true;
};

}  // namespace ticktrue
