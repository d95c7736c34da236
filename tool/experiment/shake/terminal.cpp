// Opens a pseudo-terminal of the system, and reads it in a thread.
// SPDX-License-Identifier: MIT
#include "tool/experiment/shake/terminal.h"

#ifdef __linux__
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cstdlib>
#endif

namespace ticktrue::shake {

#ifdef __linux__
namespace {

/// Reads and discards text until the pipe is closed.
void read_away(int terminal, int end) {
  char text[4096];
  for (;;) {
    pollfd watched[] = {{terminal, POLLIN, 0}, {end, POLLIN, 0}};
    if (::poll(watched, 2, -1) < 0) continue;
    if (watched[1].revents != 0) return;
    // No process has the terminal open. Watching it further would make poll return at once.
    if ((watched[0].revents & POLLIN) == 0 || ::read(terminal, text, sizeof text) <= 0) terminal = -1;
  }
}

}  // namespace

Terminal::Terminal() {
  constexpr std::size_t name_size = 64;
  char name[name_size];
  own_side_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (own_side_ < 0 || ::grantpt(own_side_) != 0 || ::unlockpt(own_side_) != 0) return;
  if (::ptsname_r(own_side_, name, sizeof name) != 0 || ::pipe2(end_, O_CLOEXEC) != 0) return;
  program_side_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  reader_ = std::thread(read_away, own_side_, end_[0]);
}

Terminal::~Terminal() {
  if (end_[1] >= 0) ::close(end_[1]);
  if (reader_.joinable()) reader_.join();
  for (const int descriptor : {own_side_, program_side_, end_[0]})
    if (descriptor >= 0) ::close(descriptor);
}

#else

Terminal::Terminal() = default;
Terminal::~Terminal() = default;

#endif

}  // namespace ticktrue::shake
