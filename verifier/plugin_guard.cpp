// The child process in which plug-ins run, and the watch over it.
// SPDX-License-Identifier: MIT
#include "verifier/plugin_guard.h"

#if !defined(_WIN32) && !defined(__EMSCRIPTEN__)
#define TICKTRUE_CAN_FORK 1
#include <sys/mman.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
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

namespace {

// Of run_guarded, for the parts of its child.
std::string guarded_names;
std::uint64_t guarded_timeout_s = 0;

/// A page that this process and the child it is about to make both see; null where there is no memory.
PluginWatch* make_watch() {
  void* page = mmap(nullptr, sizeof(PluginWatch), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return nullptr;
  std::memset(page, 0, sizeof(PluginWatch));
  return static_cast<PluginWatch*>(page);
}

/// Waits for the child; kills it when one call takes too long.
GuardedEnd wait_for(pid_t child, const PluginWatch& page) {
  using Clock = std::chrono::steady_clock;
  std::uint64_t sequence = 0;
  Clock::time_point since = Clock::now();
  long pause_ns = 500'000;
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    const std::string where = call_text(page.call.load(), page.tick.load());
    if (ended == child && WIFEXITED(status)) return GuardedEnd{WEXITSTATUS(status), ""};
    if (ended == child)
      return GuardedEnd{exit_finding,
                        "plug-in " + guarded_names + ": crashed with " + signal_text(WTERMSIG(status)) + " " + where};
    if (ended < 0 && errno != EINTR)
      return GuardedEnd{exit_usage, "plug-in " + guarded_names + ": its process is lost"};
    const std::uint64_t now = page.sequence.load(std::memory_order_acquire);
    const bool is_busy = page.call.load() != static_cast<std::uint32_t>(PluginCall::none);
    if (now != sequence || !is_busy) {
      sequence = now;
      since = Clock::now();
    } else if (Clock::now() - since > std::chrono::seconds(guarded_timeout_s)) {
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return GuardedEnd{exit_finding, "plug-in " + guarded_names + ": hangs " + where + ": found no end after " +
                                          std::to_string(guarded_timeout_s) + " s (--plugin-timeout)"};
    }
    const timespec pause{0, pause_ns};
    nanosleep(&pause, nullptr);
    if (pause_ns < 10'000'000) pause_ns *= 2;
  }
}

/// In the child: does the part and writes what it gives to `out`.
[[noreturn]] void do_part(const std::function<Bytes()>& part, std::FILE* out) {
#ifdef __linux__
  prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
  const Bytes result = part();
  const bool written = std::fwrite(result.data(), 1, result.size(), out) == result.size() && std::fflush(out) == 0;
  std::fflush(nullptr);
  _exit(written ? exit_ok : exit_usage);
}

}  // namespace

std::optional<GuardedEnd> run_guarded(const std::string& plugin_names, std::uint64_t timeout_s) {
  guarded_names = plugin_names;
  guarded_timeout_s = timeout_s;
  watch = make_watch();
  if (watch == nullptr) return GuardedEnd{exit_usage, "plug-in " + plugin_names + ": no memory for its watch"};
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) return GuardedEnd{exit_usage, "plug-in " + plugin_names + ": the system gave no process for it"};
  if (child == 0) return std::nullopt;
  guarded_child = static_cast<std::sig_atomic_t>(child);
  std::signal(SIGINT, SIG_IGN);  // a terminal sends it to the child as well
  std::signal(SIGTERM, forward_signal);
  return wait_for(child, *watch);
}

GuardedPart run_part(const std::function<Bytes()>& part) {
  if (watch == nullptr) return {part(), ""};
  PluginWatch* page = make_watch();
  std::FILE* out = std::tmpfile();
  std::fflush(nullptr);
  const pid_t child = page != nullptr && out != nullptr ? fork() : -1;
  if (child == 0) {
    watch = page;
    do_part(part, out);
  }
  GuardedPart done;
  if (child < 0) {
    done.message = "plug-in " + guarded_names + ": the system gave no process for it";
  } else {
    const GuardedEnd end = wait_for(child, *page);
    std::rewind(out);
    std::uint8_t block[4096];
    for (std::size_t size = 0; (size = std::fread(block, 1, sizeof block, out)) > 0;)
      done.result.insert(done.result.end(), block, block + size);
    done.message = end.message;
    if (end.message.empty() && (end.exit_code != exit_ok || done.result.empty()))
      done.message =
          "plug-in " + guarded_names + ": it ended the process, with exit code " + std::to_string(end.exit_code);
  }
  if (out != nullptr) std::fclose(out);
  if (page != nullptr) munmap(page, sizeof(PluginWatch));
  return done;
}

#else

bool can_guard_plugins() {
  return false;
}

std::optional<GuardedEnd> run_guarded(const std::string&, std::uint64_t) {
  return GuardedEnd{exit_usage, "plug-ins: this system has no child processes"};
}

GuardedPart run_part(const std::function<Bytes()>& part) {
  return {part(), ""};
}

#endif

}  // namespace ticktrue::verifier
