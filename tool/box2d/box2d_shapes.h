// Creates the shapes of a body in Box2D. Included only by the files of the Box2D peer.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "base/result.h"
#include "tool/box2d/box2d_peer.h"
#include "tool/box2d/box2d_units.h"

namespace ticktrue::verifier {

/// Largest extent of a shape, twice its bounding radius about its own centre.
double extent_of(const engine::Shape& shape);

/// Whether a shape of a dynamic body is so thin that it would be mostly skin: it then gets the skin of
/// Box2dOptions::match_skin.
bool is_thin(const engine::Body& description, const engine::Shape& shape, const Box2dUnits& units);

/// Adds one shape of `description` to `body`; the fixture's user data is the shape, which must outlive it.
/// `restitution_threshold`: m/s of the scene. `place` is what an error names first.
/// Errors: unsupported, with what Box2D 2.4.1 has no notion of.
Status add_box2d_shape(b2Body* body, const engine::Body& description, const engine::Shape& shape,
                       double restitution_threshold, const Box2dOptions& options, const Box2dUnits& units,
                       const std::string& place);

}  // namespace ticktrue::verifier
