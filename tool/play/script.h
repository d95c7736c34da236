// Scripted events of a session, for tests and pictures.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "tool/play/window/host.h"

namespace ticktrue::play {

/// JSON Lines, times ascending: {"t":0.5,"event":"press","button":"left","x":400,"y":300,"ctrl":true}. `event` is
/// press, release, click (both), move, wheel (with `steps`), key (with `key`) or quit; x and y are pixels. In the
/// events given back at_s counts from the start of the session. Errors: invalid_input, with place and line.
Result<std::vector<Event>> parse_script(std::string_view text, const std::string& place);

/// Adds the events of a script to the frames of a host, and ends the session after so many frames.
class ScriptedHost {
 public:
  /// `frame_count` 0: no end. The host must outlive this.
  ScriptedHost(Host& host, std::vector<Event> script, std::uint64_t frame_count)
      : host_(host), script_(std::move(script)), frame_count_(frame_count) {}
  Result<HostFrame> next(const Canvas& picture);
  std::uint64_t frames_done() const { return frames_done_; }
  void set_title(const std::string& title) { host_.set_title(title); }

 private:
  Host& host_;
  std::vector<Event> script_;
  std::size_t next_event_ = 0;
  std::uint64_t frame_count_;
  std::uint64_t frames_done_ = 0;
  double time_s_ = 0;  // sum of the frames
};

}  // namespace ticktrue::play
