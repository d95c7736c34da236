// One child process that leads its own process group: forked, read from, waited for, ended with its whole group.
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

  /// Reads once. Closes the stream at its end.
  void read();
  std::string text() const;
  std::uint64_t dropped_size() const { return dropped_size_; }
  /// Number of bytes read, including bytes that were not retained.
  std::uint64_t read_size() const { return dropped_size_ + retained_.size(); }

  /// Called with retained bytes as they arrive (Retain::first).
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

  /// Adds a stream that retains its first or last `size_max` bytes. The reference is valid as long as this object.
  ChildStream& add_stream(std::size_t size_max, ChildStream::Retain retain);

  /// Child: leads its group, ends with the calling thread if the system supports this, and has the write ends open.
  /// Parent: stop signals are forwarded to the group of the child until wait() returns. `failed`: failure() has the
  /// reason.
  Side fork();
  const std::string& failure() const { return failure_; }
  pid_t id() const { return id_; }

  /// Reads the streams until the child ends, `time_s` has passed, or `goes_on` returns false (called about every 10 ms;
  /// may be empty). Then kills the rest of the process group.
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
