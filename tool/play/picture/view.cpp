// The view at the start of a scene.
// SPDX-License-Identifier: MIT
#include "tool/play/picture/view.h"

#include <vector>

#include "tool/drawing/drawing.h"

namespace ticktrue::play {
namespace {

/// What the bodies that move would cover if they turned on the spot.
tool::WorldBox turned_bodies(const engine::Engine& engine) {
  const tool::Drawing drawing(engine.scene(), *engine.state().schema);
  std::vector<tool::DrawnBody> bodies;
  drawing.read(engine.state(), bodies);
  tool::WorldBox box;
  for (const tool::DrawnBody& body : bodies) {
    const tool::Figure& figure = drawing.figures()[body.figure];
    if (figure.type == engine::BodyType::static_body || !body.is_finite) continue;
    box.add(body.center.x - figure.extent, body.center.y - figure.extent);
    box.add(body.center.x + figure.extent, body.center.y + figure.extent);
  }
  return box;
}

}  // namespace

View first_view(const engine::Engine& engine, int width, int height) {
  View view;
  view.width = width;
  view.height = height;
  const engine::Scene& scene = engine.scene();
  if (scene.pointer && scene.pointer->window) {
    const engine::Bounds& window = *scene.pointer->window;
    tool::WorldBox box;
    box.add(window.lower.x, window.lower.y);
    box.add(window.upper.x, window.upper.y);
    view.fit(box);
  } else {
    view.fit(tool::choose_view(engine, turned_bodies(engine)));
  }
  return view;
}

}  // namespace ticktrue::play
