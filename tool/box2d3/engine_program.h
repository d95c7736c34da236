// This engine in another build, as a child process: engine_run of any preset, as WebAssembly in node.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include "base/result.h"
#include "engine/scene/scene.h"
#include "tool/box2d3/box2d3_peer.h"

namespace ticktrue::tool {

/// Whether a program is WebAssembly: a file that ends in .js, which node runs.
bool runs_in_node(const std::string& program);

/// Runs the whole plan in `program`, an engine_run (engine_run.cpp), with the scene's own substeps. The scene and plan
/// as in make_box2d3_peer; contacts are not reported. Errors: those of run_answer_program.
Result<std::unique_ptr<Box2d3Peer>> make_engine_program_peer(const std::string& program, const engine::Scene& scene,
                                                             const Box2d3Options& options, const Box2d3Plan& plan);

}  // namespace ticktrue::tool
