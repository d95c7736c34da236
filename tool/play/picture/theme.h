// The colours: calm ones on a dark ground, told apart by lightness as well as by hue.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "tool/play/picture/canvas.h"

namespace ticktrue::play::theme {

inline constexpr Color ground{22, 26, 33};
inline constexpr Color grid{29, 34, 43};
inline constexpr Color grid_axis{38, 45, 57};
inline constexpr Color panel{15, 18, 23, 225};
inline constexpr Color panel_edge{48, 56, 70};
inline constexpr Color text{214, 220, 230};
inline constexpr Color faint{128, 140, 158};
inline constexpr Color accent{120, 190, 235};
inline constexpr Color good{112, 178, 140};
inline constexpr Color bad{236, 104, 92};
inline constexpr Color warning{236, 190, 104};

inline constexpr Color fixed_body{92, 102, 119};
inline constexpr Color kinematic_body{176, 150, 214};
inline constexpr std::array<Color, 6> moving_bodies{
    {{106, 160, 212}, {122, 184, 150}, {216, 178, 118}, {205, 132, 132}, {158, 142, 205}, {110, 186, 192}}};
inline constexpr Color ghost{240, 196, 110};

inline constexpr Color contact{250, 214, 120};
inline constexpr Color overlap{240, 100, 90};
inline constexpr Color normal{140, 220, 250};
inline constexpr Color joint{190, 230, 130};
inline constexpr Color box{120, 130, 150, 150};
inline constexpr Color pair{230, 150, 230, 130};
inline constexpr Color pull{250, 240, 200};

/// A share of `b` in `a`, 0..1.
constexpr Color mix(Color a, Color b, double share) {
  const auto channel = [share](std::uint8_t x, std::uint8_t y) {
    return static_cast<std::uint8_t>(x + (y - x) * share + 0.5);
  };
  return {channel(a.red, b.red), channel(a.green, b.green), channel(a.blue, b.blue), 255};
}

}  // namespace ticktrue::play::theme
