// The view at the start of a scene.
// SPDX-License-Identifier: MIT
#include "play/view.h"

namespace ticktrue::play {

View first_view(const engine::Engine& engine, int width, int height) {
  View view;
  view.width = width;
  view.height = height;
  const engine::Scene& scene = engine.scene();
  if (scene.pointer && scene.pointer->window) {
    const engine::Bounds& window = *scene.pointer->window;
    verifier::WorldBox box;
    box.add(window.lower.x, window.lower.y);
    box.add(window.upper.x, window.upper.y);
    view.fit(box);
  } else {
    view.fit(verifier::choose_view(engine, {}));
  }
  return view;
}

}  // namespace ticktrue::play
