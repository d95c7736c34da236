// Gaps and drawn lines of joints in world coordinates, from poses in f64: one table row for each kind.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// Anchors and axis of a joint in world coordinates.
struct JointPlaces {
  engine::Point anchor_a;  // m; if the joint has no body A: the point of the world that holds B
  engine::Point anchor_b;  // m
  engine::Point axis;      // rotated with A, of any length
};

/// Line segments between points.
struct JointLines {
  std::size_t count = 0;
  std::array<std::array<engine::Point, 2>, 3> lines;
};

/// The joint with the bodies and anchors between which a picture shows it: for a gear, body B and B's anchor of each of
/// its joints. Requires: a joint of the scene.
engine::Joint shown_joint(const engine::Scene& scene, const engine::Joint& joint);

/// The position error of a joint, m: the distance from its rigid constraints, without limits and angles; 0 for a
/// gear.
double joint_gap(const engine::Joint& joint, const JointPlaces& places);

/// The position error of each joint of the scene, m: distance of the anchors (revolute, weld), distance from the axis
/// (prismatic, wheel), error of the length (rigid distance) or of the length of the rope (pulley). The error of any
/// other joint is 0. If a body of a joint no longer exists, the error of the joint is 0.
std::vector<double> joint_gaps(const engine::Scene& scene, const std::vector<engine::BodyReport>& bodies);

/// The lines that a picture draws between the anchors of a joint.
JointLines joint_lines(const engine::Joint& joint, const JointPlaces& places);

}  // namespace ticktrue::tool
