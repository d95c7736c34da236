// Lengths of the scene in Box2D's units. Only the files of the Box2D peer include this header.
// SPDX-License-Identifier: MIT
#pragma once

#include <box2d/box2d.h>

#include "engine/scene/scene.h"

namespace ticktrue::tool {

/// Box2D lengths are scene lengths times `scale`.
struct Box2dUnits {
  double scale;

  b2Vec2 scaled(const engine::Point& p) const {
    return {static_cast<float>(p.x * scale), static_cast<float>(p.y * scale)};
  }
  engine::Point unscaled(const b2Vec2& v) const {
    return {static_cast<double>(v.x) / scale, static_cast<double>(v.y) / scale};
  }
};

}  // namespace ticktrue::tool
