// Reports completion as one byte through a pipe.
// SPDX-License-Identifier: MIT
#include "verifier/runs/completion.h"

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

int completion_descriptor = -1;

}  // namespace

void take_completion_pipe() {
  const char* text = std::getenv(completion_variable);
  if (text == nullptr) return;
  int number = -1;
  const auto [end, code] = std::from_chars(text, text + std::strlen(text), number);
  struct stat found {};
  const bool is_pipe =
      code == std::errc{} && *end == '\0' && number > 2 && ::fstat(number, &found) == 0 && S_ISFIFO(found.st_mode);
  ::unsetenv(completion_variable);
  if (!is_pipe) return;
  completion_descriptor = number;
  ::fcntl(number, F_SETFD, FD_CLOEXEC);
}

void close_completion_pipe() {
  if (completion_descriptor >= 0) ::close(completion_descriptor);
  completion_descriptor = -1;
}

void report_completion() {
  if (completion_descriptor < 0) return;
  const auto written = ::write(completion_descriptor, "!", 1);
  static_cast<void>(written);  // fails if the reader has closed the pipe
  close_completion_pipe();
}

#else

void take_completion_pipe() {}
void close_completion_pipe() {}
void report_completion() {}

#endif

}  // namespace ticktrue::verifier
