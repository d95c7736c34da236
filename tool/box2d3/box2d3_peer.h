// A scene in Box2D 3, for the cross-check and the studies, as a child process: ticktrue_box2d3, which is built with an
// installed Box2D 3, or npm's box2d3-wasm in node.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/box2d3/box2d3_scene.h"

namespace ticktrue::tool {

/// The environment variable that names ticktrue_box2d3, or the folder with node_modules/box2d3-wasm. Without the
/// variable, ticktrue_box2d3 beside this program is used.
inline constexpr const char* box2d3_variable = "TICKTRUE_BOX2D3";

/// A finished run that is played back: step() goes to the next tick. Requires: at most Box2d3Plan::tick_count steps;
/// bodies() and contacts() only after ticks of which the plan asks for them.
class Box2d3Peer : public Box2dPeer {
 public:
  /// Processor time of a tick in the child process, the steps alone.
  virtual double ms_per_tick() const = 0;
};

/// Runs the whole plan in a child process. Contact forces are those of the last substep; separations are those that
/// Box2D found at the start of the last step. Bodies never sleep. Errors: unsupported (the scene: joints, shapes or
/// forces that Box2D 3 lacks); usage (no node, no package, a wrong folder); limit (an answer that would be too large);
/// io (node fails, hangs or prints too much); corrupt (its answer).
Result<std::unique_ptr<Box2d3Peer>> make_box2d3_peer(const engine::Scene& scene, const Box2d3Options& options,
                                                     const Box2d3Plan& plan);

/// Whether Box2D 3 runs as WebAssembly, so that its times are not comparable with native ones.
bool box2d3_runs_in_node();

/// "3 (box2d3-wasm 5.2.0)", "3 (native 3.2.0)". Errors: usage (no node, no package, no program).
Result<std::string> box2d3_version();

}  // namespace ticktrue::tool
