// Makes a complete trace of a black box.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "replay/trace_reader.h"

namespace ticktrue::replay {

/// Whether the file begins as a black box. False also where it cannot be read.
bool is_box_file(const std::string& path);

struct RecoveredBox {
  RecoverResult result;
  std::uint64_t first_tick = 0;
  bool was_closed = false;            // by its session
  bool has_save = false;              // at the first checkpoint: it can be run again from there
  std::vector<std::string> left_out;  // slots that are not in the trace, and why
};

/// Copies the slots that go on from each other up to the last tick; of a damaged one what stands before the damage.
/// Reads one slot at a time; no more than the file has is held. No file is written where no tick is intact. Errors: io;
/// corrupt (no slot can be read), incompatible, usage (the output is the box).
Result<RecoveredBox> recover_box(const std::string& input, const std::string& output, bool overwrite);

/// The same of the box of a session that goes on: the trace ends as a complete one, behind the last whole tick.
Result<RecoveredBox> save_box(const std::string& input, const std::string& output, bool overwrite);
/// The same into memory.
Result<Bytes> save_box(const std::string& input);

}  // namespace ticktrue::replay
