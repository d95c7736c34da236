// Position errors of joints, measured on the bodies' reports by the geometry of each kind alone.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "engine/engine.h"

namespace ticktrue::test {

/// The error of a joint in its constrained directions.
struct JointGap {
  double gap = 0;     // m, in its locked directions; an angle counts with `size` as lever arm
  double beyond = 0;  // m, beyond its limits; an angle counts with `size` as lever arm
  double size = 0;    // m, diameter of the shapes of its smaller moving body
  bool exists = true;
};

/// One for each existing joint of the scene. A joint whose body was removed does not exist.
std::vector<JointGap> joint_gaps(const engine::Scene& scene, const std::vector<engine::BodyReport>& bodies);

}  // namespace ticktrue::test
