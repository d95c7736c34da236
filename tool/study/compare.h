// Compares ways to simulate one scene: integrators, clocks, solvers, substeps, precisions, steps, threads and more.
// SPDX-License-Identifier: MIT
//
// Every variant runs the same session as a base and is compared with the base at equal simulated times. Twins of the
// base run too (as in identical-twin experiments): every moving body is shifted by one unit in the last place. A
// difference counts as drift of the variant only if it exceeds the differences of the twins: chaos separates any runs.
// Verified: bits, tick by tick, where the ticks are the same: of the bodies, and of the whole state in variants that
// only change choices that no bit may depend on (broad phase, threads); poses at equal times; which bodies stand, in
// what order, where bodies rest. Not verified: which of two runs has the smaller error (`ticktrue accuracy` does that).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/scene/scene.h"
#include "tool/crosscheck/crosscheck.h"
#include "tool/session/scene_key.h"
#include "tool/study/measures.h"

namespace ticktrue::verifier {

/// A scene and its inputs.
struct CompareSession {
  struct TimedInput {
    double time_s = 0;  // start of the tick it acts in
    engine::Input input;
  };
  engine::Scene scene;
  std::vector<TimedInput> inputs;  // ascending
  std::vector<double> dts;         // s, of the recorded ticks; empty: the scene's
  double seconds = 10;
};
/// The session of a trace: its scene, inputs and lengths of ticks. Errors: what TraceReader refuses; incompatible (not
/// of the engine).
Result<CompareSession> session_of_trace(const std::string& path);

/// One way to run the session; absent fields are those of the base.
struct Variant {
  std::string name;  // "rk4, f64"; the base's is "base"
  std::optional<engine::IntegratorKind> integrator = {};
  std::optional<engine::ClockKind> clock = {};
  std::optional<engine::SolverKind> solver = {};
  std::optional<int> substeps = {};  // 0: automatic
  std::optional<engine::Precision> precision = {};
  std::optional<double> dt = {};
  std::optional<engine::BroadPhaseKind> broad_phase = {};
  std::optional<unsigned> threads = {};             // of a tick; the base has one
  std::string host = {};                            // of a clock: the model of its frames
  std::shared_ptr<const engine::Scene> scene = {};  // null: that of the session
};

/// Values per axis. Each combination of them is a variant.
struct CompareAxes {
  std::vector<engine::IntegratorKind> integrators;
  std::vector<engine::ClockKind> clocks;
  std::vector<std::string> hosts{"jitter_60"};  // of the clocks
  std::vector<engine::SolverKind> solvers;
  std::vector<int> substeps;
  std::vector<engine::Precision> precisions;
  std::vector<double> dts;
  std::vector<engine::BroadPhaseKind> broad_phases;
  std::vector<unsigned> threads;
};
std::vector<Variant> product_of(const CompareAxes& axes);
/// Each of the variants with each value at a key of the scene; without variants, one for each value. `place` comes
/// first in messages. Errors: those of scene_with.
Result<std::vector<Variant>> with_varied(const std::vector<Variant>& variants, const engine::Scene& scene,
                                         const VariedKey& varied, const std::string& place);
/// The settings of the base: "tgs_soft, semi_implicit_euler, 4 sub, f32, dt 1/60".
std::string base_text(const engine::Settings& settings);

enum class CompareVerdict : std::uint8_t { same_bits, within_twins, drift, other_outcome, not_finite, not_applicable };
inline constexpr std::array<std::string_view, 6> compare_verdict_names{
    "same_bits", "within_twins", "drift", "other_outcome", "not_finite", "not_applicable"};
inline constexpr std::array<std::string_view, 6> compare_verdict_meanings{
    "every tick of the bodies has the same bits",
    "differs, but no more than rounding makes the base differ from itself",
    "differs by the method",
    "a person would call the end another one",
    "a value is not finite (exit code 1)",
    "the choices do not go together, or the variant refuses an input (n/a)"};

/// The difference from the base at one time.
struct CompareSample {
  double time_s = 0;
  double position_max = 0;  // m
  double position_rms = 0;  // m, over bodies that both have
  double angle_max = 0;     // rad
  double twin_rms = 0;      // m, the largest value of the twins so far
  double energy = 0;        // J, kinetic and of gravity
  double momentum = 0;      // kg m/s, its length
  double overlap = 0;       // m, the deepest
  double joint_gap = 0;     // m, the largest
};

struct CompareRow {
  Variant variant;
  CompareVerdict verdict = CompareVerdict::not_applicable;
  std::string reason;                            // of the verdict
  bool same_ticks = false;                       // as the base's, so that bits can be compared
  bool whole_state = false;                      // bits of every column were compared, else those of the bodies
  std::optional<std::uint64_t> first_different;  // tick after which bits differ first
  std::uint64_t tick_count = 0;
  std::uint64_t root_hash = 0;  // of the state at the end
  std::vector<CompareSample> samples;
  double position_max = 0;         // m, over all samples
  double position_rms = 0;         // m, at the end
  double angle_max = 0;            // rad, over all samples
  std::optional<double> growth;    // 1/s, of the RMS while it grows
  std::optional<double> beyond_s;  // the first time at which it drifts further than the twins
  double energy = 0;               // J, end minus start (kinetic and of gravity)
  double momentum = 0;             // kg m/s, length at the end
  double overlap_max = 0;          // m, at samples
  double joint_gap_max = 0;        // m, at samples
  std::size_t placed_count = 0;
  std::size_t standing_count = 0;
  double order = 0;                 // share of supports that are still below the body they carried
  std::size_t resting_count = 0;    // at rest in the last second
  std::size_t elsewhere_count = 0;  // at rest in both, but more than half the size of a body apart
  double ms_per_s = 0;              // run time per simulated second, of one run: CPU time, or wall_clock
};

struct CompareReport {
  CompareRow base;
  std::vector<CompareRow> twins;
  std::vector<CompareRow> rows;
  double size = 0;  // m, median of the moving bodies
};

struct CompareOptions {
  int twin_count = 3;
  std::uint64_t host_seed = 1;  // of the hosts of clocks
  int sample_count = 120;
  unsigned thread_count = 1;  // runs at once
  bool wall_clock =
      false;  // for ms_per_s: the CPU time of threads that share a tick is larger than the time that passes
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;  // runs; from one thread at a time
};
inline constexpr double beyond_factor = 4;  // times the spread of the twins: more counts as drift

/// Errors: those of make_engine for the base; inputs that the base refuses.
Result<CompareReport> compare_variants(const CompareSession& session, const std::vector<Variant>& variants,
                                       const CompareOptions& options);

/// The base with each moving body shifted across by one unit in the last place of the larger of its coordinate and its
/// size; the sign by `seed`.
engine::Scene twin_of(const engine::Scene& scene, std::uint64_t seed);

/// Slope of log(rms) over time from the first sample that is not 0 to where it has reached a tenth of its largest.
std::optional<double> growth_rate(const std::vector<CompareSample>& samples);
/// First time at which the RMS exceeds beyond_factor times that of the twins.
std::optional<double> first_beyond(const std::vector<CompareSample>& samples);

}  // namespace ticktrue::verifier
