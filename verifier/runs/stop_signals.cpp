// A table of process groups that a signal handler may read.
// SPDX-License-Identifier: MIT
#include "verifier/runs/stop_signals.h"

#ifdef TICKTRUE_HAS_FORK

#include <array>
#include <atomic>
#include <cerrno>
#include <mutex>

namespace ticktrue::verifier {
namespace {

constexpr std::array stop_signals{SIGINT, SIGTERM, SIGHUP};
constexpr std::size_t group_count_max = 256;  // parallel children; signals are not forwarded to more

std::array<std::atomic<pid_t>, group_count_max> signal_groups{};
static_assert(std::atomic<pid_t>::is_always_lock_free);
std::atomic<int> stop_signal_seen{0};  // written by a handler, read by threads
static_assert(std::atomic<int>::is_always_lock_free);
std::array<struct sigaction, stop_signals.size()> handlers_before{};
std::mutex groups_lock;
int group_count = 0;

void pass_on(int signal) {
  const int error_number = errno;
  stop_signal_seen = signal;
  for (const std::atomic<pid_t>& group : signal_groups)
    if (const pid_t id = group.load(); id > 0) ::kill(-id, signal);
  errno = error_number;
}

void install_handlers() {
  for (std::size_t i = 0; i < stop_signals.size(); ++i) {
    ::sigaction(stop_signals[i], nullptr, &handlers_before[i]);
    if (handlers_before[i].sa_handler == SIG_IGN) continue;  // nohup, or a background job
    struct sigaction action {};
    action.sa_handler = pass_on;
    ::sigaction(stop_signals[i], &action, nullptr);
  }
}

void put_handlers_back() {
  for (std::size_t i = 0; i < stop_signals.size(); ++i) ::sigaction(stop_signals[i], &handlers_before[i], nullptr);
}

}  // namespace

BlockedSignals::BlockedSignals() {
  sigset_t set;
  ::sigemptyset(&set);
  for (const int signal : stop_signals) ::sigaddset(&set, signal);
  ::pthread_sigmask(SIG_BLOCK, &set, &before_);
}

BlockedSignals::~BlockedSignals() {
  ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void forward_stop_signals_to(pid_t group) {
  const std::lock_guard guard(groups_lock);
  if (group_count++ == 0) install_handlers();
  for (std::atomic<pid_t>& place : signal_groups) {
    pid_t none = 0;
    if (place.compare_exchange_strong(none, group)) return;
  }
}

int end_forwarding_to(pid_t group) {
  const std::lock_guard guard(groups_lock);
  for (std::atomic<pid_t>& place : signal_groups) {
    pid_t id = group;
    if (place.compare_exchange_strong(id, 0)) break;
  }
  const int seen = stop_signal_seen;
  if (--group_count > 0) return seen;
  put_handlers_back();
  stop_signal_seen = 0;
  return seen;
}

bool stop_signal_pending() {
  return stop_signal_seen != 0;
}

void reset_stop_signals() {
  if (group_count > 0) put_handlers_back();
  group_count = 0;
  stop_signal_seen = 0;
  for (std::atomic<pid_t>& place : signal_groups) place.store(0);
}

}  // namespace ticktrue::verifier

#endif
