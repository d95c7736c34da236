// Marks of calls: the session of the program takes them as marks of the program.
// SPDX-License-Identifier: MIT
#include "shim/shim.h"

namespace ticktrue::shim {
namespace {

struct Wanted {
  CallSink sink = nullptr;
  void* with = nullptr;
};
Wanted wanted;
std::uint32_t wanted_groups = 0;  // bits by number of the group

constexpr const char* names[] = {
#define TICKTRUE_SHIM_NAME(name, group) "libc." #name,
    TICKTRUE_SHIM_OTHERS(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME
#define TICKTRUE_SHIM_NAME(name) "libm." #name, "libm." #name "f",
        TICKTRUE_SHIM_LIBM_1(TICKTRUE_SHIM_NAME) TICKTRUE_SHIM_LIBM_2(TICKTRUE_SHIM_NAME)
#undef TICKTRUE_SHIM_NAME
};
static_assert(sizeof names / sizeof names[0] == function_count);

const char* name_of(Function function) {
  if (function == Function::sincos) return "libm.sincos";
  if (function == Function::sincosf) return "libm.sincosf";
  return names[static_cast<std::size_t>(function)];
}

}  // namespace

void mark_call(Function function, std::uint64_t value, const void* caller) {
  const auto group = static_cast<std::uint32_t>(functions[static_cast<std::size_t>(function)].group);
  if ((__atomic_load_n(&wanted_groups, __ATOMIC_ACQUIRE) >> group & 1u) != 0)
    wanted.sink(wanted.with, name_of(function), value, caller);
}

void mark_bytes(Function function, const void* bytes, std::size_t size, const void* caller) {
  // Up to 8 bytes are the value itself. Source for more bytes: FNV-1a.
  std::uint64_t value = size > 8 ? 0xcbf29ce484222325 : 0;
  const auto* at = static_cast<const unsigned char*>(bytes);
  for (std::size_t i = 0; i < size; ++i)
    value = size > 8 ? (value ^ at[i]) * 0x100000001b3 : value | std::uint64_t{at[i]} << (8 * i);
  mark_call(function, value, caller);
}

}  // namespace ticktrue::shim

using namespace ticktrue::shim;

/// The session calls this before its first tick and at its end. `groups`: bits by number; 0: none.
TICKTRUE_SHIM_API void ticktrue_shim_calls(CallSink sink, void* with, std::uint32_t groups) {
  __atomic_store_n(&wanted_groups, 0, __ATOMIC_RELEASE);
  wanted = {sink, with};
  __atomic_store_n(&wanted_groups, groups, __ATOMIC_RELEASE);
}
