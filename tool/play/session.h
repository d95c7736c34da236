// An interactive session, independent of the window: converts events and frame times into inputs and ticks of a
// recording.
// SPDX-License-Identifier: MIT
//
// An event acts in the tick during which it came, not in the frame in which it was seen: under the clock `fixed` the
// same events give the same ticks whatever the frames are. Under the other clocks frames make ticks, and an event acts
// in the first tick after it. What lies under the pointer is decided from the state just before the tick.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/clock/step_control.h"
#include "engine/clock/tick_clock.h"
#include "engine/engine.h"
#include "replay/recorder.h"
#include "tool/drawing/drawing.h"
#include "tool/play/picture/layers.h"
#include "tool/play/picture/view.h"
#include "tool/play/play_scene.h"
#include "tool/play/window/host.h"

namespace ticktrue::play {

/// What the person requested by ending a session.
enum class Request : std::uint8_t { none, quit, restart, scene };

class Session : public replay::InputSource {
 public:
  /// Draws, and waits for the frame that follows. Errors end the recording.
  using NextFrame = std::function<Result<HostFrame>(const Session& session)>;

  /// `engine` is made from `playable.scene`; both must outlive this, and what is in `view` is where it begins.
  Session(engine::Engine& engine, const PlayScene& playable, const View& view, const LayerSet& layers,
          NextFrame next_frame);

  Result<std::optional<TickInput>> next(std::uint64_t tick) override;
  bool repeatable() const override { return false; }

  Request request() const { return request_; }
  int requested_scene() const { return requested_scene_; }  // 1..9, with Request::scene

  const View& view() const { return view_; }
  const LayerSet& layers() const { return layers_; }
  bool is_paused() const { return paused_; }
  bool shows_help() const { return help_; }
  const std::optional<engine::Point>& pull() const { return pull_; }  // where the pointer pulls to, while it holds
  std::uint64_t input_count() const { return input_count_; }

 private:
  enum class Action : std::uint8_t { press, drag, release, spawn };
  /// An event whose tick has not come.
  struct Pending {
    double time_s;  // of the session
    Action action;
    Piece piece;
    bool is_static;
    engine::Point at;
  };

  void take(const HostFrame& frame);
  void handle(const Event& event);
  void handle_press(const Event& event);
  void handle_release(const Event& event);
  void handle_move(const Event& event);
  void handle_key(const std::string& key);
  void add(Action action, Piece piece, const Event& event);
  /// Lets the session's time pass, unless it is paused.
  void pass(double seconds);
  Result<std::optional<double>> next_dt();
  void make_inputs(std::uint64_t tick);
  void make_input(const Pending& pending);
  void add_input(engine::InputKind kind, std::uint16_t prototype, const engine::Point* at);

  engine::Engine& engine_;
  const PlayScene& playable_;
  tool::Drawing drawing_;
  NextFrame next_frame_;
  View view_;
  engine::TickClock clock_;
  std::optional<engine::StepControl> control_;  // of the clock `adaptive`
  double time_s_ = 0;                           // of the session: what went by while it was not paused
  double frame_s_ = 0;                          // passed in the frame at hand
  std::vector<Pending> pending_;                // by time_s
  std::vector<engine::Input> inputs_;           // of the tick at hand
  Bytes bytes_;
  std::vector<tool::DrawnBody> bodies_;
  std::optional<engine::Point> pull_;
  std::uint64_t input_count_ = 0;

  LayerSet layers_;
  bool paused_ = false;
  bool help_ = false;
  Request request_ = Request::none;
  int requested_scene_ = 0;
  bool left_down_ = false;
  std::optional<Pixel> middle_down_;  // where the middle button went down
  bool panning_ = false;
  Pixel pointer_;  // where it was last
};

/// The newest body at a point of the world: index in `bodies`, or bodies.size(). Lines and sensors are not hit.
std::size_t body_at(const tool::Drawing& drawing, const std::vector<tool::DrawnBody>& bodies,
                    const engine::Point& point);

}  // namespace ticktrue::play
