// A reserved range of addresses in stripes. Freed blocks are reused by size.
// SPDX-License-Identifier: MIT
//
// The first stripe is used from its begin, the other stripes from their end.
#include "shim/arena.h"

#include <pthread.h>
#include <sys/mman.h>

#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

constexpr std::size_t stripe_size = std::size_t{1} << 32;
constexpr std::size_t stripe_count = 16;
constexpr std::size_t unit = 64;              // bytes: block sizes are multiples of it
constexpr std::size_t unit_count_max = 4096;  // larger blocks return their pages to the system when freed
constexpr std::size_t page_size = 4096;

/// The header directly before each block.
struct Header {
  std::uint64_t whole;   // bytes with header and gap
  std::uint64_t offset;  // from the begin of `whole` to the block
};

struct FreeBlock {
  FreeBlock* next;
};

char* arena = nullptr;
bool has_failed = false;
char* stripe_ends[stripe_count];
char* first_stripe_begin = nullptr;  // for rising addresses
FreeBlock* free_blocks[unit_count_max];
int arena_lock = 0;

void unlock_in_child() {
  __atomic_store_n(&arena_lock, 0, __ATOMIC_RELEASE);
}

bool reserve() {
  if (arena != nullptr || has_failed) return arena != nullptr;
  void* found = ::mmap(nullptr, stripe_size * stripe_count, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  has_failed = found == MAP_FAILED;
  if (has_failed) return false;
  for (std::size_t i = 0; i < stripe_count; ++i) stripe_ends[i] = static_cast<char*>(found) + (i + 1) * stripe_size;
  first_stripe_begin = static_cast<char*>(found) + unit;
  __atomic_store_n(&arena, static_cast<char*>(found), __ATOMIC_RELEASE);
  return true;
}

Header* header_of(void* block) {
  return static_cast<Header*>(block) - 1;
}

/// The offset of blocks without an alignment of their own. Only freed blocks with this offset are reused.
std::size_t usual_step(std::uint32_t most_alignment) {
  return most_alignment != 0 ? most_alignment : sizeof(Header);
}

}  // namespace

bool is_in_arena(const void* block) {
  const char* begin = __atomic_load_n(&arena, __ATOMIC_ACQUIRE);
  const auto* at = static_cast<const char*>(block);
  return begin != nullptr && at >= begin && at < begin + stripe_size * stripe_count;
}

std::size_t arena_size(const void* block) {
  const Header* header = static_cast<const Header*>(block) - 1;
  return header->whole - header->offset;
}

void* arena_allocate(std::size_t alignment, std::size_t size, std::uint32_t order, std::uint32_t most_alignment,
                     std::uint64_t number) {
  // The block begins at an odd multiple of `step`: it is aligned to `step` and to no larger power of two.
  std::size_t step = usual_step(most_alignment);
  if (step < alignment) step = alignment;
  const std::size_t boundary = 2 * step < unit ? unit : 2 * step;
  if (size > stripe_size / 4 || boundary > stripe_size / 4) return nullptr;
  const std::size_t whole = (step + size + boundary - 1) / boundary * boundary;
  const Locked locked(arena_lock);
  if (!reserve()) return nullptr;
  static bool is_watched = false;
  if (!is_watched) {
    is_watched = true;
    const Inside inside;
    ::pthread_atfork(nullptr, nullptr, unlock_in_child);
  }
  char* at = nullptr;
  FreeBlock*& list = free_blocks[whole / unit < unit_count_max ? whole / unit : 0];
  if (step == usual_step(most_alignment) && whole / unit < unit_count_max && list != nullptr) {
    at = reinterpret_cast<char*>(list);
    list = list->next;
  } else if (order == 0) {
    char* begin = first_stripe_begin + boundary - 1;
    begin -= reinterpret_cast<std::uintptr_t>(begin) % boundary;
    if (begin + whole > arena + stripe_size) return nullptr;
    first_stripe_begin = begin + whole;
    at = begin;
  } else {
    char*& end = stripe_ends[order == 2 ? 1 + mixed(number) % (stripe_count - 1) : stripe_count - 1];
    const char* stripe = arena + static_cast<std::size_t>(end - 1 - arena) / stripe_size * stripe_size;
    char* begin = end - whole;
    begin -= reinterpret_cast<std::uintptr_t>(begin) % boundary;
    if (begin < stripe + boundary) return nullptr;
    end = begin;
    at = begin;
  }
  char* block = at + step;
  header_of(block)->whole = whole;
  header_of(block)->offset = step;
  return block;
}

void arena_free(void* block) {
  const Header header = *header_of(block);
  char* at = static_cast<char*>(block) - header.offset;
  if (header.whole / unit < unit_count_max) {
    if (header.offset != usual_step(settings().heap_alignment)) return;
    const Locked locked(arena_lock);
    auto* freed = reinterpret_cast<FreeBlock*>(at);
    freed->next = free_blocks[header.whole / unit];
    free_blocks[header.whole / unit] = freed;
    return;
  }
  const auto first = (reinterpret_cast<std::uintptr_t>(at) + page_size - 1) / page_size * page_size;
  const auto last = (reinterpret_cast<std::uintptr_t>(at) + header.whole) / page_size * page_size;
  if (last > first) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
}

}  // namespace ticktrue::shim
