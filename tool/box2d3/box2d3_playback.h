// A finished run that is played back as a peer.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include "engine/scene/scene.h"
#include "tool/box2d3/box2d3_answer.h"
#include "tool/box2d3/box2d3_peer.h"

namespace ticktrue::tool {

/// `length_scale`: lengths of the answer over those of the scene. Requires: an answer to this scene and plan.
std::unique_ptr<Box2d3Peer> play_back(const engine::Scene& scene, const Box2d3Plan& plan, double length_scale,
                                      Box2d3Answer answer);

}  // namespace ticktrue::tool
