// Rounding and prediction.
// SPDX-License-Identifier: MIT
#include "tool/report_page/frame_coding.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/math/trig.h"

namespace ticktrue::tool {
namespace {

constexpr std::int32_t grid_max = 1 << 28;  // further out bodies are drawn at this number
constexpr double prediction_max = 1 << 29;

/// 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
std::uint32_t without_sign(std::int32_t value) {
  return static_cast<std::uint32_t>(value) << 1 ^ (value < 0 ? 0xffffffffu : 0u);
}
/// The predicted next value of a lane. page_base.js computes the same: double arithmetic that is exact except for the
/// division.
class Predictor {
 public:
  std::int32_t next(std::uint64_t tick) const {
    if (count_ == 0) return 0;
    if (count_ == 1) return last_;
    const double ahead = static_cast<double>(tick - last_tick_),
                 behind = static_cast<double>(last_tick_ - before_tick_);
    const double moved = static_cast<double>(last_) - static_cast<double>(before_);
    const double value = static_cast<double>(last_) + std::floor(moved * ahead / behind + 0.5);
    return static_cast<std::int32_t>(std::clamp(value, -prediction_max, prediction_max));
  }
  void process(std::uint64_t tick, std::int32_t value) {
    before_ = last_;
    before_tick_ = last_tick_;
    last_ = value;
    last_tick_ = tick;
    ++count_;
  }

 private:
  std::size_t count_ = 0;
  std::int32_t last_ = 0, before_ = 0;
  std::uint64_t last_tick_ = 0, before_tick_ = 0;
};

constexpr std::array<std::int32_t GridPose::*, 3> grid_lanes{&GridPose::x, &GridPose::y, &GridPose::angle};

std::int32_t round_to_grid(double value) {
  const double rounded = std::floor(value + 0.5);
  return static_cast<std::int32_t>(std::clamp(rounded, -static_cast<double>(grid_max), static_cast<double>(grid_max)));
}

/// The largest power of two that is not above the value, which is positive.
double power_of_two_below(double value) {
  int exponent = 0;
  std::frexp(value, &exponent);
  return std::ldexp(1.0, exponent - 1);
}

}  // namespace

PoseGrid choose_grid(const Animation& animation) {
  double smallest = 0, largest = 0;  // m
  for (const AnimatedBody& body : animation.bodies) {
    const Figure& figure = animation.figures[body.figure];
    if (figure.type == engine::BodyType::static_body || figure.extent <= 0) continue;
    smallest = smallest == 0 ? figure.extent : std::min(smallest, figure.extent);
    largest = std::max(largest, figure.extent);
  }
  if (smallest == 0) smallest = largest = 1;
  double width = 1;
  if (animation.view.size() == 2)
    width = std::max({1e-9, animation.view[1].x - animation.view[0].x, animation.view[1].y - animation.view[0].y});
  constexpr double steps_of_smallest = 512, steps_of_view = 1 << 24;
  PoseGrid grid;
  grid.length = power_of_two_below(std::max(smallest / steps_of_smallest, width / steps_of_view));
  // The far end of the largest body moves by a step of the grid, too.
  const double angle_count = power_of_two_below(2 * engine::pi * largest / grid.length);
  grid.angle_count = static_cast<std::uint32_t>(std::clamp(angle_count, 1024.0, 65536.0));
  return grid;
}

GridPose to_grid(const Pose& pose, const PoseGrid& grid) {
  return {round_to_grid(pose.x / grid.length), round_to_grid(pose.y / grid.length),
          round_to_grid(pose.angle / (2 * engine::pi) * grid.angle_count)};
}

CodedFrames code_frames(const std::vector<Frame>& frames, std::size_t body_count, const PoseGrid& grid) {
  CodedFrames coded;
  coded.presence.resize(body_count);
  std::vector<std::vector<std::pair<std::uint64_t, GridPose>>> poses(body_count);
  for (std::uint32_t f = 0; f < frames.size(); ++f)
    for (const Pose& pose : frames[f].poses) {
      std::vector<BodyFrames>& rows = coded.presence[pose.body];
      if (!rows.empty() && rows.back().first + rows.back().count == f)
        ++rows.back().count;
      else
        rows.push_back({f, 1});
      poses[pose.body].emplace_back(frames[f].ticks_done, to_grid(pose, grid));
    }
  ByteWriter out;
  for (const auto& of_body : poses)
    for (const auto lane : grid_lanes) {
      Predictor predictor;
      for (const auto& [tick, pose] : of_body) {
        out.varint(without_sign(pose.*lane - predictor.next(tick)));
        predictor.process(tick, pose.*lane);
      }
    }
  coded.numbers = out.take();
  return coded;
}

std::string base64(ByteView bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j) group = group << 8 | (j < count ? bytes[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += j <= count ? digits[group >> (18 - 6 * j) & 63u] : '=';
  }
  return text;
}

}  // namespace ticktrue::tool
