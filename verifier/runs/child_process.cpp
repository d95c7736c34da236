// Child processes by fork, poll and waitid. On a system without child processes, nothing is compiled.
// SPDX-License-Identifier: MIT
#include "verifier/runs/child_process.h"

#ifdef TICKTRUE_HAS_FORK

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <vector>

#include "verifier/runs/data_file.h"
#include "verifier/runs/escaped.h"
#include "verifier/runs/stop_signals.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t stream_read_size = 64u << 10;
constexpr int pause_max_ms = 10;
// The killed processes of a group end within milliseconds, unless the disk blocks them.
constexpr double group_end_max_s = 2;

void close_descriptor(int& descriptor) {
  if (descriptor >= 0) ::close(descriptor);
  descriptor = -1;
}

}  // namespace

ChildStream::ChildStream(std::size_t size_max, Retain retain) : size_max_(size_max), retain_(retain) {
  int ends[2];
  if (::pipe(ends) != 0) return;
  read_end_ = ends[0];
  write_end_ = ends[1];
  for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
  ::fcntl(read_end_, F_SETFL, O_NONBLOCK);
}

ChildStream::~ChildStream() {
  close_descriptor(read_end_);
  close_descriptor(write_end_);
}

void ChildStream::close_write_end() {
  close_descriptor(write_end_);
}

void ChildStream::retain(std::string_view bytes) {
  if (retain_ == Retain::first) {
    const std::string_view part = bytes.substr(0, size_max_ - std::min(size_max_, retained_.size()));
    if (relay && !part.empty()) relay(part);
    retained_ += part;
    dropped_size_ += bytes.size() - part.size();
    return;
  }
  retained_ += bytes;
  if (retained_.size() <= 2 * size_max_ + stream_read_size) return;  // not after each read
  dropped_size_ += retained_.size() - size_max_;
  retained_.erase(0, retained_.size() - size_max_);
}

void ChildStream::read() {
  char block[stream_read_size];
  const auto count = ::read(read_end_, block, sizeof block);
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (count <= 0) return close_descriptor(read_end_);
  retain({block, static_cast<std::size_t>(count)});
}

std::string ChildStream::text() const {
  return retain_ == Retain::first || retained_.size() <= size_max_ ? retained_
                                                                   : retained_.substr(retained_.size() - size_max_);
}

ChildStream& ChildProcess::add_stream(std::size_t size_max, ChildStream::Retain retain) {
  return streams_.emplace_back(size_max, retain);
}

ChildProcess::Side ChildProcess::fork() {
  const bool has_streams =
      std::all_of(streams_.begin(), streams_.end(), [](const ChildStream& stream) { return stream.is_open(); });
  if (!has_streams) {
    failure_ = system_message(errno);
    return Side::failed;
  }
  const BlockedSignals held;  // no signal arrives between the fork and the forwarding of signals
  if (stop_signal_pending()) {
    failure_ = "stopped";
    return Side::failed;
  }
  std::signal(SIGCHLD, SIG_DFL);  // if SIGCHLD were ignored, there would be nothing to wait for
  start_ = std::chrono::steady_clock::now();
  id_ = fork_own_child();
  if (id_ < 0) {
    failure_ = system_message(errno);
    return Side::failed;
  }
  if (id_ == 0) {
    ::setpgid(0, 0);
#ifdef __linux__
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    reset_stop_signals();
    return Side::child;
  }
  ::setpgid(id_, id_);  // in parent and child, because either may run first
  forward_stop_signals_to(id_);
  for (ChildStream& stream : streams_) stream.close_write_end();
  return Side::parent;
}

double ChildProcess::elapsed_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

/// Whether the child has ended. Its id, and so the id of its group, stays in use until end_group.
bool ChildProcess::has_ended() const {
  siginfo_t info{};
  return ::waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ? errno != EINTR
                                                                                          : info.si_pid == id_;
}

void ChildProcess::read_ready(int wait_ms) {
  std::vector<pollfd> watched;
  std::vector<ChildStream*> streams;
  for (ChildStream& stream : streams_) {
    if (!stream.is_open()) continue;
    watched.push_back({stream.read_end(), POLLIN, 0});
    streams.push_back(&stream);
  }
  if (::poll(watched.data(), static_cast<nfds_t>(watched.size()), wait_ms) <= 0) return;
  for (std::size_t i = 0; i < watched.size(); ++i)
    if (watched[i].revents != 0) streams[i]->read();
}

ChildEnd ChildProcess::wait(std::optional<double> time_s, const std::function<bool()>& goes_on) {
  ChildEnd end;
  end.how = ChildEnd::How::exited;
  for (int pause_ms = 1; !has_ended(); pause_ms = std::min(2 * pause_ms, pause_max_ms)) {
    if (time_s && elapsed_s() >= *time_s) {
      end.how = ChildEnd::How::timed_out;
      break;
    }
    if (goes_on && !goes_on()) {
      end.how = ChildEnd::How::stopped;
      break;
    }
    read_ready(pause_ms);
  }
  return end_group(std::move(end));
}

ChildEnd ChildProcess::end_group(ChildEnd end) {
  ::kill(-id_, SIGKILL);
  ::kill(id_, SIGKILL);  // the child may not have made its group yet
  int status = 0;
  pid_t found = 0;
  while ((found = ::waitpid(id_, &status, 0)) < 0 && errno == EINTR) {
  }
  end.wall_s = elapsed_s();
  // Reaps adopted children of the child. Afterwards no process of the group has a write end.
  const double last_s = end.wall_s + group_end_max_s;
  while (::waitpid(-id_, nullptr, WNOHANG) >= 0 && elapsed_s() < last_s) ::poll(nullptr, 0, 1);
  for (ChildStream& stream : streams_) {
    // Reads the rest of the pipe. An escaped process may still write; it is not waited for.
    for (int reads = 0; stream.is_open() && reads < 64; ++reads) {
      pollfd watched{stream.read_end(), POLLIN, 0};
      if (::poll(&watched, 1, 0) <= 0) break;
      stream.read();
    }
  }
  end.stop_signal = end_forwarding_to(id_);
  forget_own_child(id_);
  end.escaped = escaped_children();
  if (end.how != ChildEnd::How::exited) return end;
  if (found > 0 && WIFSIGNALED(status)) {
    end.how = ChildEnd::How::killed_by_signal;
    end.signal = WTERMSIG(status);
  } else {
    end.exit_status = found > 0 ? WEXITSTATUS(status) : 127;
  }
  return end;
}

}  // namespace ticktrue::verifier

#endif
