// The choice of row kernels for this machine; hashes as text.
// SPDX-License-Identifier: MIT
#include "base/hash.h"

#include "base/row_kernels.h"

namespace ticktrue {

std::span<const RowKernels* const> all_row_kernels() {
#ifdef TICKTRUE_HAS_AVX2_ROWS
  static constexpr const RowKernels* list[] = {&baseline::row_kernels, &avx2::row_kernels};
  return {list, __builtin_cpu_supports("avx2") ? 2u : 1u};
#else
  static constexpr const RowKernels* list[] = {&baseline::row_kernels};
  return list;
#endif
}

const RowKernels& row_kernels() {
  static const RowKernels& widest = *all_row_kernels().back();
  return widest;
}

std::uint64_t hash64(ByteView bytes, std::uint64_t seed) {
  return row_kernels().hash(bytes.data(), bytes.size(), seed);
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
