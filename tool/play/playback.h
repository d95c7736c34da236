// The controls of playback, independent of the window: play, pause, step, seek, view.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "tool/play/picture/layers.h"
#include "tool/play/picture/view.h"
#include "tool/play/player.h"
#include "tool/play/window/host.h"

namespace ticktrue::play {

/// The place of the timeline in the picture.
struct Timeline {
  double left = 0, right = 0, top = 0, bottom = 0;  // px
  static Timeline of(const View& view);
  bool contains(const Pixel& pixel) const;
  /// The x of a position (ticks done), and the position at an x.
  double x_of(std::uint64_t position, std::uint64_t tick_count) const;
  std::uint64_t position_at(double x, std::uint64_t tick_count) const;
};

class Playback {
 public:
  /// `player` must outlive this. `other`: a second trace at the same tick; may be null.
  Playback(Player& player, Player* other, const View& view, const LayerSet& layers);

  /// Takes what happened in a frame, then runs ticks until `is_late` says that it is time for a picture.
  void take(const HostFrame& frame, const std::function<bool()>& is_late);

  bool wants_quit() const { return quit_; }
  bool is_playing() const { return playing_; }
  bool is_seeking() const { return searching_ || player_.position() != target_; }
  bool shows_help() const { return help_; }
  bool shows_ghosts() const { return ghosts_; }
  double speed() const { return speed_; }
  const View& view() const { return view_; }
  const LayerSet& layers() const { return layers_; }

 private:
  void handle(const Event& event);
  void handle_key(const std::string& key);
  void seek(std::uint64_t position);
  void let_time_pass(double seconds);
  std::uint64_t checkpoint_beside(bool later) const;

  Player& player_;
  Player* other_;
  View view_;
  LayerSet layers_;
  bool playing_ = true;
  bool help_ = false;
  bool ghosts_ = true;
  bool quit_ = false;
  double speed_ = 1;
  double due_s_ = 0;          // simulated time that has come and was not played
  std::uint64_t target_ = 0;  // ticks done
  bool searching_ = false;    // for the first difference
  bool on_timeline_ = false;  // the button went down there
  std::optional<Pixel> pan_;  // where the pointer was last, while a button pans
};

}  // namespace ticktrue::play
