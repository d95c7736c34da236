// A picture in memory, with anti-aliased shapes drawn on it: the same pixels on every machine.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace ticktrue::play {

struct Color {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
  std::uint8_t alpha = 255;
  bool operator==(const Color&) const = default;
};
constexpr Color with_alpha(Color color, std::uint8_t alpha) {
  return {color.red, color.green, color.blue, alpha};
}

/// A place in the picture, px; (0, 0) is the upper left corner of the upper left pixel, y grows downwards.
struct Pixel {
  double x = 0;
  double y = 0;
};

/// Coverage of a small picture of one colour, 0..255, row by row.
struct Mask {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> coverage;
};

/// How an area is painted: its inside, and a border of `edge_px` along the inside of its outline.
struct Paint {
  Color fill;
  Color edge;
  double edge_px = 0;
};

class Canvas {
 public:
  Canvas(int width, int height) { resize(width, height); }
  /// Requires: both positive. What was drawn is lost.
  void resize(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }
  /// 0xffRRGGBB, row by row from the top.
  const std::vector<std::uint32_t>& pixels() const { return pixels_; }
  Color at(int x, int y) const;

  void clear(Color color);
  /// The corners of a convex area, in order. Shapes with a coordinate that is not finite are not drawn.
  void convex(std::span<const Pixel> corners, const Paint& paint);
  void circle(Pixel center, double radius, const Paint& paint);
  void rectangle(Pixel lower, Pixel upper, const Paint& paint);
  void line(Pixel a, Pixel b, double width_px, Color color);
  /// A circle's outline, half of `width_px` on each side of the radius.
  void ring(Pixel center, double radius, double width_px, Color color);
  void mask(const Mask& mask, int x, int y, Color color);

 private:
  void blend(std::uint32_t& pixel, Color color, double coverage) const;
  void span(int y, int begin, int end, Color color);

  int width_ = 0;
  int height_ = 0;
  std::vector<std::uint32_t> pixels_;
  // Work space of convex(): a x + b y + c is the distance outside of an edge.
  struct Edge {
    double a, b, c;
  };
  std::vector<Edge> edges_;
};

}  // namespace ticktrue::play
