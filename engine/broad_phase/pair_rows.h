// Proxies and pairs, and the caches and workspaces of broad phases.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "engine/broad_phase/box_tree.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// A convex shape of a body in the world. Proxies are in (body row, child) order, so that comparing indices compares
/// shape ids. A shape that can touch nothing in its scene has no proxy.
struct Proxy {
  std::uint32_t body;   // row in State::bodies
  std::uint32_t shape;  // in Model::shapes
  std::uint32_t child;  // index in the body
  bool is_dynamic;
  bool is_static;
  bool is_sensor;
  bool is_line;
  Filter filter;
  Real ccd_margin;  // m: part of its box that counts against CCD targets only; < 0: a CCD target, all of its box counts
};

/// Two proxies that may touch, first < second.
struct Pair {
  std::uint32_t first;
  std::uint32_t second;
};

/// The pose for which the tight AABBs of a body were made. They are valid while its points have moved by less than
/// `margin` and it is slower than `speed`.
struct BoxedBody {
  Vec2 position;
  Rotation rotation;
  Real extent;  // m, of BodyModel
  Real margin;  // m
  Real speed;   // m/s, upper bound for any of its points
};

/// The cache of aabb_tree: fat AABBs, and pairs of them that overlap. While each shape is inside its fat AABB, all
/// pairs that may touch are among these.
struct PairCache {
  bool is_valid = false;
  Real dt = 0;                             // s, for which `boxes` are valid
  Real gravity_displacement = 0;           // m, likewise
  Real farthest = 0;                       // m, likewise
  std::vector<BodyRow> bodies;             // at the last update of the boxes
  std::vector<std::uint8_t> is_unchanged;  // [body] pose (with speculative contacts: row) is that of the tick before
  std::uint32_t body_set = 0;              // changes with the set of bodies
  std::size_t static_count = 0;            // of bodies
  bool many_are_unchanged = false;         // of the others
  std::vector<std::uint32_t> first_proxy;  // [body], one more at the end
  std::vector<Proxy> proxies;
  std::vector<std::uint8_t> box_flags;  // [body] bits (aabb_tree.cpp)
  bool any_ccd_margin = false;
  bool any_swept = false;
  std::vector<Box> boxes;          // [proxy] m, tight AABBs: with the margins of the shapes, and a margin of motion
  std::vector<BoxedBody> boxed;    // [body] if its boxes have a margin of motion
  std::vector<Box> fat_boxes;      // [proxy]
  std::vector<Pair> pairs;         // overlapping fat AABBs, by (first, second)
  std::vector<Pair> merged;        // replaces `pairs`
  std::vector<Pair> present;       // the pairs whose tight AABBs overlap
  bool has_present = false;        // `present` is that of the last tick
  bool present_unchanged = false;  // `present` is unchanged
  std::vector<std::uint8_t> is_moved_proxy;  // [proxy] has left the fat AABB in the tree; 2: in this tick
  std::vector<std::uint32_t> moved_proxies;
  std::vector<std::uint32_t> leaving;   // proxies outside of their fat AABBs
  bool has_pairs = false;               // `pairs`, fat AABBs and trees are valid
  std::uint32_t ticks_since_build = 0;  // of `pairs`
  std::uint32_t high_churn_ticks = 0;   // left in which no pairs are cached
  Real common_side = 0;                 // m, of their boxes (neighbour_cells.h)
  BoxTree moving_tree;
  BoxTree static_tree;
};

/// The extent of lower corners, m.
struct Spread {
  Vec2 lowest{Real(1e38), Real(1e38)};
  Vec2 highest{Real(-1e38), Real(-1e38)};
};

/// Properties of some boxes.
struct BoxOutline {
  Spread spread;      // of those that fit into cells
  Real farthest = 0;  // m, the largest CCD margin
  bool any_ccd_target = false;
};

/// The workspace in which a range of pairs is sorted.
struct PairSorter {
  std::vector<Pair> pairs;
  std::vector<Pair> by_second;
  std::vector<std::uint32_t> start;  // [proxy]
};

/// The proxy and the cell of a box in the order of cells.
struct SweptPlace {
  std::uint32_t proxy;
  std::uint32_t cell;
};

/// The cells of the uniform grid that a proxy's box overlaps, both ends included.
struct CellRange {
  std::int32_t first_x;
  std::int32_t first_y;
  std::int32_t last_x;
  std::int32_t last_y;
};

/// A proxy in one cell.
struct CellEntry {
  std::int32_t x;
  std::int32_t y;
  std::uint32_t proxy;
};

/// Where a proxy is in this tick.
struct Circle {
  Vec2 center;  // world, m
  Real radius;  // with margin, m
};

}  // namespace ticktrue::engine::TICKTRUE_PRECISION
