// Draws a state of the engine: bodies, and on request how the engine sees them. Looks only, changes nothing.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/engine.h"
#include "tool/drawing/drawing.h"
#include "tool/play/picture/canvas.h"
#include "tool/play/picture/layers.h"
#include "tool/play/picture/view.h"

namespace ticktrue::play {

class WorldPicture {
 public:
  /// The engine must outlive this.
  explicit WorldPicture(const engine::Engine& engine);

  /// The ground, the bodies of the engine's present state, and the layers that are on.
  void draw(Canvas& canvas, const View& view, const LayerSet& layers);
  /// The outlines of the bodies of another state of the same or a similar scene.
  void draw_ghosts(Canvas& canvas, const View& view, const tool::Drawing& drawing, const StateView& state);
  /// A ring around each of these bodies. Those that are not there get none.
  void draw_rings(Canvas& canvas, const View& view, const std::vector<std::uint32_t>& ids);
  /// From the point of the body that a pointer holds to where it pulls.
  void draw_pulls(Canvas& canvas, const View& view);

  /// What was drawn last, as it was read from the state.
  const std::vector<tool::DrawnBody>& bodies() const { return bodies_; }
  const tool::Drawing& drawing() const { return drawing_; }

 private:
  void draw_body(Canvas& canvas, const View& view, const tool::DrawnBody& body, const Paint& paint, double line_px);
  void draw_outline(Canvas& canvas, const View& view, const tool::DrawnBody& body, const tool::Figure& figure,
                    const tool::Outline& outline, const Paint& paint, double line_px);
  void draw_turn(Canvas& canvas, const View& view, const tool::DrawnBody& body, const tool::Figure& figure,
                 Color color);
  void draw_contacts(Canvas& canvas, const View& view, const LayerSet& layers,
                     const std::vector<engine::ContactReport>& contacts);
  void draw_joints(Canvas& canvas, const View& view);
  void draw_broad_phase(Canvas& canvas, const View& view, const LayerSet& layers);
  void find_islands(const std::vector<engine::ContactReport>& contacts);
  void find_sleepers();
  const tool::DrawnBody* find(std::uint32_t id) const;
  std::size_t row_of(std::uint32_t id) const;

  const engine::Engine& engine_;
  tool::Drawing drawing_;
  std::vector<tool::DrawnBody> bodies_;
  std::vector<std::uint32_t> island_;    // [body] row of the first body of its island
  std::vector<std::uint8_t> asleep_;     // [body]
  std::vector<engine::Point> points_;    // work space
  std::vector<Pixel> corners_;           // work space
  const tool::Drawing* used_ = nullptr;  // of the bodies being drawn
};

/// Draws a grid of whole metres (or tens, or tenths of them).
void draw_ground(Canvas& canvas, const View& view);

}  // namespace ticktrue::play
