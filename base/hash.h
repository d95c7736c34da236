// The one hash of the project: XXH3-64, the same value on every platform.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "base/bytes.h"

namespace ticktrue {

/// XXH3-64 of the bytes. Source: xxHash 0.8 specification (XXH3 is stable since 0.8.0).
std::uint64_t hash64(ByteView bytes, std::uint64_t seed = 0);

/// Sixteen lower-case hexadecimal digits, the form of hashes in all output.
std::string hex64(std::uint64_t value);
std::string hex32(std::uint32_t value);

}  // namespace ticktrue
