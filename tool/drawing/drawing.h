// The drawable content of a state: an outline for each shape and a pose for each body.
// SPDX-License-Identifier: MIT
//
// Outlines belong to the scene (a body, or a prototype) and are in the body's frame. Poses are read from the columns of
// a state, so that what is drawn and what is hashed are the same bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/state/state_view.h"
#include "engine/scene/scene.h"

namespace ticktrue::verifier {

/// A shape, all kinds in one form: everything within `radius` of the points and of what lies between them.
struct Outline {
  std::vector<engine::Point> points;  // in the body's frame, m. An area: circle 1, capsule 2, else 3 or more,
                                      // counter-clockwise and convex. A line: in order
  double radius = 0;                  // m; 0: sharp corners, or a line without width
  bool is_line = false;               // segment, chain: from point to point, without an inside
  bool is_closed = false;             // of a line: the last point joins the first
  bool is_sensor = false;             // touches nothing
  bool operator==(const Outline&) const = default;
};

/// The shapes and constants of all bodies made from one description.
struct Figure {
  std::string name;  // of the body or prototype; may be empty
  bool is_prototype = false;
  engine::BodyType type = engine::BodyType::dynamic_body;
  engine::Point center;  // centre of mass in the body's frame, m
  double mass = 0;       // kg; 0 for static and kinematic bodies
  double inertia = 0;    // kg m^2 about the centre of mass; 0 for static, kinematic, fixed rotation
  double gravity_scale = 1;
  double extent = 0;  // m: largest distance of a drawn point from the centre of mass
  std::vector<Outline> outlines;
};

/// A body of a state.
struct DrawnBody {
  std::uint32_t id = 0;
  std::uint32_t figure = 0;     // index in Drawing::figures()
  engine::Point center;         // centre of mass, world, m
  double cos = 1;               // of its angle
  double sin = 0;               // of its angle
  engine::Point velocity;       // of the centre of mass, m/s
  double angular_velocity = 0;  // rad/s
  bool is_finite = true;        // false: position or rotation are not, there is nothing to draw
};

/// Reads what can be drawn from states of one scene.
class Drawing {
 public:
  /// `schema`: of an engine made from the scene. Requires: check_scene(scene).
  Drawing(const engine::Scene& scene, const StateSchema& schema);
  Drawing(const Drawing&) = delete;  // points into itself
  Drawing(Drawing&&) noexcept = default;
  Drawing& operator=(Drawing&&) noexcept = default;

  /// One for each body of the scene, then one for each prototype.
  const std::vector<Figure>& figures() const { return figures_; }

  /// The bodies in the order of their rows. Replaces `out`. A row of no known description is left out.
  void read(const StateView& state, std::vector<DrawnBody>& out) const;

  /// Gravity in the state, which inputs may change; m/s^2.
  engine::Point gravity(const StateView& state) const;

  /// What people and reports call it: "crate_7"; spawned bodies: "<prototype>#<id>".
  std::string name(const DrawnBody& body) const;

 private:
  std::vector<Figure> figures_;
  std::optional<std::size_t> bodies_;  // index of the table
  std::optional<std::size_t> world_;
  std::array<const Column*, 6> columns_{};  // id, source, position, rotation, velocity, angular_velocity
  const Column* gravity_ = nullptr;
  std::size_t body_row_size_ = 0;
  StateSchema schema_;  // what the columns above are of
};

/// The outline of a shape. Requires: a valid shape.
Outline outline_of(const engine::Shape& shape);

/// A point of the body's frame in the world, m.
engine::Point to_world(const DrawnBody& body, const Figure& figure, const engine::Point& local);

}  // namespace ticktrue::verifier
