// Reads of the cycle counter: the system traps the instruction, and this file replaces it.
// SPDX-License-Identifier: MIT
//
// The kernel can make a process's rdtsc and rdtscp end in SIGSEGV (PR_SET_TSC). The setting belongs to a thread; new
// threads inherit it. The system's own clock uses rdtsc in the vDSO, which gets the true value.
#include <pthread.h>
#include <signal.h>
#include <sys/auxv.h>
#include <sys/prctl.h>

#include "shim/shim.h"

#if defined(__x86_64__) && defined(PR_SET_TSC)
#include <ucontext.h>
#include <x86intrin.h>

namespace ticktrue::shim {
namespace {

constexpr std::uint32_t mode_virtual = 2;
constexpr std::uint64_t shift_cycles = 0x123456789abcd;
constexpr std::uint64_t virtual_step_cycles = 1000;
constexpr std::uintptr_t vdso_size = 4 * 4096;

bool is_trapping = false;
std::uint64_t virtual_cycles = 0;
struct sigaction program_action {};  // the program's own action for SIGSEGV

using SetAction = int (*)(int, const struct sigaction*, struct sigaction*);
int set_action(int number, const struct sigaction* action, struct sigaction* before) {
  static SetAction real = nullptr;
  return real_function(real, "sigaction")(number, action, before);
}

/// Size of the rdtsc or rdtscp at an address, bytes; 0: another instruction.
std::size_t instruction_size(const unsigned char* at) {
  if (at[0] != 0x0f) return 0;
  if (at[1] == 0x31) return 2;
  return at[1] == 0x01 && at[2] == 0xf9 ? 3 : 0;
}

bool is_of_system(std::uintptr_t at) {
  const std::uintptr_t vdso = ::getauxval(AT_SYSINFO_EHDR);
  return vdso != 0 && at >= vdso && at < vdso + vdso_size;
}

std::uint64_t shown_cycles(std::uint64_t real) {
  count_change();
  if (settings().cycle_mode == mode_virtual)
    return __atomic_add_fetch(&virtual_cycles, virtual_step_cycles, __ATOMIC_RELAXED);
  return real + shift_cycles;
}

/// Passes a fault of the program on to the program: its instruction runs again, or the signal is raised again.
void hand_over(const siginfo_t& info) {
  is_trapping = false;
  set_action(SIGSEGV, &program_action, nullptr);
  if (info.si_code <= 0) ::raise(SIGSEGV);
}

void take_place(int, siginfo_t* info, void* with) {
  auto* registers = static_cast<ucontext_t*>(with)->uc_mcontext.gregs;
  const auto at = static_cast<std::uintptr_t>(registers[REG_RIP]);
  const std::size_t size =
      info->si_code == SI_KERNEL ? instruction_size(reinterpret_cast<const unsigned char*>(at)) : 0;
  if (size == 0) return hand_over(*info);
  ::prctl(PR_SET_TSC, PR_TSC_ENABLE, 0, 0, 0);
  unsigned processor = 0;
  std::uint64_t cycles = __rdtscp(&processor);
  ::prctl(PR_SET_TSC, PR_TSC_SIGSEGV, 0, 0, 0);
  if (!is_of_system(at) && begin_call(Function::rdtsc, 0, reinterpret_cast<const void*>(at + size)).is_changed)
    cycles = shown_cycles(cycles);
  constexpr unsigned half_bits = 32;
  constexpr std::size_t rdtscp_size = 3;
  registers[REG_RAX] = greg_t{static_cast<std::uint32_t>(cycles)};
  registers[REG_RDX] = greg_t{static_cast<std::uint32_t>(cycles >> half_bits)};
  if (size == rdtscp_size) registers[REG_RCX] = static_cast<greg_t>(processor);
  const std::uint64_t next = at + size;
  registers[REG_RIP] = static_cast<greg_t>(next);
}

/// The program that a child process starts may run without this library.
void end_in_child() {
  ::prctl(PR_SET_TSC, PR_TSC_ENABLE, 0, 0, 0);
}

}  // namespace

void begin_cycle_counter() {
  if (settings().cycle_mode == 0) return;
  struct sigaction action {};
  action.sa_sigaction = take_place;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  if (set_action(SIGSEGV, &action, &program_action) != 0) return;
  is_trapping = true;
  ::pthread_atfork(nullptr, nullptr, end_in_child);
  ::prctl(PR_SET_TSC, PR_TSC_SIGSEGV, 0, 0, 0);
}

}  // namespace ticktrue::shim

using namespace ticktrue::shim;

TICKTRUE_SHIM_API int sigaction(int number, const struct sigaction* action, struct sigaction* before) noexcept {
  if (number != SIGSEGV || !is_trapping) return set_action(number, action, before);
  if (before != nullptr) *before = program_action;
  if (action != nullptr) program_action = *action;
  return 0;
}

TICKTRUE_SHIM_API sighandler_t signal(int number, sighandler_t handler) noexcept {
  static sighandler_t (*real)(int, sighandler_t) = nullptr;
  if (number != SIGSEGV || !is_trapping) return real_function(real, "signal")(number, handler);
  const sighandler_t before = program_action.sa_handler;
  program_action = {};
  program_action.sa_handler = handler;
  program_action.sa_flags = SA_RESTART;
  return before;
}

#else

namespace ticktrue::shim {

void begin_cycle_counter() {}

}  // namespace ticktrue::shim

#endif
