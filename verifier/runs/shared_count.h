// The number of ticks compared, in shared memory that outlives a crash of the child process.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>

namespace ticktrue::verifier {

/// A count in memory that this process shares with its later children. If the system has no child processes, or no
/// memory for the page, this process has the count alone.
class SharedCount {
 public:
  SharedCount();
  ~SharedCount();
  SharedCount(const SharedCount&) = delete;
  SharedCount& operator=(const SharedCount&) = delete;

  void add_tick(double time_s);
  std::uint64_t ticks() const;
  /// Simulated time at the end of the last added tick, s.
  double time_s() const;

 private:
  struct Page {
    std::atomic<std::uint64_t> ticks{0};
    std::atomic<double> time_s{0};
  };
  Page own_;
  Page* page_ = &own_;
};

}  // namespace ticktrue::verifier
