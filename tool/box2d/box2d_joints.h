// Creates the joints of a scene in a Box2D world. Included only by the files of the Box2D peer.
// SPDX-License-Identifier: MIT
#pragma once

#include <box2d/box2d.h>

#include <string>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"
#include "tool/box2d/box2d_units.h"

namespace ticktrue::verifier {

/// The joints of a scene in a world of Box2D.
class Box2dJoints {
 public:
  /// `dt`: s, of a step. Requires: the world outlives it.
  Box2dJoints(b2World& world, const Box2dUnits& units, float dt) : world_(world), units_(units), dt_(dt) {}

  /// `a`: of a joint that has one. Requires: `joint` outlives this object. `place` is what an error names first.
  /// Errors: unsupported, with what Box2D 2.4.1 has no notion of.
  Status add(const engine::Joint& joint, b2Body* a, b2Body* b, const std::string& place);

  /// Before a step: springs given in hertz are as stiff as their row's mass asks, which turns with the bodies.
  void set_stiffness() const;

  /// Before a body is destroyed, and its joints with it.
  void forget(const b2Body* body);

  /// Whether the world has a body of ours that holds what is pulled to points of the world.
  bool has_anchorage() const { return anchorage_ != nullptr; }

 private:
  struct SoftJoint {
    b2Joint* joint;
    const engine::Joint* description;
  };
  b2World& world_;
  Box2dUnits units_;
  float dt_;
  std::vector<SoftJoint> soft_joints_;
  b2Body* anchorage_ = nullptr;  // made when first needed
};

}  // namespace ticktrue::verifier
