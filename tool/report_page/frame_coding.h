// Compresses poses: rounding to a grid, prediction from the two previous frames, Rice codes of the residuals.
// SPDX-License-Identifier: MIT
//
// Source: Rice, "Some Practical Universal Noiseless Coding Techniques", 1979.
// page_base.js decodes this format: change both together.
//
// For each body, then for each of x, y and angle: the values at the frames in which the body is there, whole numbers of
// the grid. A value is predicted to move on as it did between the two frames before, in proportion to their ticks. The
// differences from that come in blocks of 32: a bit 0 if all are 0; else a bit 1, five bits k, and each difference as a
// number without sign (0, -1, 1, -2, ... become 0, 1, 2, 3, ...): its high bits as so many bits 1 and a bit 0, then its
// k low bits. From 24 bits 1 on there is no bit 0, and the whole number follows in 32 bits. The first bit of a byte is
// its highest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/bytes.h"
#include "tool/report_page/animation.h"

namespace ticktrue::verifier {

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
  Bytes bits;
};

/// `body_count`: number of bodies that the poses refer to.
CodedFrames code_frames(const std::vector<Frame>& frames, std::size_t body_count, const PoseGrid& grid);

/// A pose in grid steps.
struct GridPose {
  std::int32_t x = 0, y = 0, angle = 0;
};
GridPose to_grid(const Pose& pose, const PoseGrid& grid);

/// Decodes poses: [body][frame in which the body exists]. For tests; missing bits count as zeros.
std::vector<std::vector<GridPose>> decode_frames(const CodedFrames& coded, std::span<const std::uint64_t> ticks_done);

std::string base64(ByteView bytes);

}  // namespace ticktrue::verifier
