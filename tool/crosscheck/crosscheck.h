// The cross-check: one scene in a peer and in the engine, compared by outcome and not by poses.
// SPDX-License-Identifier: MIT
//
// Verified: whether structures stand, fall, hold or slide alike; their height and order; when they come to rest; the
// depth of overlaps; whether contact forces carry the weights. Each is verified over an ensemble of jittered starts.
// Not verified: poses, bits, and any effect of inputs. docs/crosscheck.md
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
#include "tool/crosscheck/peers.h"

namespace ticktrue::tool {

enum class Agreement : std::uint8_t { agree, differ, expected, not_applicable };
inline constexpr std::array<std::string_view, 4> verdict_names{"agree", "differ", "expected", "not_applicable"};

/// A body of the scene at its start, in coordinates along gravity: `across` to the right, `up` against gravity.
struct CrosscheckBody {
  bool is_dynamic = false;
  bool shows_tilt = false;  // has a shape other than circles, so that its rotation is visible
  bool is_placed = false;   // starts at rest, on or just above a static or placed body
  double across = 0;        // m, centre of mass
  double up = 0;            // m, centre of mass
  double angle = 0;         // rad
  double width = 0;         // m, across
  double height = 0;        // m, up
  double weight = 0;        // N
  double friction = 0;      // the least of its shapes
  double drop = 0;  // m that the body sinks straight down until all bodies below touch; infinite: nothing is below
  std::vector<std::uint32_t> supports;  // ids of the bodies that carry it after the drop
};

/// The structure of a scene at its start, equal for both engines.
struct CrosscheckLayout {
  engine::Point up{0, 1};
  engine::Point right{1, 0};
  double gravity = 0;                  // m/s^2
  std::vector<CrosscheckBody> bodies;  // by id
  std::size_t dynamic_count = 0;
  std::size_t placed_count = 0;
  bool is_structure = false;      // at least half of the dynamic bodies are placed
  bool has_weight_alone = false;  // no joints, force elements, conveyors or moving kinematic bodies
  engine::MixRule friction_mix = engine::MixRule::geometric_mean;
  bool is_column = false;  // a structure in which every body lies on one body and carries at most one
  double size = 0;         // m, median over dynamic bodies of the smaller of width and height
  double base = 0;         // m up, lowest point of the dynamic bodies after the drop
  double height = 0;       // m, of the highest centre of mass above the base after the drop, at least `size`
  double rest_speed = 0;   // m/s: a slower body counts as at rest
  std::vector<std::vector<std::uint32_t>> body_rows;  // bodies that touch side by side, from left to right
  std::shared_ptr<const engine::Scene> jointed;       // the scene, if it has joints
};
CrosscheckLayout make_layout(const engine::Scene& scene);

/// The final place of a body of the scene, in coordinates along gravity.
struct CrosscheckPlace {
  bool is_left = false;      // a dynamic body that was not removed
  bool rests = false;        // slower than 0.05 m/s throughout the last second
  double across = 0;         // m, centre of mass
  double up = 0;             // m
  double moved = 0;          // m, distance from its start
  double chain_gap = 0;      // m up, sum of gaps between shapes, from the body to the ground; overlaps are negative
  double chain_gap_max = 0;  // m, the largest of these gaps
};

/// The outcome of one run of one engine.
struct CrosscheckRun {
  bool is_finite = true;
  std::size_t standing_count = 0;      // placed bodies that are still upright and near their places
  bool stood = false;                  // nearly all placed bodies stand
  double top = 0;                      // m over the base, highest centre of mass of a dynamic body
  double order = 0;                    // share of supports that are still below the body that they carried
  double tilt_deg = 0;                 // largest rotation of a placed body, at most 45; 45 for good once it had it
  bool toppled = false;                // a placed body had a rotation of 45 degrees
  bool balances = false;               // it stands, and statics finds contact forces that carry it; false: or not known
  double settle_s = 0;                 // time at which the bodies came to rest for good; infinite: never
  double penetration = 0;              // deepest overlap, relative to the size of the smaller body
  double penetration_unexplained = 0;  // the same, minus the overlap that the contact forces cause in soft contacts
  std::vector<double> travel;          // m across, of each remaining dynamic body, ascending
  std::vector<double> travel_closed;   // the same without the gaps that the skin opened inside rows
  double joint_gap = 0;                // m, the largest in the last second
  double ground_force = 0;             // upward force of static bodies over the total weight
  bool ground_is_flat = false;         // the ground force comes from level contacts only
  double column_error = 0;  // largest relative error of the force under a body of a column, against the weight above
  // The chain from the highest body down to the ground, contact by contact:
  bool has_chain = false;               // the chain ends on the ground
  std::size_t chain_count = 0;          // contacts in the chain
  double chain_gap = 0;                 // m up, sum of the gaps between shapes; overlaps count as negative
  double chain_gap_max = 0;             // m, the largest of these gaps
  std::vector<CrosscheckPlace> places;  // by id
};

/// Measures one run.
class CrosscheckMeasure {
 public:
  /// `contact_hertz`: softness of the engine's contacts, 0 for rigid contacts. `skin`: the distance at which the engine
  /// may keep shapes apart, m. Requires: `layout` outlives this object.
  CrosscheckMeasure(const CrosscheckLayout& layout, double contact_hertz, double skin);
  /// Call after each tick, in order. `contacts` may be null. The result averages all given contacts: pass those of the
  /// last second.
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
    std::size_t body = 0;  // the body that carries
    double force = -1;     // N up, of the strongest contact with the body that carries
    double gap_sum = 0;    // m up, over all contact points of the two bodies
    int point_count = 0;   // 0: no body carries
  };
  std::vector<Carrier> find_carriers() const;
  Chain follow_chain(std::size_t body, const std::vector<Carrier>& carriers) const;
  bool balances(const std::vector<const engine::BodyReport*>& found) const;
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
  std::vector<bool> toppled_;           // by id
  std::vector<engine::BodyReport> last_bodies_;
  std::vector<engine::ContactReport> last_contacts_;
  std::size_t contact_sample_count_ = 0;
  double joint_gap_ = 0;  // m
  double penetration_sum_ = 0;
  double penetration_unexplained_sum_ = 0;
  double ground_up_sum_ = 0;         // N
  double ground_side_sum_ = 0;       // N
  double ground_all_sum_ = 0;        // N
  std::vector<double> carried_sum_;  // by id, N up from the support in a column
};

inline constexpr std::string_view stands_criterion = "stands or falls";
inline constexpr std::string_view joints_criterion = "joints hold";
inline constexpr std::string_view top_criterion = "top height";
inline constexpr std::string_view travel_criterion = "slides or holds";

/// One criterion of one solver.
struct CriterionResult {
  std::string solver;
  std::string criterion;
  Agreement verdict = Agreement::not_applicable;
  std::string unit;
  std::vector<double> ours;   // by seed; empty: not applicable
  std::vector<double> box2d;  // by seed
  // By seed, with the smallest steps. Empty: the smallest steps did not run, or the criterion does not use them.
  std::vector<double> ours_finest;
  std::vector<double> box2d_finest;
  double difference = 0;
  double tolerance = 0;  // the largest difference that counts as agreement
  std::string reason;    // of any verdict other than agree
};

/// The mean of the values of the seeds.
double mean_of(const std::vector<double>& values);

/// Judges an ensemble against Box2D's. `box2d_skin`: the distance at which Box2D may keep shapes apart, m. Requires:
/// neither ensemble is empty.
std::vector<CriterionResult> compare_runs(const CrosscheckLayout& layout, const std::vector<CrosscheckRun>& ours,
                                          const std::vector<CrosscheckRun>& box2d, double box2d_skin);

/// Corrects `rows`, which compare the engine with Box2D at its recommended steps. `finest` compares the engine with
/// Box2D at its finest steps. A difference that disappears with the finest steps becomes `expected`. So does a
/// difference in which the engine lies between both values of Box2D, except under `stands`. If `stands` agrees in
/// `rows` and differs in `finest`, the row differs. Rows that judge single bodies stay unchanged. `steps_per_tick`: of
/// the finest steps.
void judge_by_finest(std::vector<CriterionResult>& rows, const std::vector<CriterionResult>& finest,
                     int steps_per_tick);

/// Corrects top height and `slides or holds` of a structure that topples in every run. `with_finer`: ours with smaller
/// steps against Box2D's finest; `ours_moved`, `theirs_moved`: smaller steps of each against its own. A difference is
/// `expected` if ours agrees with smaller steps, and stays if it does not and nobody's end moves with the step.
/// Otherwise nobody knows the end: not applicable.
void judge_collapse(std::vector<CriterionResult>& rows, const std::vector<CriterionResult>& with_finer,
                    const std::vector<CriterionResult>& ours_moved, const std::vector<CriterionResult>& theirs_moved,
                    int steps_per_tick);

/// Corrects `stands` by what statics says, whoever drops the structure. Requires of every run of `own_finest`, ours
/// with smaller steps, that it stands at rest and that forces balance it (statics.h, without a solver). Then ours
/// differs if it falls, also where Box2D's finest steps fall; and if ours stands at rest too, the fall of Box2D's
/// finest steps is a missing convergence of Box2D, and the differences that follow from it are `expected`. `how`: the
/// smaller steps.
void judge_by_rest(std::vector<CriterionResult>& rows, const std::vector<CrosscheckRun>& ours,
                   const std::vector<CrosscheckRun>& own_finest, std::string_view how);

/// The criteria that judge single bodies. A body differs only if both engines are certain of its place. Box2D is
/// certain if its seeds and its smaller steps agree (`finer`: one ensemble per step size). The engine is certain if its
/// smaller steps agree (`own_finer`). The rows follow the order of these names, as in compare_runs.
inline constexpr std::string_view place_criterion = "rests at same place";  // values: m from Box2D's mean place
inline constexpr std::string_view distance_criterion = "travels as far";    // values: m, largest of a body
std::vector<CriterionResult> compare_bodies(const CrosscheckLayout& layout, const std::vector<CrosscheckRun>& ours,
                                            const std::vector<CrosscheckRun>& box2d,
                                            const std::vector<std::vector<CrosscheckRun>>& finer,
                                            const std::vector<std::vector<CrosscheckRun>>& own_finer,
                                            double box2d_skin);

struct CrosscheckOptions {
  std::vector<engine::SolverKind> solvers;  // empty: the solver of the scene
  std::uint32_t seed_count = 5;             // seed 0 starts exactly at the poses of the scene
  double seconds = 20;
  bool match_skin = false;  // Box2D's polygons rest with their geometry in contact, not a skin apart
  PeerKind peer = PeerKind::box2d2;
  unsigned thread_count = 1;
  std::function<void(std::uint64_t done, std::uint64_t total)>
      progress;  // ticks of all runs; called by one thread at a time
};

struct CrosscheckSolver {
  std::string solver;
  int passed = 0;
  int failed = 0;
  int expected = 0;
  int not_applicable = 0;
  std::size_t stood = 0;  // number of seeds
  std::string summary;    // one line
};

struct CrosscheckReport {
  std::string scene;
  PeerKind peer = PeerKind::box2d2;
  std::string box2d_version;    // of the peer, without "Box2D"
  int velocity_iterations = 0;  // of box2d2
  int position_iterations = 0;
  double length_scale = 1;
  bool match_skin = false;
  std::size_t thin_shape_count = 0;  // shapes with a thinner skin; 0 with match_skin, which thins every skin
  std::uint32_t seed_count = 0;
  std::uint64_t tick_count = 0;
  double seconds = 0;
  bool is_structure = false;
  std::size_t box2d_stood = 0;  // number of seeds
  std::vector<CrosscheckSolver> solvers;
  std::vector<CriterionResult> rows;
};

/// Compares the scene in both engines. Errors: those of make_engine; unsupported (a build without Box2D); usage (seeds
/// or seconds out of range, no node or no package for Box2D 3); those of a run of Box2D 3. If the peer does not support
/// the scene, the report has one row, not_applicable.
Result<CrosscheckReport> crosscheck(const engine::Scene& scene, const CrosscheckOptions& options);

/// The scene with each dynamic body shifted across gravity by up to 1 mm per metre of the body's size. Without gravity,
/// bodies shift in both directions. Seed 0 changes nothing. `layout` is make_layout of the scene.
engine::Scene jittered_scene(const engine::Scene& scene, const CrosscheckLayout& layout, std::uint32_t seed);

/// The scene with another solver. If the scene's substeps do not fit the solver, the solver's default replaces them.
engine::Scene scene_with_solver(const engine::Scene& scene, engine::SolverKind solver);

}  // namespace ticktrue::tool
