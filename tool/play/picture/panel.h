// Text over the picture: panels of lines, bars, a list of keys.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "tool/play/picture/canvas.h"
#include "tool/play/picture/font.h"
#include "tool/play/picture/layers.h"
#include "tool/play/picture/theme.h"

namespace ticktrue::play {

/// The sizes of letters that are used.
struct Fonts {
  Font small{8};
  Font normal{9};
  Font large{14};
};

/// A line: a faint word and what it is about.
struct PanelLine {
  std::string name;
  std::string value;
  Color color = theme::text;
};

enum class Corner : std::uint8_t { upper_left, upper_right, lower_left, lower_right };

/// A box with lines, `away_px` further from the upper or lower edge of the picture than other panels.
void draw_panel(Canvas& canvas, const Font& font, Corner corner, const std::vector<PanelLine>& lines, int away_px = 0);

/// The layers and their keys along the upper right edge, those that are on lit.
void draw_layer_keys(Canvas& canvas, const Font& font, const LayerSet& on);

/// In the middle, over everything.
void draw_help(Canvas& canvas, const Fonts& fonts, const std::string& title, const std::vector<PanelLine>& lines);

}  // namespace ticktrue::play
