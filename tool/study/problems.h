// The verification problems: scenes with a known solution, from a closed form or from high-precision numbers.
// SPDX-License-Identifier: MIT
//
// Errors are relative to `scale`, which is a length, angle, speed or force of the problem. Reference values never come
// from the engine. Each smooth problem also states its equation of motion, so that the same functions can judge a
// stand-in for an integrator.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::tool {

enum class ProblemClass : std::uint8_t { smooth, joint, impact, friction, rest, roll, slide, stack, bounce };
inline constexpr std::array<std::string_view, 9> problem_class_names{"smooth", "joint", "impact", "friction", "rest",
                                                                     "roll",   "slide", "stack",  "bounce"};

/// Limits for the points of a method at a setting.
struct Bar {
  std::string method;
  std::string setting;  // as setting_text prints it; empty: every setting
  double error = 0;     // the largest relative error, root mean square; 0: no limit
  double energy = 0;    // J, the largest change in either direction; 0: no limit
};

/// A method that misses a bar of a problem, the reason (also in docs/study.md), and the largest accepted miss.
struct Shortfall {
  std::string method;
  std::string reason;
  double error = 0;   // as Bar::error, for points that miss a bar
  double energy = 0;  // J, as Bar::energy
};

struct Problem {
  std::string name;
  std::string summary;
  std::string reference;  // the source of the exact values
  ProblemClass kind = ProblemClass::smooth;
  double duration = 1;                    // s
  int sample_count = 20;                  // at equal intervals; the last sample is at the end
  double scale = 1;                       // errors are relative to this value
  int step_count = 60;                    // smooth: steps of the coarsest run, a multiple of sample_count
  int substeps_max = 64;                  // the largest count of the sweep, a power of two
  double dt = 1.0 / 60;                   // s, the tick length of a sweep over substeps
  std::vector<int> substep_counts;        // counts of the sweep, ascending; empty: powers of two
  std::vector<std::string> method_names;  // the methods of methods_of to run; empty: all
  bool has_clocks = false;                // smooth: also run on the frames of a host
  bool is_exact_from_order_2 = false;     // smooth: integrators of order 2 or more have only rounding errors
  bool is_angle = false;                  // values are angles; differences are taken modulo 2 pi
  double size = 0;                        // m, size of the smallest shape if errors are lengths, else 0
  int corner_count = -1;                  // of the shape families: 0 for a disc, 3..16 for a polygon

  std::function<engine::Scene(engine::Precision)> scene;
  std::function<std::vector<double>(const engine::Engine&)> observe;
  std::function<std::vector<double>(double time_s)> exact;

  /// Theoretical slope of the error of the default solver over h. Absent: `why_no_slope` gives the reason.
  std::optional<double> slope;
  /// The slope for integrators of order 2 or more, if different.
  std::optional<double> slope_of_higher;
  std::string why_no_slope;
  bool is_exact = false;  // the scheme has only rounding errors
  bool is_pair = false;   // one impact of two bodies, exact even without location of impacts
  std::vector<Bar> bars;
  std::vector<Shortfall> shortfalls;

  /// Of a user's file: what it claims is judged, or the run fails.
  bool is_own = false;
  std::vector<std::pair<std::string, double>> slopes;  // claimed by method; then `slope` is absent
  std::vector<std::string> value_names;                // what `observe` returns, as the file names it
  std::vector<double> value_scales;  // what `observe` and `exact` divide their values by; empty: by nothing

  /// Smooth problems: the start and the acceleration, of a point or of an angle (x alone).
  engine::Point start;
  engine::Point start_velocity;
  std::function<engine::Point(engine::Point position, engine::Point velocity)> acceleration;
};

/// All problems except the shape families, in the order of the printed tables.
std::vector<Problem> verification_problems();
/// A disc and regular polygons of 3..16 corners, each of 1 kg: rolling, sliding, stacked, bouncing.
std::vector<Problem> shape_problems();

/// Height above the floor of a ball dropped from `height` that bounces with `restitution`, g = 10. Requires:
/// restitution < 1, or few bounces.
double bouncing_height(double height, double restitution, double time_s);

}  // namespace ticktrue::tool
