// Clocks: shifted, faster or slower, or virtual. Deadlines are translated back for the system.
// SPDX-License-Identifier: MIT
#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;
constexpr std::int64_t virtual_start_s = 1'700'000'000;
constexpr std::int64_t virtual_step_ns = 10'000;
constexpr std::uint32_t mode_shifted = 1;
constexpr std::uint32_t mode_virtual = 2;

std::int64_t virtual_ns = 0;  // since the start

std::int64_t ns_of(const timespec& time) {
  return time.tv_sec * second_ns + time.tv_nsec;
}
timespec timespec_of(std::int64_t ns) {
  timespec time{};
  time.tv_sec = ns / second_ns;
  time.tv_nsec = ns % second_ns;
  if (time.tv_nsec < 0) {
    time.tv_nsec += second_ns;
    --time.tv_sec;
  }
  return time;
}

int real_time(clockid_t clock, timespec* time) {
  static int (*real)(clockid_t, timespec*) = nullptr;
  return real_function(real, "clock_gettime")(clock, time);
}

bool is_wall_clock(clockid_t clock) {
  return clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE || clock == CLOCK_TAI;
}
bool is_process_clock(clockid_t clock) {
  return clock == CLOCK_PROCESS_CPUTIME_ID || clock == CLOCK_THREAD_CPUTIME_ID || clock < 0;
}

std::int64_t offset_ns(clockid_t clock) {
  if (is_process_clock(clock)) return 0;
  return (is_wall_clock(clock) ? settings().realtime_offset_s : settings().monotonic_offset_s) * second_ns;
}

/// The value of each clock when this process first read it. From this time on the rate applies.
std::int64_t start_of(clockid_t clock) {
  static std::int64_t wall = 0;
  static std::int64_t steady = 0;
  if (is_process_clock(clock)) return 0;
  std::int64_t& start = is_wall_clock(clock) ? wall : steady;
  std::int64_t found = __atomic_load_n(&start, __ATOMIC_RELAXED);
  if (found != 0) return found;
  timespec now{};
  real_time(is_wall_clock(clock) ? CLOCK_REALTIME : CLOCK_MONOTONIC, &now);
  __atomic_store_n(&start, ns_of(now), __ATOMIC_RELAXED);
  return ns_of(now);
}

timespec shown_time(clockid_t clock, const timespec& real) {
  count_change();
  if (settings().clock_mode == mode_virtual) {
    const std::int64_t ns = __atomic_add_fetch(&virtual_ns, virtual_step_ns, __ATOMIC_RELAXED);
    return timespec_of(ns + (is_wall_clock(clock) ? virtual_start_s * second_ns : second_ns));
  }
  const std::int64_t start = start_of(clock);
  const double passed = static_cast<double>(ns_of(real) - start) * settings().clock_rate;
  return timespec_of(start + offset_ns(clock) + static_cast<std::int64_t>(passed));
}

bool is_shifted() {
  return settings().clock_mode == mode_shifted;
}

/// Converts a deadline by a clock that is shown shifted to a deadline of the system's clock.
timespec* real_deadline(clockid_t clock, const timespec* shown, timespec* room) {
  *room = *shown;
  if (!is_shifted() || is_process_clock(clock)) {
    if (settings().clock_mode != mode_virtual) return room;
    real_time(clock, room);  // a virtual clock does not wait
    return room;
  }
  const std::int64_t start = start_of(clock);
  const double passed = static_cast<double>(ns_of(*shown) - start - offset_ns(clock)) / settings().clock_rate;
  *room = timespec_of(start + static_cast<std::int64_t>(passed));
  return room;
}

}  // namespace
}  // namespace ticktrue::shim

using namespace ticktrue::shim;

TICKTRUE_SHIM_API int clock_gettime(clockid_t clock, timespec* time) noexcept {
  const Call call = begin_call(Function::clock_gettime);
  const int status = real_time(clock, time);
  if (status == 0 && call.is_changed && settings().clock_mode != 0) *time = shown_time(clock, *time);
  return status;
}

TICKTRUE_SHIM_API int gettimeofday(timeval* time, void* zone) noexcept {
  static int (*real)(timeval*, void*) = nullptr;
  const Call call = begin_call(Function::gettimeofday);
  if (!call.is_changed || settings().clock_mode == 0) return real_function(real, "gettimeofday")(time, zone);
  timespec now{};
  const int status = real_time(CLOCK_REALTIME, &now);
  now = shown_time(CLOCK_REALTIME, now);
  time->tv_sec = now.tv_sec;
  time->tv_usec = now.tv_nsec / 1000;
  return status;
}

TICKTRUE_SHIM_API time_t time(time_t* result) noexcept {
  const Call call = begin_call(Function::time);
  timespec now{};
  real_time(CLOCK_REALTIME, &now);
  if (call.is_changed && settings().clock_mode != 0) now = shown_time(CLOCK_REALTIME, now);
  if (result != nullptr) *result = now.tv_sec;
  return now.tv_sec;
}

TICKTRUE_SHIM_API clock_t clock() noexcept {
  const Call call = begin_call(Function::clock);
  timespec now{};
  real_time(CLOCK_PROCESS_CPUTIME_ID, &now);
  if (call.is_changed && settings().clock_mode != 0) now = shown_time(CLOCK_PROCESS_CPUTIME_ID, now);
  return static_cast<clock_t>(ns_of(now) / (second_ns / CLOCKS_PER_SEC));
}

TICKTRUE_SHIM_API int timespec_get(timespec* time, int base) noexcept {
  const Call call = begin_call(Function::timespec_get);
  if (base != TIME_UTC) return 0;
  real_time(CLOCK_REALTIME, time);
  if (call.is_changed && settings().clock_mode != 0) *time = shown_time(CLOCK_REALTIME, *time);
  return base;
}

// A virtual clock advances at once.
TICKTRUE_SHIM_API int nanosleep(const timespec* length, timespec* left) {
  static int (*real)(const timespec*, timespec*) = nullptr;
  if (settings().clock_mode != mode_virtual) return real_function(real, "nanosleep")(length, left);
  __atomic_add_fetch(&virtual_ns, ns_of(*length), __ATOMIC_RELAXED);
  return 0;
}

TICKTRUE_SHIM_API int usleep(useconds_t us) {
  static int (*real)(useconds_t) = nullptr;
  if (settings().clock_mode != mode_virtual) return real_function(real, "usleep")(us);
  __atomic_add_fetch(&virtual_ns, std::int64_t{us} * 1000, __ATOMIC_RELAXED);
  return 0;
}

TICKTRUE_SHIM_API unsigned sleep(unsigned seconds) {
  static unsigned (*real)(unsigned) = nullptr;
  if (settings().clock_mode != mode_virtual) return real_function(real, "sleep")(seconds);
  __atomic_add_fetch(&virtual_ns, seconds * second_ns, __ATOMIC_RELAXED);
  return 0;
}

TICKTRUE_SHIM_API int clock_nanosleep(clockid_t clock, int flags, const timespec* length, timespec* left) {
  static int (*real)(clockid_t, int, const timespec*, timespec*) = nullptr;
  const auto system_sleep = real_function(real, "clock_nanosleep");
  timespec room{};
  if ((flags & TIMER_ABSTIME) != 0) return system_sleep(clock, flags, real_deadline(clock, length, &room), left);
  if (settings().clock_mode != mode_virtual) return system_sleep(clock, flags, length, left);
  __atomic_add_fetch(&virtual_ns, ns_of(*length), __ATOMIC_RELAXED);
  return 0;
}

TICKTRUE_SHIM_API int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                                             const timespec* deadline) {
  static int (*real)(pthread_cond_t*, pthread_mutex_t*, const timespec*) = nullptr;
  // The clock of the condition is unknown here. A deadline near the steady clock is taken as a deadline of that clock.
  timespec steady{};
  real_time(CLOCK_MONOTONIC, &steady);
  const std::int64_t shown_steady = ns_of(steady) + offset_ns(CLOCK_MONOTONIC);
  const std::int64_t distance = ns_of(*deadline) - shown_steady;
  constexpr std::int64_t year_s = 365 * 86400;
  const bool is_steady = distance > -year_s * second_ns && distance < year_s * second_ns;
  timespec room{};
  return real_function(real, "pthread_cond_timedwait")(
      condition, mutex, real_deadline(is_steady ? CLOCK_MONOTONIC : CLOCK_REALTIME, deadline, &room));
}

TICKTRUE_SHIM_API int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                                             const timespec* deadline) {
  static int (*real)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*) = nullptr;
  timespec room{};
  return real_function(real, "pthread_cond_clockwait")(condition, mutex, clock, real_deadline(clock, deadline, &room));
}

TICKTRUE_SHIM_API int pthread_mutex_timedlock(pthread_mutex_t* mutex, const timespec* deadline) noexcept {
  static int (*real)(pthread_mutex_t*, const timespec*) = nullptr;
  timespec room{};
  return real_function(real, "pthread_mutex_timedlock")(mutex, real_deadline(CLOCK_REALTIME, deadline, &room));
}

TICKTRUE_SHIM_API int sem_timedwait(sem_t* semaphore, const timespec* deadline) {
  static int (*real)(sem_t*, const timespec*) = nullptr;
  timespec room{};
  return real_function(real, "sem_timedwait")(semaphore, real_deadline(CLOCK_REALTIME, deadline, &room));
}
