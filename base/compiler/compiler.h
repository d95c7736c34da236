// Compiler-specific language for libticktrue, in one place for g++, clang and MSVC.
// SPDX-License-Identifier: MIT
//
// The kernels of base/ (row_kernels.cpp, hash.cpp, parallel/workers.cpp, bytes.h) have their own compiler words, which
// choose instructions. This file includes no header of the C++ library, so that it can be checked for systems without
// one.
#pragma once

#include <stdint.h>
#if defined(_MSC_VER)
#include <intrin.h>
#endif

#if defined(__GNUC__) || defined(__clang__)
/// The return address of the function that contains the macro.
#define TICKTRUE_RETURN_ADDRESS() __builtin_return_address(0)
/// Before a function: the function is never inlined.
#define TICKTRUE_NO_INLINE __attribute__((noinline))
/// Before a declaration: its address is null if no loaded library defines it. Linux.
#define TICKTRUE_WEAK __attribute__((weak))
#elif defined(_MSC_VER)
#define TICKTRUE_RETURN_ADDRESS() _ReturnAddress()
#define TICKTRUE_NO_INLINE __declspec(noinline)
#else
#define TICKTRUE_RETURN_ADDRESS() nullptr
#define TICKTRUE_NO_INLINE
#endif

namespace ticktrue::compiler {

// Untorn loads and stores of plain integers and pointers that another thread or process may read.
#if defined(__GNUC__) || defined(__clang__)

template <typename T>
T load_relaxed(const T& place) {
  return __atomic_load_n(&place, __ATOMIC_RELAXED);
}

template <typename T>
void store_relaxed(T& place, T value) {
  __atomic_store_n(&place, value, __ATOMIC_RELAXED);
}

/// Stores after all earlier loads and stores.
inline void store_release(uint64_t& place, uint64_t value) {
  __atomic_store_n(&place, value, __ATOMIC_RELEASE);
}
inline void store_release(uint32_t& place, uint32_t value) {
  __atomic_store_n(&place, value, __ATOMIC_RELEASE);
}

/// No load and no store moves across the fence.
inline void full_fence() {
  __atomic_thread_fence(__ATOMIC_SEQ_CST);
}

#elif defined(_MSC_VER)

template <typename T>
T load_relaxed(const T& place) {
  return *static_cast<const volatile T*>(&place);
}

template <typename T>
void store_relaxed(T& place, T value) {
  *static_cast<volatile T*>(&place) = value;
}

inline void store_release(uint64_t& place, uint64_t value) {
  _InterlockedExchange64(reinterpret_cast<volatile long long*>(&place), static_cast<long long>(value));
}
inline void store_release(uint32_t& place, uint32_t value) {
  _InterlockedExchange(reinterpret_cast<volatile long*>(&place), static_cast<long>(value));
}

inline void full_fence() {
  volatile long place = 0;
  _InterlockedExchange(&place, 1);
}

#endif

/// The control word for the rounding of floats. Without a name: no such word is known for this machine.
struct FloatControl {
  const char* name;
  uint64_t word;
};

inline FloatControl float_control() {
#if defined(_MSC_VER) && !defined(__clang__) && (defined(_M_X64) || defined(_M_IX86))
  return {"MXCSR", _mm_getcsr()};
#elif defined(__x86_64__) || defined(__SSE__)
  return {"MXCSR", __builtin_ia32_stmxcsr()};
#elif defined(__aarch64__)
  uint64_t word = 0;
  __asm__ volatile("mrs %0, fpcr" : "=r"(word));
  return {"FPCR", word};
#elif defined(__arm__)
  uint32_t word = 0;
  __asm__ volatile("vmrs %0, fpscr" : "=r"(word));
  return {"FPSCR", word};
#elif defined(__riscv)
  uint64_t word = 0;
  __asm__ volatile("frcsr %0" : "=r"(word));
  return {"FCSR", word};
#elif defined(__s390x__)
  uint32_t word = 0;
  __asm__ volatile("efpc %0" : "=d"(word));
  return {"FPC", word};
#elif defined(__powerpc64__)
  double word = 0;
  __asm__ volatile("mffs %0" : "=d"(word));
  return {"FPSCR", __builtin_bit_cast(uint64_t, word)};
#else
  return {nullptr, 0};
#endif
}

}  // namespace ticktrue::compiler
