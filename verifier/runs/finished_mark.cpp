// One byte through a pipe.
// SPDX-License-Identifier: MIT
#include "verifier/runs/finished_mark.h"

#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <cstring>
#endif

namespace ticktrue::verifier {

#ifdef TICKTRUE_HAS_FORK
namespace {

int finished_descriptor = -1;

}  // namespace

void take_finished_mark() {
  const char* text = std::getenv(finished_mark_variable);
  if (text == nullptr) return;
  int number = -1;
  const auto [end, code] = std::from_chars(text, text + std::strlen(text), number);
  struct stat found {};
  const bool is_pipe =
      code == std::errc{} && *end == '\0' && number > 2 && ::fstat(number, &found) == 0 && S_ISFIFO(found.st_mode);
  ::unsetenv(finished_mark_variable);
  if (!is_pipe) return;
  finished_descriptor = number;
  ::fcntl(number, F_SETFD, FD_CLOEXEC);
}

void drop_finished_mark() {
  if (finished_descriptor >= 0) ::close(finished_descriptor);
  finished_descriptor = -1;
}

void write_finished_mark() {
  if (finished_descriptor < 0) return;
  const auto written = ::write(finished_descriptor, "!", 1);
  static_cast<void>(written);  // whoever asked is gone
  drop_finished_mark();
}

#else

void take_finished_mark() {}
void drop_finished_mark() {}
void write_finished_mark() {}

#endif

}  // namespace ticktrue::verifier
