// Parts of the preload library: the page, which calls are changed, and records of calls.
// SPDX-License-Identifier: MIT
//
// The library uses the C library and nothing else: no exception, no static constructor, no allocation through malloc.
#pragma once

#include <dlfcn.h>

#include "shim/page.h"

#define TICKTRUE_SHIM_API extern "C" __attribute__((visibility("default")))

namespace ticktrue::shim {

/// The page of this run; without a launcher, one on which everything is off.
Page& page();
inline const Settings& settings() {
  return page().settings;
}

/// Counts a call. Says whether it is one of those that are to be changed. `stack_size`: what malloc was asked for.
/// False and not counted: inside of libticktrue, and inside of this library.
struct Call {
  bool is_changed = false;
  std::uint64_t number = 0;
};
/// `trapped_at`: of an instruction that stands for a call, the address behind it.
Call begin_call(Function function, std::uint64_t size = 0, const void* trapped_at = nullptr);

/// A call was in fact changed. Calls that are chosen and come out the same do not count.
void count_change();

/// Whether the present tick is one in which something is changed.
bool is_chosen_tick();

/// While it lives, calls of this thread are neither counted nor changed.
class Inside {
 public:
  Inside();
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;
  ~Inside();
};

/// In the child of a fork: its thread has another id.
void forget_thread();

/// Whole numbers that follow from the seed and `value`.
std::uint64_t mixed(std::uint64_t value);

/// The function that this library stands in front of. `cache` is static.
template <typename F>
F real_function(F& cache, const char* name) {
  F found = __atomic_load_n(&cache, __ATOMIC_RELAXED);
  if (found != nullptr) return found;
  const Inside inside;
  found = reinterpret_cast<F>(::dlsym(RTLD_NEXT, name));
  __atomic_store_n(&cache, found, __ATOMIC_RELAXED);
  return found;
}

/// Settings of this thread, at its start and around ticks.
void begin_thread_state();
/// Takes the place of reads of the cycle counter, if the settings say so.
void begin_cycle_counter();
/// A pause of at most so many microseconds that follows from the seed and `value`.
void pause_for(std::uint32_t most_us, std::uint64_t value);

/// Tells the session of a call, if it wants those of the group.
void mark_call(Function function, std::uint64_t value, const void* caller);
/// The same for bytes that a call gave.
void mark_bytes(Function function, const void* bytes, std::size_t size, const void* caller);

/// A result of libm goes to the log.
void log_libm(Function function, const Call& call, std::uint64_t arguments, std::uint64_t result,
              const void* return_address);

}  // namespace ticktrue::shim
