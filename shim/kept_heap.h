// The heap of `ticktrue unsaved`: contiguous blocks that record where they were allocated.
// SPDX-License-Identifier: MIT
#pragma once

#include "shim/kept_block.h"

namespace ticktrue::shim {

/// Null: the heap is full.
void* kept_allocate(std::size_t alignment, std::size_t size);
void kept_free(void* block);
bool is_kept(const void* block);
std::size_t kept_size(const void* block);

}  // namespace ticktrue::shim
