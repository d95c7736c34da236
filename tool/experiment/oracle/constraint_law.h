// Compares overlaps and joint gaps of a run with the law of soft constraints: docs/soak.md, Overlaps and gaps.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/engine.h"
#include "tool/study/measures.h"

namespace ticktrue::soak {

/// A contact or a joint that is further off than the law allows, for longer than the law allows.
struct Breach {
  std::uint32_t first = 0;   // contact: id of body A; joint: its index in the scene
  std::uint32_t second = 0;  // contact: id of body B
  std::uint64_t tick = 0;    // at whose end the allowed time is over
  double error = 0;          // m, overlap or gap
  double tolerance = 0;      // m
  double yielded = 0;        // m, by the load
  double lasted_s = 0;       // for which the error was above tolerance and yield
  double allowed_s = 0;
};
std::string overlap_text(const Breach& breach);
std::string gap_text(const Breach& breach);

/// Whether docs/physics.md bounds overlaps and gaps of a world with these settings.
bool promises_accuracy(const engine::Settings& settings);

/// Follows a run of a solver with soft constraints tick by tick. The constants are those of docs/physics.md, so an
/// engine with other ones breaks the law.
class ConstraintLaw {
 public:
  /// The scene must outlive this object. Requires: promises_accuracy.
  explicit ConstraintLaw(const engine::Scene& scene) : scene_(scene) {}

  /// To be called after each tick, which has `dt` s.
  void look(const engine::Engine& engine, double dt);

  /// The first breach of the run.
  const std::optional<Breach>& overlap() const { return overlap_; }
  const std::optional<Breach>& gap() const { return gap_; }
  /// The energy that joints hold by what they are off, after the last look, J: that of springs of stiffness w^2 / K.
  double stored_energy() const { return stored_energy_; }

  /// Sizes of a body, m; infinity where lines alone have none.
  struct Extent {
    double size = 0;   // twice the radius of the largest circle inside its largest shape
    double reach = 0;  // the greatest distance of its points from its centre of mass
  };

 private:
  using Key = std::pair<std::uint32_t, std::uint32_t>;
  struct Clock {
    double lasted_s = 0;
    double allowed_s = 0;
    double error_max = 0;  // m
    double others_s = 0;   // the longest settling time of another error of its cluster so far
    bool is_running = false;
  };
  struct Pose {
    engine::Point center;
    double angle = 0;
  };

  const engine::Scene& scene_;
  std::map<std::uint32_t, Extent> extents_;  // [body id]
  std::map<std::uint32_t, Pose> poses_;      // [body id], of the tick before
  std::map<Key, Clock> contact_clocks_;      // [bodies]
  std::map<Key, Clock> joint_clocks_;        // [joint, 0]
  std::optional<Breach> overlap_;
  std::optional<Breach> gap_;
  double stored_energy_ = 0;
};

}  // namespace ticktrue::soak
