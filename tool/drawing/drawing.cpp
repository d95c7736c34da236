// Makes outlines from scenes, and reads poses from columns.
// SPDX-License-Identifier: MIT
#include "tool/drawing/drawing.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/scene/hull.h"

namespace ticktrue::tool {
namespace {

using engine::Point;
using engine::Shape;
using engine::ShapeKind;

double distance(const Point& a, const Point& b) {
  return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
}

Figure figure_of(const engine::Body& body, bool is_prototype) {
  Figure figure;
  figure.name = body.name;
  figure.is_prototype = is_prototype;
  figure.type = body.type;
  const engine::MassProperties mass = engine::body_mass(body);
  figure.center = mass.center;
  figure.mass = mass.mass;
  figure.inertia = mass.inertia;
  figure.gravity_scale = body.gravity_scale;
  for (const Shape& shape : body.shapes) {
    figure.outlines.push_back(outline_of(shape));
    for (const Point& point : figure.outlines.back().points)
      figure.extent = std::max(figure.extent, distance(point, figure.center) + shape.radius);
  }
  return figure;
}

const Column* find_column(const TableSchema& table, std::string_view name, std::uint8_t lane_count) {
  for (const Column& column : table.columns)
    if (column.name == name && column.lane_count == lane_count) return &column;
  return nullptr;
}

template <typename T>
T read_as(const std::uint8_t* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

/// A lane in the machine's byte order. A type that no drawn column has gives 0.
double lane(const std::uint8_t* row, const Column& column, std::size_t index) {
  const std::uint8_t* at = row + column.offset;
  if (column.type == ScalarType::f32) return static_cast<double>(read_as<float>(at + 4 * index));
  if (column.type == ScalarType::f64) return read_as<double>(at + 8 * index);
  if (column.type == ScalarType::u32) return read_as<std::uint32_t>(at + 4 * index);
  return 0;
}

Point point_lanes(const std::uint8_t* row, const Column& column) {
  return {lane(row, column, 0), lane(row, column, 1)};
}

}  // namespace

Outline outline_of(const Shape& shape) {
  Outline outline;
  outline.points = engine::core_of(shape);
  outline.radius = shape.radius;
  outline.is_line = engine::is_line(shape.kind);
  outline.is_closed = outline.is_line && shape.loop;
  outline.is_sensor = shape.sensor;
  return outline;
}

Point to_world(const DrawnBody& body, const Figure& figure, const Point& local) {
  const double x = local.x - figure.center.x, y = local.y - figure.center.y;
  return {body.center.x + body.cos * x - body.sin * y, body.center.y + body.sin * x + body.cos * y};
}

Drawing::Drawing(const engine::Scene& scene, const StateSchema& schema) : schema_(schema) {
  for (const engine::Body& body : scene.bodies) figures_.push_back(figure_of(body, false));
  for (const engine::Body& body : scene.prototypes) figures_.push_back(figure_of(body, true));

  world_ = schema_.find_table("world");
  if (world_) gravity_ = find_column(schema_.tables[*world_], "gravity", 2);
  const std::optional<std::size_t> bodies = schema_.find_table("bodies");
  if (!bodies) return;
  const TableSchema& table = schema_.tables[*bodies];
  columns_ = {find_column(table, "id", 1),       find_column(table, "source", 1),
              find_column(table, "position", 2), find_column(table, "rotation", 2),
              find_column(table, "velocity", 2), find_column(table, "angular_velocity", 1)};
  body_row_size_ = table.row_size;
  if (std::find(columns_.begin(), columns_.end(), nullptr) == columns_.end()) bodies_ = bodies;
}

void Drawing::read(const StateView& state, std::vector<DrawnBody>& out) const {
  out.clear();
  if (!bodies_) return;
  const TableRows& rows = state.tables[*bodies_];
  const auto& [id, source, position, rotation, velocity, angular_velocity] = columns_;
  for (std::uint32_t i = 0; i < rows.row_count; ++i) {
    const std::uint8_t* row = rows.data + i * body_row_size_;
    DrawnBody body;
    body.id = read_as<std::uint32_t>(row + id->offset);
    body.figure = read_as<std::uint32_t>(row + source->offset);
    if (body.figure >= figures_.size()) continue;
    body.center = point_lanes(row, *position);
    const Point turn = point_lanes(row, *rotation);
    body.cos = turn.x;
    body.sin = turn.y;
    body.velocity = point_lanes(row, *velocity);
    body.angular_velocity = lane(row, *angular_velocity, 0);
    body.is_finite = std::isfinite(body.center.x) && std::isfinite(body.center.y) && std::isfinite(body.cos) &&
                     std::isfinite(body.sin);
    out.push_back(body);
  }
}

Point Drawing::gravity(const StateView& state) const {
  if (gravity_ == nullptr || state.tables[*world_].row_count == 0) return {};
  return point_lanes(state.tables[*world_].data, *gravity_);
}

std::string Drawing::name(const DrawnBody& body) const {
  const Figure& figure = figures_[body.figure];
  if (figure.is_prototype) return figure.name + "#" + std::to_string(body.id);
  return figure.name.empty() ? "body#" + std::to_string(body.id) : figure.name;
}

}  // namespace ticktrue::tool
