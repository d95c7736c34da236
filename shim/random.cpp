// Random bytes of the system, and the generators of the C library.
// SPDX-License-Identifier: MIT
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <unistd.h>

#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

constexpr std::size_t device_size = 1u << 16;  // size of a random device's replacement
constexpr std::size_t entropy_size_max = 256;  // limit of getentropy
constexpr std::uint32_t rand_other = 1;
constexpr std::uint32_t rand_drawn = 2;
constexpr unsigned rand_bits = 0x2a5a5a5au & 0x7fffffffu;

bool is_streaming(const Call& call) {
  return call.is_changed && settings().random_mode != 0;
}

void fill_from_seed(void* target, std::size_t size) {
  static std::uint64_t count = 0;
  auto* bytes = static_cast<unsigned char*>(target);
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < size; ++i) {
    if (i % 8 == 0) word = mixed(__atomic_add_fetch(&count, 1, __ATOMIC_RELAXED) + 0x72616e64u);
    bytes[i] = static_cast<unsigned char>(word >> (8 * (i % 8)));
  }
  count_change();
}

bool is_random_device(const char* path) {
  return path != nullptr && (::strcmp(path, "/dev/urandom") == 0 || ::strcmp(path, "/dev/random") == 0);
}

/// A file whose bytes follow from the seed; -1: the file could not be made.
int open_stream() {
  const int file = ::memfd_create("random", 0);
  if (file < 0) return -1;
  unsigned char block[1024];
  for (std::size_t done = 0; done < device_size; done += sizeof block) {
    fill_from_seed(block, sizeof block);
    if (::write(file, block, sizeof block) != static_cast<ssize_t>(sizeof block)) break;
  }
  ::lseek(file, 0, SEEK_SET);
  return file;
}

bool takes_device(const char* path) {
  return is_random_device(path) && is_streaming(begin_call(Function::dev_random));
}

using Open = int (*)(const char*, int, ...);
int open_any(Open real, const char* path, int flags, unsigned mode) {
  const int stream = takes_device(path) ? open_stream() : -1;
  return stream >= 0 ? stream : real(path, flags, mode);
}

FILE* open_file(FILE* (*real)(const char*, const char*), const char* path, const char* mode) {
  const int stream = takes_device(path) ? open_stream() : -1;
  return stream >= 0 ? ::fdopen(stream, "rb") : real(path, mode);
}

template <typename T, typename Draw>
T changed_draw(const Call& call, Draw&& draw, T (*other)(T)) {
  if (!call.is_changed || settings().rand_mode == 0) return draw();
  count_change();
  if (settings().rand_mode == rand_drawn) draw();
  const T found = draw();
  return settings().rand_mode == rand_other ? other(found) : found;
}

/// Draws of the generators of the C library. `draw` returns the next number.
template <typename T, typename Draw>
T drawn(Function function, Draw&& draw, T (*other)(T), const void* caller) {
  const T value = changed_draw<T>(begin_call(function), draw, other);
  mark_bytes(function, &value, sizeof value, caller);
  return value;
}

void fill_arc4random(void* target, std::size_t size, const void* caller) {
  static void (*real)(void*, std::size_t) = nullptr;
  if (is_streaming(begin_call(Function::arc4random))) {
    fill_from_seed(target, size);
  } else if (const auto found = real_function(real, "arc4random_buf"); found != nullptr) {
    found(target, size);
  } else {
    const Inside inside;
    ::getentropy(target, size < entropy_size_max ? size : entropy_size_max);
  }
  mark_bytes(Function::arc4random, target, size, caller);
}

}  // namespace
}  // namespace ticktrue::shim

using namespace ticktrue::shim;

TICKTRUE_SHIM_API ssize_t getrandom(void* target, std::size_t size, unsigned flags) {
  static ssize_t (*real)(void*, std::size_t, unsigned) = nullptr;
  ssize_t got = static_cast<ssize_t>(size);
  if (is_streaming(begin_call(Function::getrandom)))
    fill_from_seed(target, size);
  else
    got = real_function(real, "getrandom")(target, size, flags);
  if (got > 0) mark_bytes(Function::getrandom, target, static_cast<std::size_t>(got), __builtin_return_address(0));
  return got;
}

TICKTRUE_SHIM_API int getentropy(void* target, std::size_t size) {
  static int (*real)(void*, std::size_t) = nullptr;
  int status = 0;
  if (is_streaming(begin_call(Function::getentropy)) && size <= entropy_size_max)
    fill_from_seed(target, size);
  else
    status = real_function(real, "getentropy")(target, size);
  if (status == 0) mark_bytes(Function::getentropy, target, size, __builtin_return_address(0));
  return status;
}

TICKTRUE_SHIM_API void arc4random_buf(void* target, std::size_t size) {
  fill_arc4random(target, size, __builtin_return_address(0));
}

TICKTRUE_SHIM_API std::uint32_t arc4random() {
  std::uint32_t value = 0;
  fill_arc4random(&value, sizeof value, __builtin_return_address(0));
  return value;
}

TICKTRUE_SHIM_API std::uint32_t arc4random_uniform(std::uint32_t end) {
  if (end < 2) return 0;
  std::uint32_t value = 0;
  fill_arc4random(&value, sizeof value, __builtin_return_address(0));
  return static_cast<std::uint32_t>(std::uint64_t{value} * end >> 32);
}

// std::random_device::_M_getval(): it may use an instruction of the processor, which no library can replace.
TICKTRUE_SHIM_API unsigned _ZNSt13random_device9_M_getvalEv(void* device) {
  static unsigned (*real)(void*) = nullptr;
  unsigned value = 0;
  if (is_streaming(begin_call(Function::random_device)))
    fill_from_seed(&value, sizeof value);
  else
    value = real_function(real, "_ZNSt13random_device9_M_getvalEv")(device);
  mark_call(Function::random_device, value, __builtin_return_address(0));
  return value;
}

#define TICKTRUE_SHIM_OPEN(name)                                                               \
  TICKTRUE_SHIM_API int name(const char* path, int flags, ...) {                               \
    static Open real = nullptr;                                                                \
    va_list more;                                                                              \
    va_start(more, flags);                                                                     \
    const unsigned mode = (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(more, unsigned) : 0; \
    va_end(more);                                                                              \
    return open_any(real_function(real, #name), path, flags, mode);                            \
  }
TICKTRUE_SHIM_OPEN(open)
TICKTRUE_SHIM_OPEN(open64)

#define TICKTRUE_SHIM_FOPEN(name)                                    \
  TICKTRUE_SHIM_API FILE* name(const char* path, const char* mode) { \
    static FILE* (*real)(const char*, const char*) = nullptr;        \
    return open_file(real_function(real, #name), path, mode);        \
  }
TICKTRUE_SHIM_FOPEN(fopen)
TICKTRUE_SHIM_FOPEN(fopen64)

TICKTRUE_SHIM_API int rand() noexcept {
  static int (*real)() = nullptr;
  return drawn<int>(
      Function::rand, real_function(real, "rand"),
      [](int value) { return static_cast<int>(static_cast<unsigned>(value) ^ rand_bits); },
      __builtin_return_address(0));
}

TICKTRUE_SHIM_API long random() noexcept {
  static long (*real)() = nullptr;
  return drawn<long>(
      Function::random, real_function(real, "random"),
      [](long value) { return static_cast<long>(static_cast<unsigned long>(value) ^ rand_bits); },
      __builtin_return_address(0));
}

TICKTRUE_SHIM_API double drand48() noexcept {
  static double (*real)() = nullptr;
  return drawn<double>(
      Function::drand48, real_function(real, "drand48"), [](double value) { return 0.5 * value; },
      __builtin_return_address(0));
}
