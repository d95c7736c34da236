// Golden traces: a directory of traces, and a manifest with the recording command and the final state of each.
// SPDX-License-Identifier: MIT
//
// MANIFEST.tsv: lines of tab-separated columns file, scene, inputs, ticks, detail, hash, bytes, why; lines that begin
// with # and the line of the column names are kept as they are. inputs -: none. ticks -: to the `end` input.
// hash -: a trace that is still to be recorded. scene `command:./mygame --verify {}`: the program that recorded the
// trace verifies it, and it has no inputs and ticks of its own. scene `plugin:SETUP`: of the plug-in that is loaded.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "replay/trace_reader.h"

namespace ticktrue::verifier {

inline constexpr const char* manifest_name = "MANIFEST.tsv";

inline constexpr std::string_view golden_command = "command:";
inline constexpr std::string_view golden_plugin = "plugin:";

struct GoldenRow {
  std::string file;  // name in the directory
  std::string scene;
  std::string inputs;                       // empty: none
  std::optional<std::uint64_t> tick_count;  // absent: to the `end` input
  std::string detail;
  std::string hash;        // root hash after the last tick, 16 digits; "-": not recorded yet
  std::uint64_t size = 0;  // bytes
  std::string why;
  std::string before;  // lines that stand above it in the manifest

  /// Verified by a program of its own, whose words these are; empty: a scene.
  std::string_view command() const {
    const bool is_command = scene.compare(0, golden_command.size(), golden_command) == 0;
    return is_command ? std::string_view(scene).substr(golden_command.size()) : std::string_view();
  }
  /// Recorded by a plug-in from this setup, a file or a word, which may be empty; nothing: it is not.
  std::optional<std::string_view> plugin_setup() const {
    if (scene.compare(0, golden_plugin.size(), golden_plugin) != 0) return std::nullopt;
    return std::string_view(scene).substr(golden_plugin.size());
  }
};

struct GoldenManifest {
  std::vector<GoldenRow> rows;
  std::string after;  // lines below the last row
};

/// Errors: invalid_input, with the line.
Result<GoldenManifest> parse_manifest(std::string_view text, const std::string& name);
std::string manifest_text(const GoldenManifest& manifest);

/// Adds the row behind all others. Errors: usage (a name that is taken; texts that do not come back from the file as
/// they are, such as one with a tab).
Status add_row(GoldenManifest& manifest, GoldenRow row, const std::string& name);

/// "137..599, 601 of 700" ticks whose root hashes differ, from the start of both; a tick only one has counts as
/// differing. Empty: none.
std::string changed_ticks(replay::TraceReader& a, replay::TraceReader& b);

}  // namespace ticktrue::verifier
