// Simulates a full disk for this process.
// SPDX-License-Identifier: MIT
#pragma once

#ifndef _WIN32
#include <sys/resource.h>

#include <csignal>

namespace ticktrue::test {

/// During the lifetime of this object, files can be made, renamed and removed, but no byte can be written. The hint of
/// the error is that of a limit, not that of a full disk.
class FullDisk {
 public:
  FullDisk() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    const rlimit nothing{0, limit_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &nothing);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit limit_{};
};

}  // namespace ticktrue::test
#endif
