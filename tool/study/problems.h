// The verification problems: scenes with a known solution, from a closed form or from high-precision numbers.
// SPDX-License-Identifier: MIT
//
// Errors are relative to a length, angle, speed or force of the problem, its scale. References never come from the
// engine. Each smooth problem also states its equation of motion, so that a stand-in for an integrator can be judged by
// the same functions.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::verifier {

enum class ProblemClass : std::uint8_t { smooth, joint, impact, friction, rest, roll, slide, stack, bounce };
inline constexpr std::array<std::string_view, 9> problem_class_names{"smooth", "joint", "impact", "friction", "rest",
                                                                     "roll",   "slide", "stack",  "bounce"};

/// Limits for the points of a method at a setting.
struct Bar {
  std::string method;
  std::string setting;  // as setting_text prints it; empty: every setting
  double error = 0;     // the largest, relative, root mean square; 0: no limit
  double energy = 0;    // J, the largest change in either direction; 0: no limit
};

/// A method that misses a bar of a problem, the reason (docs/study.md has it, too), and how large the miss may be.
struct Shortfall {
  std::string method;
  std::string reason;
  double error = 0;   // as Bar::error, of the points that miss a bar
  double energy = 0;  // J, as Bar::energy
};

struct Problem {
  std::string name;
  std::string summary;
  std::string reference;  // where the exact values come from
  ProblemClass kind = ProblemClass::smooth;
  double duration = 1;                    // s
  int sample_count = 20;                  // at equal times, the last at the end
  double scale = 1;                       // what errors are relative to
  int step_count = 60;                    // smooth: of the coarsest run, a multiple of sample_count
  int substeps_max = 64;                  // the finest of the sweep, a power of two
  double dt = 1.0 / 60;                   // s, of a tick where substeps are swept
  std::vector<int> substep_counts;        // of the sweep, ascending; empty: powers of two
  std::vector<std::string> method_names;  // the methods of methods_of to run; empty: all
  bool has_clocks = false;                // smooth: also run on the frames of a host
  bool is_exact_from_order_2 = false;     // smooth: integrators of order 2 or more have only rounding errors
  bool is_angle = false;                  // values are angles: differences count modulo a turn
  double size = 0;                        // m, of the smallest shape, where errors are lengths; 0: they are not
  int corner_count = -1;                  // of the shape families: 0 a disc, 3..16

  std::function<engine::Scene(engine::Precision)> scene;
  std::function<std::vector<double>(const engine::Engine&)> observe;
  std::function<std::vector<double>(double time_s)> exact;

  /// Theoretical slope of the default solver's error over h; absent: none, see `why_no_slope`.
  std::optional<double> slope;
  /// The slope under integrators of order 2 or more, where it differs.
  std::optional<double> slope_of_higher;
  std::string why_no_slope;
  bool is_exact = false;  // the scheme has only rounding errors
  bool is_pair = false;   // one impact of two bodies: exact also if it is not located
  std::vector<Bar> bars;
  std::vector<Shortfall> shortfalls;

  /// Smooth problems: the start and the acceleration, of a point or (x alone) an angle.
  engine::Point start;
  engine::Point start_velocity;
  std::function<engine::Point(engine::Point position, engine::Point velocity)> acceleration;
};

/// All problems except the shape families, in the order of the tables.
std::vector<Problem> verification_problems();
/// A disc and regular polygons of 3..16 corners, each of 1 kg: rolling, sliding, stacked, bouncing.
std::vector<Problem> shape_problems();

/// sn(u, k) by descending Landen transformation.
double jacobi_sn(double u, double k);
/// Angle of a pendulum of small frequency `w` rad/s let go at `amplitude` rad.
double pendulum_angle(double amplitude, double w, double time_s);
/// Height over the floor of a ball dropped from `height` that bounces with `restitution`, g = 10. Requires: < 1 or
/// few bounces.
double bouncing_height(double height, double restitution, double time_s);

}  // namespace ticktrue::verifier
