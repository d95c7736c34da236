// Rounding, prediction and Rice codes.
// SPDX-License-Identifier: MIT
#include "tool/report_page/frame_coding.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/math/trig.h"

namespace ticktrue::verifier {
namespace {

constexpr std::size_t block_length = 32;
constexpr std::uint32_t quotient_max = 24;  // from here on the whole number is written
constexpr std::int32_t grid_max = 1 << 28;  // further out bodies are drawn at this number
constexpr double prediction_max = 1 << 29;

/// Bits one by one, the highest of a byte first.
class BitWriter {
 public:
  void put(std::uint32_t value, unsigned bit_count) {
    for (unsigned i = bit_count; i-- > 0;) {
      if (used_ == 0) bytes_.push_back(0);
      bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | ((value >> i & 1u) << (7 - used_)));
      used_ = (used_ + 1) % 8;
    }
  }
  Bytes take() { return std::move(bytes_); }

 private:
  Bytes bytes_;
  unsigned used_ = 0;  // bits of the last byte
};

class BitReader {
 public:
  explicit BitReader(ByteView bytes) : bytes_(bytes) {}
  std::uint32_t take(unsigned bit_count) {
    std::uint32_t value = 0;
    for (unsigned i = 0; i < bit_count; ++i, ++at_) {
      const std::uint8_t byte = at_ / 8 < bytes_.size() ? bytes_[at_ / 8] : std::uint8_t{0};
      value = value << 1 | (byte >> (7 - at_ % 8) & 1u);
    }
    return value;
  }

 private:
  ByteView bytes_;
  std::size_t at_ = 0;  // bit
};

std::uint32_t without_sign(std::int32_t value) {
  return static_cast<std::uint32_t>(value) << 1 ^ (value < 0 ? 0xffffffffu : 0u);
}
std::int32_t with_sign(std::uint32_t value) {
  return static_cast<std::int32_t>(value >> 1 ^ ((value & 1u) != 0 ? 0xffffffffu : 0u));
}

std::uint64_t rice_size(std::span<const std::uint32_t> block, unsigned k) {
  std::uint64_t size = 0;
  for (const std::uint32_t value : block) {
    const std::uint32_t quotient = value >> k;
    size += quotient < quotient_max ? quotient + 1 + k : quotient_max + 32;
  }
  return size;
}

void put_block(std::span<const std::uint32_t> block, BitWriter& out) {
  if (std::all_of(block.begin(), block.end(), [](std::uint32_t value) { return value == 0; })) {
    out.put(0, 1);
    return;
  }
  unsigned best = 0;
  for (unsigned k = 1; k < 31; ++k)
    if (rice_size(block, k) < rice_size(block, best)) best = k;
  out.put(1, 1);
  out.put(best, 5);
  for (const std::uint32_t value : block) {
    const std::uint32_t quotient = value >> best;
    if (quotient < quotient_max) {
      out.put((1u << quotient) - 1, quotient);
      out.put(0, 1);
      out.put(value & ((1u << best) - 1), best);
    } else {
      out.put((1u << quotient_max) - 1, quotient_max);
      out.put(value, 32);
    }
  }
}

void take_block(BitReader& in, std::span<std::uint32_t> block) {
  std::fill(block.begin(), block.end(), 0u);
  if (in.take(1) == 0) return;
  const unsigned k = in.take(5);
  for (std::uint32_t& value : block) {
    std::uint32_t quotient = 0;
    while (quotient < quotient_max && in.take(1) == 1) ++quotient;
    value = quotient < quotient_max ? quotient << k | in.take(k) : in.take(32);
  }
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
  BitWriter out;
  std::vector<std::uint32_t> rest;
  for (const auto& of_body : poses)
    for (const auto lane : grid_lanes) {
      Predictor predictor;
      rest.clear();
      for (const auto& [tick, pose] : of_body) {
        rest.push_back(without_sign(pose.*lane - predictor.next(tick)));
        predictor.process(tick, pose.*lane);
      }
      for (std::size_t i = 0; i < rest.size(); i += block_length)
        put_block(std::span(rest).subspan(i, std::min(block_length, rest.size() - i)), out);
    }
  coded.bits = out.take();
  return coded;
}

std::vector<std::vector<GridPose>> decode_frames(const CodedFrames& coded, std::span<const std::uint64_t> ticks_done) {
  std::vector<std::vector<GridPose>> poses;
  BitReader in(coded.bits);
  for (const std::vector<BodyFrames>& rows : coded.presence) {
    std::vector<std::uint64_t> ticks;
    for (const BodyFrames& part : rows)
      for (std::uint32_t i = 0; i < part.count; ++i) ticks.push_back(ticks_done[part.first + i]);
    std::vector<GridPose>& of_body = poses.emplace_back(ticks.size());
    std::vector<std::uint32_t> rest(ticks.size());
    for (const auto lane : grid_lanes) {
      Predictor predictor;
      for (std::size_t i = 0; i < rest.size(); i += block_length)
        take_block(in, std::span(rest).subspan(i, std::min(block_length, rest.size() - i)));
      for (std::size_t i = 0; i < ticks.size(); ++i) {
        of_body[i].*lane = predictor.next(ticks[i]) + with_sign(rest[i]);
        predictor.process(ticks[i], of_body[i].*lane);
      }
    }
  }
  return poses;
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

}  // namespace ticktrue::verifier
