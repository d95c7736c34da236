// A tick of a session: what recording and comparing are given of it.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/result.h"
#include "base/state_view.h"

namespace ticktrue::capi {

/// A tick that has run. Views are valid during the call.
struct DoneTick {
  std::uint64_t tick = 0;
  double dt = 0;  // s
  ByteView inputs;
  std::vector<std::uint64_t> stage_hashes;  // empty unless wanted
  const StateView* state = nullptr;         // after it
};

/// The name of a row, empty where it has none: table, row.
using RowNamer = std::function<std::string(std::size_t table, std::size_t row)>;

/// What a program says of itself.
struct Identity {
  std::string name;
  std::uint32_t version = 0;
  std::string build;
};

/// "table balls, row 3 (player 2), column velocity, lane 1".
std::string place_text(const StateSchema& schema, const StatePlace& place, const RowNamer& row_name);

/// How the calling thread's floats deviate from IEEE 754's defaults, in words; empty if they do not.
std::string float_deviation();

}  // namespace ticktrue::capi
