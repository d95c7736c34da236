// Parts of the preload library: the page, the choice of changed calls, and records of calls.
// SPDX-License-Identifier: MIT
//
// The library uses only the C library: no exception, no static constructor, no allocation through malloc.
#pragma once

#include <dlfcn.h>
#include <sched.h>

#include "shim/page.h"

#define TICKTRUE_SHIM_API extern "C" __attribute__((visibility("default")))

namespace ticktrue::shim {

/// The page of this run. Without a launcher, a page with everything off.
Page& page();
inline const Settings& settings() {
  return page().settings;
}

/// A counted call, and whether it is to be changed. Calls from libticktrue and from this library are neither counted
/// nor changed.
struct Call {
  bool is_changed = false;
  std::uint64_t number = 0;
};
/// Counts a call. `size`: requested from malloc. `trapped_at`: for an instruction in place of a call, the address after
/// it.
Call begin_call(Function function, std::uint64_t size = 0, const void* trapped_at = nullptr);

/// Counts a call that was changed. A chosen call with an unchanged result does not count.
void count_change();

/// Whether the present tick is one of the chosen ticks.
bool is_chosen_tick();

/// During its lifetime, calls of this thread are neither counted nor changed.
class Inside {
 public:
  Inside();
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;
  ~Inside();
};

/// For the child of a fork, whose thread has another id.
void forget_thread();

/// Holds a lock during its lifetime. It calls no function of pthread, because this library replaces these.
class Locked {
 public:
  /// `lock`: 0 if it is free.
  explicit Locked(int& lock) : lock_(lock) {
    while (__atomic_exchange_n(&lock_, 1, __ATOMIC_ACQUIRE) != 0) ::sched_yield();
  }
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;
  ~Locked() { __atomic_store_n(&lock_, 0, __ATOMIC_RELEASE); }

 private:
  int& lock_;
};

/// A whole number that follows from the seed and `value`.
std::uint64_t mixed(std::uint64_t value);

/// The function that this library replaces. `cache` is static.
template <typename F>
F real_function(F& cache, const char* name) {
  F found = __atomic_load_n(&cache, __ATOMIC_RELAXED);
  if (found != nullptr) return found;
  const Inside inside;
  found = reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
  __atomic_store_n(&cache, found, __ATOMIC_RELAXED);
  return found;
}

/// Applies the settings of this thread, at its start and around ticks.
void begin_thread_state();
/// Replaces reads of the cycle counter, if the settings require it.
void begin_cycle_counter();
/// Pauses for at most `most_us` microseconds; the length follows from the seed and `value`.
void pause_for(std::uint32_t most_us, std::uint64_t value);

/// Reports a call to the session, if the session wants calls of its group.
void mark_call(Function function, std::uint64_t value, const void* caller);
/// Reports bytes that a call returned.
void mark_bytes(Function function, const void* bytes, std::size_t size, const void* caller);

/// Writes a result of libm to the log.
void log_libm(Function function, const Call& call, std::uint64_t arguments, std::uint64_t result,
              const void* return_address);

}  // namespace ticktrue::shim
