// The drawable content of a state: an outline for each shape and a pose for each body.
// SPDX-License-Identifier: MIT
//
// Outlines belong to a description in the scene (a body or a prototype) and are in the body's frame. Poses come from
// the columns of a state, so the drawn bytes are the hashed bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/state/state_view.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// A shape of any kind in one form: all places within `radius` of the points and of the area or line between the
/// points.
struct Outline {
  std::vector<engine::Point> points;  // in the body's frame, m. An area: circle 1, capsule 2, else 3 or more,
                                      // counter-clockwise and convex. A line: in order
  double radius = 0;                  // m; 0: sharp corners, or a line without width
  bool is_line = false;               // segment, chain: from point to point, without an inside
  bool is_closed = false;             // of a line: the last point joins the first
  bool is_sensor = false;             // never touches
  bool operator==(const Outline&) const = default;
};

/// The shapes and constants of all bodies from one description.
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
  bool is_finite = true;        // false: position or rotation is not finite, and the body is not drawn
};

/// Reads the drawable content of states of one scene.
class Drawing {
 public:
  /// `schema`: of an engine made from the scene. Requires: check_scene(scene).
  Drawing(const engine::Scene& scene, const StateSchema& schema);
  Drawing(const Drawing&) = delete;  // points into itself
  Drawing(Drawing&&) noexcept = default;
  Drawing& operator=(Drawing&&) noexcept = default;

  /// The figures of the scene's bodies, then those of the prototypes.
  const std::vector<Figure>& figures() const { return figures_; }

  /// The bodies in the order of their state rows. Replaces `out`. Omits a state row without a known description.
  void read(const StateView& state, std::vector<DrawnBody>& out) const;

  /// Gravity of the state, m/s^2; inputs may change it.
  engine::Point gravity(const StateView& state) const;

  /// The name of a body for people and reports: "crate_7". A spawned body is "<prototype>#<id>".
  std::string name(const DrawnBody& body) const;

 private:
  std::vector<Figure> figures_;
  std::optional<std::size_t> bodies_;  // index of the table
  std::optional<std::size_t> world_;
  std::array<const Column*, 6> columns_{};  // id, source, position, rotation, velocity, angular_velocity
  const Column* gravity_ = nullptr;
  std::size_t body_row_size_ = 0;
  StateSchema schema_;  // the schema that `columns_` points into
};

/// The outline of a shape. Requires: a valid shape.
Outline outline_of(const engine::Shape& shape);

/// A point of the body's frame in world coordinates, m.
engine::Point to_world(const DrawnBody& body, const Figure& figure, const engine::Point& local);

}  // namespace ticktrue::tool
