// A tick of a session, as passed to recording and comparing.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state/row_names.h"
#include "base/state/state_view.h"
#include "capi/marks/marks.h"

namespace ticktrue::capi {

/// What a program gives for a state beside the judged columns. Null: nothing.
struct CheckpointContents {
  const Bytes* save = nullptr;
  const Bytes* shown = nullptr;  // encoded
};

/// A tick that has run. Views are valid during the call.
struct DoneTick {
  std::uint64_t tick = 0;
  double dt = 0;  // s
  ByteView inputs;
  std::vector<std::uint64_t> stage_hashes;  // empty unless wanted
  const StateView* state = nullptr;         // after it
  CheckpointContents contents = {};
  const BoundContents* bound = nullptr;
  std::uint64_t root_hash = 0;  // of the state
};

/// What a program says of itself.
struct Identity {
  std::string name;
  std::uint32_t version = 0;
};

/// How the calling thread's floats deviate from IEEE 754's defaults, as text; empty if they do not.
std::string float_deviation();

}  // namespace ticktrue::capi
