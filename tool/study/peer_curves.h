// Error against run time beside Box2D 2.4.1: this engine over substeps, Box2D over iterations, on four scenes.
// SPDX-License-Identifier: MIT
//
// The error is the distance from the ideal geometry, root mean square over the bodies and samples of the measured time.
// In a chain, the error is the distance between two anchors that should coincide. Box2D keeps polygons up to two skins
// (0.02 m) apart: in a stack, gaps of at most two skins count as no error. Joints have no skin.
// Each repeat runs every setting of this engine and then every setting of Box2D, on one thread.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/result.h"
#include "tool/study/measures.h"

namespace ticktrue::verifier {

struct PeerPoint {
  std::string setting;   // "8 sub", "16/6 it"
  double error = 0;      // m
  double error_max = 0;  // m
  bool stands = true;    // no body is farther than half its size from its ideal place; no gap is wider than half a link
  SampleSpread time_ms;  // per tick
};

struct PeerCurves {
  std::string name;
  std::string measure;  // definition of the error, and when samples are taken
  std::vector<PeerPoint> ours;
  std::vector<PeerPoint> box2d;
  double ratio = 0;    // the best error here within the time of Box2D's best point, over the error of that point
  bool holds = false;  // ratio is at most 0.5
  std::string conclusion;
};

/// The point with the smallest error among the points that take at most `time_ms` (the minimum over repeats). Null if
/// there is none.
const PeerPoint* best_within(const std::vector<PeerPoint>& points, double time_ms);
/// Fills ratio, holds and conclusion.
void conclude(PeerCurves& curves);

/// The curves of the named scenes; without names, of all four: stack_40, stack_ratio_100, hanging_chain,
/// swinging_chain. Errors: usage (unknown name), unsupported (a build without Box2D).
Result<std::vector<PeerCurves>> run_peer_curves(
    const std::vector<std::string>& names, int repeat_max,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& progress);

std::string peer_version();

}  // namespace ticktrue::verifier
