// Makes poses small numbers: rounding to a grid, prediction from the two previous frames.
// SPDX-License-Identifier: MIT
//
// page_base.js decodes this format: change both together. Packed by zlib the numbers of four golden traces take 0.7 to
// 1.35 of the bytes of Rice codes, which an earlier version had: at most 3 % of a page.
//
// For each body, then for each of x, y and angle: the values at the frames in which the body is there, whole numbers of
// the grid. A value is predicted to move on as it did between the two frames before, in proportion to their ticks. The
// difference from that becomes a number without sign (0, -1, 1, -2, ... become 0, 1, 2, 3, ...) of 7 bits a byte, low
// bits first, the top bit set on all but the last.
#pragma once

#include <cstdint>
#include <vector>

#include "base/bytes.h"
#include "tool/report_page/animation.h"

namespace ticktrue::tool {

/// The grid to which poses are rounded.
struct PoseGrid {
  double length = 1;              // m; a power of two
  std::uint32_t angle_count = 1;  // steps of a full turn; a power of two
};

/// So fine that rounding is invisible even if the smallest moving body fills the screen.
PoseGrid choose_grid(const Animation& animation);

/// Consecutive frames in which a body exists.
struct BodyFrames {
  std::uint32_t first = 0;  // index of a frame
  std::uint32_t count = 0;
};

struct CodedFrames {
  std::vector<std::vector<BodyFrames>> presence;  // [body]
  Bytes numbers;
};

/// `body_count`: number of bodies that the poses refer to.
CodedFrames code_frames(const std::vector<Frame>& frames, std::size_t body_count, const PoseGrid& grid);

/// A pose in grid steps.
struct GridPose {
  std::int32_t x = 0, y = 0, angle = 0;
};
GridPose to_grid(const Pose& pose, const PoseGrid& grid);

std::string base64(ByteView bytes);

}  // namespace ticktrue::tool
