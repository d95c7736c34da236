// The criteria: an ensemble of runs of the engine judged against an ensemble of Box2D.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tool/crosscheck/crosscheck.h"

namespace ticktrue::tool {
namespace {

// A difference agrees up to its tolerance here, or up to scatter_factor times the scatter of Box2D's seeds if that is
// larger.
constexpr double scatter_factor = 2;                // standard deviations of Box2D's seeds
constexpr double stood_tolerance = 0.2;             // of the seeds: one of five may have another outcome
constexpr double standing_tolerance = 0.02;         // of the placed bodies, if Box2D's structure stands
constexpr double collapsed_tolerance = 0.15;        // of the placed bodies, if Box2D's structure falls
constexpr double top_tolerance = 0.01;              // of the height
constexpr std::size_t heap_count_min = 10;          // fewer bodies are no heap
constexpr double top_explained_tolerance = 0.0025;  // of the height, without the gaps between shapes
constexpr double tilt_tolerance_deg = 3;
constexpr double settle_tolerance_share = 0.25;
constexpr double settle_tolerance_min_s = 2;
constexpr double penetration_tolerance = 0.02;  // of the smaller body's size
constexpr double joint_tolerance = 0.02;        // of a body's size
constexpr double travel_tolerance_share = 0.025;
constexpr double travel_tolerance_min = 0.05;  // of a body's size
constexpr double force_tolerance = 0.02;       // of the weight
constexpr double place_tolerance = 0.02;       // m
constexpr double rounding_m = 1e-4;            // m: a gap this small between resting shapes is none
constexpr double distance_tolerance_share = 0.1;
constexpr double distance_tolerance_min = 1;  // m

struct Statistics {
  double mean = 0;
  double deviation = 0;  // standard deviation of the sample
};
Statistics statistics_of(const std::vector<double>& values) {
  Statistics s;
  for (const double value : values) s.mean += value / static_cast<double>(values.size());
  if (values.size() < 2) return s;
  double sum = 0;
  for (const double value : values) sum += (value - s.mean) * (value - s.mean);
  s.deviation = std::sqrt(sum / static_cast<double>(values.size() - 1));
  return s;
}

template <typename Field>
std::vector<double> each(const std::vector<CrosscheckRun>& runs, Field field) {
  std::vector<double> values;
  for (const CrosscheckRun& run : runs) values.push_back(static_cast<double>(field(run)));
  return values;
}

template <typename Condition>
bool all(const std::vector<CrosscheckRun>& runs, Condition condition) {
  return std::all_of(runs.begin(), runs.end(), condition);
}

CriterionResult not_applicable(std::string criterion, std::string reason) {
  CriterionResult row;
  row.criterion = std::move(criterion);
  row.reason = std::move(reason);
  return row;
}

// Compares means. Means differ if their distance exceeds the tolerance and the scatter of Box2D's seeds.
CriterionResult compare_means(std::string criterion, std::string unit, std::vector<double> ours,
                              std::vector<double> box2d, double tolerance) {
  CriterionResult row;
  row.criterion = std::move(criterion);
  row.unit = std::move(unit);
  const Statistics reference = statistics_of(box2d);
  row.difference = std::fabs(mean_of(ours) - reference.mean);
  row.tolerance = std::max(tolerance, scatter_factor * reference.deviation);
  row.verdict = row.difference <= row.tolerance ? Agreement::agree : Agreement::differ;
  row.ours = std::move(ours);
  row.box2d = std::move(box2d);
  return row;
}

// Distance between two distributions: the mean difference of values of equal rank. If a run has lost bodies, ranks are
// matched by their share of the count.
double rank_distance(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.empty() || b.empty()) return a.size() == b.size() ? 0 : std::numeric_limits<double>::infinity();
  const std::size_t count = std::max(a.size(), b.size());
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) sum += std::fabs(a[i * a.size() / count] - b[i * b.size() / count]);
  return sum / static_cast<double>(count);
}

// The mean value of each rank over the ensemble.
std::vector<double> mean_ranks(const std::vector<CrosscheckRun>& runs, std::vector<double> CrosscheckRun::*field) {
  std::size_t count = 0;
  for (const CrosscheckRun& run : runs) count = std::max(count, (run.*field).size());
  std::vector<double> ranks(count, 0);
  for (const CrosscheckRun& run : runs) {
    const std::vector<double>& values = run.*field;
    if (values.empty()) continue;
    for (std::size_t i = 0; i < count; ++i)
      ranks[i] += values[i * values.size() / count] / static_cast<double>(runs.size());
  }
  return ranks;
}

struct Judge {
  const CrosscheckLayout& layout;
  const std::vector<CrosscheckRun>& ours;
  const std::vector<CrosscheckRun>& box2d;
  double skin;

  bool box2d_stood() const {
    return all(box2d, [](const CrosscheckRun& run) { return run.stood; });
  }
  double standing_share() const { return box2d_stood() ? standing_tolerance : collapsed_tolerance; }

  // Many bodies that fall together, from the air or out of a structure that falls.
  bool is_heap() const { return layout.dynamic_count >= heap_count_min && !(layout.is_structure && box2d_stood()); }

  // The reason why the criteria of structures do not apply; empty if they apply.
  std::string not_a_structure() const {
    if (layout.gravity == 0) return "no gravity";
    if (layout.is_structure) return {};
    return fmt::format("{} of {} moving bodies start at rest on something", layout.placed_count, layout.dynamic_count);
  }

  CriterionResult stands() const {
    if (std::string reason = not_a_structure(); !reason.empty())
      return not_applicable(std::string(stands_criterion), reason);
    const auto stood = [](const CrosscheckRun& run) { return run.stood ? 1 : 0; };
    CriterionResult row =
        compare_means(std::string(stands_criterion), "of the seeds", each(ours, stood), each(box2d, stood), 0);
    row.tolerance = stood_tolerance + 1e-9;
    row.verdict = row.difference <= row.tolerance ? Agreement::agree : Agreement::differ;
    return row;
  }

  CriterionResult standing() const {
    if (std::string reason = not_a_structure(); !reason.empty()) return not_applicable("standing bodies", reason);
    const auto count = [](const CrosscheckRun& run) { return run.standing_count; };
    const double placed = static_cast<double>(layout.placed_count);
    return compare_means("standing bodies", fmt::format("of {}", layout.placed_count), each(ours, count),
                         each(box2d, count), std::max(0.5, standing_share() * placed));
  }

  CriterionResult top() const {
    if (layout.gravity == 0) return not_applicable(std::string(top_criterion), "no gravity");
    const auto height = [](const CrosscheckRun& run) { return run.top; };
    // The tolerance for bodies that fly or fall far is relative to their distance.
    const double reach = std::max(layout.height, std::fabs(mean_of(each(box2d, height))));
    // The top of a heap is a body by chance: one body higher or lower is the same heap.
    const double heap = is_heap() ? layout.size : 0;
    CriterionResult row = compare_means(std::string(top_criterion), "m", each(ours, height), each(box2d, height),
                                        std::max(top_tolerance * reach, heap));
    if (row.verdict != Agreement::differ) return row;
    const auto chained = [](const CrosscheckRun& run) { return run.has_chain; };
    if (!all(ours, chained) || !all(box2d, chained)) return row;
    const auto gap = [](const CrosscheckRun& run) { return run.chain_gap; };
    const auto bare = [](const CrosscheckRun& run) { return run.top - run.chain_gap; };
    const double without = std::fabs(mean_of(each(ours, bare)) - mean_of(each(box2d, bare)));
    const double skin_max = skin;
    const bool gaps_are_skin = all(
        box2d, [&](const CrosscheckRun& run) { return run.chain_gap_max <= std::max(1.05 * skin_max, rounding_m); });
    const bool overlaps_are_softness =
        all(ours, [](const CrosscheckRun& run) { return run.penetration_unexplained <= penetration_tolerance; });
    if (without > top_explained_tolerance * reach || !gaps_are_skin || !overlaps_are_softness) return row;
    row.verdict = Agreement::expected;
    row.reason = fmt::format(
        "gaps from the top down: ours {:+.4f} m (soft contacts), Box2D {:+.4f} m ({}); without them {:.4f} m apart",
        mean_of(each(ours, gap)), mean_of(each(box2d, gap)), skin > 0 ? "skin" : "no skin", without);
    return row;
  }

  CriterionResult order() const {
    if (std::string reason = not_a_structure(); !reason.empty()) return not_applicable("order upwards", reason);
    const bool any = std::any_of(layout.bodies.begin(), layout.bodies.end(), [&](const CrosscheckBody& body) {
      return std::any_of(body.supports.begin(), body.supports.end(),
                         [&](std::uint32_t support) { return layout.bodies[support].is_dynamic; });
    });
    if (!any) return not_applicable("order upwards", "no moving body lies on another");
    const auto share = [](const CrosscheckRun& run) { return 100 * run.order; };
    return compare_means("order upwards", "% kept", each(ours, share), each(box2d, share), 100 * standing_share());
  }

  CriterionResult tilt() const {
    if (std::string reason = not_a_structure(); !reason.empty()) return not_applicable("largest tilt", reason);
    const bool any = std::any_of(layout.bodies.begin(), layout.bodies.end(),
                                 [](const CrosscheckBody& body) { return body.is_placed && body.shows_tilt; });
    if (!any) return not_applicable("largest tilt", "only circles");
    const auto degrees = [](const CrosscheckRun& run) { return run.tilt_deg; };
    return compare_means("largest tilt", "deg, up to 45", each(ours, degrees), each(box2d, degrees),
                         tilt_tolerance_deg);
  }

  CriterionResult settle() const {
    if (layout.is_structure && !box2d_stood())
      return not_applicable("comes to rest", "Box2D's structure falls or slides: when that ends is chance");
    const auto settled = [](const CrosscheckRun& run) { return std::isfinite(run.settle_s) ? 1.0 : 0.0; };
    const double ours_settled = mean_of(each(ours, settled));
    const double box2d_settled = mean_of(each(box2d, settled));
    const auto time = [](const CrosscheckRun& run) { return run.settle_s; };
    CriterionResult row;
    row.criterion = "comes to rest";
    row.unit = "s";
    row.ours = each(ours, time);
    row.box2d = each(box2d, time);
    row.tolerance = settle_tolerance_min_s;
    if ((ours_settled > 0.5) != (box2d_settled > 0.5)) {
      // If the seeds of both engines are divided, the criterion decides nothing.
      const bool split = box2d_settled > 0.25 && box2d_settled < 0.75 && ours_settled > 0.2 && ours_settled < 0.8;
      row.verdict = split ? Agreement::agree : Agreement::differ;
      row.difference = std::numeric_limits<double>::infinity();
      row.reason = split ? ""
                         : fmt::format("at rest in {:.0f} % of the seeds, Box2D in {:.0f} %", 100 * ours_settled,
                                       100 * box2d_settled);
      return row;
    }
    if (ours_settled <= 0.5) {  // in neither engine do the bodies come to rest
      row.verdict = Agreement::agree;
      return row;
    }
    const auto finite = [](std::vector<double> values) {
      values.erase(std::remove_if(values.begin(), values.end(), [](double v) { return !std::isfinite(v); }),
                   values.end());
      return values;
    };
    const Statistics reference = statistics_of(finite(row.box2d));
    row.difference = std::fabs(mean_of(finite(row.ours)) - reference.mean);
    row.tolerance = std::max(
        {settle_tolerance_min_s, settle_tolerance_share * reference.mean, scatter_factor * reference.deviation});
    row.verdict = row.difference <= row.tolerance ? Agreement::agree : Agreement::differ;
    return row;
  }

  CriterionResult penetration() const {
    const auto depth = [](const CrosscheckRun& run) { return 100 * run.penetration; };
    CriterionResult row = compare_means("deepest overlap", "% of size", each(ours, depth), each(box2d, depth),
                                        100 * penetration_tolerance);
    if (row.verdict != Agreement::differ) return row;
    // Where Box2D's contacts are rigid, its rest is its whole overlap.
    const auto rest = [](const CrosscheckRun& run) { return 100 * run.penetration_unexplained; };
    const double ours_rest = mean_of(each(ours, rest));
    const double box2d_rest = mean_of(each(box2d, rest));
    const bool is_deeper = mean_of(row.ours) >= mean_of(row.box2d);
    const double without = is_deeper ? ours_rest - box2d_rest : box2d_rest - ours_rest;
    const bool is_soft = is_deeper || box2d_rest < mean_of(row.box2d);
    if (!is_soft || without > row.tolerance) return row;
    row.verdict = Agreement::expected;
    row.reason = fmt::format("{}soft contacts give way by force / (stiffness * mass); without that {:.2f} %",
                             is_deeper ? "" : "Box2D's ", is_deeper ? ours_rest : box2d_rest);
    return row;
  }

  CriterionResult joints() const {
    const auto gap = [&](const CrosscheckRun& run) { return 100 * run.joint_gap / layout.size; };
    CriterionResult row = compare_means(std::string(joints_criterion), "% of size", each(ours, gap), each(box2d, gap),
                                        100 * joint_tolerance);
    // The true gap is none: a smaller one than Box2D's is no fault.
    if (mean_of(row.ours) <= mean_of(row.box2d)) row.verdict = Agreement::agree;
    return row;
  }

  CriterionResult travel_by(std::vector<double> CrosscheckRun::*field) const {
    CriterionResult row;
    row.criterion = travel_criterion;
    row.unit = "m across";
    const auto mean = [&](const CrosscheckRun& run) { return (run.*field).empty() ? 0 : mean_of(run.*field); };
    row.ours = each(ours, mean);
    row.box2d = each(box2d, mean);
    const std::vector<double> reference = mean_ranks(box2d, field);
    double scatter = 0;
    for (const CrosscheckRun& run : box2d)
      scatter += rank_distance(run.*field, reference) / static_cast<double>(box2d.size());
    row.difference = rank_distance(mean_ranks(ours, field), reference);
    row.tolerance =
        std::max({travel_tolerance_min * layout.size,
                  travel_tolerance_share * (reference.empty() ? 0 : mean_of(reference)), scatter_factor * scatter});
    row.verdict = row.difference <= row.tolerance ? Agreement::agree : Agreement::differ;
    return row;
  }

  CriterionResult travel() const {
    CriterionResult row = travel_by(&CrosscheckRun::travel);
    if (row.verdict != Agreement::differ || !box2d_stood()) return row;
    const CriterionResult closed = travel_by(&CrosscheckRun::travel_closed);
    if (closed.verdict != Agreement::agree) return row;
    row.verdict = Agreement::expected;
    row.reason = fmt::format("Box2D's skin pushes rows of touching bodies apart; with its gaps closed {:.4f} m apart",
                             closed.difference);
    return row;
  }

  // ---- Body by body ----

  using Runs = std::vector<CrosscheckRun>;

  static bool is_left(const Runs& runs, std::size_t id) {
    return all(runs, [&](const CrosscheckRun& run) { return id < run.places.size() && run.places[id].is_left; });
  }
  static bool rests(const Runs& runs, std::size_t id) {
    return all(runs, [&](const CrosscheckRun& run) { return run.places[id].rests; });
  }
  static double mean_at(const Runs& runs, std::size_t id, double CrosscheckPlace::*field) {
    return mean_of(each(runs, [&](const CrosscheckRun& run) { return run.places[id].*field; }));
  }
  static void raise(std::vector<double>& values, const std::vector<double>& others) {
    values.resize(others.size(), 0);
    for (std::size_t i = 0; i < others.size(); ++i) values[i] = std::max(values[i], others[i]);
  }

  // The mean place of a body over an ensemble.
  struct Rest {
    bool exists = false;   // the body rests in every seed
    bool certain = false;  // every seed is within 1 cm of the mean
    double across = 0;     // m
    double up = 0;
    double gap = 0;
    double gap_max = 0;
    std::vector<double> scatter;  // by seed, m from the mean
    double off(const Rest& other) const { return std::hypot(across - other.across, up - other.up); }
  };
  static std::vector<double> distances(const Runs& runs, std::size_t id, const Rest& rest) {
    return each(runs, [&](const CrosscheckRun& run) {
      return std::hypot(run.places[id].across - rest.across, run.places[id].up - rest.up);
    });
  }
  static Rest rest_of(const Runs& runs, std::size_t id) {
    Rest rest;
    rest.exists = is_left(runs, id) && rests(runs, id);
    if (!rest.exists) return rest;
    rest.across = mean_at(runs, id, &CrosscheckPlace::across);
    rest.up = mean_at(runs, id, &CrosscheckPlace::up);
    rest.gap = mean_at(runs, id, &CrosscheckPlace::chain_gap);
    for (const CrosscheckRun& run : runs) rest.gap_max = std::max(rest.gap_max, run.places[id].chain_gap_max);
    rest.scatter = distances(runs, id, rest);
    rest.certain = *std::max_element(rest.scatter.begin(), rest.scatter.end()) <= 0.5 * place_tolerance;
    return rest;
  }
  // How far the skin may push a body along the row in which it starts, m: half the number of gaps in the row, times the
  // skin.
  double row_slack(std::uint32_t id) const {
    for (const std::vector<std::uint32_t>& row : layout.body_rows)
      if (std::find(row.begin(), row.end(), id) != row.end()) return 0.5 * skin * static_cast<double>(row.size() - 1);
    return 0;
  }
  bool is_same(const Rest& own, const Rest& theirs) const { return own.off(theirs) <= place_tolerance; }
  // Compares places without the gaps of the skin and without the overlaps of soft contacts.
  bool is_same_without_gaps(std::uint32_t id, const Rest& own, const Rest& theirs) const {
    const double across = std::max(0.0, std::fabs(own.across - theirs.across) - row_slack(id));
    const double up = (own.up - own.gap) - (theirs.up - theirs.gap);
    return theirs.gap_max <= 1.05 * skin && std::hypot(across, up) <= place_tolerance;
  }

  // `finer`: the ensembles of Box2D with smaller steps that have run. `own_finer`: the same for this engine.
  CriterionResult same_place(const std::vector<Runs>& finer, const std::vector<Runs>& own_finer) const {
    enum class Found { same, same_without_gaps, converges, unsettled, differs };
    const auto judge = [&](std::uint32_t id, const Rest& own, const Rest& theirs) {
      if (is_same(own, theirs)) return Found::same;
      if (is_same_without_gaps(id, own, theirs)) return Found::same_without_gaps;
      bool settled = true;
      for (const Runs& runs : finer) {
        const Rest fine = rest_of(runs, id);
        if (fine.certain && (is_same(own, fine) || is_same_without_gaps(id, own, fine))) return Found::converges;
        settled &= fine.certain && is_same(fine, theirs);
      }
      for (const Runs& runs : own_finer) {
        const Rest fine = rest_of(runs, id);
        settled &= fine.certain && is_same(fine, own);
      }
      return settled ? Found::differs : Found::unsettled;
    };

    CriterionResult row;
    row.criterion = place_criterion;
    row.tolerance = place_tolerance;
    row.verdict = Agreement::agree;
    std::size_t judged = 0, uncertain = 0, explained = 0, converging = 0, unsettled = 0;
    double most = 0;
    for (std::uint32_t id = 0; id < layout.bodies.size(); ++id) {
      const Rest own = rest_of(ours, id);
      const Rest theirs = rest_of(box2d, id);
      if (!own.exists || !theirs.exists) continue;
      const Found found = theirs.certain ? judge(id, own, theirs) : Found::unsettled;
      uncertain += theirs.certain ? 0 : 1;
      unsettled += found == Found::unsettled ? 1 : 0;
      if (found == Found::unsettled) continue;
      ++judged;
      explained += found == Found::same_without_gaps ? 1 : 0;
      converging += found == Found::converges ? 1 : 0;
      raise(row.ours, distances(ours, id, theirs));
      raise(row.box2d, theirs.scatter);
      row.difference = std::max(row.difference, own.off(theirs));
      if (found != Found::differs) continue;
      row.verdict = Agreement::differ;
      if (own.off(theirs) <= most) continue;
      most = own.off(theirs);
      row.reason = fmt::format("body {} rests {:+.3f} m across and {:+.3f} m up from where Box2D's does", id,
                               own.across - theirs.across, own.up - theirs.up);
    }
    if (judged == 0)
      return not_applicable(row.criterion,
                            fmt::format("of {} bodies that rest in both Box2D knows no place", unsettled));
    row.unit = fmt::format("m, {} of {}", judged, layout.dynamic_count);
    if (row.verdict == Agreement::differ) return row;
    const std::size_t moved = unsettled - uncertain;  // bodies that smaller steps put elsewhere
    if (explained + converging + moved > 0) row.verdict = Agreement::expected;
    if (explained > 0)
      row.reason = fmt::format("{} but for the gaps of Box2D's skin and the overlaps of soft contacts; ", explained);
    if (converging > 0) row.reason += fmt::format("{} where Box2D comes to with smaller steps; ", converging);
    if (moved > 0) row.reason += fmt::format("{} not judged: smaller steps put them elsewhere; ", moved);
    if (row.verdict == Agreement::expected) row.reason.erase(row.reason.size() - 2);
    return row;
  }

  CriterionResult same_distance(const std::vector<Runs>& finer) const {
    CriterionResult row;
    row.criterion = distance_criterion;
    row.verdict = Agreement::agree;
    std::size_t judged = 0, unsettled = 0;
    double worst = -1;
    for (std::uint32_t id = 0; id < layout.bodies.size(); ++id) {
      if (!is_left(ours, id) || !is_left(box2d, id) || (rests(ours, id) && rests(box2d, id))) continue;
      const auto distance = [&](const CrosscheckRun& run) { return run.places[id].moved; };
      std::vector<double> theirs = each(box2d, distance);
      std::vector<double> own = each(ours, distance);
      const double tolerance = std::max(distance_tolerance_min, distance_tolerance_share * mean_of(theirs));
      const auto [least, most] = std::minmax_element(theirs.begin(), theirs.end());
      if (*most - *least > tolerance) continue;  // Box2D's own seeds disagree
      const double difference = std::fabs(mean_of(own) - mean_of(theirs));
      const bool is_settled = std::all_of(finer.begin(), finer.end(), [&](const Runs& runs) {
        return is_left(runs, id) && std::fabs(mean_of(each(runs, distance)) - mean_of(theirs)) <= tolerance;
      });
      if (difference > tolerance && !is_settled) {
        ++unsettled;
        continue;
      }
      ++judged;
      if (difference / tolerance <= worst) continue;
      worst = difference / tolerance;
      row.ours = std::move(own);
      row.box2d = std::move(theirs);
      row.difference = difference;
      row.tolerance = tolerance;
      row.reason = difference > tolerance ? fmt::format("body {} is the farthest off", id) : "";
      row.verdict = difference > tolerance ? Agreement::differ : Agreement::agree;
    }
    if (judged == 0) return not_applicable(row.criterion, "nothing moves on of which Box2D knows how far it comes");
    row.unit = fmt::format("m, {} of {}", judged, layout.dynamic_count);
    if (row.verdict == Agreement::agree && unsettled > 0) {
      row.verdict = Agreement::expected;
      row.reason = fmt::format("{} not judged: with smaller steps Box2D's come elsewhere", unsettled);
    }
    return row;
  }

  CriterionResult column() const {
    if (!layout.is_column) return not_applicable("weights in the stack", "not a single stack");
    const auto error = [](const CrosscheckRun& run) { return 100 * run.column_error; };
    CriterionResult row =
        compare_means("weights in the stack", "% off", each(ours, error), each(box2d, error), 100 * force_tolerance);
    if (mean_of(row.box2d) > 100 * force_tolerance)
      return not_applicable("weights in the stack", "Box2D's own stack does not rest");
    row.tolerance = 100 * force_tolerance;
    row.verdict = mean_of(row.ours) <= row.tolerance ? Agreement::agree : Agreement::differ;
    return row;
  }

  CriterionResult ground() const {
    if (layout.gravity == 0) return not_applicable("weight on the ground", "no gravity");
    if (!all(box2d, [](const CrosscheckRun& run) { return std::isfinite(run.settle_s); }))
      return not_applicable("weight on the ground", "Box2D does not come to rest");
    const bool ours_leans = std::any_of(
        ours.begin(), ours.end(), [](const CrosscheckRun& run) { return run.ground_force > 0 && !run.ground_is_flat; });
    if (ours_leans || !all(box2d, [](const CrosscheckRun& run) { return run.ground_is_flat; }))
      return not_applicable("weight on the ground", "slopes or walls carry a part by friction");
    const auto share = [](const CrosscheckRun& run) { return 100 * run.ground_force; };
    return compare_means("weight on the ground", "% of weight", each(ours, share), each(box2d, share),
                         100 * force_tolerance);
  }
};

}  // namespace

double mean_of(const std::vector<double>& values) {
  return statistics_of(values).mean;
}

std::vector<CriterionResult> compare_runs(const CrosscheckLayout& layout, const std::vector<CrosscheckRun>& ours,
                                          const std::vector<CrosscheckRun>& box2d, double box2d_skin) {
  const auto finite = [](const CrosscheckRun& run) { return run.is_finite; };
  if (!all(box2d, finite)) return {not_applicable("scene", "Box2D's state becomes non-finite")};
  if (!all(ours, finite)) {
    CriterionResult row = not_applicable("scene", "a state becomes non-finite");
    row.verdict = Agreement::differ;
    return {row};
  }
  const Judge judge{layout, ours, box2d, box2d_skin};
  std::vector<CriterionResult> rows{judge.stands(), judge.standing(), judge.top(),         judge.order(),
                                    judge.tilt(),   judge.settle(),   judge.penetration(), judge.travel(),
                                    judge.column(), judge.ground()};
  if (layout.jointed && layout.size > 0) rows.push_back(judge.joints());
  for (CriterionResult& row : compare_bodies(layout, ours, box2d, {}, {}, box2d_skin)) rows.push_back(std::move(row));
  return rows;
}

std::vector<CriterionResult> compare_bodies(const CrosscheckLayout& layout, const std::vector<CrosscheckRun>& ours,
                                            const std::vector<CrosscheckRun>& box2d,
                                            const std::vector<std::vector<CrosscheckRun>>& finer,
                                            const std::vector<std::vector<CrosscheckRun>>& own_finer,
                                            double box2d_skin) {
  const Judge judge{layout, ours, box2d, box2d_skin};
  return {judge.same_place(finer, own_finer), judge.same_distance(finer)};
}

}  // namespace ticktrue::tool
