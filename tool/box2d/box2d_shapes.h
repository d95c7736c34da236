// Creates the shapes of a body in Box2D. Included only by the files of the Box2D peer.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/result.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/box2d/box2d_units.h"

namespace ticktrue::tool {

/// Whether a shape of a dynamic body is so thin that its skin would dominate. A thin shape gets the skin of
/// Box2dOptions::match_skin.
bool is_thin(const engine::Body& description, const engine::Shape& shape, const Box2dUnits& units);

/// Adds one shape of `description` to `body`. The user data of the fixture points to the shape, which must outlive the
/// fixture. `restitution_threshold`: of the scene, m/s. Errors begin with `place`. Errors: unsupported, for a shape
/// that Box2D 2.4.1 cannot represent.
Status add_box2d_shape(b2Body* body, const engine::Body& description, const engine::Shape& shape,
                       double restitution_threshold, const Box2dOptions& options, const Box2dUnits& units,
                       const std::string& place);

}  // namespace ticktrue::tool
