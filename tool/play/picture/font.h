// A font of our own: ASCII letters made of strokes, drawn once for each size.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <string_view>

#include "tool/play/picture/canvas.h"

namespace ticktrue::play {

/// Every letter is equally wide, so that numbers do not jump.
class Font {
 public:
  /// `size_px`: height of capital letters.
  explicit Font(double size_px);
  int advance() const { return advance_; }  // px from letter to letter
  int line() const { return line_; }        // px from line to line
  int width(std::string_view text) const { return advance_ * static_cast<int>(text.size()); }
  /// `x`, `y`: the upper left corner of the line. What is not printable ASCII is shown as a question mark.
  void draw(Canvas& canvas, int x, int y, std::string_view text, Color color) const;

 private:
  int advance_ = 0;
  int line_ = 0;
  int above_ = 0;  // px from the top of a mask to the top of the line
  std::array<Mask, 95> letters_;
};

}  // namespace ticktrue::play
