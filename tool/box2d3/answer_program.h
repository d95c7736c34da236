// Runs a program that answers as peer.mjs does, within limits.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"
#include "tool/box2d3/box2d3_answer.h"

namespace ticktrue::tool {

/// `name` begins messages. `argv`: the program first. Errors: limit (the answer would be too large; nothing was run),
/// usage (the program cannot be started), io (it fails, hangs or prints too much), corrupt (its answer), unsupported
/// (it refuses the scene).
Result<Box2d3Answer> run_answer_program(const std::string& name, const std::vector<std::string>& argv,
                                        const engine::Scene& scene, const Box2d3Options& options,
                                        const Box2d3Plan& plan);

}  // namespace ticktrue::tool
