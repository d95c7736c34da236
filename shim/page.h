// The page of memory that `ticktrue shake`, the session of a program and the preload library share.
// SPDX-License-Identifier: MIT
//
// `ticktrue shake` makes a file for each run, and names it in the variable TICKTRUE_SHAKE. The session (capi/) and the
// preload library (shim/) map the file. The session writes the tick. The preload library reads the tick and the
// settings, counts calls and records some of them. All data stay in the file, even if the program crashes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ticktrue::shim {

inline constexpr const char* page_variable = "TICKTRUE_SHAKE";
/// The variable names a file. A session that ends appends lines to it: the paths of the program and of each shared
/// library that is mapped at this time, and an empty line.
inline constexpr const char* mapped_variable = "TICKTRUE_MAPPED";
inline constexpr std::uint64_t page_magic = 0x31656b6168737474;  // "ttshake1"

/// Calls are numbered within a group, from 0 at the start of the process. Calls from libticktrue are not counted.
enum class Group : std::uint32_t {
  heap,
  clock,
  random,
  rand,
  directory,
  thread,
  lock,
  processors,
  sort,
  libm,
  identity,
  cycle_counter
};
inline constexpr std::size_t group_count = 12;

// name, group. A float function and its double version have one row each.
#define TICKTRUE_SHIM_LIBM_1(X)                                                                                        \
  X(sin)                                                                                                               \
  X(cos)                                                                                                               \
  X(tan)                                                                                                               \
  X(asin)                                                                                                              \
  X(acos)                                                                                                              \
  X(atan)                                                                                                              \
  X(sinh)                                                                                                              \
  X(cosh) X(tanh) X(asinh) X(acosh) X(atanh) X(exp) X(exp2) X(expm1) X(exp10) X(log) X(log2) X(log10) X(log1p) X(cbrt) \
      X(erf) X(erfc) X(tgamma) X(lgamma)
#define TICKTRUE_SHIM_LIBM_2(X) X(pow) X(atan2) X(hypot)
#define TICKTRUE_SHIM_OTHERS(X)                                                                          \
  X(malloc, heap)                                                                                        \
  X(calloc, heap)                                                                                        \
  X(realloc, heap)                                                                                       \
  X(free, heap)                                                                                          \
  X(memalign, heap)                                                                                      \
  X(clock_gettime, clock)                                                                                \
  X(gettimeofday, clock)                                                                                 \
  X(time, clock) X(clock, clock) X(timespec_get, clock) X(getrandom, random) X(getentropy, random)       \
      X(arc4random, random) X(random_device, random) X(dev_random, random) X(rand, rand) X(random, rand) \
          X(drand48, rand) X(readdir, directory) X(pthread_create, thread) X(pthread_mutex_lock, lock)   \
              X(pthread_cond_signal, lock) X(sysconf, processors) X(get_nprocs, processors)              \
                  X(sched_getaffinity, processors) X(qsort, sort) X(sincos, libm) X(sincosf, libm)       \
                      X(gethostname, identity) X(uname, identity) X(getpid, identity) X(rdtsc, cycle_counter)

/// Functions that the preload library replaces.
enum class Function : std::uint32_t {
#define TICKTRUE_SHIM_NAME(name, group) name,
  TICKTRUE_SHIM_OTHERS(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME
#define TICKTRUE_SHIM_NAME(name) name, name##f,
      TICKTRUE_SHIM_LIBM_1(TICKTRUE_SHIM_NAME) TICKTRUE_SHIM_LIBM_2(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME
          count
};
inline constexpr std::size_t function_count = static_cast<std::size_t>(Function::count);

struct FunctionInfo {
  const char* name;
  Group group;
};
inline constexpr FunctionInfo functions[] = {
#define TICKTRUE_SHIM_NAME(name, group) {#name, Group::group},
    TICKTRUE_SHIM_OTHERS(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME
#define TICKTRUE_SHIM_NAME(name) {#name, Group::libm}, {#name "f", Group::libm},
        TICKTRUE_SHIM_LIBM_1(TICKTRUE_SHIM_NAME) TICKTRUE_SHIM_LIBM_2(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME
};
static_assert(sizeof functions / sizeof functions[0] == function_count);

/// The session of a program receives each call of a group in this function. `name`: of the function, as in "libc.rand";
/// `value`: its result; `caller`: its return address. Any thread may call it.
using CallSink = void (*)(void* with, const char* name, std::uint64_t value, const void* caller);

/// Calls [first, end) of a group.
struct CallRange {
  std::uint64_t first;
  std::uint64_t end;
};

inline constexpr std::size_t call_range_count_max = 1024;
inline constexpr int heap_fill_off = -1;
inline constexpr int heap_fill_varied = 256;  // a different byte for each block

/// The changes of the preload library. If all values but the fills are zero, it changes nothing.
struct Settings {
  std::int32_t heap_fill = heap_fill_off;   // a byte for fresh and for freed blocks
  std::int32_t stack_fill = heap_fill_off;  // a byte, below the stack, at the start and before each tick
  std::uint32_t heap_order = 0;             // 1: falling addresses, 2: scattered addresses
  std::uint32_t heap_alignment = 0;         // 16, 32, 64: blocks begin at such a multiple, and at no larger one
  std::uint32_t heap_kept = 0;              // 1: blocks record where they were allocated (kept_block.h)
  std::uint32_t clock_mode = 0;             // 1: shifted, 2: virtual (each call is 10 us later)
  std::uint32_t random_mode = 0;            // 1: bytes from the seed
  std::uint32_t rand_mode = 0;              // 1: other numbers, 2: one number is drawn and dropped first
  std::uint32_t directory_mode = 0;         // 1: reversed, 2: by name, 3: by name, reversed
  std::uint32_t thread_delay_us = 0;        // at most: before a thread begins
  std::uint32_t threads_in_turn = 0;        // 1: the starter of a thread waits for its end, 20 ms at most
  std::uint32_t lock_delay_us = 0;          // at most: before some locks
  std::uint32_t processor_count = 0;        // as shown to the program
  std::uint32_t sort_mode = 0;              // 1: equal elements are in reverse order
  std::uint32_t libm_mode = 0;              // 1: one ulp up, 2: one ulp down, 3: one of both
  std::uint32_t float_mode = 0;             // 1: flush to zero, 2: round up, 3: round down, 4: keep denormal numbers
  std::uint32_t host_mode = 0;              // 1: another host name
  std::uint32_t process_mode = 0;           // 1: getpid returns a fixed number
  std::uint32_t cycle_mode = 0;             // of rdtsc. 1: shifted, 2: virtual (each read is 1000 cycles later)
  std::int64_t realtime_offset_s = 0;
  std::int64_t monotonic_offset_s = 0;
  double clock_rate = 1;
  std::uint64_t seed = 1;
  // The range of changes. Ticks count from 0. The time before the first tick counts as tick 0.
  std::uint64_t tick_first = 0;
  std::uint64_t tick_last = ~std::uint64_t{0};
  std::uint32_t call_range_count = 0;  // 0: all calls; ascending
  std::uint32_t logged_group = 0;
  CallRange call_ranges[call_range_count_max] = {};
  CallRange logged = {0, 0};   // calls of logged_group that are recorded with their stack
  std::uint32_t libm_log = 0;  // 1: every libm call goes to the file PAGE.libm
};

inline constexpr std::size_t stack_depth_max = 16;
inline constexpr std::size_t module_count_max = 96;
inline constexpr std::size_t module_path_size = 232;
inline constexpr std::size_t call_record_count_max = 64;

/// An address as a module and the offset in it.
struct CodePlace {
  std::uint32_t module;  // module_count_max: unknown
  std::uint32_t reserved;
  std::uint64_t offset;
};

struct CallRecord {
  std::uint64_t number;    // in its group
  std::uint64_t position;  // as Page::session.position
  std::uint64_t size;      // the block size requested from malloc and the like
  std::uint32_t function;
  std::uint32_t nth;  // call of this function at this position, from 1
  std::uint32_t depth;
  std::uint32_t reserved;
  CodePlace stack[stack_depth_max];  // return addresses, the innermost first
};

struct Module {
  std::uint64_t base;
  char path[module_path_size];
};

/// The begin of the page, which the session writes. Its layout never changes: a program may have an older libticktrue.
struct SessionPart {
  std::uint64_t magic;
  std::int32_t session_process;  // 0: no session was opened
  std::int32_t library_thread;   // the thread inside libticktrue; 0: none
  std::uint64_t position;        // 0: before the first tick; 2 t + 1: in tick t; 2 t + 2: after tick t
};

struct Page {
  SessionPart session;
  std::uint64_t size;  // of the page: tool and preload library must have the same version
  Settings settings;
  // Written by the preload library for the process of the session.
  std::uint32_t is_loaded;
  std::uint32_t record_count;
  std::uint32_t module_count;
  std::uint32_t reserved;
  std::uint64_t call_counts[function_count];  // all of them
  std::uint64_t tick_counts[function_count];  // calls inside ticks
  std::uint64_t changed_count;                // calls that were changed
  CallRecord records[call_record_count_max];
  Module modules[module_count_max];
};

/// A libm call in the file PAGE.libm.
struct LibmCall {
  std::uint64_t number;  // in its group
  std::uint64_t position;
  std::uint64_t arguments;  // their bits, mixed
  std::uint64_t result;     // its bits
  std::uint64_t offset;     // of the return address, in its module
  std::uint32_t function;
  std::uint32_t nth;
  std::uint32_t module;
  std::uint32_t reserved;
};
inline constexpr std::uint64_t libm_log_count_max = 1u << 20;

struct LibmLog {
  std::uint64_t count;  // of all calls, including calls beyond the capacity
  LibmCall calls[libm_log_count_max];
};

}  // namespace ticktrue::shim
