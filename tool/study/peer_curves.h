// Error against run time beside Box2D 2.4.1: ours over substeps, Box2D over iterations, on four scenes.
// SPDX-License-Identifier: MIT
//
// The error is the distance from the ideal geometry, root mean square over bodies and samples of the measured time. Of
// chains it is the distance between two anchors that should meet. Box2D keeps polygons up to two skins apart (0.02 m):
// gaps of a stack between 0 and two skins count as no error. Joints have no skin.
// The engines run alternately, repeat by repeat, on one thread.
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
  bool stands = true;    // no body is farther than half its size from its place, no gap wider than half a link
  SampleSpread time_ms;  // per tick
};

struct PeerCurves {
  std::string name;
  std::string measure;  // the definition of the error, and when it is taken
  std::vector<PeerPoint> ours;
  std::vector<PeerPoint> box2d;
  double ratio = 0;    // our best error at the time of Box2D's best point, over the error of that point
  bool holds = false;  // ratio at most 0.5
  std::string conclusion;
};

/// The point with the least error among those that take at most `time_ms` (the least of the repeats); null
/// if none does.
const PeerPoint* best_within(const std::vector<PeerPoint>& points, double time_ms);
/// Fills ratio, holds and conclusion.
void conclude(PeerCurves& curves);

/// The curves of the scenes (all four if none is named): stack_40, stack_ratio_100, hanging_chain, swinging_chain.
/// Errors: usage (a name), unsupported (a build without Box2D).
Result<std::vector<PeerCurves>> run_peer_curves(
    const std::vector<std::string>& names, int repeat_max,
    const std::function<void(std::uint64_t done, std::uint64_t total)>& progress);

std::string peer_version();

}  // namespace ticktrue::verifier
