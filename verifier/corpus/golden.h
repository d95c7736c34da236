// Golden traces: a directory of traces, and a manifest with the recording command and the final state of each.
// SPDX-License-Identifier: MIT
//
// MANIFEST.tsv: lines of tab-separated columns file, scene, inputs, ticks, detail, hash, bytes, why. Lines that begin
// with # and the line of column names are kept. inputs -: none. ticks -: up to the `end` input. hash -: the trace is
// not recorded yet. scene `command:./mygame --verify {}`: the program that recorded the trace verifies it; inputs and
// ticks come from the program. scene `plugin:SETUP`: the setup of the loaded plug-in.
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
  std::string file;  // name inside the directory
  std::string scene;
  std::string inputs;                       // empty: none
  std::optional<std::uint64_t> tick_count;  // absent: up to the `end` input
  std::string detail;
  std::string hash;        // root hash after the last tick, 16 digits; "-": not recorded yet
  std::uint64_t size = 0;  // bytes
  std::string why;
  std::string before;  // the lines above it in the manifest

  /// The words of the program that verifies this trace; empty: the tool verifies it.
  std::string_view command() const {
    const bool is_command = scene.compare(0, golden_command.size(), golden_command) == 0;
    return is_command ? std::string_view(scene).substr(golden_command.size()) : std::string_view();
  }
  /// The setup for the plug-in that recorded the trace: a file or a word, which may be empty; nothing: no plug-in.
  std::optional<std::string_view> plugin_setup() const {
    if (scene.compare(0, golden_plugin.size(), golden_plugin) != 0) return std::nullopt;
    return std::string_view(scene).substr(golden_plugin.size());
  }
};

struct GoldenManifest {
  std::vector<GoldenRow> rows;
  std::string after;  // lines below the last row
};

/// Errors: invalid_input, with the line number.
Result<GoldenManifest> parse_manifest(std::string_view text, const std::string& name);
std::string manifest_text(const GoldenManifest& manifest);

/// Appends the row. Errors: usage (an existing name; a text that cannot be read back from the file, such as a text with
/// a tab).
Status add_row(GoldenManifest& manifest, GoldenRow row, const std::string& name);

/// The ticks with different root hashes, such as "137..599, 601 of 700", from the start of both traces. A tick in only
/// one trace counts as different. Empty: no difference.
std::string changed_ticks(replay::TraceReader& a, replay::TraceReader& b);

}  // namespace ticktrue::verifier
