// Compares ways to simulate one scene: integrators, clocks, solvers, substeps, precisions, steps, threads and more.
// SPDX-License-Identifier: MIT
//
// Every variant runs the same session as a base and is compared with the base at equal simulated times. Twins of the
// base run too (as in identical-twin experiments): in a twin, every moving body is shifted by one unit in the last
// place. A difference counts as drift of the variant only if it exceeds the differences of the twins, because chaos
// separates any two runs.
// Verified: the bits of the bodies, tick by tick, if variant and base have the same ticks. The bits of the whole state,
// if the variant only changes choices that must not change a bit (broad phase, threads). Poses at equal times. Which
// bodies stand, their order, and their places of rest.
// Not verified: which of two runs has the smaller error (`ticktrue accuracy` measures the error).
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
#include "engine/engine.h"
#include "engine/scene/scene.h"
#include "tool/crosscheck/crosscheck.h"
#include "tool/session/scene_key.h"
#include "tool/study/measures.h"

namespace ticktrue::tool {

/// A scene and its inputs.
struct CompareSession {
  struct TimedInput {
    double time_s = 0;  // start of the tick that takes the input
    engine::Input input;
  };
  engine::Scene scene;
  std::vector<TimedInput> inputs;  // ascending
  std::vector<double> dts;         // s, of the recorded ticks; empty: every tick has the scene's dt
  double seconds = 10;
};
/// The session of a trace: its scene, inputs and tick lengths. Errors: those of TraceReader; incompatible (the trace
/// is not from this engine).
Result<CompareSession> session_of_trace(const std::string& path);

/// One way to run the session. An absent field has the value of the base.
struct Variant {
  std::string name;  // "rk4, f64"; the base is named "base"
  std::optional<engine::IntegratorKind> integrator = {};
  std::optional<engine::ClockKind> clock = {};
  std::optional<engine::SolverKind> solver = {};
  std::optional<int> substeps = {};  // 0: automatic
  std::optional<engine::Precision> precision = {};
  std::optional<double> dt = {};
  std::optional<engine::BroadPhaseKind> broad_phase = {};
  std::optional<unsigned> threads = {};             // threads per tick; the base uses one
  std::string host = {};                            // for a clock: the host model that makes its frames
  std::shared_ptr<const engine::Scene> scene = {};  // null: the scene of the session
  std::vector<std::string> varied_values = {};      // of the varied keys, in the order of with_varied
};

/// Values per axis. Each combination of them is a variant.
struct CompareAxes {
  std::vector<engine::IntegratorKind> integrators;
  std::vector<engine::ClockKind> clocks;
  std::vector<std::string> hosts{"jitter_60"};  // host models for the clocks
  std::vector<engine::SolverKind> solvers;
  std::vector<int> substeps;
  std::vector<engine::Precision> precisions;
  std::vector<double> dts;
  std::vector<engine::BroadPhaseKind> broad_phases;
  std::vector<unsigned> threads;
};
std::vector<Variant> product_of(const CompareAxes& axes);
/// Combines each variant with each value of a key of the scene. Without variants, each value makes one variant.
/// Messages begin with `place`. Errors: those of scene_with.
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
  double position_max = 0;     // m
  double position_rms = 0;     // m, over the bodies that exist in both runs
  double angle_max = 0;        // rad
  double twin_rms = 0;         // m, the largest RMS of the twins so far
  double energy = 0;           // J, kinetic energy plus potential energy of gravity
  double momentum = 0;         // kg m/s, magnitude
  double overlap = 0;          // m, the deepest
  double joint_gap = 0;        // m, the largest
  std::vector<double> values;  // those of CompareOptions::measure, after the tick that reaches the time
  double values_time_s = 0;    // the end of that tick
};

struct CompareRow {
  Variant variant;
  CompareVerdict verdict = CompareVerdict::not_applicable;
  std::string reason;                            // of the verdict
  bool same_ticks = false;                       // ticks equal those of the base, so that bits can be compared
  bool whole_state = false;                      // true: bits of every column were compared; false: bits of the bodies
  std::optional<std::uint64_t> first_different;  // the first tick after which bits differ
  std::uint64_t tick_count = 0;
  std::uint64_t root_hash = 0;  // of the state at the end
  std::vector<CompareSample> samples;
  double position_max = 0;         // m, over all samples
  double position_rms = 0;         // m, at the end
  double angle_max = 0;            // rad, over all samples
  std::optional<double> growth;    // 1/s, of the RMS while the RMS grows
  std::optional<double> beyond_s;  // the first time at which the drift exceeds that of the twins
  double energy = 0;               // J, end minus start: kinetic energy plus potential energy of gravity
  double momentum = 0;             // kg m/s, magnitude at the end
  double overlap_max = 0;          // m, at samples
  double joint_gap_max = 0;        // m, at samples
  std::size_t placed_count = 0;
  std::size_t standing_count = 0;
  double order = 0;                 // share of supports that are still below the body that they carried
  std::size_t resting_count = 0;    // at rest in the last second
  std::size_t elsewhere_count = 0;  // at rest in both runs, but more than half the size of a body apart
  double ms_per_s = 0;  // run time per simulated second, of one run: CPU time, or wall time if wall_clock is set
};

struct CompareReport {
  CompareRow base;
  std::vector<CompareRow> twins;
  std::vector<CompareRow> rows;
  double size = 0;  // m, median size of the moving bodies
};

struct CompareOptions {
  int twin_count = 3;
  std::uint64_t host_seed = 1;  // seed of the host models
  int sample_count = 120;
  unsigned thread_count = 1;  // number of runs at the same time
  bool wall_clock =
      false;  // for ms_per_s: the CPU time of threads that share a tick is larger than the time that passes
  /// Measures more values at every sample; may be empty. Several threads call it at once.
  std::function<std::vector<double>(const engine::Engine&)> measure;
  std::function<void(std::uint64_t done, std::uint64_t total)> progress;  // counts runs; called by one thread at a time
};
inline constexpr double beyond_factor = 4;  // a distance above this multiple of the twins' spread counts as drift

/// Errors: those of make_engine for the base; inputs that the base refuses.
Result<CompareReport> compare_variants(const CompareSession& session, const std::vector<Variant>& variants,
                                       const CompareOptions& options);

/// The base with each moving body shifted across by one unit in the last place of its coordinate or of its size,
/// whichever is larger. `seed` decides the sign.
engine::Scene twin_of(const engine::Scene& scene, std::uint64_t seed);

/// Slope of log(rms) over time, from the first sample that is not 0 to the sample that reaches a tenth of the largest
/// RMS.
std::optional<double> growth_rate(const std::vector<CompareSample>& samples);
/// First time at which the RMS exceeds beyond_factor times the RMS of the twins.
std::optional<double> first_beyond(const std::vector<CompareSample>& samples);

}  // namespace ticktrue::tool
