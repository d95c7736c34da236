// What the law of soft constraints sees of a world after a tick. For constraint_law.cpp and unmeetable.cpp alone.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <vector>

#include "engine/math/union_find.h"
#include "tool/experiment/oracle/constraint_law.h"
#include "tool/expression/named_table.h"

namespace ticktrue::soak {

inline constexpr double infinite = std::numeric_limits<double>::infinity();

inline constexpr double size_share = 0.025;  // what located bounces leave, 0.02 sizes, and the slop, 0.005
inline constexpr double epsilon_count = 16;  // roundings of a coordinate

inline bool is_dynamic(const engine::BodyReport& body) {
  return body.type == engine::BodyType::dynamic_body;
}

inline engine::Point velocity_at(const engine::BodyReport& body, const engine::Point& p) {
  const engine::Point arm{p.x - body.center.x, p.y - body.center.y};
  return {body.velocity.x - body.angular_velocity * arm.y, body.velocity.y + body.angular_velocity * arm.x};
}

inline bool overlaps(const engine::ContactReport& contact) {
  return contact.separation[0] < 0 || (contact.point_count == 2 && contact.separation[1] < 0);
}

/// Sets of bodies that are tied together.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t of(std::uint32_t i) { return engine::find_root(parent_, i); }
  void tie(std::uint32_t a, std::uint32_t b) { engine::unite(parent_, a, b); }

 private:
  std::vector<std::uint32_t> parent_;
};

/// The world at the end of a tick.
struct TickView {
  const engine::Scene& scene;
  double dt;
  tool::Bodies bodies;
  std::vector<engine::ContactReport> contacts;
  tool::NamedTable joints;
  std::map<std::uint32_t, std::uint32_t> index;  // [body id]
  std::vector<double> h;                         // [body], s
  std::vector<ConstraintLaw::Extent> extents;    // [body]
  std::vector<std::uint8_t> is_asleep;           // [body]
  std::vector<double> moved;                     // [body], in this tick, m: no point of it more
  double push_share;                             // of a push that moves bodies

  double substep_of(std::uint32_t a, std::uint32_t b) const {
    return std::max(is_dynamic(bodies[a]) ? h[a] : 0, is_dynamic(bodies[b]) ? h[b] : 0);
  }
  /// The rounding of the positions of two bodies, m. Each tick rounds them once.
  double rounding_of(std::uint32_t a, std::uint32_t b) const {
    const double epsilon = scene.settings.precision == engine::Precision::f32
                               ? double{std::numeric_limits<float>::epsilon()}
                               : std::numeric_limits<double>::epsilon();
    double coordinates = 0;
    for (const std::uint32_t i : {a, b}) coordinates += std::fabs(bodies[i].center.x) + std::fabs(bodies[i].center.y);
    return epsilon * coordinates;
  }
  /// The error that is no matter, m.
  double slack_of(std::uint32_t a, std::uint32_t b) const {
    return size_share * std::min(extents[a].size, extents[b].size) + epsilon_count * rounding_of(a, b);
  }
  /// The error below which the scene asks for no more substeps, m.
  double target_error_of(std::uint32_t a, std::uint32_t b) const {
    const auto& automatic = scene.settings.auto_substeps;
    return automatic ? automatic->target_error * std::min(extents[a].size, extents[b].size) : 0;
  }
  /// What bodies that sleep may be off by, m: what was pushed out no faster than the scene takes for rest.
  double asleep_slack_of(std::uint32_t a, std::uint32_t b, double bias_rate) const {
    const int count = is_asleep[a] + is_asleep[b];
    return count > 0 ? count * scene.settings.sleep->speed_max / (bias_rate * push_share) : 0;
  }
  bool is_fixed(std::uint32_t a, std::uint32_t b) const { return !is_dynamic(bodies[a]) && !is_dynamic(bodies[b]); }
};

/// Calls tie(a, b) for the moving bodies of each joint.
template <typename Tie>
void tie_joined(const TickView& view, const Tie& tie) {
  for (std::uint32_t i = 0; i < view.joints.row_count(); ++i) {
    std::optional<std::uint32_t> last;
    engine::for_each_body(view.scene, view.scene.joints[view.joints.whole(i, "joint")], [&](std::uint32_t id) {
      const std::uint32_t body = view.index.at(id);
      if (!is_dynamic(view.bodies[body])) return;
      if (last) tie(*last, body);
      last = body;
    });
  }
}

/// Calls tie(a, b) for moving bodies that overlap.
template <typename Tie>
void tie_touching(const TickView& view, const Tie& tie) {
  for (const engine::ContactReport& contact : view.contacts) {
    const std::uint32_t a = view.index.at(contact.body_a), b = view.index.at(contact.body_b);
    if (overlaps(contact) && is_dynamic(view.bodies[a]) && is_dynamic(view.bodies[b])) tie(a, b);
  }
}

}  // namespace ticktrue::soak
