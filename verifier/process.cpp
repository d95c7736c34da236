// fork, exec, poll: and nothing of that where the system has no processes to start.
// SPDX-License-Identifier: MIT
#include "verifier/process.h"

#if defined(__unix__) && !defined(__EMSCRIPTEN__)
#define TICKTRUE_HAS_PROCESSES
#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#endif

#include "verifier/data_file.h"

namespace ticktrue::verifier {

#ifdef TICKTRUE_HAS_PROCESSES
namespace {

constexpr std::size_t message_size_max = 64u << 10;
constexpr std::size_t read_size = 64u << 10;

struct Pipe {
  int read_end = -1;
  int write_end = -1;
  Pipe() {
    int ends[2];
    if (::pipe(ends) != 0) return;
    read_end = ends[0];
    write_end = ends[1];
    for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  }
  Pipe(const Pipe&) = delete;
  ~Pipe() {
    close_end(read_end);
    close_end(write_end);
  }
  static void close_end(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
  bool is_open() const { return read_end >= 0; }
};

/// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void become(char* const* words, const Pipe& output, const Pipe& message, const Pipe& failure) {
  ::setpgid(0, 0);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing >= 0) ::dup2(nothing, 0);
  ::dup2(output.write_end, 1);
  ::dup2(message.write_end, 2);
  ::signal(SIGPIPE, SIG_DFL);
  ::execvp(words[0], words);
  const int reason = errno;
  const auto written = ::write(failure.write_end, &reason, sizeof reason);
  ::_exit(written < 0 ? 126 : 127);
}

/// Reads what is there. False: the end.
bool take_some(int descriptor, std::string& text) {
  char block[read_size];
  const auto count = ::read(descriptor, block, sizeof block);
  if (count < 0) return errno == EINTR || errno == EAGAIN;
  text.append(block, static_cast<std::size_t>(count));
  return count > 0;
}

class Child {
 public:
  Child(pid_t id, Pipe& output, Pipe& message) : id_(id), output_(output), message_(message) {}

  ProcessResult wait(const ProcessLimits& limits) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limits.time_s);
    ProcessResult result;
    result.end = ProcessResult::End::exited;
    while (output_.is_open() || message_.is_open()) {
      const auto left = std::chrono::duration<double>(end - std::chrono::steady_clock::now()).count();
      if (left <= 0) return kill(std::move(result), ProcessResult::End::timed_out);
      read_ready(left, result);
      if (result.output.size() > limits.output_size_max)
        return kill(std::move(result), ProcessResult::End::too_much_output);
    }
    // It closed its output, but may still run.
    while (!reap(result, WNOHANG)) {
      if (std::chrono::steady_clock::now() >= end) return kill(std::move(result), ProcessResult::End::timed_out);
      ::poll(nullptr, 0, 5);
    }
    return result;
  }

 private:
  void read_ready(double left_s, ProcessResult& result) {
    pollfd watched[2] = {{output_.read_end, POLLIN, 0}, {message_.read_end, POLLIN, 0}};
    const int wait_ms = left_s > 1 ? 1000 : static_cast<int>(left_s * 1000) + 1;
    if (::poll(watched, 2, wait_ms) <= 0) return;
    if (watched[0].revents != 0 && !take_some(output_.read_end, result.output)) Pipe::close_end(output_.read_end);
    if (watched[1].revents != 0 && !take_some(message_.read_end, result.message)) Pipe::close_end(message_.read_end);
    if (result.message.size() > 2 * message_size_max) result.message.erase(0, result.message.size() - message_size_max);
  }

  bool reap(ProcessResult& result, int flags) {
    int status = 0;
    const pid_t found = ::waitpid(id_, &status, flags);
    if (found == 0 || (found < 0 && errno == EINTR)) return false;
    if (found > 0 && WIFSIGNALED(status)) {
      result.end = ProcessResult::End::killed_by_signal;
      result.code = WTERMSIG(status);
    } else {
      result.code = found > 0 ? WEXITSTATUS(status) : 127;
    }
    return true;
  }

  ProcessResult kill(ProcessResult result, ProcessResult::End reason) {
    ::kill(-id_, SIGKILL);
    ::kill(id_, SIGKILL);  // it may not have made its group yet
    while (!reap(result, 0)) {
    }
    result.end = reason;
    return result;
  }

  pid_t id_;
  Pipe& output_;
  Pipe& message_;
};

}  // namespace

ProcessResult run_process(std::vector<std::string> words, const ProcessLimits& limits) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  Pipe output, message, failure;
  ProcessResult result;
  const pid_t id = output.is_open() && message.is_open() && failure.is_open() ? ::fork() : -1;
  if (id == 0) become(arguments.data(), output, message, failure);
  if (id < 0) {
    result.message = system_message(errno);
    return result;
  }
  ::setpgid(id, id);
  Pipe::close_end(output.write_end);
  Pipe::close_end(message.write_end);
  Pipe::close_end(failure.write_end);
  int reason = 0;
  auto count = ::read(failure.read_end, &reason, sizeof reason);
  while (count < 0 && errno == EINTR) count = ::read(failure.read_end, &reason, sizeof reason);
  if (count == static_cast<decltype(count)>(sizeof reason)) {
    int status = 0;
    while (::waitpid(id, &status, 0) < 0 && errno == EINTR) {
    }
    result.message = system_message(reason);
    return result;
  }
  return Child(id, output, message).wait(limits);
}

std::string process_failure(const ProcessResult& result, const ProcessLimits& limits) {
  switch (result.end) {
    case ProcessResult::End::exited:
      return "";
    case ProcessResult::End::killed_by_signal:
      return "was killed by signal " + std::to_string(result.code) + " (" + ::strsignal(result.code) + ")";
    case ProcessResult::End::timed_out:
      return "did not end within " + std::to_string(static_cast<long>(limits.time_s)) + " s and was killed";
    case ProcessResult::End::too_much_output:
      return "printed more than " + std::to_string(limits.output_size_max) + " bytes and was killed";
    case ProcessResult::End::not_started:
      return "cannot be started: " + result.message;
  }
  return "";
}

#else

ProcessResult run_process(std::vector<std::string>, const ProcessLimits&) {
  ProcessResult result;
  result.message = "this build of ticktrue cannot start other programs";
  return result;
}

std::string process_failure(const ProcessResult& result, const ProcessLimits&) {
  return "cannot be started: " + result.message;
}

#endif

}  // namespace ticktrue::verifier
