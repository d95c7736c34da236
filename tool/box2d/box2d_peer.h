// A scene in Box2D 2.4.1: the peer of the cross-check and of the benchmark. No Box2D header is needed to use it.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::verifier {

struct Box2dOptions {
  int velocity_iterations = 8;  // Box2D's own recommendation
  int position_iterations = 3;
  int steps_per_tick = 1;   // more: smaller steps, the same ticks
  bool match_skin = false;  // polygons get a skin so thin that they rest where their geometry touches
  bool sleep = false;       // where the scene lets bodies sleep, Box2D may too
  // Capsules, which Box2D 2.4.1 has not, become octagons of the same ends and width: good enough to compare run time.
  bool capsules_as_octagons = false;
};

/// The world of a scene in Box2D. No inputs: bodies move as the scene starts them. Sleeping is off unless asked for,
/// everything else is Box2D's default. Masses are ours (geometry/hull.h), given explicitly. Joints and bullets are the
/// scene's. Bodies that leave the scene's bounds are removed, as ours are.
class Box2dPeer {
 public:
  virtual ~Box2dPeer() = default;

  /// Advances one tick of the scene's dt.
  virtual void step() = 0;

  /// In the scene's units; id = place in Scene::bodies. Removed bodies are absent.
  virtual std::vector<engine::BodyReport> bodies() const = 0;
  /// Touching pairs. Separations are those of the geometry, Box2D's polygon skin not counted: shapes that rest on
  /// their skins have positive ones. Forces are those of the last tick.
  virtual std::vector<engine::ContactReport> contacts() const = 0;

  virtual std::size_t body_count() const = 0;
  virtual std::size_t contact_count() const = 0;  // touching

  /// Scene lengths times this are Box2D's: a power of two, not 1 only where bodies are far from the 0.1 m to 10 m that
  /// Box2D is tuned for.
  virtual double length_scale() const = 0;
  /// The largest gap that Box2D leaves between the geometry of two resting polygons, scene m.
  virtual double skin() const = 0;
  /// Shapes that got the skin of Box2dOptions::match_skin because they are thinner than three skins.
  virtual std::size_t thin_shape_count() const = 0;
  /// The first tick, from 1, in which Box2D cut a movement to its limit of 2 m or 90 degrees a step; 0: none.
  virtual std::size_t clamped_tick() const = 0;
};

/// Errors: unsupported, with the reason: joints, shapes or forces that 2.4.1 does not have, a polygon of more than 8
/// vertices, shapes thinner than a few of the thinnest skins, coordinates too far out for floats; or a build without
/// Box2D.
Result<std::unique_ptr<Box2dPeer>> make_box2d_peer(const engine::Scene& scene, const Box2dOptions& options = {});

/// "2.4.1"; empty in a build without Box2D.
std::string box2d_version();

}  // namespace ticktrue::verifier
