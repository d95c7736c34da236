// Tells `ticktrue shake` the tick of a session, and which thread is inside the library. Takes calls of the program.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

namespace ticktrue::capi {

/// While it lives, calls that this thread makes are of the library, not of the program. May be nested.
class InLibrary {
 public:
  InLibrary();
  InLibrary(const InLibrary&) = delete;
  InLibrary& operator=(const InLibrary&) = delete;
  ~InLibrary();

 private:
  bool is_outermost_ = false;
};

/// While it lives, calls that this thread makes are of the program again: of its callbacks.
class OutOfLibrary {
 public:
  OutOfLibrary();
  OutOfLibrary(const OutOfLibrary&) = delete;
  OutOfLibrary& operator=(const OutOfLibrary&) = delete;
  ~OutOfLibrary();

 private:
  const void* frame_ = nullptr;
};

/// Where on the stack the library was entered: what is above belongs to the program. Null: there is no page.
const void* library_frame();
/// Behind a fork, and behind the end of the child: this thread is inside of the library.
void enter_library_again();

/// A session of this process begins.
void tell_session();
/// Tick `tick` runs from now on, or has ended.
void tell_tick_begin(std::uint64_t tick);
void tell_tick_end(std::uint64_t tick);

/// The preload library calls it for each call of the C library that it marks.
using CallSink = void (*)(void* with, const char* name, std::uint64_t value, const void* caller);
/// Has calls marked as TICKTRUE_CALLS asks ("random,libm"); one session of a process at a time. Says what hinders it;
/// empty: nothing, or nobody asks. `is_marking`: whether calls will come.
std::string follow_calls(CallSink sink, void* with, bool& is_marking);
/// No more calls of this session. Without it: nothing.
void leave_calls(void* with);

/// Appends the report as one line to the file that the variable TICKTRUE_RESULT names. Without it: nothing.
void append_result(const std::string& json);

/// Appends the paths of the program and of its shared libraries to the file that the variable TICKTRUE_MAPPED names, a
/// line for each. Without it, and elsewhere than on Linux: nothing.
void append_mapped();

}  // namespace ticktrue::capi
