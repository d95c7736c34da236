// The page, the choice of calls, and records of calls with their stack.
// SPDX-License-Identifier: MIT
#include "shim/shim.h"

#include <execinfo.h>
#include <fcntl.h>
#include <sched.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>

namespace ticktrue::shim {
namespace {

constexpr std::size_t path_size_max = 4096;

Page nothing_changed;
Page* attached = nullptr;
LibmLog* libm_log = nullptr;
int own_process = 0;

// Counts of this process. The page publishes those of the session's process.
std::uint64_t group_counts[group_count];
std::uint64_t call_counts[function_count];
std::uint64_t tick_counts[function_count];
std::uint64_t changed_count;
bool is_published = false;

// Calls of each function at the present position.
std::uint64_t nth_position[function_count];
std::uint32_t nth_counts[function_count];

thread_local int inside_depth __attribute__((tls_model("initial-exec")));
thread_local int thread_id __attribute__((tls_model("initial-exec")));

int own_thread() {
  if (thread_id == 0) thread_id = static_cast<int>(::syscall(SYS_gettid));
  return thread_id;
}

void* map_file(const char* path, std::size_t size) {
  const int file = ::open(path, O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;
  struct stat facts {};
  void* at = MAP_FAILED;
  if (::fstat(file, &facts) == 0 && static_cast<std::size_t>(facts.st_size) >= size)
    at = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::close(file);
  return at == MAP_FAILED ? nullptr : at;
}

/// Runs once, at the first call of any function of this library.
void attach() {
  const Inside inside;
  own_process = static_cast<int>(::syscall(SYS_getpid));
  nothing_changed.session.magic = page_magic;
  Page* found = &nothing_changed;
  const char* path = ::getenv(page_variable);
  if (path != nullptr && ::strlen(path) < path_size_max) {
    auto* mapped = static_cast<Page*>(map_file(path, sizeof(Page)));
    if (mapped != nullptr && mapped->session.magic == page_magic && mapped->size == sizeof(Page)) found = mapped;
  }
  if (found->settings.libm_log != 0) {
    char name[path_size_max + 8];
    ::strcpy(name, path);
    ::strcat(name, ".libm");
    libm_log = static_cast<LibmLog*>(map_file(name, sizeof(LibmLog)));
  }
  found->is_loaded = 1;
  __atomic_store_n(&attached, found, __ATOMIC_RELEASE);
  if (found->settings.logged.end > 0) {
    void* stack[2];
    ::backtrace(stack, 2);  // loads the unwinder now, not during the recorded call
  }
}

/// The process of the session publishes its counts; without a session, every process does.
bool is_publishing(Page& shared) {
  const std::int32_t process = __atomic_load_n(&shared.session.session_process, __ATOMIC_RELAXED);
  return process == own_process || process == 0;
}

void publish_all(Page& shared) {
  for (std::size_t f = 0; f < function_count; ++f) {
    shared.call_counts[f] = call_counts[f];
    shared.tick_counts[f] = tick_counts[f];
  }
  shared.changed_count = changed_count;
  is_published = true;
}

/// The index of the module with this base.
std::uint32_t module_of(Page& shared, const Dl_info& info) {
  const auto base = reinterpret_cast<std::uint64_t>(info.dli_fbase);
  for (std::uint32_t i = 0; i < shared.module_count; ++i)
    if (shared.modules[i].base == base) return i;
  if (shared.module_count >= module_count_max) return module_count_max;
  Module& module = shared.modules[shared.module_count];
  module.base = base;
  const char* name = info.dli_fname != nullptr ? info.dli_fname : "";
  if (name[0] == '/')
    ::strncpy(module.path, name, module_path_size - 1);
  else if (::readlink("/proc/self/exe", module.path, module_path_size - 1) < 0)
    module.path[0] = 0;
  return shared.module_count++;
}

CodePlace place_of(Page& shared, const void* address) {
  CodePlace place{static_cast<std::uint32_t>(module_count_max), 0, reinterpret_cast<std::uint64_t>(address)};
  Dl_info info{};
  if (::dladdr(address, &info) == 0) return place;
  place.module = module_of(shared, info);
  place.offset -= reinterpret_cast<std::uint64_t>(info.dli_fbase);
  return place;
}

int record_lock = 0;

void lock_records() {
  while (__atomic_exchange_n(&record_lock, 1, __ATOMIC_ACQUIRE) != 0) ::sched_yield();
}
void unlock_records() {
  __atomic_store_n(&record_lock, 0, __ATOMIC_RELEASE);
}

__attribute__((noinline)) void record_call(Page& shared, Function function, std::uint64_t number,
                                           std::uint64_t position, std::uint32_t nth, std::uint64_t size,
                                           const void* trapped_at) {
  const Inside inside;
  lock_records();
  if (shared.record_count < call_record_count_max) {
    CallRecord& record = shared.records[shared.record_count];
    record.number = number;
    record.position = position;
    record.size = size;
    record.function = static_cast<std::uint32_t>(function);
    record.nth = nth;
    void* stack[stack_depth_max + 4];
    const int depth = ::backtrace(stack, static_cast<int>(stack_depth_max + 4));
    Dl_info own{};
    ::dladdr(reinterpret_cast<const void*>(&record_call), &own);
    record.depth = 0;
    if (trapped_at != nullptr) record.stack[record.depth++] = place_of(shared, trapped_at);
    for (int i = 0; i < depth && record.depth < stack_depth_max; ++i) {
      Dl_info info{};
      if (::dladdr(stack[i], &info) != 0 && info.dli_fbase == own.dli_fbase) continue;  // a frame of this library
      record.stack[record.depth++] = place_of(shared, stack[i]);
    }
    ++shared.record_count;
  }
  unlock_records();
}

bool is_in_ranges(const Settings& chosen, std::uint64_t number) {
  if (chosen.call_range_count == 0) return true;
  std::uint32_t low = 0;
  std::uint32_t high = chosen.call_range_count;
  while (low < high) {
    const std::uint32_t middle = (low + high) / 2;
    if (chosen.call_ranges[middle].end <= number)
      low = middle + 1;
    else
      high = middle;
  }
  return low < chosen.call_range_count && chosen.call_ranges[low].first <= number;
}

/// Whether the tick of a position is chosen. The time before a tick belongs to this tick.
bool is_chosen_position(const Settings& chosen, std::uint64_t position) {
  const std::uint64_t tick = position / 2;
  return tick >= chosen.tick_first && tick <= chosen.tick_last;
}

std::uint32_t count_at(Function function, std::uint64_t position) {
  const auto f = static_cast<std::size_t>(function);
  if (__atomic_exchange_n(&nth_position[f], position, __ATOMIC_RELAXED) != position)
    __atomic_store_n(&nth_counts[f], 0, __ATOMIC_RELAXED);
  return __atomic_add_fetch(&nth_counts[f], 1, __ATOMIC_RELAXED);
}

__attribute__((constructor(101))) void begin_process() {
  page();
  begin_thread_state();
  begin_cycle_counter();
}

__attribute__((destructor)) void end_process() {
  Page& shared = page();
  if (is_publishing(shared)) publish_all(shared);
}

}  // namespace

Page& page() {
  Page* found = __atomic_load_n(&attached, __ATOMIC_ACQUIRE);
  if (found != nullptr) return *found;
  if (inside_depth > 0 || environ == nullptr) return nothing_changed;
  attach();
  return *attached;
}

Inside::Inside() {
  ++inside_depth;
}
Inside::~Inside() {
  --inside_depth;
}

Call begin_call(Function function, std::uint64_t size, const void* trapped_at) {
  if (inside_depth > 0) return {};
  Page& shared = page();
  if (&shared == &nothing_changed) return {};
  const std::int32_t library_thread = __atomic_load_n(&shared.session.library_thread, __ATOMIC_RELAXED);
  if (library_thread != 0 && library_thread == own_thread()) return {};
  const auto f = static_cast<std::size_t>(function);
  const auto group = static_cast<std::size_t>(functions[f].group);
  Call call;
  call.number = __atomic_fetch_add(&group_counts[group], 1, __ATOMIC_RELAXED);
  const std::uint64_t position = __atomic_load_n(&shared.session.position, __ATOMIC_RELAXED);
  __atomic_fetch_add(&call_counts[f], 1, __ATOMIC_RELAXED);
  if (position % 2 == 1) __atomic_fetch_add(&tick_counts[f], 1, __ATOMIC_RELAXED);
  if (is_publishing(shared)) {
    if (!is_published) publish_all(shared);
    shared.call_counts[f] = call_counts[f];
    shared.tick_counts[f] = tick_counts[f];
  }
  const std::uint32_t nth = count_at(function, position);
  const Settings& chosen = shared.settings;
  if (chosen.logged.end > 0 && chosen.logged_group == group && call.number >= chosen.logged.first &&
      call.number < chosen.logged.end)
    record_call(shared, function, call.number, position, nth, size, trapped_at);
  call.is_changed = is_chosen_position(chosen, position) && is_in_ranges(chosen, call.number);
  return call;
}

void forget_thread() {
  thread_id = 0;
}

void count_change() {
  Page& shared = page();
  __atomic_fetch_add(&changed_count, 1, __ATOMIC_RELAXED);
  if (is_publishing(shared)) shared.changed_count = changed_count;
}

bool is_chosen_tick() {
  const Page& shared = page();
  return is_chosen_position(shared.settings, __atomic_load_n(&shared.session.position, __ATOMIC_RELAXED));
}

std::uint64_t mixed(std::uint64_t value) {
  // Source: Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014 (splitmix64).
  std::uint64_t z = value + settings().seed * 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

void pause_for(std::uint32_t most_us, std::uint64_t value) {
  const auto us = static_cast<long>(mixed(value) % (std::uint64_t{most_us} + 1));
  timespec pause{};
  pause.tv_nsec = us * 1000;
  ::syscall(SYS_nanosleep, &pause, nullptr);
}

void log_libm(Function function, const Call& made, std::uint64_t arguments, std::uint64_t result,
              const void* return_address) {
  if (libm_log == nullptr) return;
  Page& shared = page();
  if (!is_publishing(shared)) return;
  const std::uint64_t number = __atomic_fetch_add(&libm_log->count, 1, __ATOMIC_RELAXED);
  if (number >= libm_log_count_max) return;
  LibmCall& call = libm_log->calls[number];
  call.position = shared.session.position;
  call.number = made.number;
  call.arguments = arguments;
  call.result = result;
  call.function = static_cast<std::uint32_t>(function);
  call.nth = nth_counts[call.function];
  const Inside inside;
  lock_records();
  const CodePlace place = place_of(shared, return_address);
  unlock_records();
  call.module = place.module;
  call.offset = place.offset;
}

}  // namespace ticktrue::shim
