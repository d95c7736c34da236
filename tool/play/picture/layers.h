// What can be drawn over the bodies to see how the engine sees them, each on a key.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace ticktrue::play {

enum class Layer : std::uint8_t { contacts, normals, joints, islands, boxes, pairs };
struct LayerInfo {
  Layer layer;
  std::string_view key;
  std::string_view name;
  std::string_view summary;
};
inline constexpr std::array<LayerInfo, 6> all_layers{{
    {Layer::contacts, "c", "contacts", "where bodies touch; red where they overlap by over a pixel"},
    {Layer::normals, "n", "normals", "directions of the contacts, and their forces"},
    {Layer::joints, "j", "joints", "joints, from body to anchor to body"},
    {Layer::islands, "i", "islands", "bodies that hang together, in one colour each"},
    {Layer::boxes, "b", "boxes", "the box around each shape that the broad phase works with"},
    {Layer::pairs, "p", "pairs", "the pairs that the broad phase hands on to be tested"},
}};

/// Which of them are on.
class LayerSet {
 public:
  bool has(Layer layer) const { return on_[static_cast<std::size_t>(layer)]; }
  void toggle(Layer layer) { on_[static_cast<std::size_t>(layer)] = !has(layer); }
  /// False where no layer has this key.
  bool toggle_key(std::string_view key) {
    for (const LayerInfo& info : all_layers)
      if (info.key == key) {
        toggle(info.layer);
        return true;
      }
    return false;
  }

 private:
  std::array<bool, all_layers.size()> on_{};
};

}  // namespace ticktrue::play
