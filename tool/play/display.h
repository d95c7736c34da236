// The display of both modes: canvas, window, frame times, and the files written from the last picture.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "engine/engine.h"
#include "tool/output/json_output.h"
#include "tool/play/picture/canvas.h"
#include "tool/play/picture/panel.h"
#include "tool/play/picture/view.h"
#include "tool/play/picture/world_picture.h"
#include "tool/play/play.h"
#include "tool/play/script.h"
#include "tool/play/window/host.h"
#include "tool/play/window/pacing.h"
#include "tool/session/session.h"

namespace ticktrue::play {

class Display {
 public:
  /// Opens the window, if there is one, and reads the script. Errors: usage, io, invalid_input.
  static Result<std::unique_ptr<Display>> open(const cli::PlayOptions& options);

  /// The canvas, of the size of the view, to draw on.
  Canvas& begin_picture(const View& view);
  /// Shows the picture; returns the events since the last call. Ctrl-C counts as closing the window. Errors: io.
  Result<HostFrame> show();
  /// Whether the time budget of the frame is used up. Always false without a window.
  bool is_late() const;

  void set_title(const std::string& title) { host_->set_title(title); }
  const Fonts& fonts() const { return fonts_; }

  /// Writes the files that were asked for. Errors: io.
  Status write_files(const engine::Engine& engine, const WorldPicture& picture, const View& view);

  /// Frames shown, per second from the first to the last; how long one takes to simulate, draw and show.
  cli::Json frames_json() const;
  std::string frames_text() const;
  /// The same for about the last second, shown in the picture; empty without a window.
  std::string pace_text() const;

 private:
  Display(const cli::PlayOptions& options, std::unique_ptr<Host> host, std::vector<Event> script);
  using Clock = Pacer::Clock;
  double frames_per_second() const;

  const cli::PlayOptions& options_;
  std::unique_ptr<Host> host_;
  ScriptedHost scripted_;
  Canvas canvas_;
  Fonts fonts_;
  Clock::time_point first_ = Clock::now();  // when the first frame began
  Clock::time_point last_ = Clock::now();   // when the last one did: from here on it is simulated and drawn
  tool::TickTimes work_;
  tool::TickTimes shown_;
  double recent_frame_s_ = 0;
  double recent_work_s_ = 0;
};

/// The layers whose keys are in `keys`. Errors: usage.
Result<LayerSet> parse_layers(const std::string& keys);

/// The two modes. They return the exit code.
int play_in_scene(const cli::PlayOptions& options);
int play_trace_file(const cli::PlayOptions& options);

}  // namespace ticktrue::play
