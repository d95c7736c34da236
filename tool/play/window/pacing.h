// The time of the next picture: by the clock and not from picture to picture, so that errors do not accumulate.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <chrono>

namespace ticktrue::play {

inline constexpr double picture_s = 1.0 / 60;      // pictures are not shown faster
inline constexpr double picture_s_max = 1.0 / 20;  // s; a longer frame counts as this: no unbounded backlog of ticks

/// Picture times at a constant distance. A late picture does not delay the next ones; a delay of more than
/// picture_s_max is dropped.
class Pacer {
 public:
  using Clock = std::chrono::steady_clock;

  /// Until when to wait before the next picture: in the past if it is late already. Called once a picture.
  Clock::time_point next(Clock::time_point now) {
    if (!began_) due_ = now - length(picture_s);
    began_ = true;
    const Clock::time_point before = due_;
    due_ = std::max(due_ + length(picture_s), now - length(picture_s_max));
    passed_s_ = std::min(std::chrono::duration<double>(due_ - before).count(), picture_s_max);
    return due_;
  }
  /// From the moment before to the last one: what passes in the world, evenly where single pictures are not.
  double passed_s() const { return passed_s_; }

 private:
  static constexpr Clock::duration length(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

  bool began_ = false;
  double passed_s_ = 0;
  Clock::time_point due_;
};

}  // namespace ticktrue::play
