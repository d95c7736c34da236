// A progress bar on stderr for work that takes longer than a second.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace ticktrue::cli {

/// Shown on a terminal only, after 1 s, at most 10 times a second: percentage, rate, time left. NO_COLOR is honoured;
/// the environment variable TICKTRUE_PROGRESS overrides the terminal: `always` (from the first update on) or `never`.
class Progress {
 public:
  /// `label`: the task ("verify stack.ttr"). `total` 0: not known, then only count and rate are shown.
  /// `unit` is what is counted.
  Progress(std::string label, std::uint64_t total, std::string unit = "ticks");
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();

  /// Cheap: may be called once a tick.
  void update(std::uint64_t done);
  /// The same if the total becomes known later.
  void update(std::uint64_t done, std::uint64_t total) {
    total_ = total;
    update(done);
  }
  /// Removes the bar, so that the next output begins on a clean line.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  void draw(Clock::time_point now, std::uint64_t done);

  std::string label_;
  std::uint64_t total_;
  std::string unit_;
  Clock::time_point start_;
  Clock::time_point next_draw_;
  bool enabled_ = false;
  bool colored_ = false;
  bool drawn_ = false;
};

}  // namespace ticktrue::cli
