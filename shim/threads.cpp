// Threads that start late, locks that are taken late, another number of processors.
// SPDX-License-Identifier: MIT
#include <pthread.h>
#include <sched.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include "shim/shim.h"

extern "C" void* __libc_malloc(std::size_t size);
extern "C" void __libc_free(void* block);

namespace ticktrue::shim {
namespace {

constexpr std::uint64_t locks_between_pauses = 8;
constexpr std::uint64_t pause_count_max = 4000;  // limits the cost of the pauses

constexpr int turn_wait_count = 400;
constexpr std::uint32_t turn_wait_us = 50;

struct Start {
  void* (*function)(void*);
  void* argument;
  std::uint32_t delay_us;
  std::uint64_t number;
  int* turn;  // count of owners: the starter and the thread; null: nobody waits
};

/// Leaves the turn. The last owner frees it.
void leave_turn(int* turn) {
  if (turn != nullptr && __atomic_sub_fetch(turn, 1, __ATOMIC_ACQ_REL) == 0) __libc_free(turn);
}

void wait_for_turn(int* turn) {
  if (turn == nullptr) return;
  const Inside inside;
  for (int i = 0; i < turn_wait_count && __atomic_load_n(turn, __ATOMIC_ACQUIRE) > 1; ++i) ::usleep(turn_wait_us);
  leave_turn(turn);
}

void* run_thread(void* given) {
  const Start start = *static_cast<Start*>(given);
  {
    const Inside inside;
    __libc_free(given);
    begin_thread_state();
    if (start.delay_us > 0) pause_for(start.delay_us, start.number);
  }
  void* result = start.function(start.argument);
  leave_turn(start.turn);
  return result;
}

void pause_at_lock(const Call& call) {
  static std::uint64_t pause_count = 0;
  if (!call.is_changed || settings().lock_delay_us == 0) return;
  if (mixed(call.number) % locks_between_pauses != 0) return;
  if (__atomic_add_fetch(&pause_count, 1, __ATOMIC_RELAXED) > pause_count_max) return;
  count_change();
  pause_for(settings().lock_delay_us, ~call.number);
}

}  // namespace
}  // namespace ticktrue::shim

using namespace ticktrue::shim;

TICKTRUE_SHIM_API int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*function)(void*),
                                     void* argument) noexcept {
  static int (*real)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*) = nullptr;
  const auto create = real_function(real, "pthread_create");
  const Call call = begin_call(Function::pthread_create);
  auto* start = static_cast<Start*>(__libc_malloc(sizeof(Start)));
  if (start == nullptr) return create(thread, attributes, function, argument);
  *start = {function, argument, call.is_changed ? settings().thread_delay_us : 0, call.number, nullptr};
  if (call.is_changed && settings().threads_in_turn != 0) start->turn = static_cast<int*>(__libc_malloc(sizeof(int)));
  int* turn = start->turn;
  if (turn != nullptr) *turn = 2;
  if (start->delay_us > 0) count_change();
  const int status = create(thread, attributes, run_thread, start);
  if (status != 0) {
    __libc_free(turn);
    __libc_free(start);
    return status;
  }
  wait_for_turn(turn);
  return status;
}

TICKTRUE_SHIM_API int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static int (*real)(pthread_mutex_t*) = nullptr;
  pause_at_lock(begin_call(Function::pthread_mutex_lock));
  return real_function(real, "pthread_mutex_lock")(mutex);
}

TICKTRUE_SHIM_API int pthread_cond_signal(pthread_cond_t* condition) noexcept {
  static int (*real)(pthread_cond_t*) = nullptr;
  pause_at_lock(begin_call(Function::pthread_cond_signal));
  return real_function(real, "pthread_cond_signal")(condition);
}

TICKTRUE_SHIM_API int pthread_cond_broadcast(pthread_cond_t* condition) noexcept {
  static int (*real)(pthread_cond_t*) = nullptr;
  pause_at_lock(begin_call(Function::pthread_cond_signal));
  return real_function(real, "pthread_cond_broadcast")(condition);
}

TICKTRUE_SHIM_API long sysconf(int name) noexcept {
  static long (*real)(int) = nullptr;
  const auto found = real_function(real, "sysconf");
  if (name != _SC_NPROCESSORS_ONLN && name != _SC_NPROCESSORS_CONF) return found(name);
  if (!begin_call(Function::sysconf).is_changed || settings().processor_count == 0) return found(name);
  count_change();
  return settings().processor_count;
}

TICKTRUE_SHIM_API int get_nprocs() noexcept {
  static int (*real)() = nullptr;
  if (!begin_call(Function::get_nprocs).is_changed || settings().processor_count == 0)
    return real_function(real, "get_nprocs")();
  count_change();
  return static_cast<int>(settings().processor_count);
}

TICKTRUE_SHIM_API int get_nprocs_conf() noexcept {
  return get_nprocs();
}

TICKTRUE_SHIM_API int sched_getaffinity(pid_t process, std::size_t size, cpu_set_t* set) noexcept {
  static int (*real)(pid_t, std::size_t, cpu_set_t*) = nullptr;
  const int status = real_function(real, "sched_getaffinity")(process, size, set);
  if (!begin_call(Function::sched_getaffinity).is_changed || settings().processor_count == 0 || status != 0)
    return status;
  CPU_ZERO_S(size, set);
  for (std::size_t i = 0; i < settings().processor_count; ++i) CPU_SET_S(i, size, set);
  count_change();
  return status;
}
