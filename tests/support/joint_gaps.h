// How far joints are from what they hold: measured on the bodies' reports, by the geometry of each kind alone.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/engine.h"

namespace ticktrue::test {

/// The error of a joint in the directions that it holds.
struct JointGap {
  double gap = 0;     // m, of its locked directions; an angle counts with `size` as its arm
  double beyond = 0;  // m, over its limits; an angle counts with `size` as its arm
  double size = 0;    // m, of its smaller moving body: the diameter of that body's shapes
  bool exists = true;
};

/// One for each joint of the scene. Joints of bodies that are gone do not exist.
std::vector<JointGap> joint_gaps(const engine::Scene& scene, const std::vector<engine::BodyReport>& bodies);

}  // namespace ticktrue::test
