// Runs plug-ins in a child process and watches it.
// SPDX-License-Identifier: MIT
#include "verifier/runs/plugin_isolation.h"

#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <string_view>

#include "verifier/runs/completion.h"
#include "verifier/runs/escaped.h"
#endif

#include <cstdlib>

#include "verifier/report/exit_codes.h"

namespace ticktrue::verifier {
namespace {

PluginWatch* watch = nullptr;

}  // namespace

WatchedCall::WatchedCall(PluginCall call, std::uint64_t tick) {
  if (watch == nullptr) return;
  watch->tick.store(tick, std::memory_order_relaxed);
  watch->last.store(static_cast<std::uint32_t>(call), std::memory_order_relaxed);
  watch->call.store(static_cast<std::uint32_t>(call), std::memory_order_relaxed);
  watch->sequence.fetch_add(1, std::memory_order_release);
}

WatchedCall::~WatchedCall() {
  if (watch == nullptr) return;
  watch->call.store(static_cast<std::uint32_t>(PluginCall::none), std::memory_order_relaxed);
  watch->sequence.fetch_add(1, std::memory_order_release);
}

#ifdef TICKTRUE_HAS_FORK

namespace {

constexpr std::size_t plugin_output_size_max = 64u << 10;
constexpr std::size_t part_result_size_max = std::size_t{1} << 30;

/// The call with its preposition: "in step of tick 7".
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
    case PluginCall::save:
      return "in save, after " + std::to_string(tick) + " ticks";
    case PluginCall::load:
      return "in load of the save of tick " + std::to_string(tick);
    case PluginCall::elements:
      return "in a callback of a child table, after tick " + std::to_string(tick);
  }
  return "";
}

/// The present or last call of the plug-in.
std::string place_text(const PluginWatch& page) {
  const std::uint32_t none = static_cast<std::uint32_t>(PluginCall::none);
  if (page.call.load() != none || page.last.load() == none) return call_text(page.call.load(), page.tick.load());
  return "outside its functions; it was last " + call_text(page.last.load(), page.tick.load());
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

// Set by run_isolated, for run_part in its child.
std::string isolated_names;
std::uint64_t isolated_timeout_s = 0;
std::FILE* output_of_tool = nullptr;

/// A page that this process shares with its next child; null: out of memory.
PluginWatch* make_watch() {
  void* page = mmap(nullptr, sizeof(PluginWatch), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (page == MAP_FAILED) return nullptr;
  std::memset(page, 0, sizeof(PluginWatch));
  return static_cast<PluginWatch*>(page);
}

/// Measures the duration of the current call.
class CallClock {
 public:
  CallClock(const PluginWatch& page, pid_t child) : page_(page), child_(child) {}

  /// False: the child is not waited for any longer, and text() has the reason.
  bool goes_on() {
    const std::uint64_t now = page_.sequence.load(std::memory_order_acquire);
    if (now != sequence_) {
      sequence_ = now;
      since_ = Clock::now();
    }
    const bool is_busy = page_.call.load() != static_cast<std::uint32_t>(PluginCall::none);
    const bool is_over = page_.finished.load() != 0;
    if (Clock::now() - since_ <= std::chrono::seconds(isolated_timeout_s)) return true;
    if (is_busy || is_over) {
      text_ = "hangs " + (is_over ? std::string("while it was unloaded") : place_text(page_)) +
              ": found no end after " + std::to_string(isolated_timeout_s) + " s (--plugin-timeout)";
      return false;
    }
    if (!main_thread_has_ended(child_)) return true;  // the tool's own work has no time limit
    text_ = "ended the main thread " + place_text(page_);
    return false;
  }
  const std::string& text() const { return text_; }

 private:
  using Clock = std::chrono::steady_clock;
  const PluginWatch& page_;
  pid_t child_;
  std::uint64_t sequence_ = 0;
  Clock::time_point since_ = Clock::now();
  std::string text_;
};

/// What the plug-in did to the process; empty: the tool ended the process.
std::string fault_text(const ChildEnd& end, const PluginWatch& page) {
  const bool is_over = page.finished.load() != 0;
  const std::string where = is_over ? "while it was unloaded" : place_text(page);
  if (end.how == ChildEnd::How::killed_by_signal) return "crashed with " + signal_text(end.signal) + " " + where;
  if (is_over && end.exit_status == page.exit_code.load()) return "";
  return "ended the process with exit code " + std::to_string(end.exit_status) + " " + where;
}

/// Waits for the child, and kills it if one call takes too long.
IsolatedEnd wait_for(ChildProcess& child, const PluginWatch& page, const std::function<void()>& meanwhile) {
  CallClock clock(page, child.id());
  const ChildEnd end = child.wait(std::nullopt, [&] {
    if (meanwhile) meanwhile();
    return clock.goes_on();
  });
  IsolatedEnd result;
  result.escaped = end.escaped;
  if (end.how == ChildEnd::How::killed_by_signal && end.signal == end.stop_signal) {
    result.exit_code = exit_finding;
    result.stop_signal = end.stop_signal;
    result.message = "plug-in " + isolated_names + ": stopped by " + signal_text(end.signal);
    return result;
  }
  const std::string fault = end.how == ChildEnd::How::stopped ? clock.text() : fault_text(end, page);
  if (!fault.empty()) result.message = "plug-in " + isolated_names + ": " + fault;
  result.exit_code = fault.empty() ? end.exit_status : exit_finding;
  return result;
}

/// In the child: from now on, output on standard output counts as the plug-in's.
void separate_output(const ChildStream& plugin_output) {
  const int descriptor = ::fcntl(1, F_DUPFD_CLOEXEC, 3);
  output_of_tool = descriptor < 0 ? nullptr : ::fdopen(descriptor, "w");
  ::dup2(plugin_output.write_end(), 1);
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // so that the lines before a crash arrive
  // A process in its own group may write to the terminal, and reads nothing from it.
  for (const int signal : {SIGTTIN, SIGTTOU}) std::signal(signal, SIG_IGN);
  close_completion_pipe();
}

bool write_whole(int descriptor, ByteView bytes) {
  while (!bytes.empty()) {
    const auto written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

/// In the child: runs the part and writes its result to the pipe.
[[noreturn]] void do_part(const std::function<Bytes()>& part, const ChildStream& out) {
  const bool written = write_whole(out.write_end(), part());
  std::fflush(nullptr);
  if (written) finish_isolated(exit_ok);
  _exit(written ? exit_ok : exit_usage);
}

}  // namespace

bool can_isolate_plugins() {
  return true;
}

std::FILE* isolated_output() {
  return output_of_tool;
}

void finish_isolated(int exit_code) {
  if (watch == nullptr) return;
  watch->exit_code.store(exit_code);
  watch->finished.store(1);
  watch->sequence.fetch_add(1, std::memory_order_release);
}

void end_by_signal(int signal) {
  std::fflush(nullptr);
  std::signal(signal, SIG_DFL);
  std::raise(signal);
  _exit(128 + signal);
}

std::optional<IsolatedEnd> run_isolated(const std::string& plugin_names, std::uint64_t timeout_s) {
  isolated_names = plugin_names;
  isolated_timeout_s = timeout_s;
  IsolatedEnd refused;
  refused.exit_code = exit_usage;
  PluginWatch* page = make_watch();
  if (page == nullptr) {
    refused.message = "plug-in " + plugin_names + ": no memory for its watch";
    return refused;
  }
  ChildProcess process;
  ChildStream& plugin_output = process.add_stream(plugin_output_size_max, ChildStream::Retain::first);
  plugin_output.relay = [](std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); };
  std::fflush(nullptr);
  const ChildProcess::Side side = process.fork();
  if (side == ChildProcess::Side::failed) {
    refused.message = "plug-in " + plugin_names + ": the system gave no process for it: " + process.failure();
    return refused;
  }
  if (side == ChildProcess::Side::child) {
    watch = page;
    separate_output(plugin_output);
    return std::nullopt;
  }
  IsolatedEnd end = wait_for(process, *page, {});
  end.dropped_output_size = plugin_output.dropped_size();
  return end;
}

IsolatedPart run_part(const std::function<Bytes()>& part, const std::function<void()>& meanwhile) {
  if (watch == nullptr) return {part(), ""};
  IsolatedPart done;
  PluginWatch* page = make_watch();
  if (page == nullptr) {
    done.message = "plug-in " + isolated_names + ": no memory for its watch";
    return done;
  }
  ChildProcess process;
  ChildStream& out = process.add_stream(part_result_size_max, ChildStream::Retain::first);
  std::fflush(nullptr);
  const ChildProcess::Side side = process.fork();
  if (side == ChildProcess::Side::child) {
    watch = page;
    do_part(part, out);
  }
  if (side == ChildProcess::Side::failed) {
    done.message = "plug-in " + isolated_names + ": the system gave no process for it: " + process.failure();
  } else {
    const IsolatedEnd end = wait_for(process, *page, meanwhile);
    if (end.stop_signal != 0) std::raise(end.stop_signal);
    const std::string text = out.text();
    done.result.assign(text.begin(), text.end());
    done.message = end.message;
  }
  munmap(page, sizeof(PluginWatch));
  return done;
}

#else

bool can_isolate_plugins() {
  return false;
}

std::FILE* isolated_output() {
  return stdout;
}

void finish_isolated(int) {}

void end_by_signal(int) {
  std::abort();
}

std::optional<IsolatedEnd> run_isolated(const std::string&, std::uint64_t) {
  IsolatedEnd refused;
  refused.exit_code = exit_usage;
  refused.message = "plug-ins: this system has no child processes";
  return refused;
}

IsolatedPart run_part(const std::function<Bytes()>& part, const std::function<void()>&) {
  return {part(), ""};
}

#endif

}  // namespace ticktrue::verifier
