// The peers: Box2D 2.4.1 in this process, Box2D 3 in a child process.
// SPDX-License-Identifier: MIT
#include "tool/crosscheck/peers.h"

#include <algorithm>
#include <utility>

#include "tool/box2d3/box2d3_peer.h"

namespace ticktrue::tool {
namespace {

Result<std::string> version_of_box2d2() {
  std::string version = box2d_version();
  if (version.empty()) return make_box2d_peer(engine::Scene{}).error();
  return version;
}

Result<std::unique_ptr<Box2dPeer>> make_box2d2(const engine::Scene& scene, const PeerRun& run) {
  Box2dOptions options;
  options.steps_per_tick = run.steps_per_tick;
  options.match_skin = run.match_skin;
  return make_box2d_peer(scene, options);
}

double rigid_contacts(double) {
  return 0;
}

Result<std::unique_ptr<Box2dPeer>> make_box2d3(const engine::Scene& scene, const PeerRun& run) {
  Box2d3Options options;
  options.steps_per_tick = run.steps_per_tick;
  Box2d3Plan plan;
  plan.tick_count = run.tick_count;
  plan.contact_window = run.contact_window;
  plan.contact_interval = run.contact_interval;
  Result<std::unique_ptr<Box2d3Peer>> made = make_box2d3_peer(scene, options, plan);
  if (!made) return made.error();
  return std::unique_ptr<Box2dPeer>(*std::move(made));
}

// Box2D 3's default, limited to a quarter of the rate of substeps.
double soft_contacts(double dt) {
  return std::min(30.0, 0.25 * Box2d3Options{}.substeps / dt);
}

}  // namespace

const std::array<PeerInfo, 2> peers{{
    {PeerKind::box2d2, "box2d2", "Box2D 2.4.1, in this process", "8/3 iterations", "2 m or 90 degrees a step",
     version_of_box2d2, make_box2d2, rigid_contacts},
    {PeerKind::box2d3, "box2d3", "Box2D 3, as installed, or npm's box2d3-wasm in node", "4 substeps",
     "400 m/s or 45 degrees a substep", box2d3_version, make_box2d3, soft_contacts},
}};

}  // namespace ticktrue::tool
