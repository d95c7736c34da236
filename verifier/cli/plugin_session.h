// `run` and `record` of a plug-in's simulation: setup and inputs as bytes, since only the plug-in knows what they mean.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "verifier/session.h"

namespace ticktrue::cli {

struct PluginSession {
  std::string scene;   // the setup: the bytes of this file, or of the word itself where there is none
  std::string inputs;  // JSON Lines {"tick": N, "bytes": "hex"}, ticks ascending; "dt": s, from that tick on; or empty
  std::optional<std::uint64_t> tick_count;
  verifier::TraceChoices choices;  // record
  std::string output;              // record
  bool compress = true;
  bool force = false;
  bool json = false;
};

/// Whether SCENE is meant for a plug-in.
bool has_plugin();
/// The exit code. Require: has_plugin().
int run_plugin(const PluginSession& session);
int record_plugin(const PluginSession& session);

}  // namespace ticktrue::cli
