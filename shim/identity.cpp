// The identity of machine and process: another host name, a fixed process number.
// SPDX-License-Identifier: MIT
#include <errno.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "shim/shim.h"

namespace {

constexpr char other_name[] = "another-machine";
constexpr pid_t fixed_process = 4711;

}  // namespace

using namespace ticktrue::shim;

TICKTRUE_SHIM_API int gethostname(char* name, std::size_t size) noexcept {
  static int (*real)(char*, std::size_t) = nullptr;
  const Call call = begin_call(Function::gethostname);
  if (!call.is_changed || settings().host_mode == 0) return real_function(real, "gethostname")(name, size);
  count_change();
  ::strncpy(name, other_name, size);
  if (size >= sizeof other_name) return 0;
  errno = ENAMETOOLONG;
  return -1;
}

TICKTRUE_SHIM_API int uname(utsname* facts) noexcept {
  static int (*real)(utsname*) = nullptr;
  const Call call = begin_call(Function::uname);
  const int status = real_function(real, "uname")(facts);
  if (status != 0 || !call.is_changed || settings().host_mode == 0) return status;
  count_change();
  ::strncpy(facts->nodename, other_name, sizeof facts->nodename - 1);
  return status;
}

TICKTRUE_SHIM_API pid_t getpid() noexcept {
  const Call call = begin_call(Function::getpid);
  if (!call.is_changed || settings().process_mode == 0) return static_cast<pid_t>(::syscall(SYS_getpid));
  count_change();
  return fixed_process;
}
