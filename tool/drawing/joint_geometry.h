// Gaps and lines of joints in the world, from poses in f64: one row for each kind.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "engine/scene/scene.h"

namespace ticktrue::verifier {

/// Places of a joint in the world.
struct JointPlaces {
  engine::Point anchor_a;  // m; where the joint holds B to the world: its point there
  engine::Point anchor_b;  // m
  engine::Point axis;      // turned with A, of any length
};

/// Line segments between points.
struct JointLines {
  std::size_t count = 0;
  std::array<std::array<engine::Point, 2>, 3> lines;
};

/// How far a joint is from what its rigid rows hold, without limits and angles, m.
double joint_gap(const engine::Joint& joint, const JointPlaces& places);

/// What a picture shows of a joint between its anchors.
JointLines joint_lines(const engine::Joint& joint, const JointPlaces& places);

}  // namespace ticktrue::verifier
