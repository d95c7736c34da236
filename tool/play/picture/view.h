// Which part of the world the picture shows.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>

#include "engine/scene/scene.h"
#include "tool/drawing/svg.h"
#include "tool/play/picture/canvas.h"

namespace ticktrue::play {

/// For a notch of the wheel.
inline constexpr double zoom_step = 1.1;

struct View {
  engine::Point center;  // m, in the middle of the picture
  double scale = 20;     // px per m
  int width = 1;         // px
  int height = 1;        // px

  Pixel to_pixel(const engine::Point& point) const {
    return {width / 2.0 + (point.x - center.x) * scale, height / 2.0 - (point.y - center.y) * scale};
  }
  engine::Point to_world(const Pixel& pixel) const {
    return {center.x + (pixel.x - width / 2.0) / scale, center.y - (pixel.y - height / 2.0) / scale};
  }
  /// Everything of the box, as large as fits.
  void fit(const tool::WorldBox& box) {
    center = {(box.lower_x + box.upper_x) / 2, (box.lower_y + box.upper_y) / 2};
    scale = std::min(width / std::max(box.width(), 1e-3), height / std::max(box.height(), 1e-3));
    limit();
  }
  void pan(double dx_px, double dy_px) {
    center.x -= dx_px / scale;
    center.y += dy_px / scale;
  }
  /// What is under the pixel stays there.
  void zoom(const Pixel& at, double factor) {
    const engine::Point before = to_world(at);
    scale *= factor;
    limit();
    const engine::Point after = to_world(at);
    center.x += before.x - after.x;
    center.y += before.y - after.y;
  }

 private:
  void limit() { scale = std::clamp(scale, 1e-4, 1e5); }
};

/// What a scene shows at first: the window it names for its pointer, else its bodies at the start.
View first_view(const engine::Engine& engine, int width, int height);

}  // namespace ticktrue::play
