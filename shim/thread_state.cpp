// The initial state of a thread: bytes below its stack, rounding of floats. The session limits the changes to ticks.
// SPDX-License-Identifier: MIT
#include <alloca.h>
#include <fenv.h>
#include <pthread.h>
#include <string.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

constexpr std::size_t stack_fill_size = std::size_t{96} << 10;  // threads may have small stacks
constexpr std::uint32_t mode_flush = 1;
constexpr std::uint32_t mode_up = 2;
constexpr std::uint32_t mode_keep = 4;

/// Leaves the bytes below the stack of the caller.
__attribute__((noinline)) void fill_stack(int byte) {
  volatile auto* bytes = static_cast<volatile unsigned char*>(::alloca(stack_fill_size));
  for (std::size_t i = 0; i < stack_fill_size; ++i) bytes[i] = static_cast<unsigned char>(byte);
}

#ifdef __SSE2__
constexpr unsigned flush_bits = 0x8040;  // results and operands
#endif

bool set_flush(bool on) {
#ifdef __SSE2__
  const unsigned before = _mm_getcsr();
  _mm_setcsr(on ? before | flush_bits : before & ~flush_bits);
  return true;
#else
  static_cast<void>(on);
  return false;
#endif
}

/// Clears the flags that a library has set, and sets them again.
void keep_denormals(bool on) {
#ifdef __SSE2__
  static thread_local unsigned taken __attribute__((tls_model("initial-exec"))) = 0;
  const unsigned before = _mm_getcsr();
  if (on && (before & flush_bits) != 0) {
    taken = before & flush_bits;
    _mm_setcsr(before & ~flush_bits);
    count_change();
  } else if (!on) {
    _mm_setcsr(before | taken);
    taken = 0;
  }
#else
  static_cast<void>(on);
#endif
}

void set_floats(bool on) {
  const std::uint32_t mode = settings().float_mode;
  if (mode == 0) return;
  if (mode == mode_keep) return keep_denormals(on);
  const bool is_set = mode == mode_flush
                          ? set_flush(on)
                          : ::fesetround(!on ? FE_TONEAREST : (mode == mode_up ? FE_UPWARD : FE_DOWNWARD)) == 0;
  if (on && is_set) count_change();
}

}  // namespace

void begin_thread_state() {
  if (!is_chosen_tick()) return;
  if (settings().stack_fill != heap_fill_off) {
    fill_stack(settings().stack_fill);
    count_change();
  }
  set_floats(true);
}

}  // namespace ticktrue::shim

using namespace ticktrue::shim;

/// The session calls this function: 0 when libticktrue is entered, 1 when it is left, 2 when it is left into a tick.
TICKTRUE_SHIM_API void ticktrue_shim_library(int way) {
  constexpr int is_entered = 0;
  constexpr int begins_tick = 2;
  if (way == is_entered) return set_floats(false);
  if (!is_chosen_tick()) return;
  set_floats(true);
  if (way != begins_tick || settings().stack_fill == heap_fill_off) return;
  fill_stack(settings().stack_fill);
  count_change();
}
