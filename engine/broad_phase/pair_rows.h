// Proxies and pairs, and what broad phases keep of them and work with.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "engine/broad_phase/box_tree.h"
#include "engine/model/state.h"

namespace ticktrue::engine::TICKTRUE_PRECISION {

/// One convex shape of one body in the world. In (body row, child) order, so that comparing indices compares shape ids.
/// Shapes that can meet nothing in their scene have none.
struct Proxy {
  std::uint32_t body;   // row in State::bodies
  std::uint32_t shape;  // in Model::shapes
  std::uint32_t child;  // index in the body
  bool is_dynamic;
  bool is_static;
  bool is_sensor;
  bool is_line;
  Filter filter;
  Real ccd_margin;  // m: so much of its box is there for what must not be passed through alone; < 0: all is for
                    // everything
};

/// Two proxies that may touch, first < second.
struct Pair {
  std::uint32_t first;
  std::uint32_t second;
};

/// The pose that the boxes of a body were made for, and how long they hold its shapes: while its points have moved by
/// less than `room` and it is slower than `speed`.
struct BoxedBody {
  Vec2 position;
  Rotation rotation;
  Real extent;  // m, BodyModel's
  Real margin;  // m
  Real speed;   // m/s, of any of its points, as its velocities bound it
};

/// What aabb_tree keeps: boxes that are too large on purpose, and which of them overlap. As long as every shape is
/// inside its large box, the pairs that may touch are among these.
struct PairCache {
  bool is_valid = false;
  Real dt = 0;                    // s, for which `boxes` hold
  Real gravity_displacement = 0;  // m, likewise
  Real farthest = 0;              // m, likewise
  std::vector<BodyRow> bodies;    // as the boxes below were made
  std::vector<std::uint8_t>
      is_unchanged;  // [body] its pose (where contacts are foreseen: all of it) has the bits of the tick before
  std::uint32_t body_set = 0;              // another number in each tick that has other bodies than the one before
  std::size_t static_count = 0;            // of bodies
  bool many_are_unchanged = false;         // of the others
  std::vector<std::uint32_t> first_proxy;  // [body], one more at the end
  std::vector<Proxy> proxies;
  std::vector<std::uint8_t> box_flags;  // [body] bits: how its boxes were made (aabb_tree.cpp)
  bool any_ccd_margin = false;
  bool any_swept = false;
  std::vector<Box> boxes;                    // [proxy] m, hold the shapes with their margins, and room to move
  std::vector<BoxedBody> boxed;              // [body] of those whose boxes have room
  std::vector<Box> fat_boxes;                // [proxy]
  std::vector<Pair> pairs;                   // of large boxes that overlap, by (first, second)
  std::vector<Pair> merged;                  // the rows that replace them
  std::vector<Pair> present;                 // of them, those whose boxes overlap
  bool has_present = false;                  // those of the last tick
  bool present_unchanged = false;            // they are those of the tick before
  std::vector<std::uint8_t> is_moved_proxy;  // [proxy] has left the large box that is in the tree; 2: in this tick
  std::vector<std::uint32_t> moved_proxies;
  std::vector<std::uint32_t> leaving;   // proxies that are not inside their large boxes
  bool has_pairs = false;               // `pairs`, large boxes and trees are those of these proxies
  std::uint32_t ticks_since_build = 0;  // since they were built
  std::uint32_t high_churn_ticks = 0;   // for so many no pairs are kept
  Real common_side = 0;                 // m, of their boxes (neighbour_cells.h)
  BoxTree moving_tree;
  BoxTree static_tree;
};

/// Where lower corners are, m.
struct Spread {
  Vec2 lowest{Real(1e38), Real(1e38)};
  Vec2 highest{Real(-1e38), Real(-1e38)};
};

/// What some boxes are like together.
struct BoxOutline {
  Spread spread;      // of those that fit into cells
  Real farthest = 0;  // m, any looks ahead
  bool any_ccd_target = false;
};

/// Where a range of pairs is sorted.
struct PairSorter {
  std::vector<Pair> pairs;
  std::vector<Pair> by_second;
  std::vector<std::uint32_t> start;  // [proxy]
};

/// Where a box in the order of cells comes from.
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
