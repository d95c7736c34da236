// Runs a child with a limit of processor time, and reads its resource use from wait4.
// SPDX-License-Identifier: MIT
#include "tests/damage/run_tool.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace ticktrue::damage {

void fail(const std::string& message) {
  std::fprintf(stderr, "error: %s\n", message.c_str());
  std::exit(2);
}

void set_sanitizer_options() {
  const std::string code = std::to_string(sanitizer_exit_code);
  ::setenv("ASAN_OPTIONS", ("exitcode=" + code + ":detect_leaks=0").c_str(), 1);
  ::setenv("UBSAN_OPTIONS", ("exitcode=" + code).c_str(), 1);
}

bool Outcome::is_hang() const {
  return cpu_s > cpu_max_s || signal == SIGALRM || signal == SIGXCPU;
}

Outcome run_tool(const std::vector<std::string>& words) {
  const pid_t child = ::fork();
  if (child < 0) fail("fork: " + std::string(std::strerror(errno)));
  if (child == 0) {
    const int null = ::open("/dev/null", O_RDWR);
    for (const int descriptor : {0, 1, 2}) ::dup2(null, descriptor);
    const rlimit cpu{static_cast<rlim_t>(cpu_max_s) + 1, static_cast<rlim_t>(cpu_max_s) + 1};
    ::setrlimit(RLIMIT_CPU, &cpu);
    ::alarm(wall_max_s);
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  if (::wait4(child, &status, 0, &usage) != child) fail("wait4: " + std::string(std::strerror(errno)));
  Outcome outcome;
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  outcome.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  outcome.memory_mb = static_cast<double>(usage.ru_maxrss) / 1000;  // Linux reports KiB
  return outcome;
}

}  // namespace ticktrue::damage
