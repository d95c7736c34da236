// Makes a complete trace from a black box.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "replay/trace_reader.h"

namespace ticktrue::replay {

/// Whether the file begins as a black box. False also if the file cannot be read.
bool is_box_file(const std::string& path);

struct RecoveredBox {
  RecoverResult result;
  std::uint64_t first_tick = 0;
  bool was_closed = false;            // by its session
  bool has_save = false;              // of the first checkpoint: a run can begin there
  std::vector<std::string> left_out;  // slots that the trace lacks, and why
};

/// Copies the contiguous slots up to the last tick. Of a damaged slot, the part before the damage is copied. Only one
/// slot at a time is in memory. No file is written if no tick is intact. Errors: io; corrupt (no slot can be read),
/// incompatible, usage (the output is the box).
Result<RecoveredBox> recover_box(const std::string& input, const std::string& output, bool overwrite);

/// Does the same for the box of a running session. The trace ends as a complete trace, after the last complete tick.
Result<RecoveredBox> save_box(const std::string& input, const std::string& output, bool overwrite);
/// Returns the trace as bytes.
Result<Bytes> save_box(const std::string& input);

}  // namespace ticktrue::replay
