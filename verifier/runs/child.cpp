// Starts a program as a child process. Arguments, environment and folder are prepared before the fork.
// SPDX-License-Identifier: MIT
#include "verifier/runs/child.h"

#include "verifier/runs/child_process.h"
#include "verifier/runs/completion.h"

#ifdef TICKTRUE_HAS_FORK
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>

#include "verifier/runs/data_file.h"

extern "C" char** environ;
#endif

namespace ticktrue::verifier {

#ifdef TICKTRUE_HAS_FORK
namespace {

/// Strings in the form that exec needs.
class CStrings {
 public:
  void add(std::string text) { texts_.push_back(std::move(text)); }
  /// For an environment: sets a variable. An existing variable keeps its index; without a value it is removed.
  void set_variable(const std::string& name, const std::optional<std::string>& value) {
    const std::string start = name + "=";
    const auto is_it = [&](const std::string& text) { return text.compare(0, start.size(), start) == 0; };
    auto rest = std::find_if(texts_.begin(), texts_.end(), is_it);
    if (value && rest == texts_.end()) return add(start + *value);
    if (value) *rest++ = start + *value;
    texts_.erase(std::remove_if(rest, texts_.end(), is_it), texts_.end());
  }
  char** pointers() {
    pointers_.clear();
    for (std::string& text : texts_) pointers_.push_back(text.data());
    pointers_.push_back(nullptr);
    return pointers_.data();
  }

 private:
  std::vector<std::string> texts_;
  std::vector<char*> pointers_;
};

CStrings environment_of(const ChildCommand& command, int completion_descriptor) {
  CStrings strings;
  if (command.inherited)
    for (const std::string& variable : *command.inherited) strings.add(variable);
  else
    for (char** at = environ; at != nullptr && *at != nullptr; ++at) strings.add(*at);
  for (const auto& [name, value] : command.environment) strings.set_variable(name, value);
  strings.set_variable(completion_variable, std::to_string(completion_descriptor));
  return strings;
}

/// The output pipes of one program.
struct ProgramStreams {
  ChildStream& output;
  ChildStream& message;
  ChildStream& finished;
  ChildStream& failure;
};

/// In the child between fork and exec: calls only functions that are safe there.
[[noreturn]] void become_program(char** argv, char** environment, const ChildCommand& command,
                                 const ProgramStreams& streams) {
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing >= 0) ::dup2(nothing, 0);
  ::dup2(streams.output.write_end(), 1);
  ::dup2(streams.message.write_end(), 2);
  ::fcntl(streams.finished.write_end(), F_SETFD, 0);
  for (const int signal : {SIGPIPE, SIGXFSZ}) ::signal(signal, SIG_DFL);
  const char* cwd = command.cwd.c_str();
  if (*cwd == '\0' || ::chdir(cwd) == 0) {
    if (command.prepare != nullptr) command.prepare(command.prepare_with);
    environ = environment;
    ::execvp(argv[0], argv);
  }
  const int reason = errno;
  const auto written = ::write(streams.failure.write_end(), &reason, sizeof reason);
  ::_exit(written < 0 ? 126 : 127);
}

}  // namespace

ChildResult run_child(const ChildCommand& command) {
  ChildResult result;
  if (command.argv.empty()) {
    result.end.failure = "no program was named";
    return result;
  }
  ChildProcess process;
  const ProgramStreams streams{process.add_stream(command.limits.output_size_max, ChildStream::Retain::first),
                               process.add_stream(command.limits.message_size_max, ChildStream::Retain::last),
                               process.add_stream(1, ChildStream::Retain::first),
                               process.add_stream(sizeof(int), ChildStream::Retain::first)};
  CStrings arguments;
  for (const std::string& word : command.argv) arguments.add(word);
  CStrings environment = environment_of(command, streams.finished.write_end());
  char** argv = arguments.pointers();
  char** variables = environment.pointers();
  const ChildProcess::Side side = process.fork();
  if (side == ChildProcess::Side::child) become_program(argv, variables, command, streams);
  if (side == ChildProcess::Side::failed) {
    result.end.failure = process.failure();
    return result;
  }
  result.end = process.wait(command.limits.time_s, [&] {
    return streams.output.read_size() + streams.message.read_size() <= command.limits.printed_size_max;
  });
  result.finished = !streams.finished.text().empty();
  result.output = streams.output.text();
  result.output_dropped_size = streams.output.dropped_size();
  result.message = streams.message.text();
  result.message_dropped_size = streams.message.dropped_size();
  if (const std::string failure = streams.failure.text(); failure.size() == sizeof(int)) {
    int reason = 0;
    std::memcpy(&reason, failure.data(), sizeof reason);
    result.end.how = ChildEnd::How::not_started;
    result.end.failure = system_message(reason);
  }
  if (result.end.stop_signal != 0) std::raise(result.end.stop_signal);
  return result;
}

std::string child_failure(const ChildResult& result, const ChildLimits& limits) {
  switch (result.end.how) {
    case ChildEnd::How::exited:
      break;
    case ChildEnd::How::killed_by_signal:
      return "was killed by signal " + std::to_string(result.end.signal) + " (" + ::strsignal(result.end.signal) + ")";
    case ChildEnd::How::stopped:
      return "printed more than " + std::to_string(limits.printed_size_max) + " bytes and was killed";
    case ChildEnd::How::timed_out:
      return "did not end within " + std::to_string(static_cast<long>(limits.time_s)) + " s and was killed";
    case ChildEnd::How::not_started:
      return "cannot be started: " + result.end.failure;
  }
  if (result.output_dropped_size == 0) return "";
  return "printed " + std::to_string(result.output.size() + result.output_dropped_size) + " bytes, expected at most " +
         std::to_string(limits.output_size_max);
}

#else

ChildResult run_child(const ChildCommand&) {
  ChildResult result;
  result.end.failure = "this build of ticktrue cannot start other programs";
  return result;
}

std::string child_failure(const ChildResult& result, const ChildLimits&) {
  return "cannot be started: " + result.end.failure;
}

#endif

}  // namespace ticktrue::verifier
