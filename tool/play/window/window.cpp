// A window with SDL2: shows pictures and collects events. This file and sdl2_loader.cpp alone include SDL.
// SPDX-License-Identifier: MIT
#include <SDL2/SDL.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <thread>

#include "tool/play/window/host.h"
#include "tool/play/window/pacing.h"

namespace ticktrue::play {
namespace {

using Clock = Pacer::Clock;

class SdlWindow : public Host {
 public:
  explicit SdlWindow(SDL_Window* window) : window_(window) {}
  SdlWindow(const SdlWindow&) = delete;
  SdlWindow& operator=(const SdlWindow&) = delete;
  ~SdlWindow() override {
    SDL_DestroyWindow(window_);
    SDL_Quit();
  }

  Result<HostFrame> next(const Canvas& picture) override {
    const Clock::time_point before = Clock::now();
    if (const Status status = show(picture); !status) return status.error();
    HostFrame frame;
    const Clock::time_point shown = Clock::now();
    frame.show_s = std::chrono::duration<double>(shown - before).count();
    std::this_thread::sleep_until(pacer_.next(shown));
    frame.seconds = pacer_.passed_s();
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
  Pacer pacer_;
  bool ctrl_ = false;
  Pixel pointer_;  // where it was last
};

constexpr const char* no_display_hint = "run it on a desktop, under xvfb-run, or without a window: --headless";

bool is_set(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0';
}

/// Begins with the display that the environment names. Left to itself SDL, where that does not answer, goes on to
/// drivers that draw where nobody sees it, and says nothing. Errors: io.
Status start_video() {
#if defined(__unix__) && !defined(__APPLE__)
  if (!is_set("SDL_VIDEODRIVER")) {
    if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY"))
      return Error{ErrorCode::io, "window: there is no display: found neither DISPLAY nor WAYLAND_DISPLAY",
                   no_display_hint};
    std::string why;
    for (const auto& [variable, driver] : {std::pair{"DISPLAY", "x11"}, std::pair{"WAYLAND_DISPLAY", "wayland"}}) {
      if (!is_set(variable)) continue;
      SDL_setenv("SDL_VIDEODRIVER", driver, 1);
      if (SDL_Init(SDL_INIT_VIDEO) == 0) return {};
      why += (why.empty() ? "" : "; ") + std::string(variable) + "=" + std::getenv(variable) + ": " + SDL_GetError();
    }
    return Error{ErrorCode::io, "window: no display answers: " + why, no_display_hint};
  }
#endif
  if (SDL_Init(SDL_INIT_VIDEO) == 0) return {};
  return Error{ErrorCode::io, std::string("window: cannot open one: ") + SDL_GetError(), no_display_hint};
}

}  // namespace

Result<std::unique_ptr<Host>> open_window(const std::string& title, WindowSize size) {
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");        // Ctrl-C is the tool's
  SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0");  // the pictures are made in memory: no detour by a renderer
  SDL_SetHint(SDL_HINT_RENDER_VSYNC, "0");              // and where SDL takes it all the same, it does not wait, too
  SDL_SetHint(SDL_HINT_MOUSE_FOCUS_CLICKTHROUGH, "1");  // the click that wakes the window counts
  if (const Status started = start_video(); !started) return started.error();
  SDL_Window* window = SDL_CreateWindow(title.c_str(), SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, size.width,
                                        size.height, SDL_WINDOW_RESIZABLE);
  if (window == nullptr) {
    const Error failed{ErrorCode::io, std::string("window: cannot open one: ") + SDL_GetError(), no_display_hint};
    SDL_Quit();
    return failed;
  }
  return std::unique_ptr<Host>(std::make_unique<SdlWindow>(window));
}

}  // namespace ticktrue::play
