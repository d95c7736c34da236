// Building of trees of boxes.
// SPDX-License-Identifier: MIT
#include "engine/broad_phase/box_tree.h"

#include "engine/broad_phase/broad_phase.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

namespace {

constexpr int coordinate_bits = 27;  // of a centre along one axis, within the box of all centres

/// The bits of `value` with a zero after each.
std::uint64_t spread_bits(std::uint64_t value) {
  value = (value | value << 16) & 0x0000ffff0000ffffull;
  value = (value | value << 8) & 0x00ff00ff00ff00ffull;
  value = (value | value << 4) & 0x0f0f0f0f0f0f0f0full;
  value = (value | value << 2) & 0x3333333333333333ull;
  return (value | value << 1) & 0x5555555555555555ull;
}

/// Enlarges `box` to include `other`. A NaN changes nothing.
void include(Box& box, const Box& other) {
  if (other.lower.x < box.lower.x) box.lower.x = other.lower.x;
  if (other.lower.y < box.lower.y) box.lower.y = other.lower.y;
  if (other.upper.x > box.upper.x) box.upper.x = other.upper.x;
  if (other.upper.y > box.upper.y) box.upper.y = other.upper.y;
}

/// Sorts proxies along the Morton curve through the middles of their boxes.
void sort_along_curve(std::span<const Box> boxes, std::vector<SortEntry>& entries, std::vector<SortEntry>& buffer) {
  const auto middle = [&](const SortEntry& entry) {
    const Box& box = boxes[entry.proxy];
    return Real(0.5) * (box.lower + box.upper);
  };
  Box middles = empty_box;
  for (const SortEntry& entry : entries) include(middles, {middle(entry), middle(entry)});
  constexpr Real limit = Real(1 << coordinate_bits);
  const Vec2 extent = middles.upper - middles.lower;
  const Real scale = limit / larger(larger(extent.x, extent.y), Real(1e-30));
  const auto last = static_cast<std::int32_t>(limit) - 1;
  const auto coordinate = [&](Real value) {
    const std::int32_t whole = clamped_floor(value, limit);
    return static_cast<std::uint64_t>(whole < 0 ? 0 : (whole > last ? last : whole));
  };
  for (SortEntry& entry : entries) {
    const Vec2 place = scale * (middle(entry) - middles.lower);
    entry.key = spread_bits(coordinate(place.x)) | spread_bits(coordinate(place.y)) << 1;
  }
  sort_entries(entries, buffer, 2 * coordinate_bits);
}

}  // namespace

void build_tree(std::span<const Box> boxes, std::vector<SortEntry>& entries, std::vector<SortEntry>& buffer,
                BoxTree& tree) {
  sort_along_curve(boxes, entries, buffer);
  tree.boxes.clear();
  tree.proxies.clear();
  tree.level_start.clear();
  tree.level_start.push_back(0);
  for (const SortEntry& entry : entries) {
    tree.boxes.push_back(boxes[entry.proxy]);
    tree.proxies.push_back(entry.proxy);
  }
  auto begin = std::uint32_t{0};
  auto end = static_cast<std::uint32_t>(tree.boxes.size());
  while (end - begin > 1) {
    tree.level_start.push_back(end);
    for (std::uint32_t first = begin; first < end; first += fan_out) {
      Box box = empty_box;
      for (std::uint32_t i = first; i < end && i < first + fan_out; ++i) include(box, tree.boxes[i]);
      tree.boxes.push_back(box);
    }
    begin = end;
    end = static_cast<std::uint32_t>(tree.boxes.size());
  }
  tree.level_start.push_back(end);
}

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
