// One reserved range of addresses. Freed blocks are reused by size, unless the session forbids it.
// SPDX-License-Identifier: MIT
#include "shim/kept_heap.h"

#include <execinfo.h>
#include <pthread.h>
#include <string.h>
#include <sys/mman.h>

#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

constexpr std::size_t range_size = std::size_t{1} << 36;
constexpr std::size_t unit = 16;                          // bytes: block sizes are multiples of it
constexpr std::size_t class_count = 4096;                 // of sizes that are reused
constexpr std::size_t large_size = std::size_t{1} << 20;  // bytes: freed blocks of this size return their pages
constexpr std::size_t page_size = 4096;
constexpr std::uint64_t stack_count_max = 2'000'000;  // allocations with a recorded stack

KeptHeap heap{nullptr, nullptr, 0, 1};
bool has_failed = false;
KeptBlock* free_blocks[class_count];
int heap_lock = 0;

void unlock_in_child() {
  __atomic_store_n(&heap_lock, 0, __ATOMIC_RELEASE);
  forget_thread();
}

bool reserve() {
  if (heap.begin != nullptr || has_failed) return heap.begin != nullptr;
  void* found = ::mmap(nullptr, range_size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  has_failed = found == MAP_FAILED;
  if (has_failed) return false;
  heap.top = static_cast<char*>(found);
  __atomic_store_n(&heap.begin, static_cast<char*>(found), __ATOMIC_RELEASE);
  const Inside inside;
  ::pthread_atfork(nullptr, nullptr, unlock_in_child);
  return true;
}

KeptBlock* header_of(const void* block) {
  return static_cast<KeptBlock* const*>(block)[-1];
}

/// Takes a block from the lists of freed blocks, or after the last block.
KeptBlock* take(std::size_t whole) {
  KeptBlock*& list = free_blocks[whole / unit < class_count ? whole / unit : 0];
  if (heap.has_reuse != 0 && whole / unit < class_count && list != nullptr) {
    KeptBlock* found = list;
    list = found->next_free;
    return found;
  }
  if (whole > static_cast<std::size_t>(heap.begin + range_size - heap.top)) return nullptr;
  auto* found = reinterpret_cast<KeptBlock*>(heap.top);
  heap.top += whole;
  found->magic = kept_magic;
  found->whole = whole;
  return found;
}

void record_stack(KeptBlock& block) {
  constexpr int own_frames = 3;  // of this library
  void* stack[kept_depth_max + own_frames];
  const Inside inside;
  const int depth = ::backtrace(stack, static_cast<int>(kept_depth_max) + own_frames);
  Dl_info own{};
  ::dladdr(reinterpret_cast<const void*>(&record_stack), &own);
  block.depth = 0;
  for (int i = 0; i < depth && block.depth < kept_depth_max; ++i) {
    Dl_info info{};
    if (i < own_frames + 1 && ::dladdr(stack[i], &info) != 0 && info.dli_fbase == own.dli_fbase) continue;
    block.stack[block.depth++] = stack[i];
  }
}

}  // namespace

bool is_kept(const void* block) {
  const char* begin = __atomic_load_n(&heap.begin, __ATOMIC_ACQUIRE);
  const auto* at = static_cast<const char*>(block);
  return begin != nullptr && at >= begin && at < begin + range_size;
}

std::size_t kept_size(const void* block) {
  return header_of(block)->size;
}

void* kept_allocate(std::size_t alignment, std::size_t size) {
  const std::size_t gap = alignment > unit ? alignment : 0;
  if (size > range_size / 4 || gap > range_size / 4) return nullptr;
  const std::size_t whole = (sizeof(KeptBlock) + gap + (size == 0 ? 1 : size) + unit - 1) / unit * unit;
  KeptBlock* block = nullptr;
  {
    const Locked locked(heap_lock);
    if (!reserve()) return nullptr;
    block = take(whole);
    if (block == nullptr) return nullptr;
    block->number = ++heap.number;
  }
  auto at = reinterpret_cast<std::uintptr_t>(block + 1);
  if (gap > 0) at = (at + alignment - 1) / alignment * alignment;
  block->size = size;
  block->offset = static_cast<std::uint32_t>(at - reinterpret_cast<std::uintptr_t>(block));
  block->depth = 0;
  if (block->number <= stack_count_max) record_stack(*block);
  reinterpret_cast<KeptBlock**>(at)[-1] = block;
  __atomic_store_n(&block->is_live, 1, __ATOMIC_RELEASE);
  return reinterpret_cast<void*>(at);
}

void kept_free(void* at) {
  KeptBlock* block = header_of(at);
  const Locked locked(heap_lock);
  block->is_live = 0;
  if (heap.has_reuse == 0) return;
  if (block->whole / unit < class_count) {
    block->next_free = free_blocks[block->whole / unit];
    free_blocks[block->whole / unit] = block;
  } else if (block->size >= large_size) {
    const auto first = (reinterpret_cast<std::uintptr_t>(at) + page_size - 1) / page_size * page_size;
    const auto last = (reinterpret_cast<std::uintptr_t>(at) + block->size) / page_size * page_size;
    if (last > first) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
  }
}

}  // namespace ticktrue::shim

using namespace ticktrue::shim;

/// For the session of the program: reads the values of the heap. `wanted`: its top, number and `has_reuse` are set
/// first.
TICKTRUE_SHIM_API void ticktrue_shim_heap(KeptHeap* found, const KeptHeap* wanted) {
  const Locked locked(heap_lock);
  if (wanted != nullptr) {
    if (wanted->top > heap.top) heap.top = wanted->top;
    if (wanted->number > heap.number) heap.number = wanted->number;
    heap.has_reuse = wanted->has_reuse;
  }
  if (found != nullptr) *found = heap;
}
