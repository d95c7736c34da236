// malloc and its family: fresh and freed blocks are filled, or are placed elsewhere.
// SPDX-License-Identifier: MIT
#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "shim/arena.h"
#include "shim/kept_heap.h"
#include "shim/shim.h"

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);
}

namespace ticktrue::shim {
namespace {

constexpr std::size_t smallest_alignment = 16;

std::size_t size_of(void* block) {
  static std::size_t (*real)(void*) = nullptr;
  if (is_in_arena(block)) return arena_size(block);
  if (is_kept(block)) return kept_size(block);
  const auto found = real_function(real, "malloc_usable_size");
  return found == nullptr ? 0 : found(block);
}

void fill(void* block, std::size_t size, std::uint64_t number) {
  const std::int32_t byte = settings().heap_fill;
  if (byte == heap_fill_off || block == nullptr || size == 0) return;
  ::memset(block, byte == heap_fill_varied ? static_cast<int>(mixed(number) % 255 + 1) : byte, size);
  count_change();
}

bool wants_arena() {
  return settings().heap_order != 0 || settings().heap_alignment != 0 || settings().heap_kept != 0;
}

/// Allocates a block without filling it.
void* place(const Call& call, std::size_t alignment, std::size_t size) {
  if (call.is_changed && settings().heap_kept != 0) {
    if (void* block = kept_allocate(alignment, size); block != nullptr) return block;
  } else if (call.is_changed && wants_arena()) {
    void* block = arena_allocate(alignment, size, settings().heap_order, settings().heap_alignment, call.number);
    if (block != nullptr) {
      count_change();
      return block;
    }
  }
  return alignment <= smallest_alignment ? __libc_malloc(size) : __libc_memalign(alignment, size);
}

void release(void* block) {
  if (is_in_arena(block))
    arena_free(block);
  else if (is_kept(block))
    kept_free(block);
  else
    __libc_free(block);
}

void* aligned(std::size_t alignment, std::size_t size) {
  const Call call = begin_call(Function::memalign, size);
  void* block = place(call, alignment, size);
  if (call.is_changed) fill(block, size, call.number);
  return block;
}

}  // namespace
}  // namespace ticktrue::shim

using namespace ticktrue::shim;

TICKTRUE_SHIM_API void* malloc(std::size_t size) {
  const Call call = begin_call(Function::malloc, size);
  void* block = place(call, smallest_alignment, size);
  if (call.is_changed) fill(block, size, call.number);
  return block;
}

TICKTRUE_SHIM_API void* calloc(std::size_t count, std::size_t size) {
  std::size_t whole = 0;
  const Call call = begin_call(Function::calloc, count * size);
  if (!call.is_changed || !wants_arena() || __builtin_mul_overflow(count, size, &whole))
    return __libc_calloc(count, size);
  void* block = place(call, smallest_alignment, whole);
  if (block != nullptr) ::memset(block, 0, whole);
  return block;
}

TICKTRUE_SHIM_API void free(void* block) {
  if (block == nullptr) return;
  const int error = errno;
  const Call call = begin_call(Function::free);
  if (call.is_changed && settings().heap_fill != heap_fill_off) fill(block, size_of(block), call.number);
  release(block);
  errno = error;
}

TICKTRUE_SHIM_API void* realloc(void* block, std::size_t size) {
  if (block == nullptr) return malloc(size);
  const Call call = begin_call(Function::realloc, size);
  if (size == 0) {
    release(block);
    return nullptr;
  }
  const bool moves = is_in_arena(block) || is_kept(block) || (call.is_changed && wants_arena());
  if (!moves && (!call.is_changed || settings().heap_fill == heap_fill_off)) return __libc_realloc(block, size);
  const std::size_t before = size_of(block);
  if (!moves) {
    void* grown = __libc_realloc(block, size);
    if (grown != nullptr && size > before) fill(static_cast<char*>(grown) + before, size - before, call.number);
    return grown;
  }
  void* moved = place(call, smallest_alignment, size);
  if (moved == nullptr) return nullptr;
  if (call.is_changed) fill(moved, size, call.number);
  ::memcpy(moved, block, before < size ? before : size);
  release(block);
  return moved;
}

TICKTRUE_SHIM_API void* reallocarray(void* block, std::size_t count, std::size_t size) {
  std::size_t whole = 0;
  if (__builtin_mul_overflow(count, size, &whole)) {
    errno = ENOMEM;
    return nullptr;
  }
  return realloc(block, whole);
}

TICKTRUE_SHIM_API void* memalign(std::size_t alignment, std::size_t size) {
  return aligned(alignment, size);
}
TICKTRUE_SHIM_API void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return aligned(alignment, size);
}
TICKTRUE_SHIM_API void* valloc(std::size_t size) {
  return aligned(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)), size);
}
TICKTRUE_SHIM_API int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  if (alignment % sizeof(void*) != 0 || (alignment & (alignment - 1)) != 0 || alignment == 0) return EINVAL;
  void* found = aligned(alignment, size);
  if (found == nullptr) return ENOMEM;
  *block = found;
  return 0;
}
TICKTRUE_SHIM_API std::size_t malloc_usable_size(void* block) {
  return block == nullptr ? 0 : size_of(block);
}
