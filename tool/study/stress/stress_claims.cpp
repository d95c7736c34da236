// The claims of documents about stress cases: methods named as a cure, and methods that fall short.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "tool/study/stress/stress_parts.h"

namespace ticktrue::tool {
namespace {

using engine::Precision;

/// A method that `place` names as the cure. `cases` is the beginning of the names of the cases.
struct NamedCure {
  const char* cases;
  const char* method;
  const char* place;
};
constexpr NamedCure named_cures[]{
    {"tower", "tgs_soft auto", "README.md"},
    {"hanging", "tgs_soft auto", "README.md"},
    {"top_heavy", "tgs_soft auto", "docs/study.md"},
    {"swinging", "tgs_soft auto", "docs/study.md"},
    {"load_force", "tgs_soft auto", "docs/scenes.md"},
    {"load_input", "tgs_soft auto", "docs/scenes.md"},
    {"load_ram", "tgs_soft auto", "docs/scenes.md"},
    {"load_pointer", "tgs_soft auto", "docs/scenes.md"},
    {"load_pusher", "tgs_soft auto", "docs/scenes.md"},
    {"push_", "tgs_soft auto", "docs/scenes.md"},
    {"bridge_straight", "tgs_soft auto", "docs/physics.md"},
    {"floating", "tgs_soft auto", "docs/scenes.md"},
    {"pinned", "tgs_soft auto", "docs/scenes.md"},
    {"arm_", "tgs_soft auto", "docs/physics.md"},
    {"arm_stops", "tgs_soft direct", "docs/physics.md"},
    {"direct_gain", "velocity_verlet", "docs/physics.md"},
    {"direct_gain", "position_verlet", "docs/physics.md"},
    {"direct_gain", "rk4", "docs/physics.md"},
    {"direct_gain", "semi_implicit_euler", "docs/physics.md"},
};

constexpr const char* plate = "what a kinematic plate presses with is no load";
constexpr const char* pointer = "what a pointer pulls with is no load";
constexpr const char* coarse = "f32 rounds places far from the origin";
constexpr double rounding_step = 0.47;  // m/s: f32 places at 1e5 m are 1/128 m apart, and ticks 1/60 s
constexpr const char* whirl = "direct joints lose light links that whirl at 50 rad/s";
constexpr const char* drift = "iterative joints leave a gap at 4 substeps";

/// A method whose misses from `lower` to `upper` are documented.
struct NamedShortfall {
  const char* cases;
  const char* method;
  const char* reason;
  double lower;
  double upper;
  std::optional<Precision> precision = {};
};
constexpr NamedShortfall named_shortfalls[]{
    {"gain_prismatic", "velocity_verlet", drift, 0, 0.012},
    {"gain_prismatic", "position_verlet", drift, 0, 0.012},
    {"gain_prismatic", "rk4", drift, 0, 0.012},
    {"load_pointer", "tgs_soft", pointer, 1.2, 2.1e6},
    {"load_pusher", "tgs_soft", plate, 1.2, 250},
    {"floating_bolas_50", "tgs_soft direct", whirl, 0, 16},
    {"pinned_bolas_50", "tgs_soft direct", whirl, 0, 16},
    {"far_", "tgs_soft", coarse, 0, 0.04, Precision::f32},
    {"far_", "tgs_soft auto", coarse, 0, 0.0025, Precision::f32},
    {"heap_rest_1_far_100000", "tgs_soft", coarse, 0, rounding_step, Precision::f32},
    {"heap_rest_1_far_100000", "tgs_soft auto", coarse, 0, rounding_step, Precision::f32},
};

bool name_begins(const std::string& name, std::string_view start) {
  return name.compare(0, start.size(), start) == 0;
}

}  // namespace

void add_claims(std::vector<StressCase>& cases) {
  for (StressCase& each : cases) {
    for (const NamedCure& cure : named_cures)
      if (name_begins(each.name, cure.cases)) each.cures.push_back({cure.method, cure.place});
    for (const NamedShortfall& known : named_shortfalls)
      if (name_begins(each.name, known.cases))
        each.shortfalls.push_back({known.method, known.reason, known.lower, known.upper, known.precision});
  }
}

}  // namespace ticktrue::tool
