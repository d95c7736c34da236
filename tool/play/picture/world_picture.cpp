// Drawing bodies and layers.
// SPDX-License-Identifier: MIT
#include "tool/play/picture/world_picture.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/math/union_find.h"
#include "tool/drawing/joint_geometry.h"
#include "tool/expression/named_table.h"
#include "tool/play/picture/theme.h"

namespace ticktrue::play {
namespace {

using engine::Point;
using tool::DrawnBody;
using tool::Figure;
using tool::NamedTable;
using tool::Outline;

constexpr double two_pi = 6.283185307179586;

Color color_of(const DrawnBody& body, const Figure& figure) {
  switch (figure.type) {
    case engine::BodyType::static_body:
      return theme::fixed_body;
    case engine::BodyType::kinematic_body:
      return theme::kinematic_body;
    case engine::BodyType::dynamic_body:
      return theme::moving_bodies[body.id % theme::moving_bodies.size()];
  }
  return theme::text;
}

/// The corners of a convex, counter-clockwise area pushed out by a radius: a bow at each corner, from the normal of the
/// side that ends there to that of the side that begins.
std::vector<Point> rounded(const std::vector<Point>& points, double radius, double scale) {
  std::vector<Point> corners;
  const std::size_t count = points.size();
  const auto normal_angle = [](const Point& a, const Point& b) { return std::atan2(a.x - b.x, b.y - a.y); };
  for (std::size_t i = 0; i < count; ++i) {
    const Point& here = points[i];
    const double from = normal_angle(points[(i + count - 1) % count], here);
    double to = normal_angle(here, points[(i + 1) % count]);
    if (to < from) to += two_pi;
    const int steps = std::clamp(static_cast<int>((to - from) * std::sqrt(radius * scale) * 1.2) + 1, 1, 24);
    for (int step = 0; step <= steps; ++step) {
      const double angle = from + (to - from) * step / steps;
      corners.push_back({here.x + radius * std::cos(angle), here.y + radius * std::sin(angle)});
    }
  }
  return corners;
}

}  // namespace

WorldPicture::WorldPicture(const engine::Engine& engine)
    : engine_(engine), drawing_(engine.scene(), *engine.state().schema) {}

std::size_t WorldPicture::row_of(std::uint32_t id) const {
  const auto found = std::lower_bound(bodies_.begin(), bodies_.end(), id,
                                      [](const DrawnBody& body, std::uint32_t wanted) { return body.id < wanted; });
  return found != bodies_.end() && found->id == id ? static_cast<std::size_t>(found - bodies_.begin()) : bodies_.size();
}

const DrawnBody* WorldPicture::find(std::uint32_t id) const {
  const std::size_t row = row_of(id);
  return row < bodies_.size() ? &bodies_[row] : nullptr;
}

void WorldPicture::draw_outline(Canvas& canvas, const View& view, const DrawnBody& body, const Figure& figure,
                                const Outline& outline, const Paint& paint, double line_px) {
  std::vector<Point>& points = points_;
  points.clear();
  for (const Point& point : outline.points) points.push_back(tool::to_world(body, figure, point));
  if (!outline.is_line && outline.radius > 0 && points.size() > 1) points = rounded(points, outline.radius, view.scale);
  corners_.clear();
  for (const Point& point : points) corners_.push_back(view.to_pixel(point));
  if (outline.is_line) {
    const std::size_t count = corners_.size();
    for (std::size_t i = 0; i + 1 < count + (outline.is_closed ? 1 : 0); ++i)
      canvas.line(corners_[i], corners_[(i + 1) % count], line_px, paint.edge);
  } else if (corners_.size() == 1) {
    canvas.circle(corners_[0], outline.radius * view.scale, paint);
  } else {
    canvas.convex(corners_, paint);
  }
}

/// A short mark from the middle, so that turning is seen.
void WorldPicture::draw_turn(Canvas& canvas, const View& view, const DrawnBody& body, const Figure& figure,
                             Color color) {
  for (const Outline& outline : figure.outlines) {
    if (outline.points.size() != 1 || outline.is_sensor) continue;
    const Point& center = outline.points[0];
    const Pixel from = view.to_pixel(tool::to_world(body, figure, center));
    const Pixel to = view.to_pixel(tool::to_world(body, figure, {center.x + outline.radius * 0.8, center.y}));
    if (outline.radius * view.scale > 4) canvas.line(from, to, 1.5, color);
  }
}

void WorldPicture::draw_body(Canvas& canvas, const View& view, const DrawnBody& body, const Paint& paint,
                             double line_px) {
  const Figure& figure = used_->figures()[body.figure];
  if (!body.is_finite) return;
  const Pixel middle = view.to_pixel(body.center);
  const double reach = figure.extent * view.scale + 2;
  if (middle.x + reach < 0 || middle.x - reach > canvas.width() || middle.y + reach < 0 ||
      middle.y - reach > canvas.height())
    return;
  for (const Outline& outline : figure.outlines) {
    Paint own = paint;
    if (outline.is_sensor) own.fill = with_alpha(own.edge, 30);
    draw_outline(canvas, view, body, figure, outline, own, line_px);
  }
}

void WorldPicture::find_sleepers() {
  asleep_.assign(bodies_.size(), 0);
  const NamedTable sleep(engine_.state(), "sleep");
  for (std::uint32_t row = 0; row < sleep.row_count(); ++row) {
    const std::size_t body = row_of(sleep.whole(row, "body"));
    if (body < bodies_.size()) asleep_[body] = sleep.whole(row, "asleep") != 0 ? 1 : 0;
  }
}

void WorldPicture::find_islands(const std::vector<engine::ContactReport>& contacts) {
  island_.resize(bodies_.size());
  std::iota(island_.begin(), island_.end(), 0u);
  const auto is_moving = [this](std::size_t row) {
    return row < bodies_.size() && drawing_.figures()[bodies_[row].figure].type == engine::BodyType::dynamic_body;
  };
  const auto meet = [&](std::uint32_t id_a, std::uint32_t id_b) {
    const std::size_t a = row_of(id_a), b = row_of(id_b);
    if (is_moving(a) && is_moving(b))
      engine::unite(island_, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
  };
  for (const engine::ContactReport& contact : contacts) meet(contact.body_a, contact.body_b);
  for (const engine::Joint& joint : engine_.scene().joints) {
    std::vector<std::uint32_t> joined;
    engine::for_each_body(engine_.scene(), joint, [&](std::uint32_t body) { joined.push_back(body); });
    for (const std::uint32_t a : joined)
      for (const std::uint32_t b : joined) meet(a, b);
  }
  for (const engine::Force& force : engine_.scene().forces)
    if (force.body && force.other) meet(*force.body, *force.other);
  for (std::uint32_t row = 0; row < island_.size(); ++row) island_[row] = engine::find_root(island_, row);
}

void WorldPicture::draw(Canvas& canvas, const View& view, const LayerSet& layers) {
  draw_ground(canvas, view);
  drawing_.read(engine_.state(), bodies_);
  find_sleepers();
  std::vector<engine::ContactReport> contacts;
  if (layers.has(Layer::contacts) || layers.has(Layer::normals) || layers.has(Layer::islands))
    contacts = engine_.contacts();
  if (layers.has(Layer::islands)) find_islands(contacts);

  used_ = &drawing_;
  const double edge_px = std::clamp(view.scale * 0.05, 1.0, 2.0);
  for (std::size_t row = 0; row < bodies_.size(); ++row) {
    const DrawnBody& body = bodies_[row];
    const Figure& figure = drawing_.figures()[body.figure];
    const bool moves = figure.type == engine::BodyType::dynamic_body;
    Color color = color_of(body, figure);
    if (moves && layers.has(Layer::islands))
      color = theme::moving_bodies[island_[row] * 7 % theme::moving_bodies.size()];
    const bool dim = moves && asleep_[row] != 0;
    if (dim) color = theme::mix(color, theme::ground, 0.55);
    draw_body(canvas, view, body, {theme::mix(theme::ground, color, moves ? 0.45 : 0.35), color, edge_px},
              std::max(1.5, edge_px));
    if (moves) draw_turn(canvas, view, body, figure, color);
  }
  if (layers.has(Layer::boxes) || layers.has(Layer::pairs)) draw_broad_phase(canvas, view, layers);
  if (layers.has(Layer::joints)) draw_joints(canvas, view);
  if (layers.has(Layer::contacts) || layers.has(Layer::normals)) draw_contacts(canvas, view, layers, contacts);
  draw_pulls(canvas, view);
}

void WorldPicture::draw_contacts(Canvas& canvas, const View& view, const LayerSet& layers,
                                 const std::vector<engine::ContactReport>& contacts) {
  double force_max = 1e-9;
  for (const engine::ContactReport& contact : contacts)
    for (int i = 0; i < contact.point_count; ++i) force_max = std::max(force_max, contact.normal_force[i]);
  for (const engine::ContactReport& contact : contacts)
    for (int i = 0; i < contact.point_count; ++i) {
      const Pixel at = view.to_pixel(contact.point[i]);
      if (layers.has(Layer::normals)) {
        const double length = 8 + 32 * std::sqrt(std::max(0.0, contact.normal_force[i]) / force_max);  // px
        const Pixel end{at.x + contact.normal.x * length, at.y - contact.normal.y * length};
        canvas.line(at, end, 1.5, theme::normal);
      }
      if (layers.has(Layer::contacts))
        canvas.circle(at, 2.5, {contact.separation[i] * view.scale < -1 ? theme::overlap : theme::contact, {}, 0});
    }
}

void WorldPicture::draw_joints(Canvas& canvas, const View& view) {
  const NamedTable table(engine_.state(), "joints");
  const auto mark = [&](const Point& point) { canvas.circle(view.to_pixel(point), 2.5, {theme::joint, {}, 0}); };
  for (std::uint32_t row = 0; row < table.row_count(); ++row) {
    const auto index = std::size_t{table.whole(row, "joint")};
    if (index >= engine_.scene().joints.size()) continue;
    const engine::Joint joint = tool::shown_joint(engine_.scene(), engine_.scene().joints[index]);
    const DrawnBody* b = find(joint.body_b);
    if (b == nullptr) continue;
    const Point anchor_b = tool::to_world(*b, drawing_.figures()[b->figure], joint.anchor_b);
    Point anchor_a = joint.offset;
    if (engine::has_body_a(joint.kind) || engine::joins_joints(joint.kind)) {
      const DrawnBody* a = find(joint.body_a);
      if (a == nullptr) continue;
      anchor_a = tool::to_world(*a, drawing_.figures()[a->figure], joint.anchor_a);
      canvas.line(view.to_pixel(a->center), view.to_pixel(anchor_a), 1.2, with_alpha(theme::joint, 150));
    }
    canvas.line(view.to_pixel(b->center), view.to_pixel(anchor_b), 1.2, with_alpha(theme::joint, 150));
    const tool::JointLines shown = tool::joint_lines(joint, {anchor_a, anchor_b, joint.axis});
    for (std::size_t i = 0; i < shown.count; ++i)
      canvas.line(view.to_pixel(shown.lines[i][0]), view.to_pixel(shown.lines[i][1]), 1.2, theme::joint);
    mark(anchor_a);
    mark(anchor_b);
  }
}

void WorldPicture::draw_broad_phase(Canvas& canvas, const View& view, const LayerSet& layers) {
  const engine::BroadPhaseReport report = engine_.broad_phase();
  const auto middle = [](const engine::BroadPhaseReport::Box& box) {
    return Point{(box.lower.x + box.upper.x) / 2, (box.lower.y + box.upper.y) / 2};
  };
  if (layers.has(Layer::boxes))
    for (const engine::BroadPhaseReport::Box& box : report.boxes) {
      const Pixel a = view.to_pixel(box.lower), b = view.to_pixel(box.upper);
      for (const auto& [from, to] :
           {std::pair<Pixel, Pixel>{a, {b.x, a.y}}, {{b.x, a.y}, b}, {b, {a.x, b.y}}, {{a.x, b.y}, a}})
        canvas.line(from, to, 1, theme::box);
    }
  if (layers.has(Layer::pairs))
    for (const engine::BroadPhaseReport::Pair& pair : report.pairs)
      canvas.line(view.to_pixel(middle(report.boxes[pair.first])), view.to_pixel(middle(report.boxes[pair.second])), 1,
                  theme::pair);
}

void WorldPicture::draw_pulls(Canvas& canvas, const View& view) {
  const NamedTable pointers(engine_.state(), "pointers");
  for (std::uint32_t row = 0; row < pointers.row_count(); ++row) {
    const DrawnBody* body = find(pointers.whole(row, "body"));
    if (body == nullptr) continue;
    const double x = pointers.value(row, "anchor", 0), y = pointers.value(row, "anchor", 1);
    const Pixel from =
        view.to_pixel({body->center.x + body->cos * x - body->sin * y, body->center.y + body->sin * x + body->cos * y});
    const Pixel to = view.to_pixel({pointers.value(row, "target", 0), pointers.value(row, "target", 1)});
    canvas.line(from, to, 1.5, theme::pull);
    canvas.circle(from, 3, {theme::pull, {}, 0});
    canvas.ring(to, 5, 1.5, theme::pull);
  }
}

void WorldPicture::draw_ghosts(Canvas& canvas, const View& view, const tool::Drawing& drawing, const StateView& state) {
  std::vector<DrawnBody> ghosts;
  drawing.read(state, ghosts);
  used_ = &drawing;
  for (const DrawnBody& ghost : ghosts) {
    if (drawing.figures()[ghost.figure].type == engine::BodyType::static_body) continue;
    draw_body(canvas, view, ghost, {with_alpha(theme::ghost, 22), theme::ghost, 1.2}, 1.2);
    const DrawnBody* here = find(ghost.id);
    if (here == nullptr || !here->is_finite || !ghost.is_finite) continue;
    const Pixel a = view.to_pixel(here->center), b = view.to_pixel(ghost.center);
    if (std::hypot(a.x - b.x, a.y - b.y) > 1) canvas.line(a, b, 1, with_alpha(theme::ghost, 170));
  }
}

void WorldPicture::draw_rings(Canvas& canvas, const View& view, const std::vector<std::uint32_t>& ids) {
  for (const std::uint32_t id : ids) {
    const DrawnBody* body = find(id);
    if (body == nullptr || !body->is_finite) continue;
    const double radius = drawing_.figures()[body->figure].extent * view.scale + 7;
    canvas.ring(view.to_pixel(body->center), radius, 5, with_alpha(theme::bad, 70));
    canvas.ring(view.to_pixel(body->center), radius, 2, theme::bad);
  }
}

void draw_ground(Canvas& canvas, const View& view) {
  canvas.clear(theme::ground);
  double step = 1;  // m
  while (step * view.scale < 40) step *= 10;
  while (step * view.scale > 400) step /= 10;
  const Point lower = view.to_world({0, static_cast<double>(canvas.height())});
  const Point upper = view.to_world({static_cast<double>(canvas.width()), 0});
  const auto line = [&](bool upright, double at) {
    const Pixel place = view.to_pixel({at, at});
    const Color color = std::abs(at) < step / 2 ? theme::grid_axis : theme::grid;
    if (upright)
      canvas.rectangle({std::floor(place.x), 0}, {std::floor(place.x) + 1, static_cast<double>(canvas.height())},
                       {color, {}, 0});
    else
      canvas.rectangle({0, std::floor(place.y)}, {static_cast<double>(canvas.width()), std::floor(place.y) + 1},
                       {color, {}, 0});
  };
  if (!((upper.x - lower.x) / step < 1000)) return;
  for (double x = std::ceil(lower.x / step) * step; x <= upper.x; x += step) line(true, x);
  for (double y = std::ceil(lower.y / step) * step; y <= upper.y; y += step) line(false, y);
}

}  // namespace ticktrue::play
