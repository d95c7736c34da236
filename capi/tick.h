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

/// The program's data about a state, besides the judged columns. Null: no data.
struct CheckpointContents {
  const Bytes* save = nullptr;
  const Bytes* shown = nullptr;  // encoded
};

/// A tick that has run. Views are valid during the call.
struct DoneTick {
  std::uint64_t tick = 0;
  double dt = 0;  // s
  ByteView inputs;
  std::vector<std::uint64_t> stage_hashes;  // empty unless requested
  const StateView* state = nullptr;         // after the tick
  CheckpointContents contents = {};
  const BoundContents* bound = nullptr;
  std::uint64_t root_hash = 0;  // of the state
};

/// The program's statement about itself.
struct Identity {
  std::string name;
  std::uint32_t version = 0;
};

/// The float settings of the calling thread that differ from the IEEE 754 defaults, as text; empty: none.
std::string float_deviation();

}  // namespace ticktrue::capi
