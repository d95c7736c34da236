// XXH3-128, for files that are named by their content. The same value on every platform.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "base/bytes.h"

namespace ticktrue {

struct Hash128 {
  std::uint64_t high = 0;
  std::uint64_t low = 0;
  bool operator==(const Hash128&) const = default;
};

/// Source: xxHash 0.8 specification.
Hash128 hash128(ByteView bytes);

/// The hash of bytes that come in parts: the same value as that of all bytes at once.
class Hash128Stream {
 public:
  Hash128Stream();
  void add(ByteView bytes);
  Hash128 value() const;

 private:
  alignas(64) std::array<std::uint8_t, 576> state_;
};

/// Thirty-two lower-case hexadecimal digits, in the form of xxh128sum.
std::string hex128(const Hash128& value);

}  // namespace ticktrue
