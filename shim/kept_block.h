// A block of the heap of `ticktrue unsaved`, shared by the preload library and the session.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace ticktrue::shim {

inline constexpr std::size_t kept_depth_max = 14;
inline constexpr std::uint64_t kept_magic = 0x6b636f6c6274706b;

/// Blocks are contiguous. The header of each block is before it.
struct alignas(16) KeptBlock {
  std::uint64_t magic;
  std::uint64_t whole;    // bytes to the next header
  std::uint64_t size;     // bytes that the program asked for
  std::uint64_t number;   // of the allocation, from 1
  std::uint32_t offset;   // from the header to the block
  std::uint32_t is_live;  // 0: it was freed
  std::uint32_t depth;    // of the stack; 0: not recorded
  std::uint32_t spare;
  const void* stack[kept_depth_max];  // return addresses, the innermost first
  KeptBlock* next_free;
  KeptBlock* self;  // directly before the block, wherever the block begins
};

/// The values of the heap that the session reads and sets.
struct KeptHeap {
  char* begin;              // null: no block was allocated
  char* top;                // after the last block
  std::uint64_t number;     // of allocations
  std::uint32_t has_reuse;  // 0: no freed block is reused
};

}  // namespace ticktrue::shim
