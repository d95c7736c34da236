// The engines that scenes are compared with: one table of peers.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "base/result.h"
#include "engine/scene/choices.h"
#include "tool/box2d/box2d_peer.h"

namespace ticktrue::tool {

enum class PeerKind : std::uint8_t { box2d2, box2d3 };

/// One run of a scene in a peer.
struct PeerRun {
  int steps_per_tick = 1;   // more: smaller steps, but the same ticks
  bool match_skin = false;  // Box2dOptions::match_skin; without effect in peers without a skin
  std::uint64_t tick_count = 0;
  // Contacts are asked for within so many ticks before the end, at the last of them and so many ticks apart.
  std::uint64_t contact_window = 0;
  std::uint64_t contact_interval = 1;
};

struct PeerInfo {
  PeerKind kind;
  std::string_view name;  // on the command line and in JSON
  std::string_view summary;
  std::string_view settings;  // of a step, for people
  std::string_view cut;       // movements that the peer cuts, for people
  /// Without "Box2D". Errors: unsupported, usage (the peer is not available here, and how to get it).
  Result<std::string> (*version)();
  /// At most PeerRun::tick_count steps. Errors: unsupported (the scene cannot be represented), others of the run
  /// itself.
  Result<std::unique_ptr<Box2dPeer>> (*make)(const engine::Scene& scene, const PeerRun& run);
  /// Softness of contacts for a step of `dt` seconds, Hz; 0: rigid.
  double (*contact_hertz)(double dt);
};
extern const std::array<PeerInfo, 2> peers;

}  // namespace ticktrue::tool
