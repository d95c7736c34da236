// Progress bar: one line of stderr, rewritten in place.
// SPDX-License-Identifier: MIT
#include "tool/output/progress.h"

#include <unistd.h>
#ifdef __EMSCRIPTEN__
#include <emscripten.h>
#endif
#ifdef _WIN32
#include <windows.h>
#endif

#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "base/plain_text.h"

namespace ticktrue::cli {
namespace {

constexpr auto first_draw_after = std::chrono::seconds(1);
constexpr auto draw_interval = std::chrono::milliseconds(100);
constexpr int bar_width = 24;  // label, bar, figures fit in 80 columns

std::string_view environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string_view{} : std::string_view{value};
}

/// Whether somebody reads standard error as it comes.
#if defined(__EMSCRIPTEN__)
bool is_terminal() {
  // isatty of Emscripten says yes to files and pipes, too.
  return emscripten_run_script_int("typeof process != 'undefined' && process.stderr && process.stderr.isTTY ? 1 : 0") !=
         0;
}
#elif defined(_WIN32)
bool is_terminal() {
  // _isatty says yes to every character device, NUL among them.
  DWORD mode = 0;
  return GetConsoleMode(GetStdHandle(STD_ERROR_HANDLE), &mode) != 0;
}
#else
bool is_terminal() {
  return isatty(STDERR_FILENO) != 0;
}
#endif

std::string elapsed_text(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  char text[32];
  if (whole >= 3600)
    std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
  return text;
}

}  // namespace

Progress::Progress(std::string label, std::uint64_t total, std::string unit)
    : label_(plain_line(label)), total_(total), unit_(std::move(unit)), start_(Clock::now()) {
  const std::string_view setting = environment("TICKTRUE_PROGRESS");
  enabled_ = setting == "always" || (setting != "never" && is_terminal() && environment("TERM") != "dumb");
  colored_ = environment("NO_COLOR").empty();
  next_draw_ = setting == "always" || setting == "at_once" ? start_ : start_ + first_draw_after;
}

Progress::~Progress() {
  finish();
}

void Progress::update(std::uint64_t done) {
  if (!enabled_) return;
  const Clock::time_point now = Clock::now();
  if (now < next_draw_) return;
  next_draw_ = now + draw_interval;
  draw(now, done);
}

void Progress::draw(Clock::time_point now, std::uint64_t done) {
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed > 0 ? static_cast<double>(done) / elapsed : 0;
  std::string line = "\r\x1b[K";  // not a colour: clears what stood there
  line += label_;
  char text[128];
  if (total_ > 0) {
    const double share = done >= total_ ? 1.0 : static_cast<double>(done) / static_cast<double>(total_);
    const int filled = static_cast<int>(share * bar_width);
    line += " ";
    if (colored_) line += "\x1b[32m";
    for (int i = 0; i < bar_width; ++i) line += i < filled ? '#' : '.';
    if (colored_) line += "\x1b[0m";
    std::snprintf(text, sizeof text, " %3.0f %%  %.0f %s/s", share * 100, rate, unit_.c_str());
    line += text;
    if (rate > 0 && done < total_) line += "  " + elapsed_text(static_cast<double>(total_ - done) / rate) + " left";
  } else {
    std::snprintf(text, sizeof text, " %llu %s  %.0f %s/s", static_cast<unsigned long long>(done), unit_.c_str(), rate,
                  unit_.c_str());
    line += text;
  }
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::finish() {
  if (drawn_) {
    std::fputs("\r\x1b[K", stderr);
    std::fflush(stderr);
  }
  drawn_ = false;
  enabled_ = false;
}

}  // namespace ticktrue::cli
