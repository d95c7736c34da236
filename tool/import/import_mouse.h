// Imports recorded mouse sessions of people as pointer inputs.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/input.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

struct MouseImportOptions {
  std::optional<engine::Bounds>
      window;  // part of the world that the screen covers; absent: the window of the pointer, else the bounds
  bool right_presses = false;  // the right button counts as the left one
};

/// The inputs of a session in the format of the Balabit Mouse Dynamics Challenge. Its header and lines are `record
/// timestamp, client timestamp, button, state, x, y`. docs/scenes.md, "Mouse sessions", has the rules. Errors:
/// invalid_input (with `source`:line), incompatible (the scene has no pointer), usage (no window).
Result<std::vector<engine::Input>> import_mouse(std::string_view csv, const std::string& source,
                                                const engine::Scene& scene, const MouseImportOptions& options = {});

/// The part of the world on the screen of a pointer: its window, else the scene's bounds. Errors: incompatible (no
/// pointer), usage (neither window nor bounds).
Result<engine::Bounds> pointer_window(const engine::Scene& scene);

}  // namespace ticktrue::tool
