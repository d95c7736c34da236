// Draws the timeline of a trace: what matched, where inputs and checkpoints are, where it stands.
// SPDX-License-Identifier: MIT
#pragma once

#include "tool/play/picture/canvas.h"
#include "tool/play/picture/font.h"
#include "tool/play/playback.h"
#include "tool/play/player.h"

namespace ticktrue::play {

/// `other`: a second trace; a second strip then shows where the two recordings differ. May be null.
void draw_timeline(Canvas& canvas, const Font& font, const Player& player, const Player* other, const View& view);

}  // namespace ticktrue::play
