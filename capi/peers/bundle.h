// Writes a bundle: this player's ticks since all agreed, and what is known of the others, in one trace.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"
#include "capi/peers/peers.h"
#include "replay/format/trace.h"

namespace ticktrue::capi {

/// Where the ticks of a bundle come from: the file that the session records, else the ticks in memory.
struct BundleSource {
  std::string recording;  // empty: there is none
  bool is_box = false;
  replay::TraceSetup game;  // of the ticks in memory
  replay::BuildFacts facts;
};

struct WrittenBundle {
  std::uint64_t first_tick = 0;
  std::uint64_t end = 0;         // behind the last tick
  bool has_save = false;         // at its begin
  bool is_of_recording = false;  // else of the ticks in memory
  std::string missing;           // why it is of less than it could be; may be empty
};

/// Requires: peers.has_desync() and a game. Errors: io, limit, usage (no tick at hand).
Result<WrittenBundle> write_bundle(const std::string& path, bool overwrite, const BundleSource& source, Peers& peers,
                                   const RowNamer& row_name);
/// A line for the report of the session.
std::string bundle_text(const std::string& path, const WrittenBundle& written);

}  // namespace ticktrue::capi
