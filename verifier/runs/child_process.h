// One child process that leads its own process group: forked, read from, waited for, ended with all of its group.
// SPDX-License-Identifier: MIT
#pragma once

#if !defined(_WIN32) && !defined(__EMSCRIPTEN__)
#define TICKTRUE_HAS_FORK 1
#endif

#ifdef TICKTRUE_HAS_FORK

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "verifier/runs/child_end.h"

namespace ticktrue::verifier {

/// A pipe from a child process, and the part of its output that is retained.
class ChildStream {
 public:
  enum class Retain { first, last };
  ChildStream(std::size_t size_max, Retain retain);
  ChildStream(const ChildStream&) = delete;
  ChildStream& operator=(const ChildStream&) = delete;
  ~ChildStream();

  bool is_open() const { return read_end_ >= 0; }
  int read_end() const { return read_end_; }
  int write_end() const { return write_end_; }
  void close_write_end();

  /// Reads once. At the end of the stream it is closed.
  void read();
  std::string text() const;
  std::uint64_t dropped_size() const { return dropped_size_; }
  /// Bytes that were read, retained or not.
  std::uint64_t read_size() const { return dropped_size_ + retained_.size(); }

  /// Called with bytes as they arrive, as far as they are retained (Retain::first).
  std::function<void(std::string_view)> relay;

 private:
  void retain(std::string_view bytes);
  int read_end_ = -1;
  int write_end_ = -1;
  std::size_t size_max_;
  Retain retain_;
  std::string retained_;
  std::uint64_t dropped_size_ = 0;
};

/// Order of calls: add_stream, fork, then in the parent wait.
class ChildProcess {
 public:
  enum class Side { parent, child, failed };

  /// Bytes of the stream: the first or the last `size_max`. Valid as long as this.
  ChildStream& add_stream(std::size_t size_max, ChildStream::Retain retain);

  /// In the child: leads its group, ends with this thread where the system can do that, and has the write ends open.
  /// In the parent: stop signals go to the child's group until wait() has returned. `failed`: failure() says why.
  Side fork();
  const std::string& failure() const { return failure_; }
  pid_t id() const { return id_; }

  /// Reads the streams until the child has ended, `time_s` has passed or `goes_on` (asked every 10 ms or so; may be
  /// empty) gives false. What is left of the process group is killed.
  ChildEnd wait(std::optional<double> time_s, const std::function<bool()>& goes_on);

 private:
  bool has_ended() const;
  void read_ready(int wait_ms);
  ChildEnd end_group(ChildEnd end);
  double elapsed_s() const;

  std::deque<ChildStream> streams_;
  std::string failure_;
  pid_t id_ = -1;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace ticktrue::verifier

#endif
