// Lengths of a host's frames.
// SPDX-License-Identifier: MIT
#include "tool/session/host_frames.h"

#include <thread>

#include "engine/json/number_text.h"

namespace ticktrue::tool {
namespace {

constexpr double frame_max_s = 3600;  // s; a longer frame is a wrong unit
constexpr double frame_min_s = 1e-9;

class SteadyFrames : public HostFrames {
 public:
  explicit SteadyFrames(double seconds) : seconds_(seconds) {}
  Result<std::optional<double>> next() override { return std::optional<double>(seconds_); }
  bool repeatable() const override { return true; }

 private:
  double seconds_;
};

class RandomFrames : public HostFrames {
 public:
  RandomFrames(std::uint64_t seed, bool stutters) : random_(seed), stutters_(stutters) {}
  Result<std::optional<double>> next() override {
    const double jitter_s = random_.real(-0.004, 0.004);
    if (stutters_ && random_.below(50) == 0) return std::optional<double>(random_.real(0.05, 0.2));
    return std::optional<double>(1.0 / 60 + jitter_s);
  }
  bool repeatable() const override { return true; }

 private:
  Random random_;
  bool stutters_;
};

/// Waits for the next sixtieth of a second. The length of a frame is the time since the previous frame.
class WallFrames : public HostFrames {
 public:
  Result<std::optional<double>> next() override {
    const Clock::duration interval =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / 60));
    due_ = Clock::now() > due_ + interval ? Clock::now() : due_ + interval;
    std::this_thread::sleep_until(due_);
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return std::optional<double>(seconds < frame_min_s ? frame_min_s : seconds);
  }
  bool repeatable() const override { return false; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
  Clock::time_point due_ = last_;
};

class FileFrames : public HostFrames {
 public:
  explicit FileFrames(LineReader lines) : lines_(std::move(lines)) {}
  Result<std::optional<double>> next() override {
    while (true) {
      const auto line = lines_.next({});
      if (!line) return line.error();
      if (!*line) return std::optional<double>();
      if ((*line)->find_first_not_of(" \t") == std::string_view::npos) continue;
      const std::optional<double> seconds = engine::parse_number(**line);
      if (seconds && *seconds >= frame_min_s && *seconds <= frame_max_s) return seconds;
      const std::string text((*line)->substr(0, 40));
      return Error{ErrorCode::invalid_input,
                   lines_.place() + ": frame time: found \"" + text + "\", expected seconds in " +
                       engine::number_text(frame_min_s) + ".." + engine::number_text(frame_max_s),
                   "one number a line, such as 0.0166"};
    }
  }
  bool repeatable() const override { return lines_.is_file(); }

 private:
  LineReader lines_;
};

}  // namespace

std::unique_ptr<HostFrames> steady_frames(double seconds) {
  return std::make_unique<SteadyFrames>(seconds);
}

Result<std::unique_ptr<HostFrames>> open_host(const std::string& host, std::uint64_t seed) {
  for (const HostInfo& info : hosts) {
    if (info.name != host) continue;
    switch (info.kind) {
      case HostKind::wall:
        return std::unique_ptr<HostFrames>(std::make_unique<WallFrames>());
      case HostKind::steady_30:
        return steady_frames(1.0 / 30);
      case HostKind::steady_60:
        return steady_frames(1.0 / 60);
      case HostKind::steady_144:
        return steady_frames(1.0 / 144);
      case HostKind::jitter_60:
        return std::unique_ptr<HostFrames>(std::make_unique<RandomFrames>(seed, false));
      case HostKind::stutter:
        return std::unique_ptr<HostFrames>(std::make_unique<RandomFrames>(seed, true));
    }
  }
  Result<LineReader> lines = LineReader::open(host);
  if (!lines) {
    std::string names;
    for (const HostInfo& info : hosts) names += (names.empty() ? "" : ", ") + std::string(info.name);
    return Error{lines.error().code, "--host: " + lines.error().message,
                 "give " + names + " or a file of one frame time a line, in seconds"};
  }
  return std::unique_ptr<HostFrames>(std::make_unique<FileFrames>(std::move(*lines)));
}

Status check_host(const std::string& host, std::uint64_t seed) {
  for (const HostInfo& info : hosts)
    if (info.name == host) return {};
  const auto frames = open_host(host, seed);
  if (!frames) return frames.error();
  if (!(*frames)->repeatable())
    return Error{ErrorCode::usage, "--host: found " + host + ", expected a file: each run reads it from its beginning",
                 "write the frame times to a file"};
  for (;;) {
    const auto frame = (*frames)->next();
    if (!frame) return Error{frame.error().code, "--host: " + frame.error().message, frame.error().hint};
    if (!*frame) return {};
  }
}

}  // namespace ticktrue::tool
