// Strips, marks and the playhead.
// SPDX-License-Identifier: MIT
#include "tool/play/timeline_picture.h"

#include <fmt/format.h>

#include <algorithm>

#include "tool/play/picture/theme.h"

namespace ticktrue::play {
namespace {

/// Ticks behind one column of pixels.
struct TickColumn {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};
TickColumn column_at(const Timeline& timeline, int x, std::uint64_t tick_count) {
  const auto tick_at = [&](double at) {
    const double share = std::clamp((at - timeline.left) / (timeline.right - timeline.left), 0.0, 1.0);
    return std::min(static_cast<std::uint64_t>(share * static_cast<double>(tick_count)), tick_count);
  };
  TickColumn column{tick_at(x), tick_at(x + 1.0)};
  column.begin = std::min(column.begin, tick_count - 1);
  column.end = std::max(column.end, column.begin + 1);
  return column;
}

Color match_color(const Player& player, const TickColumn& column) {
  bool known = true;
  for (std::uint64_t tick = column.begin; tick < column.end; ++tick) {
    if (player.match(tick) == Match::different) return theme::bad;
    if (player.match(tick) == Match::unknown) known = false;
  }
  return known ? theme::good : theme::panel_edge;
}

bool has_input(const Player& player, const TickColumn& column) {
  for (std::uint64_t tick = column.begin; tick < column.end; ++tick)
    if (player.has_inputs(tick)) return true;
  return false;
}

bool recordings_differ(const Player& a, const Player& b, const TickColumn& column) {
  for (std::uint64_t tick = column.begin; tick < column.end; ++tick)
    if (tick >= b.tick_count() || a.recorded_hash(tick) != b.recorded_hash(tick)) return true;
  return false;
}

}  // namespace

void draw_timeline(Canvas& canvas, const Font& font, const Player& player, const Player* other, const View& view) {
  const Timeline timeline = Timeline::of(view);
  const std::uint64_t count = player.tick_count();
  const auto fill = [&](double left, double top, double right, double bottom, Color color) {
    canvas.rectangle({left, top}, {right, bottom}, {color, {}, 0});
  };
  fill(0, timeline.top - 20, view.width, view.height, theme::panel);
  for (int x = static_cast<int>(timeline.left); x < static_cast<int>(timeline.right); ++x) {
    const TickColumn column = column_at(timeline, x, count);
    fill(x, timeline.top, x + 1, timeline.bottom, match_color(player, column));
    if (has_input(player, column)) fill(x, timeline.top - 7, x + 1, timeline.top - 2, theme::accent);
    if (other != nullptr && recordings_differ(player, *other, column))
      fill(x, timeline.bottom - 5, x + 1, timeline.bottom, theme::ghost);
  }
  for (const std::uint64_t checkpoint : player.checkpoints()) {
    const double x = timeline.x_of(checkpoint, count);
    const Pixel mark[] = {{x - 4, timeline.bottom + 8}, {x + 4, timeline.bottom + 8}, {x, timeline.bottom + 2}};
    canvas.convex(mark, {theme::faint, {}, 0});
  }
  if (player.difference()) {
    const double x = timeline.x_of(*player.difference(), count);
    fill(x - 1, timeline.top - 14, x + 1, timeline.bottom + 4, theme::bad);
  }
  const double head = timeline.x_of(player.position(), count);
  fill(head - 1, timeline.top - 10, head + 1, timeline.bottom + 6, theme::text);
  canvas.circle({head, timeline.top - 10}, 5, {theme::text, {}, 0});

  const int y = static_cast<int>(timeline.bottom) + 9;
  const std::string place = fmt::format("{} of {} ticks", player.position(), count);
  font.draw(canvas, static_cast<int>(timeline.right) - font.width(place), y, place, theme::text);
  int x = static_cast<int>(timeline.left);
  const auto legend = [&](Color color, std::string_view text) {
    fill(x, y + 2, x + 8, y + 10, color);
    font.draw(canvas, x + 13, y, text, theme::faint);
    x += 13 + font.width(text) + 18;
  };
  legend(theme::good, "as recorded");
  legend(theme::bad, "differs");
  legend(theme::panel_edge, "not run");
  legend(theme::accent, "inputs");
  legend(theme::faint, "checkpoints");
  if (other != nullptr) legend(theme::ghost, "the other trace differs");
}

}  // namespace ticktrue::play
