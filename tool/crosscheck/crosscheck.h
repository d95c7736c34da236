// The cross-check: one scene in Box2D 2.4.1 and in the engine, compared by outcome and not by poses.
// SPDX-License-Identifier: MIT
//
// Verified: whether structures stand, fall, hold or slide alike, how high, in what order, when they come to rest, how
// deep shapes overlap, and whether contact forces carry the weights; over an ensemble of jittered starts.
// Not verified: poses, bits, and anything a scene does only because of inputs. docs/crosscheck.md
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "engine/engine.h"
#include "engine/scene/scene.h"

namespace ticktrue::verifier {

enum class Agreement : std::uint8_t { agree, differ, expected, not_applicable };
inline constexpr std::array<std::string_view, 4> verdict_names{"agree", "differ", "expected", "not_applicable"};

/// A body of the scene as it starts, seen along gravity: `across` to the right, `up` against gravity.
struct CrosscheckBody {
  bool is_dynamic = false;
  bool shows_tilt = false;  // has a shape other than circles
  bool is_placed = false;   // starts at rest, on or just above something static or placed
  double across = 0;        // m, centre of mass
  double up = 0;            // m, centre of mass
  double angle = 0;         // rad
  double width = 0;         // m, across
  double height = 0;        // m, up
  double weight = 0;        // N
  double drop = 0;  // m it sinks straight down until the things below it lie on each other; infinite: nothing below
  std::vector<std::uint32_t> supports;  // ids of what it then lies on
};

/// The structure of a scene at its start, the same for both engines.
struct CrosscheckLayout {
  engine::Point up{0, 1};
  engine::Point right{1, 0};
  double gravity = 0;                  // m/s^2
  std::vector<CrosscheckBody> bodies;  // by id
  std::size_t dynamic_count = 0;
  std::size_t placed_count = 0;
  bool is_structure = false;  // at least half of the dynamic bodies are placed
  bool is_column = false;     // a structure in which every body lies on one and carries at most one
  double size = 0;            // m, median over dynamic bodies of the smaller of width and height
  double base = 0;            // m up, lowest point of the dynamic bodies once dropped
  double height = 0;          // m, of the highest centre over the base once dropped, at least `size`
  double rest_speed = 0;      // m/s: slower counts as at rest
  std::vector<std::vector<std::uint32_t>> body_rows;  // bodies side by side and touching, from left to right
};
CrosscheckLayout make_layout(const engine::Scene& scene);

/// The final place of a body of the scene, relative to gravity.
struct CrosscheckPlace {
  bool is_left = false;      // not removed; of the moving bodies
  bool rests = false;        // slower than 0.05 m/s throughout the last second
  double across = 0;         // m, centre of mass
  double up = 0;             // m
  double moved = 0;          // m, straight from where it started
  double chain_gap = 0;      // m up, sum of the gaps between shapes from the body down to the ground; overlaps negative
  double chain_gap_max = 0;  // m, the largest of them
};

/// The outcome of one run of one engine.
struct CrosscheckRun {
  bool is_finite = true;
  std::size_t standing_count = 0;      // placed bodies still upright near where they were placed
  bool stood = false;                  // nearly all placed bodies stand
  double top = 0;                      // m over the base, highest centre of mass of a dynamic body
  double order = 0;                    // share of supports that are still below what they carried
  double tilt_deg = 0;                 // largest turn of a placed body, at most 45
  double settle_s = 0;                 // when the bodies came to rest for good; infinite: they did not
  double penetration = 0;              // deepest overlap over the smaller body's size
  double penetration_unexplained = 0;  // the same, without what the softness of the contacts gives under their forces
  std::vector<double> travel;          // m across, of each dynamic body left, ascending
  std::vector<double> travel_closed;   // the same with the gaps that the skin opened inside rows closed again
  double ground_force = 0;             // upward force of static bodies over the total weight
  bool ground_is_flat = false;         // that force comes from level contacts only
  double column_error = 0;  // largest relative error of the force under a body of a column against the weight on it
  // From the highest body down to the ground, contact by contact:
  bool has_chain = false;               // it ends on the ground
  std::size_t chain_count = 0;          // contacts
  double chain_gap = 0;                 // m up, sum of the gaps between shapes; overlaps are negative
  double chain_gap_max = 0;             // m, the largest of them
  std::vector<CrosscheckPlace> places;  // by id
};

/// Measures one run.
class CrosscheckMeasure {
 public:
  /// `contact_hertz`: softness of this engine's contacts, 0 for rigid ones. `skin`: how far apart it may keep shapes,
  /// m. Requires: layout outlives this.
  CrosscheckMeasure(const CrosscheckLayout& layout, double contact_hertz, double skin);
  /// After each tick, in order. `contacts` may be null; those given are averaged: give the last second's.
  void add(double time_s, const std::vector<engine::BodyReport>& bodies,
           const std::vector<engine::ContactReport>* contacts);
  CrosscheckRun finish() const;

 private:
  void add_contacts(const std::vector<engine::BodyReport>& bodies, const std::vector<engine::ContactReport>& contacts);
  struct Chain {
    bool ends_on_ground = false;
    std::size_t count = 0;  // contacts
    double gap = 0;         // m up
    double gap_max = 0;     // m
  };
  struct Carrier {
    std::size_t body = 0;  // that carries
    double force = -1;     // N up, of its strongest contact
    double gap_sum = 0;    // m up, of all points of the two bodies
    int point_count = 0;   // 0: nothing carries
  };
  std::vector<Carrier> find_carriers() const;
  Chain follow_chain(std::size_t body, const std::vector<Carrier>& carriers) const;
  void measure_chains(CrosscheckRun& run) const;
  void measure_places(CrosscheckRun& run, const std::vector<const engine::BodyReport*>& found) const;
  void close_rows(CrosscheckRun& run, const std::vector<double>& across, const std::vector<bool>& present) const;

  const CrosscheckLayout& layout_;
  double contact_hertz_;
  double skin_;
  bool is_finite_ = true;
  double time_s_ = 0;
  std::vector<double> moving_until_s_;  // by id
  std::vector<double> fast_until_s_;    // by id
  std::vector<engine::BodyReport> last_bodies_;
  std::vector<engine::ContactReport> last_contacts_;
  std::size_t contact_sample_count_ = 0;
  double penetration_sum_ = 0;
  double penetration_unexplained_sum_ = 0;
  double ground_up_sum_ = 0;         // N
  double ground_side_sum_ = 0;       // N
  double ground_all_sum_ = 0;        // N
  std::vector<double> carried_sum_;  // by id, N up from its support in a column
};

inline constexpr std::string_view stands_criterion = "stands or falls";

/// One criterion of one solver.
struct CriterionResult {
  std::string solver;
  std::string criterion;
  Agreement verdict = Agreement::not_applicable;
  std::string unit;
  std::vector<double> ours;   // by seed; empty if not applicable
  std::vector<double> box2d;  // by seed
  // By seed, with the smallest steps; empty where these were not run or are not asked about.
  std::vector<double> ours_finest;
  std::vector<double> box2d_finest;
  double difference = 0;
  double tolerance = 0;  // largest difference that agrees
  std::string reason;    // of a verdict other than agree
};

/// Of the values of the seeds.
double mean_of(const std::vector<double>& values);

/// Judges an ensemble against Box2D's. `box2d_skin`: how far apart Box2D may keep shapes, m. Neither is empty.
std::vector<CriterionResult> compare_runs(const CrosscheckLayout& layout, const std::vector<CrosscheckRun>& ours,
                                          const std::vector<CrosscheckRun>& box2d, double box2d_skin);

/// Changes the rows of ours against Box2D as recommended by those of ours against its finest steps. A difference that
/// is gone there is expected; ours that falls, or stands, where the finest does not differs, whatever the plain one
/// did. Rows that judge body by body stay as they are. `steps_per_tick`: of the finest.
void judge_by_finest(std::vector<CriterionResult>& rows, const std::vector<CriterionResult>& finest,
                     int steps_per_tick);

/// The criteria that judge body by body. Those differ only where the engines are certain: Box2D over its seeds and with
/// smaller steps (`finer`: an ensemble for each), ours with smaller steps (`own_finer`). Rows in the order of these
/// names, which compare_runs has too.
inline constexpr std::string_view place_criterion = "rests at same place";  // values: m from Box2D's average
inline constexpr std::string_view distance_criterion = "travels as far";    // values: m of the body most off
std::vector<CriterionResult> compare_bodies(const CrosscheckLayout& layout, const std::vector<CrosscheckRun>& ours,
                                            const std::vector<CrosscheckRun>& box2d,
                                            const std::vector<std::vector<CrosscheckRun>>& finer,
                                            const std::vector<std::vector<CrosscheckRun>>& own_finer,
                                            double box2d_skin);

struct CrosscheckOptions {
  std::vector<engine::SolverKind> solvers;  // empty: the scene's
  std::uint32_t seed_count = 5;             // seed 0 starts exactly as the scene says
  double seconds = 20;
  bool match_skin = false;  // Box2D's polygons rest where their geometry touches, not a skin apart
  unsigned thread_count = 1;
  std::function<void(std::uint64_t done, std::uint64_t total)>
      progress;  // ticks of all runs; called from one thread at a time
};

struct CrosscheckSolver {
  std::string solver;
  int passed = 0;
  int failed = 0;
  int expected = 0;
  int not_applicable = 0;
  std::size_t stood = 0;  // seeds
  std::string summary;    // one line
};

struct CrosscheckReport {
  std::string scene;
  std::string box2d_version;
  int velocity_iterations = 0;
  int position_iterations = 0;
  double length_scale = 1;
  bool match_skin = false;
  std::size_t thin_shape_count = 0;  // that got a thinner skin; 0 with match_skin, where all have it
  std::uint32_t seed_count = 0;
  std::uint64_t tick_count = 0;
  double seconds = 0;
  bool is_structure = false;
  std::size_t box2d_stood = 0;  // seeds
  std::vector<CrosscheckSolver> solvers;
  std::vector<CriterionResult> rows;
};

/// Errors: what make_engine refuses; unsupported in a build without Box2D; usage (seeds or seconds out of range).
/// A scene that Box2D cannot do gives a report with one row, not_applicable.
Result<CrosscheckReport> crosscheck(const engine::Scene& scene, const CrosscheckOptions& options);

/// The scene with each dynamic body shifted across gravity (without gravity: in both directions) by up to
/// 1 mm per metre of its size; seed 0: unchanged.
/// `layout` is make_layout of the scene.
engine::Scene jittered_scene(const engine::Scene& scene, const CrosscheckLayout& layout, std::uint32_t seed);

/// The scene under another solver, with that solver's default of substeps where the scene's does not fit it.
engine::Scene scene_with_solver(const engine::Scene& scene, engine::SolverKind solver);

}  // namespace ticktrue::verifier
