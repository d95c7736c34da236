// Anti-aliased convex areas, circles, lines and masks: coverage from the distance of a pixel's centre to the outline.
// SPDX-License-Identifier: MIT
#include "tool/play/picture/canvas.h"

#include <algorithm>
#include <cmath>

#include "base/assert.h"

namespace ticktrue::play {
namespace {

constexpr std::uint32_t opaque = 0xff000000u;

std::uint32_t packed(Color color) {
  return opaque | static_cast<std::uint32_t>(color.red) << 16 | static_cast<std::uint32_t>(color.green) << 8 |
         color.blue;
}

/// A part of [0, end) as whole numbers, wherever the limits are.
int clamped(double value, int end) {
  if (!(value > 0)) return 0;
  return value < end ? static_cast<int>(value) : end;
}

std::uint8_t mixed(std::uint8_t a, std::uint8_t b, double share) {
  return static_cast<std::uint8_t>(a + (b - a) * share + 0.5);
}

/// What a pixel gets whose centre is `distance` px outside (negative: inside) of the outline.
Color shaded(const Paint& paint, double distance) {
  if (paint.edge_px <= 0) return paint.fill;
  const double share = std::clamp(distance + paint.edge_px + 0.5, 0.0, 1.0);
  return {mixed(paint.fill.red, paint.edge.red, share), mixed(paint.fill.green, paint.edge.green, share),
          mixed(paint.fill.blue, paint.edge.blue, share), mixed(paint.fill.alpha, paint.edge.alpha, share)};
}

double covered(double distance) {
  return std::clamp(0.5 - distance, 0.0, 1.0);
}

/// Pixels [begin, end) of a row whose centres lie between two places.
struct PixelSpan {
  int begin = 0;
  int end = 0;
};
PixelSpan span_between(double lower, double upper, int width) {
  PixelSpan scanline{clamped(std::ceil(lower - 0.5), width), clamped(std::floor(upper - 0.5) + 1, width)};
  if (scanline.end < scanline.begin) scanline.end = scanline.begin;
  return scanline;
}

}  // namespace

void Canvas::resize(int width, int height) {
  TICKTRUE_ASSERT(width > 0 && height > 0);
  width_ = width;
  height_ = height;
  pixels_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), opaque);
}

Color Canvas::at(int x, int y) const {
  const std::uint32_t pixel =
      pixels_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
  return {static_cast<std::uint8_t>(pixel >> 16), static_cast<std::uint8_t>(pixel >> 8),
          static_cast<std::uint8_t>(pixel), 255};
}

void Canvas::clear(Color color) {
  std::fill(pixels_.begin(), pixels_.end(), packed(color));
}

void Canvas::blend(std::uint32_t& pixel, Color color, double coverage) const {
  const auto share = static_cast<std::uint32_t>(coverage * color.alpha * (256.0 / 255.0) + 0.5);  // 0..256
  if (share == 0) return;
  const auto channel = [share, pixel](int shift, std::uint32_t to) {
    const std::uint32_t from = (pixel >> shift) & 0xffu;
    return ((from * (256 - share) + to * share) >> 8) << shift;
  };
  pixel = opaque | channel(16, color.red) | channel(8, color.green) | channel(0, color.blue);
}

void Canvas::span(int y, int begin, int end, Color color) {
  std::uint32_t* scanline = pixels_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  if (color.alpha == 255) {
    std::fill(scanline + begin, scanline + end, packed(color));
    return;
  }
  for (int x = begin; x < end; ++x) blend(scanline[x], color, 1);
}

void Canvas::convex(std::span<const Pixel> corners, const Paint& paint) {
  double area = 0, top = 1e300, bottom = -1e300;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Pixel& a = corners[i];
    const Pixel& b = corners[(i + 1) % corners.size()];
    if (!std::isfinite(a.x) || !std::isfinite(a.y)) return;
    area += a.x * b.y - a.y * b.x;
    top = std::min(top, a.y);
    bottom = std::max(bottom, a.y);
  }
  const double turn = area < 0 ? -1 : 1;
  edges_.clear();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Pixel& a = corners[i];
    const Pixel& b = corners[(i + 1) % corners.size()];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    if (length < 1e-6) continue;
    const double nx = turn * (b.y - a.y) / length;
    const double ny = turn * (a.x - b.x) / length;
    edges_.push_back({nx, ny, -(nx * a.x + ny * a.y)});
  }
  if (edges_.size() < 2) return;

  const PixelSpan rows = span_between(top - 0.5, bottom + 0.5, height_);
  const Color inside = shaded(paint, -1e9);
  for (int y = rows.begin; y < rows.end; ++y) {
    double low = -1e300, high = 1e300;                // where coverage begins
    double low_inside = -1e300, high_inside = 1e300;  // where it is whole, and the border has ended
    const double reach = 0.5 + paint.edge_px;
    for (const Edge& edge : edges_) {
      const double at_row = edge.b * (y + 0.5) + edge.c;
      if (edge.a > 1e-12) {
        high = std::min(high, (0.5 - at_row) / edge.a);
        high_inside = std::min(high_inside, (-reach - at_row) / edge.a);
      } else if (edge.a < -1e-12) {
        low = std::max(low, (0.5 - at_row) / edge.a);
        low_inside = std::max(low_inside, (-reach - at_row) / edge.a);
      } else {
        if (at_row > 0.5) high = -1e300;
        if (at_row > -reach) high_inside = -1e300;
      }
    }
    if (!(low < high)) continue;
    const PixelSpan outer = span_between(low, high, width_);
    PixelSpan inner =
        low_inside < high_inside ? span_between(low_inside, high_inside, width_) : PixelSpan{outer.end, outer.end};
    if (inner.begin >= inner.end) inner = {outer.end, outer.end};
    std::uint32_t* scanline = pixels_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    const auto soft = [&](int begin, int end) {
      for (int x = begin; x < end; ++x) {
        double distance = -1e300;
        for (const Edge& edge : edges_) distance = std::max(distance, edge.a * (x + 0.5) + edge.b * (y + 0.5) + edge.c);
        blend(scanline[x], shaded(paint, distance), covered(distance));
      }
    };
    soft(outer.begin, std::min(inner.begin, outer.end));
    span(y, inner.begin, inner.end, inside);
    soft(std::max(inner.end, outer.begin), outer.end);
  }
}

void Canvas::circle(Pixel center, double radius, const Paint& paint) {
  if (!std::isfinite(center.x) || !std::isfinite(center.y) || !std::isfinite(radius)) return;
  const PixelSpan rows = span_between(center.y - radius - 0.5, center.y + radius + 0.5, height_);
  const Color inside = shaded(paint, -1e9);
  for (int y = rows.begin; y < rows.end; ++y) {
    const double dy = y + 0.5 - center.y;
    const double outside = radius + 0.5;
    if (dy * dy >= outside * outside) continue;
    const double half = std::sqrt(outside * outside - dy * dy);
    const PixelSpan outer = span_between(center.x - half, center.x + half, width_);
    const double whole = radius - 0.5 - paint.edge_px;
    PixelSpan inner{outer.end, outer.end};
    if (whole > 0 && dy * dy < whole * whole) {
      const double half_inside = std::sqrt(whole * whole - dy * dy);
      const PixelSpan found = span_between(center.x - half_inside, center.x + half_inside, width_);
      if (found.begin < found.end) inner = found;
    }
    std::uint32_t* scanline = pixels_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
    const auto soft = [&](int begin, int end) {
      for (int x = begin; x < end; ++x) {
        const double dx = x + 0.5 - center.x;
        const double distance = std::sqrt(dx * dx + dy * dy) - radius;
        blend(scanline[x], shaded(paint, distance), covered(distance));
      }
    };
    soft(outer.begin, std::min(inner.begin, outer.end));
    span(y, inner.begin, inner.end, inside);
    soft(std::max(inner.end, outer.begin), outer.end);
  }
}

void Canvas::rectangle(Pixel lower, Pixel upper, const Paint& paint) {
  const Pixel corners[] = {lower, {upper.x, lower.y}, upper, {lower.x, upper.y}};
  convex(corners, paint);
}

void Canvas::line(Pixel a, Pixel b, double width_px, Color color) {
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  if (!(length > 1e-6)) return;
  const double x = (a.y - b.y) / length * width_px / 2;
  const double y = (b.x - a.x) / length * width_px / 2;
  const Pixel corners[] = {{a.x + x, a.y + y}, {b.x + x, b.y + y}, {b.x - x, b.y - y}, {a.x - x, a.y - y}};
  convex(corners, {color, {}, 0});
}

void Canvas::ring(Pixel center, double radius, double width_px, Color color) {
  circle(center, radius + width_px / 2, {with_alpha(color, 0), color, width_px});
}

void Canvas::mask(const Mask& mask, int x, int y, Color color) {
  for (int scanline = std::max(0, -y); scanline < mask.height && y + scanline < height_; ++scanline)
    for (int column = std::max(0, -x); column < mask.width && x + column < width_; ++column) {
      const std::uint8_t coverage =
          mask.coverage[static_cast<std::size_t>(scanline) * static_cast<std::size_t>(mask.width) +
                        static_cast<std::size_t>(column)];
      if (coverage == 0) continue;
      blend(pixels_[static_cast<std::size_t>(y + scanline) * static_cast<std::size_t>(width_) +
                    static_cast<std::size_t>(x + column)],
            color, coverage / 255.0);
    }
}

}  // namespace ticktrue::play
