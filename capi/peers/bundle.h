// Writes a bundle: one trace with this player's ticks since all players agreed, and what is known about the others.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>

#include "base/result.h"
#include "capi/peers/peers.h"
#include "replay/format/trace.h"

namespace ticktrue::capi {

/// The source of the ticks in a bundle: the file that the session records, else the ticks in memory.
struct BundleSource {
  std::string recording;  // empty: no recording
  bool is_box = false;
  replay::TraceSetup game;  // for the ticks in memory
  replay::BuildFacts facts;
};

struct WrittenBundle {
  std::uint64_t first_tick = 0;
  std::uint64_t end = 0;         // one after the last tick
  bool has_save = false;         // at its first tick
  bool is_of_recording = false;  // false: from the ticks in memory
  std::string missing;           // why the bundle contains less than it could; may be empty
};

/// Requires: peers.has_desync() and a game. Errors: io, limit, usage (no tick is available).
Result<WrittenBundle> write_bundle(const std::string& path, bool overwrite, const BundleSource& source, Peers& peers,
                                   const RowNamer& row_name);
/// The line in the report of the session.
std::string bundle_text(const std::string& path, const WrittenBundle& written);

}  // namespace ticktrue::capi
