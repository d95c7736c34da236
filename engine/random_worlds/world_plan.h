// The plan of a random world, drawn before any part of the world is made.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "base/random.h"
#include "engine/random_worlds/world_features.h"

namespace ticktrue::engine {

/// Draws of a seed. Every real number is computed from whole numbers by + - * /, so that it is the same on every
/// platform.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}

  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random_.below(count)); }
  int between(int low, int high) { return low + static_cast<int>(below(static_cast<std::uint32_t>(high - low + 1))); }
  bool chance(int percent) { return static_cast<int>(below(100)) < percent; }
  bool half() { return below(2) == 0; }
  /// A multiple of 1 / parts from low / parts to high / parts.
  double part(int low, int high, int parts) { return static_cast<double>(between(low, high)) / parts; }
  /// 2^low to 2^high.
  double power(int low, int high);
  template <std::size_t count>
  double one_of(const double (&values)[count]) {
    return values[below(count)];
  }
  template <typename List>
  auto& any(List& list) {
    return list[below(static_cast<std::uint32_t>(list.size()))];
  }

 private:
  Random random_;
};

struct WorldPlan {
  Settings settings;
  Point gravity;
  std::array<bool, world_feature_count> features{};
  std::vector<ShapeKind> shapes;
  std::vector<JointKind> joints;
  std::vector<ForceKind> forces;
  std::vector<InputKind> inputs;  // without `end`
  bool has_end = false;
  bool collides = true;                // false: no two shapes may touch
  bool is_quiet = false;               // a few bodies rest beside many that move in touch, and are pushed later
  std::uint32_t body_count = 2;        // without those of structures
  std::uint32_t link_count = 0;        // of a row of links; 0: none
  std::uint32_t plate_body_count = 0;  // of a plate under many bodies; 0: none
  std::uint32_t ring_body_count = 0;   // of a ring that closes in on a large body; 0: none
  std::uint32_t shot_count = 0;        // bodies, almost at rest, that an input shoots at a wall; 0: none
  std::uint32_t net_columns = 0;       // of a net of joints that is the whole world; 0: none
  std::uint32_t net_rows = 0;
  std::uint64_t tick_count = 1;

  bool has(WorldFeature feature) const { return features[static_cast<std::size_t>(feature)]; }
  const SolverInfo& solver() const { return info_of(solvers, settings.solver); }
  const IntegratorInfo& integrator() const { return info_of(integrators, settings.integrator); }
  /// Whether pointers and impulses of joints have an effect.
  bool carries_constraints() const { return solver().solves_constraints && integrator().carries_constraints; }
  bool carries_joints() const { return solver().solves_joints && integrator().carries_constraints; }
  /// Whether the solver supports only the thesis' features: circles, sharp polygons, no filters.
  bool is_plain() const { return solver().solves_constraints && !solver().reads_contacts; }
};

WorldPlan draw_plan(Draw& draw, const RandomWorldOptions& options);
/// Draws structures for a few worlds: long rows of links, bodies with many contacts, rings that close in on a large
/// body, shots at a wall, and nets of joints. The draws have their own stream, so that other worlds do not depend on
/// them.
void draw_structures(Draw draw, const RandomWorldOptions& options, WorldPlan& plan);

}  // namespace ticktrue::engine
