// What a scene must declare so that a person can play in it: prototypes for clicks, and a pointer.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"
#include "engine/scene/scene.h"

namespace ticktrue::play {

enum class Piece : std::uint8_t { circle, box, polygon };
inline constexpr std::array<std::string_view, 3> piece_names{"circle", "box", "polygon"};

struct PlayScene {
  engine::Scene scene;
  bool can_touch = true;                  // false: the scene's choices allow no pieces and no pointer
  std::string note;                       // then why; else empty
  std::array<std::uint16_t, 3> moving{};  // [Piece] index in Scene::prototypes
  std::array<std::uint16_t, 3> fixed{};   // [Piece] likewise, static
};

/// Adds what is missing: prototypes "circle", "box" and "polygon" (those of the scene are used where it has them) and
/// static ones of the same shapes, the inputs spawn, press, drag, release, and a pointer. A press on empty space then
/// spawns nothing by itself: which piece comes is the button's choice. Where the scene's choices allow no contacts, the
/// scene stays as it is. Errors: what make_engine refuses of the scene as it was.
Result<PlayScene> make_playable(const engine::Scene& scene);

}  // namespace ticktrue::play
