// Creates the joints of a scene in a Box2D world. Included only by the files of the Box2D peer.
// SPDX-License-Identifier: MIT
#pragma once

#include <box2d/box2d.h>

#include <string>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"
#include "tool/box2d/box2d_units.h"

namespace ticktrue::tool {

/// The joints of a scene in a Box2D world.
class Box2dJoints {
 public:
  /// `dt`: length of a step, s. Requires: the world outlives this object.
  Box2dJoints(b2World& world, const Box2dUnits& units, float dt) : world_(world), units_(units), dt_(dt) {}

  /// `a`: body A, if the joint has one; `b`: body B; both are not used for a gear. Requires: `joint` outlives this
  /// object; joints come in the order of the scene. Errors begin with `place`. Errors: unsupported, for a joint that
  /// Box2D 2.4.1 cannot represent.
  Status add(const engine::Joint& joint, b2Body* a, b2Body* b, const std::string& place);

  /// Call before a step. The stiffness of a spring given in hertz follows the effective mass, which changes as the
  /// bodies rotate.
  void set_stiffness() const;

  /// Call before a body and its joints are destroyed. Destroys the gears of these joints.
  void forget(const b2Body* body);

  /// Whether the world has an extra static body, which holds joints between a body and the world.
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
  std::vector<b2Joint*> made_;       // [joint of the scene]
  std::vector<b2GearJoint*> gears_;  // that exist
  b2Body* anchorage_ = nullptr;      // made when first needed
};

}  // namespace ticktrue::tool
