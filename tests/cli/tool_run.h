// Runs the tool as a child process under conditions that a test prepares: signals, limits, users.
// SPDX-License-Identifier: MIT
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <string>
#include <vector>

#include "tests/replay/toy_traces.h"

namespace ticktrue::test {

/// A child process that runs the tool. Its messages go to a file.
class ToolRun {
 public:
  ToolRun(const std::vector<std::string>& words, const std::string& messages, const std::function<void()>& prepare) {
    std::vector<std::string> whole{TICKTRUE_TOOL};
    whole.insert(whole.end(), words.begin(), words.end());
    std::vector<char*> arguments;
    for (std::string& word : whole) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    child_ = ::fork();
    REQUIRE(child_ >= 0);
    if (child_ != 0) return;
    const int out = ::open(messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    ::dup2(out, 1);
    ::dup2(out, 2);
    if (prepare) prepare();
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  void kill(int signal = SIGKILL) const { ::kill(child_, signal); }
  pid_t id() const { return child_; }
  /// The exit code, or -1 after a signal.
  int wait() const {
    int status = 0;
    ::waitpid(child_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t child_ = -1;
};

inline std::string text_of(const std::string& path) {
  const Bytes bytes = read_file(path);
  return {bytes.begin(), bytes.end()};
}

/// Three bodies above the ground, which inputs push.
inline const std::string pushed_scene =
    R"({"name":"three","bodies":[{"type":"static","shapes":[{"type":"box","half_size":[50,1]}]},
{"position":[0,2],"shapes":[{"type":"circle","radius":0.5}]},{"position":[2,2],"shapes":[{"type":"circle","radius":0.5}]},
{"position":[4,2],"shapes":[{"type":"box","half_size":[0.5,0.5]}]}],"inputs":["impulse"]})";

}  // namespace ticktrue::test
