// The child process in which plug-ins run, and the watch over it.
// SPDX-License-Identifier: MIT
#include "verifier/plugin_guard.h"

#if !defined(_WIN32) && !defined(__EMSCRIPTEN__)
#define TICKTRUE_CAN_FORK 1
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#endif

#include "verifier/exit_codes.h"

namespace ticktrue::verifier {
namespace {

PluginWatch* watch = nullptr;

std::string call_text(std::uint32_t call, std::uint64_t tick) {
  switch (static_cast<PluginCall>(call)) {
    case PluginCall::none:
      return "outside its functions";
    case PluginCall::open:
      return "while it was loaded";
    case PluginCall::create:
      return "in create";
    case PluginCall::columns:
      return "in columns, after tick " + std::to_string(tick);
    case PluginCall::step:
      return "in step of tick " + std::to_string(tick);
    case PluginCall::accept:
      return "in accept of tick " + std::to_string(tick);
    case PluginCall::resize:
      return "in resize";
    case PluginCall::loaded:
      return "in loaded";
    case PluginCall::names:
      return "in row_name or inputs_text";
    case PluginCall::destroy:
      return "in destroy";
  }
  return "";
}

}  // namespace

WatchedCall::WatchedCall(PluginCall call, std::uint64_t tick) {
  if (watch == nullptr) return;
  watch->tick.store(tick, std::memory_order_relaxed);
  watch->call.store(static_cast<std::uint32_t>(call), std::memory_order_relaxed);
  watch->sequence.fetch_add(1, std::memory_order_release);
}

WatchedCall::~WatchedCall() {
  if (watch == nullptr) return;
  watch->call.store(static_cast<std::uint32_t>(PluginCall::none), std::memory_order_relaxed);
  watch->sequence.fetch_add(1, std::memory_order_release);
}

#ifdef TICKTRUE_CAN_FORK

namespace {

volatile std::sig_atomic_t guarded_child = 0;

void forward_signal(int signal) {
  if (guarded_child > 0) kill(static_cast<pid_t>(guarded_child), signal);
}

std::string signal_text(int signal) {
  const char* name = signal == SIGSEGV   ? "SIGSEGV"
                     : signal == SIGABRT ? "SIGABRT"
                     : signal == SIGFPE  ? "SIGFPE"
                     : signal == SIGILL  ? "SIGILL"
                     : signal == SIGBUS  ? "SIGBUS"
                     : signal == SIGKILL ? "SIGKILL"
                                         : nullptr;
  return name != nullptr ? std::string(name) : "signal " + std::to_string(signal);
}

}  // namespace

bool can_guard_plugins() {
  return true;
}

std::optional<GuardedEnd> run_guarded(const std::string& plugin_names, std::uint64_t timeout_s) {
  using Clock = std::chrono::steady_clock;
  void* page = mmap(nullptr, sizeof(PluginWatch), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return GuardedEnd{exit_usage, "plug-in " + plugin_names + ": no memory for its watch"};
  std::memset(page, 0, sizeof(PluginWatch));
  watch = static_cast<PluginWatch*>(page);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) return GuardedEnd{exit_usage, "plug-in " + plugin_names + ": the system gave no process for it"};
  if (child == 0) return std::nullopt;

  guarded_child = static_cast<std::sig_atomic_t>(child);
  std::signal(SIGINT, SIG_IGN);  // a terminal sends it to the child as well
  std::signal(SIGTERM, forward_signal);
  std::uint64_t sequence = 0;
  Clock::time_point since = Clock::now();
  long pause_ns = 500'000;
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    const std::string where = call_text(watch->call.load(), watch->tick.load());
    if (ended == child && WIFEXITED(status)) return GuardedEnd{WEXITSTATUS(status), ""};
    if (ended == child)
      return GuardedEnd{exit_finding,
                        "plug-in " + plugin_names + ": crashed with " + signal_text(WTERMSIG(status)) + " " + where};
    if (ended < 0 && errno != EINTR) return GuardedEnd{exit_usage, "plug-in " + plugin_names + ": its process is lost"};
    const std::uint64_t now = watch->sequence.load(std::memory_order_acquire);
    const bool is_busy = watch->call.load() != static_cast<std::uint32_t>(PluginCall::none);
    if (now != sequence || !is_busy) {
      sequence = now;
      since = Clock::now();
    } else if (Clock::now() - since > std::chrono::seconds(timeout_s)) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return GuardedEnd{exit_finding, "plug-in " + plugin_names + ": hangs " + where + ": found no end after " +
                                          std::to_string(timeout_s) + " s (--plugin-timeout)"};
    }
    const timespec pause{0, pause_ns};
    nanosleep(&pause, nullptr);
    if (pause_ns < 10'000'000) pause_ns *= 2;
  }
}

#else

bool can_guard_plugins() {
  return false;
}

std::optional<GuardedEnd> run_guarded(const std::string&, std::uint64_t) {
  return GuardedEnd{exit_usage, "plug-ins: this system has no child processes"};
}

#endif

}  // namespace ticktrue::verifier
