// Lengths of a host's frames: the wall clock, seeded models of displays, or a file.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/random.h"
#include "base/result.h"
#include "tool/session/input_source.h"

namespace ticktrue::tool {

enum class HostKind : std::uint8_t { wall, steady_30, steady_60, steady_144, jitter_60, stutter };

struct HostInfo {
  HostKind kind;
  std::string_view name;     // value of --host
  std::string_view summary;  // one line for the help text
};
inline constexpr std::array<HostInfo, 6> hosts{{
    {HostKind::wall, "wall", "60 frames a second, as long as they really take"},
    {HostKind::steady_30, "steady_30", "1/30 s each"},
    {HostKind::steady_60, "steady_60", "1/60 s each"},
    {HostKind::steady_144, "steady_144", "1/144 s each"},
    {HostKind::jitter_60, "jitter_60", "1/60 s, each 4 ms longer or shorter at most, by chance"},
    {HostKind::stutter, "stutter", "as jitter_60; each fiftieth, by chance, is 50 to 200 ms long"},
}};

class HostFrames {
 public:
  virtual ~HostFrames() = default;
  /// Length of the next frame, s, > 0; absent at the end of a file. Errors: io, invalid_input.
  virtual Result<std::optional<double>> next() = 0;
  virtual bool repeatable() const = 0;
};

/// `host`: a name of the table, or a file with one frame time per line, s. Errors: io.
Result<std::unique_ptr<HostFrames>> open_host(const std::string& host, std::uint64_t seed);

/// Whether several runs can read the frames of `host`, each from the beginning. Reads a file to its end. Errors: io,
/// invalid_input; usage (a file that can be read only once).
Status check_host(const std::string& host, std::uint64_t seed);

/// Frames of equal length.
std::unique_ptr<HostFrames> steady_frames(double seconds);

}  // namespace ticktrue::tool
