// Loops over packed rows that benefit from a machine's widest vectors. Values are the same for every instruction set.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace ticktrue {

struct RowKernels {
  /// XXH3-64.
  std::uint64_t (*hash)(const std::uint8_t* bytes, std::size_t size, std::uint64_t seed);

  /// The sums over pairs of rows of products of words: docs/trace_format.md, "Cells". `first`: the even index in the
  /// table of the first row. Writes one sum for each word of a row. Requires: at least four words.
  void (*sum_products)(const std::uint32_t* rows, std::size_t word_count, std::size_t first, std::size_t row_count,
                       std::uint64_t* sums);

  /// Whether (word & mask) == want for any word of any row. Requires: at least four words.
  bool (*any_match)(const std::uint8_t* rows, std::size_t word_count, std::size_t row_count, const std::uint32_t* mask,
                    const std::uint32_t* want);

  /// XXH3-128 in parts. `state` is aligned to 64 bytes; start128 asserts that `state_size` suffices.
  void (*start128)(void* state, std::size_t state_size);
  void (*add128)(void* state, const std::uint8_t* bytes, std::size_t size);
  void (*value128)(const void* state, std::uint64_t* high, std::uint64_t* low);
};

/// The kernels of each instruction set that this build has and this machine runs, the widest last.
std::span<const RowKernels* const> all_row_kernels();
/// The kernels of the widest instruction set.
const RowKernels& row_kernels();

/// The step of row keys: row r has the key (r + 1) * row_step. The step is 2^32 / golden ratio, so that keys spread
/// evenly.
inline constexpr std::uint32_t row_step = 0x9e3779b9u;

namespace baseline {
extern const RowKernels row_kernels;
}
namespace avx2 {
extern const RowKernels row_kernels;  // if TICKTRUE_HAS_AVX2_ROWS is defined
}

}  // namespace ticktrue
