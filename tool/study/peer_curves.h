// Error against run time beside Box2D, on six scenes: this engine and Box2D 3 over substeps, Box2D 2.4.1 over
// iterations. This engine also with direct joints, where there are joints.
// SPDX-License-Identifier: MIT
//
// The error is the distance from the ideal geometry, root mean square over the bodies and samples of the measured time.
// In a chain, the error is the distance between two anchors that should coincide. Box2D keeps polygons up to two skins
// (0.02 m) apart in 2.4.1: in a stack, gaps of at most two skins count as no error. Joints have no skin.
// Box2D 3 has no skin. Each repeat runs every setting of this engine and then every setting of each peer, on one
// thread. Where Box2D 3 runs as WebAssembly in node, its times are not comparable with native ones. If this engine runs
// in this process, errors are therefore compared at equal substeps, and nothing is judged. Where it runs in node as
// well (PeerCurvesOptions::engine_program), both times are the processor time of the steps alone, in node, after a
// warm-up.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "tool/crosscheck/peers.h"
#include "tool/study/measures.h"

namespace ticktrue::tool {

struct PeerPoint {
  std::string setting;        // "8 sub", "16/6 it"
  double error = 0;           // m
  double error_max = 0;       // m
  bool joins_direct = false;  // this engine with direct joints
  bool stands = true;    // no body is farther than half its size from its ideal place; no gap is wider than half a link
  SampleSpread time_ms;  // per tick
};

/// The bar beside one setting of Box2D.
struct PeerBar {
  std::string setting;
  double ratio = 0;  // the least error here within its time, over its error; infinite if nothing here is as quick
  double ratio_max = 0;
};

struct PeerCurves {
  std::string name;
  PeerKind peer = PeerKind::box2d2;
  std::string own_label;   // of tables and plots: "tgs_soft", "tgs_soft, wasm"
  std::string peer_label;  // "Box2D", "Box2D 3", "Box2D 3, wasm"
  std::string measure;     // definition of the error, and when samples are taken
  std::vector<PeerPoint> ours;
  std::vector<PeerPoint> box2d;
  double ratio = 0;           // the best error here within the time of Box2D's best point, over the error of that point
  std::vector<PeerBar> bars;  // at common settings
  bool is_judged = true;      // false: the times of the two are not comparable; ratio is that of equal substeps
  bool holds = false;         // is_judged, ratio is at most 0.5, and so is each bar at most its own
  std::string conclusion;
};

/// The point with the smallest error among the points that take at most `time_ms` (the minimum over repeats). Null if
/// there is none.
const PeerPoint* best_within(const std::vector<PeerPoint>& points, double time_ms);
/// The point of the setting with this name. Null if there is none.
const PeerPoint* find_setting(const std::vector<PeerPoint>& points, const std::string& setting);
/// Fills ratio, bars, holds and conclusion.
void conclude(PeerCurves& curves);

struct PeerCurvesOptions {
  std::vector<std::string> names;  // of peer_scene_names; none: all of them
  std::vector<PeerKind> kinds;
  int repeat_max = 1;
  std::string engine_program;  // an engine_run of any preset, in place of the engine in this process; empty: none
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;
};
inline constexpr std::array<std::string_view, 6> peer_scene_names{
    "stack_40", "stack_ratio_100", "hanging_chain", "heavy_chain", "swinging_chain", "swinging_chain_50"};

/// For each scene one entry for each kind, in this order. Errors: usage (unknown name; no node or no package for Box2D
/// 3; no such engine program, or WebAssembly beside Box2D 2.4.1), unsupported (a build without Box2D), those of a run
/// of Box2D 3 or of the engine program.
Result<std::vector<PeerCurves>> run_peer_curves(const PeerCurvesOptions& options);

}  // namespace ticktrue::tool
