// Draws states as SVG.
// SPDX-License-Identifier: MIT
#include "tool/drawing/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "base/plain_text.h"
#include "engine/math/trig.h"
#include "engine/scene/hull.h"

namespace ticktrue::tool {
namespace {

using engine::BodyReport;
using engine::BodyType;
using engine::Point;
using engine::Shape;
using engine::ShapeKind;

constexpr double picture_width_px = 960;
constexpr double far_view_m = 100;
constexpr double degrees_per_radian = 180 / engine::pi;

// The colours are mid tones, with a contrast of at least 3:1 against white and against black.
constexpr std::string_view style =
    "<style>"
    "path,circle{stroke-linejoin:round}"
    ".static{fill:#808080;fill-opacity:.35;stroke:#808080}"
    ".kinematic{fill:#a86fc0;fill-opacity:.4;stroke:#a86fc0}"
    ".dynamic{fill:#3f8fd0;fill-opacity:.35;stroke:#3f8fd0}"
    ".mark{fill:none}"
    ".sensor{fill-opacity:.08}"
    ".contact{fill:#d9603b;stroke:none}"
    ".normal{stroke:#d9603b;fill:none}"
    "text{fill:#808080;font:14px sans-serif}"
    "</style>";

bool is_finite(const BodyReport& body) {
  return std::isfinite(body.origin.x) && std::isfinite(body.origin.y) && std::isfinite(body.angle);
}

Point to_world(const BodyReport& body, const Point& local) {
  const engine::SinCos turn = engine::pose_sin_cos(body.angle);
  return {body.origin.x + turn.cos * local.x - turn.sin * local.y,
          body.origin.y + turn.sin * local.x + turn.cos * local.y};
}

/// Corners of a box or polygon in the body's frame.
std::vector<Point> corners_of(const Shape& shape) {
  if (shape.kind == ShapeKind::polygon) return shape.vertices;
  std::vector<Point> corners;
  const engine::SinCos turn = engine::pose_sin_cos(shape.angle);
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const double dx = x * shape.half_size.x;
    const double dy = y * shape.half_size.y;
    corners.push_back({shape.center.x + turn.cos * dx - turn.sin * dy, shape.center.y + turn.sin * dx + turn.cos * dy});
  }
  return corners;
}

/// Sorts corners, which may come in any order, by angle around their mean. The result is right for a convex outline.
std::vector<Point> ordered(std::vector<Point> corners) {
  Point mean;
  for (const Point& corner : corners) {
    mean.x += corner.x / static_cast<double>(corners.size());
    mean.y += corner.y / static_cast<double>(corners.size());
  }
  std::sort(corners.begin(), corners.end(), [mean](const Point& a, const Point& b) {
    return engine::arc_tangent(a.y - mean.y, a.x - mean.x) < engine::arc_tangent(b.y - mean.y, b.x - mean.x);
  });
  return corners;
}

std::string_view class_of(BodyType type) {
  return engine::info_of(engine::body_types, type).name;
}

std::string svg_text(std::string_view text) {
  std::string escaped;
  for (const char letter : plain_line(text)) {
    if (letter == '&')
      escaped += "&amp;";
    else if (letter == '<')
      escaped += "&lt;";
    else if (letter == '>')
      escaped += "&gt;";
    else
      escaped += letter;
  }
  return escaped;
}

Point beyond(const Point& corner, const Point& from, const Point& to, double radius) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  return {corner.x + radius * (to.y - from.y) / length, corner.y - radius * (to.x - from.x) / length};
}

/// Draws the outline of all places within the radius of a hull: straight edges, and an arc at each vertex.
void draw_rounded(const Shape& shape, std::back_insert_iterator<std::string> out) {
  const std::vector<Point> core = engine::core_of(shape);
  const std::size_t count = core.size();
  const Point start = beyond(core[0], core[0], core[1], shape.radius);
  fmt::format_to(out, "<path d=\"M{:.6g} {:.6g}", start.x, start.y);
  for (std::size_t i = 0; i < count; ++i) {
    const Point &a = core[i], &b = core[(i + 1) % count], &c = core[(i + 2) % count];
    const Point end = beyond(b, a, b, shape.radius), next = beyond(b, b, c, shape.radius);
    fmt::format_to(out, "L{:.6g} {:.6g}A{:.6g} {:.6g} 0 0 1 {:.6g} {:.6g}", end.x, end.y, shape.radius, shape.radius,
                   next.x, next.y);
  }
  fmt::format_to(out, "Z\"/>");
}

void draw_line(const Shape& shape, std::back_insert_iterator<std::string> out) {
  const char* command = "M";
  fmt::format_to(out, "<path class=\"mark\" d=\"");
  for (const Point& point : shape.vertices) {
    fmt::format_to(out, "{}{:.6g} {:.6g}", command, point.x, point.y);
    command = "L";
  }
  fmt::format_to(out, "{}\"/>", shape.loop ? "Z" : "");
}

void draw_shape(const Shape& shape, std::back_insert_iterator<std::string> out) {
  if (engine::is_line(shape.kind)) return draw_line(shape, out);
  if (shape.kind != ShapeKind::circle && shape.radius > 0) return draw_rounded(shape, out);
  if (shape.kind == ShapeKind::circle) {
    // The drawn radius makes the rotation visible.
    fmt::format_to(out, "<circle cx=\"{:.6g}\" cy=\"{:.6g}\" r=\"{:.6g}\"/>", shape.center.x, shape.center.y,
                   shape.radius);
    fmt::format_to(out, "<path class=\"mark\" d=\"M{:.6g} {:.6g}h{:.6g}\"/>", shape.center.x, shape.center.y,
                   shape.radius);
    return;
  }
  const char* command = "M";
  fmt::format_to(out, "<path d=\"");
  for (const Point& corner : ordered(corners_of(shape))) {
    fmt::format_to(out, "{}{:.6g} {:.6g}", command, corner.x, corner.y);
    command = "L";
  }
  fmt::format_to(out, "Z\"/>");
}

void draw_body(const BodyReport& body, std::back_insert_iterator<std::string> out) {
  if (!is_finite(body) || body.shapes == nullptr) return;
  fmt::format_to(out, "<g class=\"{}\" transform=\"translate({:.7g} {:.7g}) rotate({:.6g})\">", class_of(body.type),
                 body.origin.x, body.origin.y, body.angle * degrees_per_radian);
  fmt::format_to(out, "<title>{} (id {})</title>", body.name.empty() ? "body" : svg_text(body.name), body.id);
  for (const Shape& shape : *body.shapes) {
    if (shape.sensor) fmt::format_to(out, "<g class=\"sensor\">");
    draw_shape(shape, out);
    if (shape.sensor) fmt::format_to(out, "</g>");
  }
  fmt::format_to(out, "</g>\n");
}

}  // namespace

void WorldBox::add(double x, double y) {
  if (is_empty) {
    lower_x = upper_x = x;
    lower_y = upper_y = y;
    is_empty = false;
    return;
  }
  lower_x = std::min(lower_x, x);
  lower_y = std::min(lower_y, y);
  upper_x = std::max(upper_x, x);
  upper_y = std::max(upper_y, y);
}

void WorldBox::add(const WorldBox& other) {
  if (other.is_empty) return;
  add(other.lower_x, other.lower_y);
  add(other.upper_x, other.upper_y);
}

WorldBox box_of(const BodyReport& body) {
  WorldBox box;
  if (!is_finite(body) || body.shapes == nullptr) return box;
  for (const Shape& shape : *body.shapes) {
    for (const Point& corner : engine::core_of(shape)) {
      const Point world = to_world(body, corner);
      box.add(world.x - shape.radius, world.y - shape.radius);
      box.add(world.x + shape.radius, world.y + shape.radius);
    }
  }
  return box;
}

WorldBox choose_view(const engine::Engine& start, const WorldBox& visited) {
  WorldBox moving;
  WorldBox fixed;
  for (const BodyReport& body : start.bodies()) (body.type == BodyType::static_body ? fixed : moving).add(box_of(body));

  WorldBox view = moving.is_empty ? visited : moving;
  if (!visited.is_empty && !moving.is_empty) {
    const double extent = std::max(far_view_m, 3 * std::max(moving.width(), moving.height()));
    view.add(std::max(visited.lower_x, moving.lower_x - extent), std::max(visited.lower_y, moving.lower_y - extent));
    view.add(std::min(visited.upper_x, moving.upper_x + extent), std::min(visited.upper_y, moving.upper_y + extent));
  }
  if (view.is_empty) view = fixed;
  if (!fixed.is_empty && !view.is_empty) {
    const double near = std::max({1.0, view.width() / 2, view.height() / 2});
    const WorldBox seen = view;
    view.add(std::clamp(fixed.lower_x, seen.lower_x - near, seen.upper_x),
             std::clamp(fixed.lower_y, seen.lower_y - near, seen.upper_y));
    view.add(std::clamp(fixed.upper_x, seen.lower_x, seen.upper_x + near),
             std::clamp(fixed.upper_y, seen.lower_y, seen.upper_y + near));
  }
  if (view.is_empty) view.add(0, 0);
  const double margin = std::max(0.5, 0.03 * std::max(view.width(), view.height()));
  view.add(view.lower_x - margin, view.lower_y - margin);
  view.add(view.upper_x + margin, view.upper_y + margin);
  return view;
}

std::string svg_picture(const engine::Engine& engine, std::uint64_t tick, const WorldBox& view) {
  std::string text;
  auto out = std::back_inserter(text);
  const double scale = picture_width_px / view.width();  // px per m
  const double height_px = std::min(view.height() * scale, 4 * picture_width_px);
  fmt::format_to(out,
                 "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{:.0f}\" height=\"{:.0f}\" viewBox=\"0 0 {:.6g} "
                 "{:.6g}\">\n",
                 picture_width_px, height_px, picture_width_px, view.height() * scale);
  fmt::format_to(out, "<title>{}, tick {}, {:.3f} s</title>\n{}\n", svg_text(engine.scene().name), tick,
                 engine.time_s(), style);
  // World axes: y up, m.
  fmt::format_to(out, "<g stroke-width=\"{:.4g}\" transform=\"scale({:.7g} {:.7g}) translate({:.7g} {:.7g})\">\n",
                 1.2 / scale, scale, -scale, -view.lower_x, -view.upper_y);
  for (const BodyReport& body : engine.bodies()) draw_body(body, out);
  const double mark = 3 / scale;  // m: 3 px
  const double normal = 16 / scale;
  for (const engine::ContactReport& contact : engine.contacts()) {
    for (int i = 0; i < contact.point_count; ++i) {
      const Point& point = contact.point[i];
      if (!std::isfinite(point.x) || !std::isfinite(point.y)) continue;
      fmt::format_to(out, "<circle class=\"contact\" cx=\"{:.7g}\" cy=\"{:.7g}\" r=\"{:.4g}\"/>", point.x, point.y,
                     mark);
      fmt::format_to(out, "<path class=\"normal\" d=\"M{:.7g} {:.7g}l{:.5g} {:.5g}\"/>\n", point.x, point.y,
                     contact.normal.x * normal, contact.normal.y * normal);
    }
  }
  fmt::format_to(out, "</g>\n<text x=\"8\" y=\"20\">{}  tick {}  {:.3f} s</text>\n</svg>\n",
                 svg_text(engine.scene().name), tick, engine.time_s());
  return text;
}

}  // namespace ticktrue::tool
