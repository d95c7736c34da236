// readdir: the entries of a folder in another order.
// SPDX-License-Identifier: MIT
#include <dirent.h>
#include <errno.h>
#include <pthread.h>
#include <string.h>

#include "shim/shim.h"

extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* __libc_realloc(void* block, std::size_t size);
extern "C" void __libc_free(void* block);

namespace ticktrue::shim {
namespace {

constexpr std::uint32_t order_by_name = 2;

using Read = dirent* (*)(DIR*);

/// A folder in reading.
struct Listing {
  DIR* folder = nullptr;
  dirent** entries = nullptr;
  std::size_t count = 0;
  std::size_t next = 0;
  Listing* following = nullptr;
};
Listing* listings = nullptr;
pthread_mutex_t listings_lock = PTHREAD_MUTEX_INITIALIZER;

Listing** find(DIR* folder) {
  Listing** at = &listings;
  while (*at != nullptr && (*at)->folder != folder) at = &(*at)->following;
  return at;
}

/// A total order of the entries. It differs from the file system's order unless that is by name.
bool comes_before(const dirent* a, const dirent* b) {
  return ::strcmp(a->d_name, b->d_name) < 0;
}

Listing* read_all(DIR* folder, Read real) {
  auto* listing = static_cast<Listing*>(__libc_malloc(sizeof(Listing)));
  if (listing == nullptr) return nullptr;
  *listing = {};
  listing->folder = folder;
  while (dirent* entry = real(folder)) {
    auto* copy = static_cast<dirent*>(__libc_malloc(sizeof(dirent)));
    auto** grown = static_cast<dirent**>(__libc_realloc(listing->entries, (listing->count + 1) * sizeof(void*)));
    if (copy == nullptr || grown == nullptr) break;
    ::memcpy(copy, entry, entry->d_reclen < sizeof *copy ? entry->d_reclen : sizeof *copy);
    listing->entries = grown;
    listing->entries[listing->count++] = copy;
  }
  const std::uint32_t mode = settings().directory_mode;
  if (mode >= order_by_name)
    for (std::size_t i = 1; i < listing->count; ++i)
      for (std::size_t k = i; k > 0 && comes_before(listing->entries[k], listing->entries[k - 1]); --k) {
        dirent* earlier = listing->entries[k - 1];
        listing->entries[k - 1] = listing->entries[k];
        listing->entries[k] = earlier;
      }
  if (mode != order_by_name)
    for (std::size_t i = 0; i < listing->count / 2; ++i) {
      dirent* earlier = listing->entries[i];
      listing->entries[i] = listing->entries[listing->count - 1 - i];
      listing->entries[listing->count - 1 - i] = earlier;
    }
  count_change();
  return listing;
}

void drop(DIR* folder) {
  ::pthread_mutex_lock(&listings_lock);
  Listing** at = find(folder);
  if (Listing* found = *at; found != nullptr) {
    *at = found->following;
    for (std::size_t i = 0; i < found->count; ++i) __libc_free(found->entries[i]);
    __libc_free(found->entries);
    __libc_free(found);
  }
  ::pthread_mutex_unlock(&listings_lock);
}

dirent* read_entry(DIR* folder, Read real) {
  const Inside inside;
  ::pthread_mutex_lock(&listings_lock);
  Listing** at = find(folder);
  if (*at == nullptr) *at = read_all(folder, real);
  dirent* entry = nullptr;
  if (Listing* found = *at; found != nullptr && found->next < found->count) entry = found->entries[found->next++];
  ::pthread_mutex_unlock(&listings_lock);
  return entry;
}

/// The first call for a folder decides for all calls.
dirent* read_next(DIR* folder, Read real) {
  if (settings().directory_mode == 0) {
    begin_call(Function::readdir);
    return real(folder);
  }
  ::pthread_mutex_lock(&listings_lock);
  const bool is_known = *find(folder) != nullptr;
  ::pthread_mutex_unlock(&listings_lock);
  const Call call = begin_call(Function::readdir);
  return is_known || call.is_changed ? read_entry(folder, real) : real(folder);
}

}  // namespace
}  // namespace ticktrue::shim

using namespace ticktrue::shim;

TICKTRUE_SHIM_API dirent* readdir(DIR* folder) {
  static Read real = nullptr;
  return read_next(folder, real_function(real, "readdir"));
}

#if __SIZEOF_POINTER__ == 8
TICKTRUE_SHIM_API dirent64* readdir64(DIR* folder) {
  static Read real = nullptr;
  return reinterpret_cast<dirent64*>(read_next(folder, real_function(real, "readdir")));
}
#endif

TICKTRUE_SHIM_API int closedir(DIR* folder) {
  static int (*real)(DIR*) = nullptr;
  const Inside inside;
  drop(folder);
  return real_function(real, "closedir")(folder);
}

TICKTRUE_SHIM_API void rewinddir(DIR* folder) noexcept {
  static void (*real)(DIR*) = nullptr;
  const Inside inside;
  drop(folder);
  real_function(real, "rewinddir")(folder);
}
