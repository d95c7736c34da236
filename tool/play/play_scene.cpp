// Adding prototypes, input kinds and a pointer to a scene.
// SPDX-License-Identifier: MIT
#include "tool/play/play_scene.h"

#include <algorithm>

#include "engine/engine.h"
#include "tool/play/picture/view.h"

namespace ticktrue::play {
namespace {

using engine::Body;
using engine::BodyType;
using engine::InputKind;
using engine::Scene;
using engine::Shape;
using engine::ShapeKind;

constexpr double piece_share = 0.025;  // half the size of a piece, of the height that the scene shows at first

/// Six corners on a circle that is cut unevenly: convex, and no two sides alike.
constexpr std::array<engine::Point, 6> corners{
    {{1.1, 0.05}, {0.55, 0.85}, {-0.45, 0.95}, {-1.05, 0.2}, {-0.6, -0.9}, {0.5, -0.95}}};

Shape shape_of(Piece piece, double size) {
  Shape shape;
  switch (piece) {
    case Piece::circle:
      shape.kind = ShapeKind::circle;
      shape.radius = size;
      break;
    case Piece::box:
      shape.kind = ShapeKind::box;
      shape.half_size = {size, size};
      break;
    case Piece::polygon:
      shape.kind = ShapeKind::polygon;
      for (const engine::Point& corner : corners) shape.vertices.push_back({corner.x * size, corner.y * size});
      break;
  }
  return shape;
}

bool has_name(const Scene& scene, const std::string& name) {
  const auto is_it = [&name](const Body& body) { return body.name == name; };
  return std::any_of(scene.bodies.begin(), scene.bodies.end(), is_it) ||
         std::any_of(scene.prototypes.begin(), scene.prototypes.end(), is_it);
}

std::string free_name(const Scene& scene, std::string name) {
  while (has_name(scene, name)) name += "_";
  return name;
}

std::uint16_t add_prototype(Scene& scene, Body body) {
  body.name = free_name(scene, body.name);
  scene.prototypes.push_back(std::move(body));
  return static_cast<std::uint16_t>(scene.prototypes.size() - 1);
}

void add_input(Scene& scene, InputKind kind) {
  const auto place = std::lower_bound(scene.inputs.begin(), scene.inputs.end(), kind);
  if (place == scene.inputs.end() || *place != kind) scene.inputs.insert(place, kind);
}

void add_pieces(PlayScene& playable, double size) {
  Scene& scene = playable.scene;
  for (const Piece piece : {Piece::circle, Piece::box, Piece::polygon}) {
    const auto index = static_cast<std::size_t>(piece);
    const std::string name(piece_names[index]);
    const auto own = std::find_if(scene.prototypes.begin(), scene.prototypes.end(), [&name](const Body& body) {
      return body.name == name && body.type == BodyType::dynamic_body;
    });
    Body body;
    if (own != scene.prototypes.end()) {
      body = *own;
      playable.moving[index] = static_cast<std::uint16_t>(own - scene.prototypes.begin());
    } else {
      body.name = name;
      body.shapes.push_back(shape_of(piece, size));
      playable.moving[index] = add_prototype(scene, body);
    }
    body.name = "static_" + name;
    body.type = BodyType::static_body;
    body.mass.reset();
    body.bullet = false;
    playable.fixed[index] = add_prototype(scene, body);
  }
  for (const InputKind kind : {InputKind::spawn, InputKind::press, InputKind::drag, InputKind::release})
    add_input(scene, kind);
  if (!scene.pointer) scene.pointer.emplace();
  scene.pointer->spawns.clear();
}

}  // namespace

Result<PlayScene> make_playable(const engine::Scene& scene) {
  const auto as_it_was = engine::make_engine(scene);
  if (!as_it_was) return as_it_was.error();
  constexpr int height_px = 1000;
  const View view = first_view(**as_it_was, 16 * height_px / 10, height_px);
  PlayScene playable;
  playable.scene = scene;
  add_pieces(playable, piece_share * height_px / view.scale);
  const auto made = engine::make_engine(playable.scene);
  if (made) return playable;
  playable = {};
  playable.scene = scene;
  playable.can_touch = false;
  playable.note = made.error().message;
  return playable;
}

}  // namespace ticktrue::play
