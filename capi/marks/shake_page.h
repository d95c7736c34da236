// Passes the tick of a session, and the thread inside the library, to `ticktrue shake`. Receives calls of the program.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

namespace ticktrue::capi {

/// During its lifetime, calls of this thread count as calls of the library, not of the program. May be nested.
class InLibrary {
 public:
  InLibrary();
  InLibrary(const InLibrary&) = delete;
  InLibrary& operator=(const InLibrary&) = delete;
  ~InLibrary();

 private:
  bool is_outermost_ = false;
};

/// During its lifetime, calls of this thread count as calls of the program: it runs a callback.
class OutOfLibrary {
 public:
  OutOfLibrary();
  OutOfLibrary(const OutOfLibrary&) = delete;
  OutOfLibrary& operator=(const OutOfLibrary&) = delete;
  ~OutOfLibrary();

 private:
  const void* frame_ = nullptr;
};

/// The stack address at which the library was entered: the stack above it belongs to the program. Null: no page.
const void* library_frame();
/// To be called after a fork, and after the end of the child: this thread is inside the library.
void enter_library_again();

/// A session of this process begins.
void tell_session();
/// Tick `tick` begins or ends.
void tell_tick_begin(std::uint64_t tick);
void tell_tick_end(std::uint64_t tick);

/// The preload library calls this function for each marked call of the C library.
using CallSink = void (*)(void* with, const char* name, std::uint64_t value, const void* caller);
/// Requests marks for the calls in TICKTRUE_CALLS ("random,libm"). Only one session of a process at a time receives
/// them. Returns why this is impossible; empty: it is possible, or the variable is not set. `is_marking`: whether calls
/// will arrive.
std::string follow_calls(CallSink sink, void* with, bool& is_marking);
/// Ends the calls to this session. Does nothing if this session receives none.
void leave_calls(void* with);

/// Appends the report as one line to the file in the variable TICKTRUE_RESULT, if it is set.
void append_result(const std::string& json);

/// Appends the paths of the program and of its shared libraries, one per line, to the file in the variable
/// TICKTRUE_MAPPED, if it is set. Linux only.
void append_mapped();

}  // namespace ticktrue::capi
