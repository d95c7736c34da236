// A scene in Box2D 2.4.1, for the cross-check and the benchmark. Users of this header need no Box2D header.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

struct Box2dOptions {
  int velocity_iterations = 8;  // Box2D's recommendation
  int position_iterations = 3;
  int steps_per_tick = 1;   // more: smaller steps, but the same ticks
  bool match_skin = false;  // polygons get a skin so thin that they rest with their geometry in contact
  bool sleep = false;       // Box2D lets bodies sleep if the scene does
  // Capsules, which Box2D 2.4.1 lacks, become octagons of equal length and width. Octagons are good enough to compare
  // run time.
  bool capsules_as_octagons = false;
};

/// A scene in a Box2D world. There are no inputs: bodies move from the start of the scene. Sleeping is off by default;
/// every other setting has Box2D's default. Masses are set explicitly to those of the engine (engine/scene/hull.h).
/// Joints and bullets follow the scene. Bodies that leave the scene's bounds are removed, as in the engine.
class Box2dPeer {
 public:
  virtual ~Box2dPeer() = default;

  /// Advances one tick of the scene's dt.
  virtual void step() = 0;

  /// In the scene's units; `id` is the index in Scene::bodies. Removed bodies are absent.
  virtual std::vector<engine::BodyReport> bodies() const = 0;
  /// Touching pairs. Separations refer to the geometry, without Box2D's polygon skin: shapes that rest on their skins
  /// have positive separations. Forces are those of the last tick.
  virtual std::vector<engine::ContactReport> contacts() const = 0;

  virtual std::size_t body_count() const = 0;
  virtual std::size_t contact_count() const = 0;  // touching

  /// Box2D lengths over scene lengths, a power of two. The scale is 1 unless the bodies are far from the 0.1 m to 10 m
  /// that Box2D is tuned for.
  virtual double length_scale() const = 0;
  /// The largest gap that Box2D leaves between the geometry of two resting polygons, scene m.
  virtual double skin() const = 0;
  /// Number of shapes that got the thin skin of Box2dOptions::match_skin because they are thinner than three skins.
  virtual std::size_t thin_shape_count() const = 0;
  /// The first tick, from 1, in which Box2D clamped a displacement to 2 m or a rotation to 90 degrees per step; 0:
  /// none.
  virtual std::size_t clamped_tick() const = 0;
};

/// Errors: unsupported, with the reason. The reasons are: joints, shapes or forces that 2.4.1 lacks; a polygon of more
/// than 8 vertices; shapes thinner than a few of the thinnest skins; coordinates too large for floats; a build without
/// Box2D.
Result<std::unique_ptr<Box2dPeer>> make_box2d_peer(const engine::Scene& scene, const Box2dOptions& options = {});

/// "2.4.1"; empty in a build without Box2D.
std::string box2d_version();

}  // namespace ticktrue::tool
