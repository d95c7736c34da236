// Blocks of memory at falling or scattered addresses, and with a given alignment.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>

namespace ticktrue::shim {

/// `order` and `most_alignment` as in Settings. Null: the arena is full, or could not be reserved.
void* arena_allocate(std::size_t alignment, std::size_t size, std::uint32_t order, std::uint32_t most_alignment,
                     std::uint64_t number);
void arena_free(void* block);
bool is_in_arena(const void* block);
std::size_t arena_size(const void* block);

}  // namespace ticktrue::shim
