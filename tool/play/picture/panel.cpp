// Panels of text.
// SPDX-License-Identifier: MIT
#include "tool/play/picture/panel.h"

#include <algorithm>

namespace ticktrue::play {
namespace {

constexpr int margin = 12;   // px, from the edge of the picture
constexpr int padding = 10;  // px, inside of a panel

Pixel at(int x, int y) {
  return {static_cast<double>(x), static_cast<double>(y)};
}

void draw_frame(Canvas& canvas, int x, int y, int width, int height) {
  canvas.rectangle(at(x, y), at(x + width, y + height), {theme::panel, theme::panel_edge, 1});
}

int name_width(const Font& font, const std::vector<PanelLine>& lines) {
  int width = 0;
  for (const PanelLine& line : lines)
    if (!line.value.empty()) width = std::max(width, font.width(line.name));
  return width == 0 ? 0 : width + 2 * font.advance();
}

int text_width(const Font& font, const std::vector<PanelLine>& lines, int column) {
  int width = 0;
  for (const PanelLine& line : lines)
    width = std::max(width, line.value.empty() ? font.width(line.name) : column + font.width(line.value));
  return width;
}

void draw_lines(Canvas& canvas, const Font& font, int x, int y, int column, const std::vector<PanelLine>& lines) {
  for (const PanelLine& line : lines) {
    font.draw(canvas, x, y, line.name, line.value.empty() ? line.color : theme::faint);
    font.draw(canvas, x + column, y, line.value, line.color);
    y += font.line();
  }
}

}  // namespace

void draw_panel(Canvas& canvas, const Font& font, Corner corner, const std::vector<PanelLine>& lines, int away_px) {
  const int column = name_width(font, lines);
  const int width = text_width(font, lines, column) + 2 * padding;
  const int height = font.line() * static_cast<int>(lines.size()) + 2 * padding - 4;
  const bool right = corner == Corner::upper_right || corner == Corner::lower_right;
  const bool lower = corner == Corner::lower_left || corner == Corner::lower_right;
  const int x = right ? canvas.width() - margin - width : margin;
  const int y = lower ? canvas.height() - margin - height - away_px : margin + away_px;
  draw_frame(canvas, x, y, width, height);
  draw_lines(canvas, font, x + padding, y + padding, column, lines);
}

void draw_layer_keys(Canvas& canvas, const Font& font, const LayerSet& on) {
  int width = 0;
  for (const LayerInfo& info : all_layers) width += font.width(info.name) + 4 * font.advance();
  int x = canvas.width() - margin - width;
  const int y = margin;
  draw_frame(canvas, x, y, width, font.line() + padding);
  x += font.advance();
  for (const LayerInfo& info : all_layers) {
    const bool lit = on.has(info.layer);
    font.draw(canvas, x, y + padding / 2 + 1, info.key, lit ? theme::text : theme::accent);
    x += 2 * font.advance();
    font.draw(canvas, x, y + padding / 2 + 1, info.name, lit ? theme::warning : theme::faint);
    x += font.width(info.name) + 2 * font.advance();
  }
}

void draw_help(Canvas& canvas, const Fonts& fonts, const std::string& title, const std::vector<PanelLine>& lines) {
  const Font& font = fonts.normal;
  const int column = name_width(font, lines);
  const int width = std::max(fonts.large.width(title), text_width(font, lines, column)) + 4 * padding;
  const int height = fonts.large.line() + font.line() * static_cast<int>(lines.size()) + 4 * padding;
  const int x = (canvas.width() - width) / 2;
  const int y = (canvas.height() - height) / 2;
  draw_frame(canvas, x, y, width, height);
  fonts.large.draw(canvas, x + 2 * padding, y + 2 * padding, title, theme::text);
  draw_lines(canvas, font, x + 2 * padding, y + 2 * padding + fonts.large.line() + padding / 2, column, lines);
}

}  // namespace ticktrue::play
