// A window by SDL2: shows the pictures and gathers events. The only file that knows SDL.
// SPDX-License-Identifier: MIT
#include <SDL2/SDL.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "play/host.h"

namespace ticktrue::play {
namespace {

constexpr double frame_s = 1.0 / 60;      // pictures are not shown faster
constexpr double frame_s_max = 1.0 / 20;  // a longer frame counts as this: slow motion, not a growing debt of ticks

class SdlWindow : public Host {
 public:
  explicit SdlWindow(SDL_Window* window) : window_(window), frame_begin_(SDL_GetPerformanceCounter()) {}
  SdlWindow(const SdlWindow&) = delete;
  SdlWindow& operator=(const SdlWindow&) = delete;
  ~SdlWindow() override {
    SDL_DestroyWindow(window_);
    SDL_Quit();
  }

  Result<HostFrame> next(const Canvas& picture) override {
    if (const Status shown = show(picture); !shown) return shown.error();
    wait();
    const std::uint64_t now = SDL_GetPerformanceCounter();
    const double seconds = seconds_between(frame_begin_, now);
    frame_begin_ = now;
    HostFrame frame;
    frame.seconds = std::clamp(seconds, 1e-4, frame_s_max);
    const std::uint32_t end_ms = SDL_GetTicks();
    SDL_Event event;
    while (SDL_PollEvent(&event) != 0) {
      // Where in the frame it came; time of the window system is whole milliseconds.
      const double before_end = static_cast<double>(static_cast<std::int32_t>(end_ms - event.common.timestamp)) / 1e3;
      const double earliest = frame.events.empty() ? 0 : frame.events.back().at_s;
      const double at = std::clamp(frame.seconds - before_end, earliest, std::max(earliest, frame.seconds));
      add(event, at, frame.events);
    }
    return frame;
  }

  void set_title(const std::string& title) override { SDL_SetWindowTitle(window_, title.c_str()); }

 private:
  static double seconds_between(std::uint64_t begin, std::uint64_t end) {
    return static_cast<double>(end - begin) / static_cast<double>(SDL_GetPerformanceFrequency());
  }

  /// Until the frame's time is up. By the clock, not from frame to frame: a delay that lasts longer is made up for.
  void wait() {
    const std::uint64_t now = SDL_GetPerformanceCounter();
    const auto length = static_cast<std::uint64_t>(frame_s * static_cast<double>(SDL_GetPerformanceFrequency()));
    due_ = due_ + 2 * length < now ? now : due_ + length;
    if (now < due_) SDL_Delay(static_cast<std::uint32_t>(1e3 * seconds_between(now, due_) + 0.5));
  }

  Status show(const Canvas& picture) {
    SDL_Surface* surface = SDL_GetWindowSurface(window_);
    if (surface == nullptr) return Error{ErrorCode::io, std::string("window: ") + SDL_GetError(), ""};
    if (SDL_MUSTLOCK(surface)) SDL_LockSurface(surface);
    SDL_ConvertPixels(std::min(picture.width(), surface->w), std::min(picture.height(), surface->h),
                      SDL_PIXELFORMAT_RGB888, picture.pixels().data(), picture.width() * 4, surface->format->format,
                      surface->pixels, surface->pitch);
    if (SDL_MUSTLOCK(surface)) SDL_UnlockSurface(surface);
    SDL_UpdateWindowSurface(window_);
    return {};
  }

  /// Keys and pointer are followed from event to event: asked later, SDL would tell of now.
  void add(const SDL_Event& event, double at_s, std::vector<Event>& out) {
    Event found;
    found.at_s = at_s;
    switch (event.type) {
      case SDL_QUIT:
        found.kind = EventKind::quit;
        break;
      case SDL_MOUSEBUTTONDOWN:
      case SDL_MOUSEBUTTONUP:
        if (event.button.button != SDL_BUTTON_LEFT && event.button.button != SDL_BUTTON_MIDDLE &&
            event.button.button != SDL_BUTTON_RIGHT)
          return;
        found.kind = event.type == SDL_MOUSEBUTTONDOWN ? EventKind::press : EventKind::release;
        found.button = event.button.button == SDL_BUTTON_LEFT     ? Button::left
                       : event.button.button == SDL_BUTTON_MIDDLE ? Button::middle
                                                                  : Button::right;
        found.x = event.button.x + 0.5;
        found.y = event.button.y + 0.5;
        found.ctrl = ctrl_;
        break;
      case SDL_MOUSEMOTION:
        found.kind = EventKind::move;
        found.x = pointer_.x = event.motion.x + 0.5;
        found.y = pointer_.y = event.motion.y + 0.5;
        break;
      case SDL_MOUSEWHEEL:
        found.kind = EventKind::wheel;
        found.x = pointer_.x;
        found.y = pointer_.y;
        found.steps = event.wheel.y;
        break;
      case SDL_KEYUP:
        ctrl_ = (event.key.keysym.mod & KMOD_CTRL) != 0;
        return;
      case SDL_KEYDOWN:
        ctrl_ = (event.key.keysym.mod & KMOD_CTRL) != 0;
        found.kind = EventKind::key;
        found.key = key_name(event.key.keysym.sym);
        break;
      case SDL_WINDOWEVENT:
        if (event.window.event != SDL_WINDOWEVENT_SIZE_CHANGED) return;
        found.kind = EventKind::resize;
        found.x = std::max(1, event.window.data1);
        found.y = std::max(1, event.window.data2);
        break;
      default:
        return;
    }
    out.push_back(found);
  }

  static std::string key_name(SDL_Keycode code) {
    if (code == SDLK_PLUS || code == SDLK_KP_PLUS) return "+";
    if (code == SDLK_KP_MINUS) return "-";
    if (code == SDLK_KP_PERIOD) return ".";
    std::string name = SDL_GetKeyName(code);
    for (char& letter : name) letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    return name == "pageup" ? "page up" : name == "pagedown" ? "page down" : name;
  }

  SDL_Window* window_;
  std::uint64_t frame_begin_;
  std::uint64_t due_ = 0;  // when the next picture may be shown
  bool ctrl_ = false;
  Pixel pointer_;  // where it was last
};

constexpr const char* no_display_hint = "run it on a desktop, under xvfb-run, or without a window: --headless";

/// Without a display, SDL draws where nobody sees it and says nothing.
Status check_display() {
#if defined(__unix__) && !defined(__APPLE__)
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"})
    if (const char* value = std::getenv(name); value != nullptr && *value != '\0') return {};
  return Error{ErrorCode::io, "window: there is no display: found neither DISPLAY nor WAYLAND_DISPLAY",
               no_display_hint};
#else
  return {};
#endif
}

}  // namespace

Result<std::unique_ptr<Host>> open_window(const std::string& title, WindowSize size) {
  if (const Status display = check_display(); !display) return display.error();
  const auto refusal = [] {
    return Error{ErrorCode::io, std::string("window: cannot open one: ") + SDL_GetError(), no_display_hint};
  };
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");        // Ctrl-C is the tool's
  SDL_SetHint(SDL_HINT_MOUSE_FOCUS_CLICKTHROUGH, "1");  // the click that wakes the window counts
  if (SDL_Init(SDL_INIT_VIDEO) != 0) return refusal();
  SDL_Window* window = SDL_CreateWindow(title.c_str(), SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, size.width,
                                        size.height, SDL_WINDOW_RESIZABLE);
  if (window == nullptr) {
    const Error failed = refusal();
    SDL_Quit();
    return failed;
  }
  return std::unique_ptr<Host>(std::make_unique<SdlWindow>(window));
}

}  // namespace ticktrue::play
