// The host of a session: shows pictures and returns events; a window, or no display.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/play/picture/canvas.h"

namespace ticktrue::play {

enum class EventKind : std::uint8_t { press, release, move, wheel, key, resize, quit };
enum class Button : std::uint8_t { left, middle, right };

/// An event of a person. The comment of a field lists the events that use it.
struct Event {
  EventKind kind = EventKind::quit;
  double at_s = 0;               // since the frame began
  Button button = Button::left;  // press, release
  double x = 0;                  // px; press, release, move, wheel; resize: width
  double y = 0;                  // px; likewise; resize: height
  double steps = 0;              // wheel: > 0 away from the person
  bool ctrl = false;             // press
  std::string key;  // key: "a", "1", ".", "space", "escape", "left", "right", "up", "down", "home", "end", "page up",
                    // "page down"; others as the window system calls them
};

/// The time between two pictures, and its events.
struct HostFrame {
  double seconds = 0;
  double show_s = 0;          // that showing the picture took, without waiting for the moment of the next one
  std::vector<Event> events;  // by at_s
};

class Host {
 public:
  virtual ~Host() = default;
  /// Shows the picture; returns the events since the previous picture. Errors: io.
  virtual Result<HostFrame> next(const Canvas& picture) = 0;
  virtual void set_title(const std::string& title) = 0;
};

/// Frames of 1 / hz s without a display, as fast as they can be drawn.
std::unique_ptr<Host> no_display(double hz);

struct WindowSize {
  int width = 1280;
  int height = 800;
};
/// A window on the display: 60 pictures a second (tool/play/window/pacing.h).
/// Errors: usage (built without SDL2), io (there is no display).
Result<std::unique_ptr<Host>> open_window(const std::string& title, WindowSize size);

}  // namespace ticktrue::play
